//! The command line: what can be asked for, in the user's words.

pub(crate) mod bench;
pub(crate) mod study;
pub(crate) mod watch;

use std::path::PathBuf;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};

use monitor_sim::guardian::Alarming;
use monitor_sim::inject::Injection;
use monitor_sim::log::{ColumnRef, Delimiter};
use monitor_sim::mission::Faults;
use monitor_sim::window::RowWindow;

use crate::{Failure, only_in_guard_mode};

const EXAMPLES: &str = "\
Examples:
  monitor-sim                                 fly the paper's mission, write tables and page
  monitor-sim --faults ramp --seed 7          the same with growing faults and other noise
  monitor-sim --mode paper                    the paper's method, with the paper's tables
  monitor-sim --save-models motor.models      keep what was learned, for --models
  monitor-sim --scenario my.toml --out DIR    a mission of your own
  monitor-sim --json | jq .faults             the tables for machines
  monitor-sim scenario > my.toml              a scenario to edit
  monitor-sim watch --pace 5                  look on while a mission is flown
  monitor-sim tune --out limits.toml          find the paper's thresholds by borderline runs
  monitor-sim study false-alarms --hours 10   count false alarms over random motors
  monitor-sim replay log.csv --speed rpm --current amps --voltage volts \\
      --rate-hz 50 --learn 5s..20s            find faults in a recorded log
  monitor-sim bench skab SKAB/data            score the monitor on a public benchmark

Exit codes: 0 done (replay: no fault), 1 replay reported a fault, 2 wrong input.";

const REPLAY_EXAMPLES: &str = "\
Examples:
  monitor-sim replay log.csv --speed rpm --current amps --voltage volts \\
      --rate-hz 50 --learn 5s..20s
  monitor-sim replay log.csv ... --resistance 0.3 --torque-constant 0.03 --load-slope 2e-4
      the same, and faults get names: load torque, speed sensor, current sensor and others
  monitor-sim replay log.csv --speed 2 --current 3 --voltage 4 --set-point 1 \\
      --rate-hz 50 --learn 0..1000
  monitor-sim replay pump.csv --channel current=Current --channel voltage=Voltage \\
      --channel flow=Flow --rate-hz 1 --learn 0..400
  monitor-sim replay log.csv ... --inject current:+0.5@800 --inject speed:ramp+2@1200..1600
      an offset from row 800 on and a ramp over rows 1200 to 1599, added to a healthy log
  monitor-sim replay logs/ last.parquet --speed rpm --current amps --voltage volts \\
      --rate-hz 50 --learn 5s..20s --out fleet
      a fleet: each log judged as it would be alone, a row of fleet/summary.csv and .parquet each
  monitor-sim replay healthy.csv ... --save-models motor.models
  monitor-sim replay next.csv --speed rpm --current amps --voltage volts --rate-hz 50 \\
      --models motor.models --relearn 15
      what was learned from one log (over 15 s) judges another from its first settled row on
  monitor-sim replay log.csv ... --mode paper
  monitor-sim replay next.csv ... --mode paper --baseline monitor-out/baseline.toml
      judge another log by what was learned from the first

Rows count from 0 (the first row under the header). Rows before and inside the learning
window are not judged.
Exit codes: 0 no fault, 1 a fault was reported, 2 wrong input (of several logs: one of them at
least; the others are judged nevertheless).";

const TUNE_EXAMPLES: &str = "\
Examples:
  monitor-sim tune                                      thresholds for the default motor, printed
  monitor-sim tune --scenario my.toml --out my-limits.toml --page tune.html
  monitor-sim --scenario my.toml --mode paper --limits my-limits.toml
  monitor-sim tune --runs 64 --margin 2 --json | jq .sweep

Exit codes: 0 done, 2 the input or the command line was wrong.";

const SCENARIO_EXAMPLES: &str = "\
Examples:
  monitor-sim scenario > my.toml         a copy to edit
  monitor-sim --scenario my.toml         fly it";

/// Finds faults of a thruster motor: flies a simulated mission, replays a recorded log, tunes thresholds.
///
/// Without a command it flies the mission of the paper's figure 1 and prints its tables.
#[derive(Debug, Parser)]
#[command(version, about, after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) mission: MissionArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Replay a recorded log: learn over a window, judge the rest
    #[command(mut_arg("speed", |arg| arg.required_unless_present("channel")))]
    #[command(mut_arg("rate_hz", |arg| arg.required(true)))]
    #[command(group = ArgGroup::new("known").args(["learn", "models", "baseline"]).required(true))]
    Replay(Box<ReplayArgs>),
    /// Watch a mission or a log in the terminal while it is judged
    #[command(after_help = watch::EXAMPLES)]
    #[command(group = ArgGroup::new("known").args(["learn", "models"]))]
    #[command(mut_arg("speed", |arg| arg.requires("log")))]
    #[command(mut_arg("channel", |arg| arg.requires("log")))]
    #[command(mut_arg("set_point", |arg| arg.requires("log")))]
    #[command(mut_arg("rate_hz", |arg| arg.requires("log")))]
    #[command(mut_arg("learn", |arg| arg.requires("log")))]
    #[command(mut_arg("inject", |arg| arg.requires("log")))]
    #[command(mut_arg("settle", |arg| arg.requires("log")))]
    #[command(mut_arg("set_point_tolerance", |arg| arg.requires("log")))]
    #[command(mut_arg("resistance", |arg| arg.requires("log")))]
    #[command(mut_arg("delimiter", |arg| arg.requires("log")))]
    Watch(Box<watch::WatchArgs>),
    /// Find thresholds for a motor by borderline fault-free and faulty runs
    #[command(after_help = TUNE_EXAMPLES)]
    Tune(TuneArgs),
    /// Fly many missions over random seeds, faults and motors, and count
    #[command(after_help = study::EXAMPLES)]
    Study(study::StudyArgs),
    /// Score the monitor on recordings, by the protocol of a benchmark or one of your own
    Bench(bench::BenchArgs),
    /// Print the default scenario, to be edited and given to --scenario
    #[command(after_help = SCENARIO_EXAMPLES)]
    Scenario,
}

/// Which monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Mode {
    /// Small faults found fast and named; limits from the false alarms that are tolerable
    Guard,
    /// The method of the paper, with fixed thresholds
    Paper,
}

/// When guard mode raises an alarm, and when it withdraws it.
#[derive(Debug, Args)]
pub(crate) struct AlarmArgs {
    /// In guard mode: false alarms that are tolerable per hour; 0.01 if none
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) false_alarms_per_hour: Option<f64>,
    /// In guard mode: how long something must be wrong before an alarm is raised, s; at once if none
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = not_negative)]
    pub(crate) raise_hold: Option<f64>,
    /// In guard mode: how long the motor must look healthy before an alarm is withdrawn, s; 0.02, and four samples at least, if none
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = not_negative)]
    pub(crate) clear_hold: Option<f64>,
}

impl AlarmArgs {
    pub(crate) fn alarming(&self) -> Alarming {
        let usual = Alarming::default();
        Alarming {
            false_alarms_per_hour: self.false_alarms_per_hour.unwrap_or(usual.false_alarms_per_hour),
            raise_hold_s: self.raise_hold.unwrap_or(usual.raise_hold_s),
            clear_hold_s: self.clear_hold,
        }
    }

    /// Refuses what paper mode has not.
    pub(crate) fn only_in_guard_mode(&self) -> Result<(), Failure> {
        only_in_guard_mode("--false-alarms-per-hour", self.false_alarms_per_hour.is_some())?;
        only_in_guard_mode("--raise-hold", self.raise_hold.is_some())?;
        only_in_guard_mode("--clear-hold", self.clear_hold.is_some())
    }
}

#[derive(Debug, Args)]
pub(crate) struct MissionArgs {
    /// Scenario file (TOML); the paper's figure 1 if none
    #[arg(long, value_name = "FILE")]
    pub(crate) scenario: Option<PathBuf>,
    /// Thresholds file for --mode paper, as `tune` writes it; those of the default motor if none
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) alarming: AlarmArgs,
    /// In guard mode: judge by what was learned before (--save-models of a flight with the same [learn], or a dump of a
    /// board's flash) as soon as the loop has settled, instead of learning
    #[arg(long, value_name = "FILE")]
    pub(crate) models: Option<PathBuf>,
    /// In guard mode: write what is known of each set point at the end, for --models
    #[arg(long, value_name = "FILE")]
    pub(crate) save_models: Option<PathBuf>,
    /// Which monitor flies
    #[arg(long, value_enum, default_value_t = Mode::Guard)]
    pub(crate) mode: Mode,
    /// How faults are introduced
    #[arg(long, value_enum, default_value_t = Faults::Step)]
    pub(crate) faults: Faults,
    /// Seed of the sensor noise
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Directory for the page and the traces
    #[arg(long, value_name = "DIR", default_value = "monitor-out")]
    pub(crate) out: PathBuf,
    /// Print one JSON document instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

/// A recorded log, and how it is judged: what `replay` and `watch` have in common.
#[derive(Debug, Args)]
pub(crate) struct LogArgs {
    /// Column of the shaft speed: header name, or number from 1
    #[arg(long, value_name = "COL", allow_negative_numbers = true, requires_all = ["current", "voltage"])]
    pub(crate) speed: Option<ColumnRef>,
    /// Column of the armature current
    #[arg(long, value_name = "COL", allow_negative_numbers = true, requires = "speed")]
    pub(crate) current: Option<ColumnRef>,
    /// Column of the armature voltage
    #[arg(long, value_name = "COL", allow_negative_numbers = true, requires = "speed")]
    pub(crate) voltage: Option<ColumnRef>,
    /// Any other channel, three times: a name of yours and its column
    #[arg(long, value_name = "NAME=COL", value_parser = named_column, conflicts_with_all = ["speed", "current", "voltage"])]
    pub(crate) channel: Vec<(String, ColumnRef)>,
    /// Column of the set point; without it the set point counts as constant
    #[arg(long, value_name = "COL", allow_negative_numbers = true)]
    pub(crate) set_point: Option<ColumnRef>,
    /// Rows per second
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub(crate) rate_hz: Option<f64>,
    /// Where to learn what healthy means: rows A..B, or seconds As..Bs. In guard mode the first two tenths of the window seed
    /// the clip of spikes, and the rest is learned from
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub(crate) learn: Option<RowWindow>,
    /// Add a fault to a channel: CHANNEL:+V@ROW, CHANNEL:ramp+V@ROW..ROW, CHANNEL:xG@ROW
    #[arg(long, value_name = "FAULT")]
    pub(crate) inject: Vec<Injection>,
    /// Settling time after a change of the set point, s
    #[arg(long, value_name = "S", default_value_t = 5.0, allow_negative_numbers = true)]
    pub(crate) settle: f64,
    /// Movement of the set point that is not a change, in its unit
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) set_point_tolerance: f64,
    #[command(flatten)]
    pub(crate) alarming: AlarmArgs,
    /// In guard mode: armature resistance of the motor, ohm. With this and the next two, within 20 %, faults get names
    #[arg(long, value_name = "OHM", allow_negative_numbers = true, value_parser = positive, requires_all = ["torque_constant", "load_slope"])]
    pub(crate) resistance: Option<f64>,
    /// In guard mode: torque constant, N m/A
    #[arg(long, value_name = "NM/A", allow_negative_numbers = true, value_parser = positive, requires = "resistance")]
    pub(crate) torque_constant: Option<f64>,
    /// In guard mode: how much the load torque grows with speed at the set point, N m s/rad; 0 if it does not
    #[arg(long, value_name = "NMS", allow_negative_numbers = true, value_parser = not_negative, requires = "resistance")]
    pub(crate) load_slope: Option<f64>,
    /// What separates the columns: `,` `;` `tab`; found by itself if none
    #[arg(long, value_name = "CHAR")]
    pub(crate) delimiter: Option<Delimiter>,
}

#[derive(Debug, Args)]
#[command(after_help = REPLAY_EXAMPLES)]
pub(crate) struct ReplayArgs {
    /// The log: comma, semicolon or tab separated, or Parquet. Several, or a directory with logs below it: one summary of all
    /// of them, summary.csv and summary.parquet
    #[arg(value_name = "LOG.csv", required = true)]
    pub(crate) logs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) how: LogArgs,
    /// With --mode paper: judge from the first row by a baseline that an earlier replay wrote (baseline.toml), instead of
    /// learning
    #[arg(long, value_name = "FILE", conflicts_with_all = ["margin", "limits", "cutoff_hz"])]
    pub(crate) baseline: Option<PathBuf>,
    /// In guard mode: judge by what was learned before (--save-models, or a dump of a board's flash) from the first row on which
    /// the motor has settled, instead of learning. In a directory each log has a file of its name, ending in .models
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) models: Option<PathBuf>,
    /// In guard mode: write what is known of each set point at the end, for --models; of several logs, a file for each in a
    /// directory
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) save_models: Option<PathBuf>,
    /// When the set point of --learn returns, judge by what was learned there instead of learning anew; guard mode always does
    #[arg(long)]
    pub(crate) recall: bool,
    /// With --models, or --mode paper: learning time at a set point that is not known, s; the length of --learn if none, and with
    /// --models so long that every time scale has its usual length. It must be that of the run that wrote the models
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) relearn: Option<f64>,
    /// With --mode paper: cutoff of the residuals' low-pass, Hz; 1, or a twentieth of the rate if that is less, if none
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub(crate) cutoff_hz: Option<f64>,
    /// With --mode paper: threshold over the largest residual of the learning window; 1.5 if none
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) margin: Option<f64>,
    /// With --mode paper: thresholds file, as `tune` writes it, instead of limits from the learning window
    #[arg(long, value_name = "FILE", conflicts_with_all = ["margin", "cutoff_hz"])]
    pub(crate) limits: Option<PathBuf>,
    /// Write no trace: it is larger than the log; of several logs none is written
    #[arg(long)]
    pub(crate) no_trace: bool,
    /// Which monitor judges
    #[arg(long, value_enum, default_value_t = Mode::Guard)]
    pub(crate) mode: Mode,
    /// Directory for the page and the trace, or for the summary of several logs
    #[arg(long, value_name = "DIR", default_value = "monitor-out")]
    pub(crate) out: PathBuf,
    /// Print one JSON document instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct TuneArgs {
    /// Scenario file (TOML); the paper's figure 1 if none
    #[arg(long, value_name = "FILE")]
    pub(crate) scenario: Option<PathBuf>,
    /// Runs of each kind: to set the thresholds, and again to check them
    #[arg(long, default_value_t = 16, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub(crate) runs: u64,
    /// Seed of the first run
    #[arg(long, default_value_t = 1000, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Threshold over the largest fault-free residual
    #[arg(long, default_value_t = 1.5, allow_negative_numbers = true, value_parser = positive)]
    pub(crate) margin: f64,
    /// Size of the borderline faults, as a share of the scenario's
    #[arg(long, default_value_t = 0.25, allow_negative_numbers = true, value_parser = positive)]
    pub(crate) borderline: f64,
    /// Write the thresholds to this file, for --limits; print them if none
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write a page to this file, with the trade-off as a picture
    #[arg(long, value_name = "FILE")]
    pub(crate) page: Option<PathBuf>,
    /// Print one JSON document instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

fn named_column(text: &str) -> Result<(String, ColumnRef), String> {
    let parts = text.split_once('=').map(|(name, column)| (name.trim(), column.trim()));
    match parts {
        Some((name, column)) if !name.is_empty() => Ok((name.to_owned(), column.parse().map_err(|e| format!("{e}"))?)),
        _ => Err("write NAME=COL, for example `flow=Volume Flow`".to_owned()),
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("a number not below zero is needed".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("a number above zero is needed".to_owned()),
    }
}
