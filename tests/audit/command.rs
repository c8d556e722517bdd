//! The command `audit`: builds the images, audits them, holds the figures to their budgets.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use serde::Serialize;

use super::budgets::{self, Budgets, Judged, Standing};
use super::cycle_audit::{self, Kernels};
use super::image_audit::{self, Audited, Vectors};
use super::images::IMAGES;
use super::print;
use super::report::{Figure, Report};
use super::witness;
use crate::toolchain;

const EXAMPLES: &str = "\
Examples:
  audit                                  build and audit everything, and hold it to tests/budgets.toml
  audit --json | jq '.figures[]'         the same for machines
  audit --all                            every symbol instead of the largest
  audit --accept                         write what was measured into the budgets file, within its limits
  audit --elf my-firmware                audit any linked Cortex-M image, without budgets
  audit --elf my-firmware --entry TIM2   only what one function reaches

Exit codes: 0 within budgets and nothing forbidden, 1 over a budget or something forbidden, 2 could not audit.";

/// Audits the linked firmware: memory, stack, time, and what must not be in it.
#[derive(Debug, Parser)]
#[command(name = "audit", version, after_help = EXAMPLES)]
pub struct Options {
    /// Audit this image, and no other, without budgets
    #[arg(long, value_name = "FILE", conflicts_with_all = ["accept", "budgets"])]
    pub elf: Option<PathBuf>,
    /// With --elf: audit only what this function reaches, by its name in `nm` or demangled; may be repeated
    #[arg(long, value_name = "NAME", requires = "elf")]
    pub entry: Vec<String>,
    /// The budgets file; tests/budgets.toml if none
    #[arg(long, value_name = "FILE")]
    pub budgets: Option<PathBuf>,
    /// Write the measured figures into the budgets file; limits stay
    #[arg(long)]
    pub accept: bool,
    /// How many of the largest symbols to list
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub largest: usize,
    /// List every symbol
    #[arg(long, conflicts_with = "largest")]
    pub all: bool,
    /// Print one JSON document instead of tables
    #[arg(long)]
    pub json: bool,
}

/// What a run of the command found.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The compiler of the images, if they were built.
    pub compiler: Option<String>,
    /// What each audit found.
    pub reports: Vec<Report>,
    /// Each figure beside its budget; empty without budgets.
    pub figures: Vec<Judged>,
    /// Everything is within budgets and nothing is forbidden.
    pub passed: bool,
}

/// Runs the command. `progress` is told what is being done. Returns what to print, and whether the audits passed.
///
/// # Errors
/// Why nothing could be audited, and what helps.
pub fn run(options: &Options, progress: &mut dyn FnMut(&str)) -> Result<(String, bool), String> {
    let outcome = match &options.elf {
        Some(path) => of_file(options, path)?,
        None => of_images(options, progress)?,
    };
    let text = if options.json {
        serde_json::to_string_pretty(&outcome).map_err(|error| error.to_string())? + "\n"
    } else {
        print::outcome(&outcome)
    };
    Ok((text, outcome.passed))
}

impl Options {
    fn largest(&self) -> usize {
        if self.all { usize::MAX } else { self.largest }
    }
}

/// Audits one file, whatever it is.
fn of_file(options: &Options, path: &Path) -> Result<Outcome, String> {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let audited = Audited::read(&name, path)?;
    let entries: Vec<&str> = options.entry.iter().map(String::as_str).collect();
    let vectors = if entries.is_empty() { Vectors::InDetail } else { Vectors::LeftOut };
    let reports = vec![
        audited.memory(options.largest(), true)?,
        audited.stack(None, vectors, &entries)?,
        audited.forbidden(None, &entries)?,
    ];
    let passed = reports.iter().all(|report| report.faults.is_empty());
    Ok(Outcome { compiler: None, reports, figures: Vec::new(), passed })
}

/// Builds and audits the images of the budgets file.
fn of_images(options: &Options, progress: &mut dyn FnMut(&str)) -> Result<Outcome, String> {
    let path = options.budgets.clone().unwrap_or_else(|| toolchain::workspace().join("tests/budgets.toml"));
    let budgets = Budgets::read(&path)?;
    let compiler = toolchain::compiler()?;
    let mut reports = Vec::new();
    for plan in IMAGES {
        progress(&format!("building {}", plan.name));
        let elf = plan.firmware.build()?;
        progress(&format!("auditing {}", plan.name));
        let audited = Audited::read(plan.name, &elf)?;
        reports.extend(image_audit::all(plan, &audited, &budgets, options.largest())?);
        if plan.flies {
            progress(&format!("flying a mission with {}", plan.name));
            reports.extend(beside_the_bound(&audited.name, &elf, &reports)?);
        }
    }
    progress("building audit-kernels");
    let kernels = Kernels::build()?;
    reports.push(cycle_audit::report(&kernels, progress)?);
    let measured: Vec<Figure> = reports.iter().flat_map(|report| report.figures.clone()).collect();
    let mut figures = budgets.judge(&measured, &FAMILIES, &compiler);
    if options.accept {
        accept(&path, &figures, &compiler)?;
        figures = Budgets::read(&path)?.judge(&measured, &FAMILIES, &compiler);
    }
    let passed =
        reports.iter().all(|report| report.faults.is_empty()) && !figures.iter().any(|figure| figure.standing.fails());
    Ok(Outcome { compiler: Some(compiler), reports, figures, passed })
}

/// What an emulated mission used of the stack, if there is a bound to set it beside.
fn beside_the_bound(name: &str, elf: &Path, reports: &[Report]) -> Result<Option<Report>, String> {
    let used = witness::high_water(elf)?;
    let bound = format!("stack.{name}");
    let bound = reports.iter().flat_map(|report| &report.figures).find(|figure| figure.name == bound);
    Ok(bound.map(|bound| witness::report(name, bound.value, used)))
}

/// First words of the names of all figures that this command measures.
const FAMILIES: [&str; 5] = ["flash", "ram", "size", "stack", "time"];

fn accept(path: &Path, figures: &[Judged], compiler: &str) -> Result<(), String> {
    let refused = |what: &str, error: String| format!("{} cannot be {what}: {error}", path.display());
    let text = fs::read_to_string(path).map_err(|error| refused("read", error.to_string()))?;
    let accepted = budgets::accepted(&text, figures, compiler).map_err(|error| refused("rewritten", error))?;
    fs::write(path, accepted).map_err(|error| refused("written", error.to_string()))
}

impl Outcome {
    /// Figures that fail, or that are worth a word.
    pub fn remarkable(&self) -> impl Iterator<Item = &Judged> {
        self.figures.iter().filter(|figure| figure.standing != Standing::Within)
    }
}
