//! The command `figures`: runs what finds the figures of the README, records them, and mends the README.

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;

use super::fly::Program;
use super::list::{FIGURES, Figure};
use super::passage::mended;
use super::{anew, claims};
use crate::toolchain::workspace;

/// What to run when a figure no longer holds.
pub const REMEDY: &str = "cargo run --release -p tests --bin figures";

const EXAMPLES: &str = "\
Examples:
  figures                                run everything, record it, say what the README states otherwise
  figures --only missions,ramp-100-guard the same for some
  figures --data RECORDINGS              with the benchmarks: RECORDINGS/skab and RECORDINGS/cnc_spindle
  figures --check                        fly some units of each record again, record nothing
  figures --readme                       write the recorded numbers into the README

What was interrupted goes on where it was: finished units are in target/figures, until monitor-sim is another.
Exit codes: 0 everything holds, 1 something does not, 2 something could not be run.";

/// Finds the figures of the README anew.
#[derive(Debug, Parser)]
#[command(name = "figures", version, after_help = EXAMPLES)]
pub struct Options {
    /// These alone, by the names of their files in tests/figures
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Directory with the recordings of the benchmarks, which are left as they are if none is given
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Fly some units of each record again and compare
    #[arg(long, conflicts_with_all = ["data", "readme"])]
    pub check: bool,
    /// Write the recorded numbers into README.md
    #[arg(long, conflicts_with_all = ["data", "only"])]
    pub readme: bool,
}

/// Runs the command. `say` is told what has been done. Returns what to print, and whether everything holds.
///
/// # Errors
/// What could not be run, and why.
pub fn run(options: &Options, say: &mut dyn FnMut(&str)) -> Result<(String, bool), String> {
    let figures = chosen(&options.only)?;
    if options.check {
        return check(&figures, say);
    }
    if !options.readme {
        record(&figures, options, say)?;
    }
    let path = workspace().join("README.md");
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let readme = fs::read_to_string(&path).map_err(failed)?;
    let (stale, wrong) = claims::stale(&readme);
    let mut text: String = stale.iter().map(|stale| claims::shown(&readme, stale) + "\n").collect();
    text.extend(wrong.iter().map(|wrong| format!("{wrong}\n")));
    if options.readme && !stale.is_empty() {
        fs::write(&path, mended(&readme, &stale)).map_err(failed)?;
        text += "README.md says so now.\n";
    }
    Ok((text, wrong.is_empty() && (options.readme || stale.is_empty())))
}

fn chosen(only: &[String]) -> Result<Vec<&'static Figure>, String> {
    if only.is_empty() {
        return Ok(FIGURES.iter().collect());
    }
    let named = |name: &String| {
        let names = || FIGURES.iter().map(|figure| figure.name).collect::<Vec<_>>().join(", ");
        let figure = FIGURES.iter().find(|figure| figure.name == name);
        figure.ok_or_else(|| format!("there is no figure `{name}`; there are {}", names()))
    };
    only.iter().map(named).collect()
}

fn record(figures: &[&Figure], options: &Options, say: &mut dyn FnMut(&str)) -> Result<(), String> {
    let data =
        options.data.as_ref().map(|data| data.canonicalize().map_err(|error| format!("{}: {error}", data.display())));
    let data = data.transpose()?;
    let program = Program::build()?;
    for figure in figures {
        let begun = Instant::now();
        let Some(record) = figure.fly(&program, data.as_deref())? else {
            say(&format!("{}: left as it is, for want of --data", figure.name));
            continue;
        };
        let path = figure.path();
        fs::write(&path, record.text()).map_err(|error| format!("{}: {error}", path.display()))?;
        say(&format!("{}: {:.1} s, monitor-sim {}", figure.name, begun.elapsed().as_secs_f64(), figure.command));
    }
    Ok(())
}

fn check(figures: &[&Figure], say: &mut dyn FnMut(&str)) -> Result<(String, bool), String> {
    let mut text = String::new();
    for figure in figures {
        let begun = Instant::now();
        match figure.record()? {
            None => text += &format!("{}: there is no record\n", figure.name),
            Some(record) => {
                if let Err(error) = anew::check(&record) {
                    text += &format!("{}: {error}\n", figure.name);
                }
            }
        }
        say(&format!("{}: {:.1} s", figure.name, begun.elapsed().as_secs_f64()));
    }
    let holds = text.is_empty();
    Ok((text, holds))
}
