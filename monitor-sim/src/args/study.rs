//! `monitor-sim study`: what can be asked for.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use monitor_sim::study::calibrate::Asked;
use monitor_sim::study::localization::Faults;
use monitor_sim::study::watch::Mode;

use super::{not_negative, positive};

pub(crate) const EXAMPLES: &str = "\
Examples:
  monitor-sim study false-alarms --motors 100 --hours 50 --asked 0.1
  monitor-sim study false-alarms --hours 1000 --motors 1000 --resume units.jsonl --out result.json
      an interrupted study goes on where it was when it is started again
  monitor-sim study false-alarms --change 30 --hours 20 --json | jq '.rows[0].judged_share'
      missions that change their speed every 30 s: how much of them is judged?
  monitor-sim study false-alarms --learn 2 --motors 300 --hours 100
      do limits learned in two seconds hold?
  monitor-sim study delay --asked 3.6 --page delay.html
  monitor-sim study ramp --seeds 50 --json | jq '.rows[0]'
  monitor-sim study localization --motors 1000
  monitor-sim study robustness

Results depend on the settings and the seed, not on the number of threads.
Exit codes: 0 done, 2 the input or the command line was wrong.";

const DELAY_EXAMPLES: &str = "\
Examples:
  monitor-sim study delay                              seven faults, seven sizes, 20 flights each
  monitor-sim study delay --asked 3.6                  with a false alarm in a million samples: beside Lorden's bound
  monitor-sim study delay --sizes 0.01,0.1,1 --json | jq '.rows[] | select(.row == \"white\")'

Exit codes: 0 done, 2 the input or the command line was wrong.";

const RAMP_EXAMPLES: &str = "\
Examples:
  monitor-sim study ramp                               limits for one false alarm in ten hours
  monitor-sim study ramp --seeds 200 --size 0.5 --json | jq '.rows[].value_at_detection.median'
  monitor-sim study ramp --scenario my.toml --ramp 100 --known 3600 --smallest
      how small a fault of my motor is found at all while it grows for 100 s?

Exit codes: 0 done, 2 the input or the command line was wrong.";

const LOCALIZATION_EXAMPLES: &str = "\
Examples:
  monitor-sim study localization                       50 motors, seven faults, five sizes
  monitor-sim study localization --faults paper        the paper's three alone
  monitor-sim study localization --motors 1000 --resume units.jsonl --out localization.json
  monitor-sim study localization --constants-off 0 --json | jq '.rows[] | select(.row == \"confusion\")'

Exit codes: 0 done, 2 the input or the command line was wrong.";

const ROBUSTNESS_EXAMPLES: &str = "\
Examples:
  monitor-sim study robustness                         outliers, missing samples, ADC steps, jitter, stuck sensors
  monitor-sim study robustness --motors 200 --size 4 --json | jq '.rows[] | select(.row == \"stuck\")'

Exit codes: 0 done, 2 the input or the command line was wrong.";

const SPEED_EXAMPLES: &str = "\
Examples:
  monitor-sim study speed --page speed.html
  monitor-sim study speed --json | jq '.rows[].steps_per_s_and_thread'

Exit codes: 0 done, 2 the input or the command line was wrong.";

/// A study that shows no rates of alarms needs limits, but not good ones.
pub(crate) const ANY_LIMITS: Asked =
    Asked { false_alarms_per_hour: 0.1, calibration_runs: 2, calibration_judged_s: 30.0 };

#[derive(Debug, Args)]
// A word that is missing is an error like any other.
#[command(after_help = EXAMPLES, arg_required_else_help = false)]
pub(crate) struct StudyArgs {
    #[command(subcommand)]
    pub(crate) study: StudyCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum StudyCommand {
    /// Fault-free hours over random motors: how often is there an alarm?
    #[command(after_help = EXAMPLES)]
    FalseAlarms {
        /// Random motors
        #[arg(long, default_value_t = 20, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        motors: u64,
        /// Hours judged, over all motors
        #[arg(long, value_name = "H", default_value_t = 2.0, allow_negative_numbers = true, value_parser = positive)]
        hours: f64,
        /// Seconds from one set point to the next, of nine from 60 % of the motor's own up; one set point if left out
        #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
        change: Option<f64>,
        /// Length of the learning window, s; the motors' own 15 if left out
        #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
        learn: Option<f64>,
        #[command(flatten)]
        common: CommonArgs,
    },
    /// How long detecting and clearing take, against the size of each fault
    #[command(after_help = DELAY_EXAMPLES)]
    Delay {
        /// Flights of each fault and size
        #[arg(long, value_name = "N", default_value_t = 20, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=100_000))]
        seeds: u64,
        /// Sizes, in shares of the faults of figure 1
        #[arg(long, value_name = "X,X,...", value_delimiter = ',', default_value = "0.03125,0.0625,0.125,0.25,0.5,1,2", allow_negative_numbers = true, value_parser = positive)]
        sizes: Vec<f64>,
        #[command(flatten)]
        common: CommonArgs,
    },
    /// The value that a growing fault has reached when it is detected
    #[command(after_help = RAMP_EXAMPLES)]
    Ramp {
        /// Flights of each fault
        #[arg(long, value_name = "N", default_value_t = 20, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=100_000))]
        seeds: u64,
        /// Last value of the ramps, in shares of the faults of figure 1 or of the scenario
        #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
        size: f64,
        /// How long the ramps take to their last value, s
        #[arg(long, value_name = "S", default_value_t = 20.0, allow_negative_numbers = true, value_parser = positive)]
        ramp: f64,
        /// How long the healthy motor has been watched before the ramp begins, s
        #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true, value_parser = not_negative)]
        known: f64,
        /// Look for the smallest ramp that is detected before it ends, down to a thousandth of --size
        #[arg(long)]
        smallest: bool,
        /// Motor at its first set point, and the faults that grow, each by itself, to its amplitude (TOML); figure 1 if left out
        #[arg(long, value_name = "FILE")]
        scenario: Option<PathBuf>,
        #[command(flatten)]
        common: CommonArgs,
    },
    /// Which name each fault is given, over random motors
    #[command(after_help = LOCALIZATION_EXAMPLES)]
    Localization {
        /// Random motors
        #[arg(long, default_value_t = 50, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        motors: u64,
        /// Sizes: how far each fault shifts the settled readings, in sigmas of one sample
        #[arg(long, value_name = "X,X,...", value_delimiter = ',', default_value = "1,2,4,8,16", allow_negative_numbers = true, value_parser = positive)]
        sizes: Vec<f64>,
        /// How far resistance, torque constant and load slope may be from what the monitor is told, as a share
        #[arg(long, value_name = "X", default_value_t = 0.2, allow_negative_numbers = true, value_parser = share)]
        constants_off: f64,
        /// Which faults there are
        #[arg(long, value_enum, default_value_t = Faults::All)]
        faults: Faults,
        #[command(flatten)]
        common: CommonArgs,
    },
    /// What bad readings and wrong constants do, over random motors
    #[command(after_help = ROBUSTNESS_EXAMPLES)]
    Robustness {
        /// Random motors
        #[arg(long, default_value_t = 20, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        motors: u64,
        /// How far the faults shift the settled readings, in sigmas of one sample
        #[arg(long, value_name = "X", default_value_t = 8.0, allow_negative_numbers = true, value_parser = positive)]
        size: f64,
        /// Seconds that each motor is judged without a fault under each disturbance
        #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true, value_parser = positive)]
        healthy: f64,
        #[command(flatten)]
        common: CommonArgs,
    },
    /// False alarms against delay by the thresholds of paper mode, and the thresholds to use: `tune` under another name
    #[command(after_help = super::TUNE_EXAMPLES)]
    Tune(super::TuneArgs),
    /// Control periods per second, and the shares of plant and monitor (by the clock)
    #[command(after_help = SPEED_EXAMPLES)]
    Speed {
        /// Control periods of each measurement and thread
        #[arg(long, value_name = "N", default_value_t = 2_000_000, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
        steps: u64,
        /// Which monitor is measured
        #[arg(long, value_enum, default_value_t = Mode::Guard)]
        mode: Mode,
        /// Seed of the random motor and the noise
        #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
        seed: u64,
        /// Write a page with pictures to this file
        #[arg(long, value_name = "FILE")]
        page: Option<PathBuf>,
        /// Print one JSON document instead of a table
        #[arg(long)]
        json: bool,
    },
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..1.0).contains(&value) => Ok(value),
        _ => Err("a number from 0 to below 1 is needed".to_owned()),
    }
}

/// What every study takes.
#[derive(Debug, Args)]
pub(crate) struct CommonArgs {
    /// Which monitor is studied
    #[arg(long, value_enum, default_value_t = Mode::Guard)]
    pub(crate) mode: Mode,
    /// False alarms per hour that the limits are set for
    #[arg(long, value_name = "RATE", default_value_t = 0.1, allow_negative_numbers = true, value_parser = positive)]
    pub(crate) asked: f64,
    /// Fault-free runs that set the limits of a motor
    #[arg(long, value_name = "N", default_value_t = 12, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub(crate) calibration_runs: u64,
    /// Seconds judged in each of them
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true, value_parser = positive)]
    pub(crate) calibration_judged: f64,
    /// Seed of everything
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Threads; all cores if none
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub(crate) threads: Option<u64>,
    /// Keep finished units in this file, and go on from it after an interruption
    #[arg(long, value_name = "FILE")]
    pub(crate) resume: Option<PathBuf>,
    /// Write the result to this file, as one JSON document
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write a page with pictures to this file
    #[arg(long, value_name = "FILE")]
    pub(crate) page: Option<PathBuf>,
    /// Print one JSON document instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

impl CommonArgs {
    /// Which monitor, the seed, and what its limits are for.
    pub(crate) fn settings(&self) -> (Mode, u64, Asked) {
        let asked = Asked {
            false_alarms_per_hour: self.asked,
            calibration_runs: self.calibration_runs,
            calibration_judged_s: self.calibration_judged,
        };
        (self.mode, self.seed, asked)
    }
}
