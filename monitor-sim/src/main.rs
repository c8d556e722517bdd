//! The command line of the simulator: reads what is asked for, runs it, prints what came of it.

mod args;
mod print;
mod study_command;

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

use args::{Cli, Command, MissionArgs, ReplayArgs, TuneArgs};
use clap::Parser;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use monitor_sim::log::{ColumnRef, LogOptions};
use monitor_sim::mission::Mission;
use monitor_sim::names::ChannelNames;
use monitor_sim::output::{self, OutputDir, PendingFile};
use monitor_sim::replay::{Learn, Limits, Replay};
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use monitor_sim::trace::TraceWriter;
use monitor_sim::tune::Tune;
use monitor_sim::{mission_page, replay_page};

type Failure = Box<dyn std::error::Error>;

/// The exit code for input that was wrong; a fault that was found has 1.
const WRONG_INPUT: u8 = 2;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match cli.command {
        None => fly(&cli.mission),
        Some(Command::Replay(args)) => replay(&args),
        Some(Command::Tune(args)) => tune(&args),
        Some(Command::Study(args)) => study_command::run(&args),
        Some(Command::Scenario) => print_all(monitor_sim::scenario::FIGURE_1_TOML),
    };
    done.unwrap_or_else(|failure| {
        eprintln!("error: {failure}");
        ExitCode::from(WRONG_INPUT)
    })
}

/// The main job.
fn fly(args: &MissionArgs) -> Result<ExitCode, Failure> {
    let mission = Mission {
        scenario: scenario(args.scenario.as_deref())?,
        settings: settings(args.limits.as_deref())?,
        seed: args.seed,
        faults: args.faults,
    };
    let out = OutputDir::prepare(&args.out)?;
    let bar = progress(Some(mission.samples()), "samples");
    let flights = mission.fly(&out, |samples| bar.inc(samples))?;
    bar.finish_and_clear();
    let mut report = flights.report(&mission);
    let page = mission_page::page(&mission, &flights, &report)?;
    report.files.insert(0, out.write("mission.html", &page)?);
    print_all(&if args.json { json(&report)? } else { print::mission(&mission, &report) })
}

fn replay(args: &ReplayArgs) -> Result<ExitCode, Failure> {
    let limits = match &args.limits {
        Some(path) => Some(settings(Some(path))?),
        None => None,
    };
    let defaults = PaperSettings::default_motor()?;
    let learn = match (&args.learn, &args.baseline) {
        (Some(window), _) => Learn::Window(*window),
        (None, Some(path)) => Learn::Stored(Box::new(parsed(path, "baseline")?)),
        (None, None) => return Err("give --learn A..B or --baseline FILE".into()),
    };
    let replay = Replay {
        path: args.log.clone(),
        channels: channels(args)?,
        set_point: args.set_point.clone(),
        log: LogOptions { delimiter: args.delimiter },
        rate_hz: args.rate_hz,
        learn,
        recall: args.recall,
        settle_s: args.settle,
        relearn_s: args.relearn,
        set_point_tolerance: args.set_point_tolerance,
        cutoff_hz: limits.as_ref().map(|l| l.cutoff_hz).or(args.cutoff_hz),
        hysteresis: limits.as_ref().map_or(defaults.hysteresis, |l| l.hysteresis),
        explained_share: limits.as_ref().map_or(defaults.explained_share, |l| l.explained_share),
        limits: limits.map_or(Limits::FromLearning { margin: args.margin }, |l| Limits::Fixed(l.thresholds)),
        injections: args.inject.clone(),
    };
    let out = OutputDir::prepare(&args.out)?;
    out.spares(&args.log, &["replay.csv", "replay.html", "baseline.toml"])?;
    let bar = progress(replay.bytes(), "bytes");
    let replayed = replay.run(
        |names| (!args.no_trace).then(|| TraceWriter::create(&out, "replay.csv", names)).transpose(),
        |bytes| bar.set_position(bytes),
    );
    bar.finish_and_clear();
    let mut replayed = replayed?;
    let page = replay_page::page(&replay, &replayed)?;
    replayed.report.files.insert(0, out.write("replay.html", &page)?);
    if args.baseline.is_none() {
        replayed.report.files.push(out.write("baseline.toml", &replayed.baseline.to_toml()?)?);
    }
    print_all(&if args.json { json(&replayed.report)? } else { print::replay(&replayed) })?;
    Ok(ExitCode::from(replayed.report.exit))
}

fn tune(args: &TuneArgs) -> Result<ExitCode, Failure> {
    let tune = Tune {
        scenario: scenario(args.scenario.as_deref())?,
        settings: settings(None)?,
        runs: args.runs,
        first_seed: args.seed,
        margin: args.margin,
        borderline_size: args.borderline,
    };
    if let (Some(scenario), Some(out)) = (&args.scenario, &args.out) {
        output::spares(scenario, out)?;
    }
    let file = args.out.as_deref().map(PendingFile::create).transpose()?;
    let bar = progress(Some(tune.samples()), "samples");
    let report = tune.run(|samples| bar.inc(samples))?;
    bar.finish_and_clear();
    let settings = report.settings.to_toml()?;
    let written = match file {
        Some(mut file) => {
            file.write_all(settings.as_bytes()).map_err(|source| file.failed(source))?;
            Some(file.finish()?)
        }
        None => None,
    };
    print_all(&if args.json { json(&report)? } else { print::tune(&tune, &report, &settings, written.as_deref()) })
}

fn scenario(path: Option<&Path>) -> Result<Scenario, Failure> {
    let Some(path) = path else { return Ok(Scenario::figure_1()) };
    let text = read(path, "scenario")?;
    Ok(Scenario::from_toml(&text).map_err(|error| format!("scenario '{}': {error}", path.display()))?)
}

fn settings(path: Option<&Path>) -> Result<PaperSettings, Failure> {
    match path {
        Some(path) => parsed(path, "thresholds"),
        None => Ok(PaperSettings::default_motor()?),
    }
}

/// A TOML file of the user's.
fn parsed<T: serde::de::DeserializeOwned>(path: &Path, what: &str) -> Result<T, Failure> {
    let text = read(path, what)?;
    Ok(toml::from_str(&text).map_err(|error| format!("{what} file '{}': {error}", path.display()))?)
}

fn read(path: &Path, what: &str) -> Result<String, Failure> {
    Ok(std::fs::read_to_string(path).map_err(|e| format!("cannot read the {what} file '{}': {e}", path.display()))?)
}

/// The three channels: those of the motor, or three of the user's own.
fn channels(args: &ReplayArgs) -> Result<[(String, ColumnRef); 3], Failure> {
    if let (Some(speed), Some(current), Some(voltage)) = (&args.speed, &args.current, &args.voltage) {
        let [a, b, c] = ChannelNames::motor().0;
        return Ok([(a, speed.clone()), (b, current.clone()), (c, voltage.clone())]);
    }
    let given = args.channel.len();
    let channels: [(String, ColumnRef); 3] = args.channel.clone().try_into().map_err(|_| {
        format!(
            "three channels are needed, {given} given: repeat --channel NAME=COL, or use --speed, --current, --voltage"
        )
    })?;
    let [(a, _), (b, _), (c, _)] = &channels;
    if a == b || b == c || a == c {
        return Err("two channels have the same name: give each --channel a name of its own".into());
    }
    Ok(channels)
}

/// A bar on a terminal, nothing elsewhere.
fn progress(length: Option<u64>, unit: &str) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(length, target);
    let counts = if unit == "bytes" {
        "{bytes}/{total_bytes}".to_owned()
    } else {
        format!("{{human_pos}}/{{human_len}} {unit}")
    };
    if let Ok(style) = ProgressStyle::with_template(&format!("{{wide_bar}} {counts}, {{eta}} left")) {
        bar.set_style(style);
    }
    bar
}

fn json(report: &impl serde::Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(report)? + "\n")
}

/// Prints to standard output; a reader that has gone away (`| head`) is no error.
fn print_all(text: &str) -> Result<ExitCode, Failure> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(ExitCode::SUCCESS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }
}
