//! The command line of the simulator: reads what is asked for, runs it, prints what came of it.

mod args;
mod bench_command;
mod fleet_command;
mod mission_command;
mod print;
mod replay_command;
mod study_command;
mod watch_command;

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use args::{Cli, Command, TuneArgs};
use clap::Parser;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use monitor_sim::output::{self, PendingFile};
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use monitor_sim::tune::Tune;
use monitor_sim::tune::page::page;

type Failure = Box<dyn std::error::Error>;

/// The exit code for input that was wrong; a fault that was found has 1.
const WRONG_INPUT: u8 = 2;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match cli.command {
        None => mission_command::run(&cli.mission),
        Some(Command::Replay(args)) => replay_command::run(&args),
        Some(Command::Watch(args)) => watch_command::run(&args),
        Some(Command::Tune(args)) => tune(&args),
        Some(Command::Study(args)) => study_command::run(&args),
        Some(Command::Bench(args)) => bench_command::run(&args),
        Some(Command::Scenario) => print_all(monitor_sim::scenario::FIGURE_1_TOML),
    };
    done.unwrap_or_else(|failure| {
        // A reader of TOML ends its message with a line.
        eprintln!("error: {}", failure.to_string().trim_end());
        ExitCode::from(WRONG_INPUT)
    })
}

/// Refuses an option that is given and means nothing in `guard` mode.
fn only_in_paper_mode(option: &str, given: bool) -> Result<(), Failure> {
    if given {
        return Err(format!("{option} belongs to the paper's method: add --mode paper, or leave {option} out").into());
    }
    Ok(())
}

/// Refuses an option that is given and means nothing in `paper` mode.
fn only_in_guard_mode(option: &str, given: bool) -> Result<(), Failure> {
    if given {
        return Err(format!("{option} belongs to guard mode: leave --mode paper out, or leave {option} out").into());
    }
    Ok(())
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
    different(&[("--scenario", &args.scenario), ("--out", &args.out), ("--page", &args.page)])?;
    let file = pending("--out", args.out.as_deref())?;
    let page_file = pending("--page", args.page.as_deref())?;
    let bar = progress(Some(tune.samples()), "samples");
    let report = tune.run(|samples| bar.inc(samples))?;
    bar.finish_and_clear();
    let settings = report.settings.to_toml()?;
    let written = file.map(|file| file.finish_with(&settings)).transpose()?;
    let pictured = page_file.map(|file| file.finish_with(&page(&tune, &report))).transpose()?;
    let shown = || print::tune(&tune, &report, &settings, written.as_deref(), pictured.as_deref());
    print_all(&if args.json { json(&report)? } else { shown() })
}

/// Begins the file that an option names, if it was given.
fn pending(option: &'static str, path: Option<&Path>) -> Result<Option<PendingFile>, Failure> {
    Ok(path.map(|path| PendingFile::create(path, option)).transpose()?)
}

/// Refuses two options that name the same file: what one of them holds would be overwritten.
fn different(options: &[(&'static str, &Option<PathBuf>)]) -> Result<(), Failure> {
    for (n, (option, path)) in options.iter().enumerate() {
        for (other, other_path) in &options[..n] {
            let (Some(path), Some(other_path)) = (path, other_path) else { continue };
            if path == other_path {
                let path = path.display();
                return Err(format!("{other} and {option} are both '{path}'; give them a file each").into());
            }
            output::spares(other_path, path, option)?;
        }
    }
    Ok(())
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
