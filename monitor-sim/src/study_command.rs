//! `monitor-sim study`: makes a study of what was asked for, runs it, prints what it found.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use monitor_sim::scenario::Scenario;
use monitor_sim::study::delay::Delay;
use monitor_sim::study::false_alarms::FalseAlarms;
use monitor_sim::study::localization::Localization;
use monitor_sim::study::page::page;
use monitor_sim::study::ramp::Ramp;
use monitor_sim::study::robustness::Robustness;
use monitor_sim::study::speed::{self, Speed};
use monitor_sim::study::{self, Run, Study};

use crate::args::study::{ANY_LIMITS, CommonArgs, StudyArgs, StudyCommand};
use crate::{Failure, different, json, pending, print, print_all, progress, scenario, tune};

pub(crate) fn run(args: &StudyArgs) -> Result<ExitCode, Failure> {
    match &args.study {
        StudyCommand::FalseAlarms { motors, hours, change, learn, common } => {
            let (mode, seed, asked) = common.settings();
            let (motors, hours, change_s, learn_s) = (*motors, *hours, *change, *learn);
            make(&FalseAlarms { mode, seed, asked, motors, hours, change_s, learn_s }, common)
        }
        StudyCommand::Delay { seeds, sizes, common } => {
            let (mode, seed, asked) = common.settings();
            make(&Delay { mode, seed, asked, seeds: *seeds, sizes: sizes.clone() }, common)
        }
        StudyCommand::Ramp { seeds, size, ramp, known, smallest, scenario, common } => {
            let (mode, seed, asked) = common.settings();
            let (seeds, size, ramp_s, known_s) = (*seeds, *size, *ramp, *known);
            let scenario = scenario.as_deref().map(faulty).transpose()?;
            let smallest = *smallest;
            make(&Ramp { mode, seed, asked, seeds, size, ramp_s, known_s, smallest, scenario }, common)
        }
        StudyCommand::Localization { motors, sizes, constants_off, faults, common } => {
            let (mode, seed, asked) = common.settings();
            let (motors, sizes, constants_off, faults) = (*motors, sizes.clone(), *constants_off, *faults);
            make(&Localization { mode, seed, asked, motors, sizes, constants_off, faults }, common)
        }
        StudyCommand::Robustness { motors, size, healthy, common } => {
            let (mode, seed, asked) = common.settings();
            let (motors, size, healthy_s) = (*motors, *size, *healthy);
            make(&Robustness { mode, seed, asked, motors, size, healthy_s }, common)
        }
        StudyCommand::Tune(args) => tune(args),
        StudyCommand::Speed { steps, mode, seed, page, json } => {
            measure(&Speed { mode: *mode, seed: *seed, asked: ANY_LIMITS, steps: *steps }, page.as_deref(), *json)
        }
    }
}

/// A scenario that has faults.
fn faulty(path: &Path) -> Result<Scenario, Failure> {
    let scenario = scenario(Some(path))?;
    if scenario.faults.is_empty() {
        return Err(format!("scenario '{}' has no fault that could grow; add a [[fault]]", path.display()).into());
    }
    Ok(scenario)
}

fn measure(study: &Speed, page: Option<&Path>, as_json: bool) -> Result<ExitCode, Failure> {
    let page = pending("--page", page)?;
    let bar = progress(Some(study.measurements()), "measurements");
    let report = study.run(|| bar.inc(1));
    bar.finish_and_clear();
    let report = report?;
    let written = page.map(|file| file.finish_with(&speed::page(&report))).transpose()?;
    if as_json {
        return print_all(&json(&report)?);
    }
    let tables = report.tables().into_iter().map(print::shown);
    print_all(&tables.chain(written.map(|path| print::written(&[path]))).collect::<String>())
}

fn make<S: Study>(study: &S, common: &CommonArgs) -> Result<ExitCode, Failure> {
    let files = [("--resume", &common.resume), ("--out", &common.out), ("--page", &common.page)];
    different(&files)?;
    // Before the work: a long run shall not find out at its end that there is no place for its result.
    let file = pending("--out", common.out.as_deref())?;
    let page_file = pending("--page", common.page.as_deref())?;
    let bar = progress(Some(study.units()), "units");
    let run = Run { threads: common.threads.map(|n| n as usize), resume: common.resume.as_deref() };
    let report = study::run(study, run, |units| bar.inc(units));
    bar.finish_and_clear();
    let report = report?;
    let document = json(&report)?;
    let written = file.map(|file| file.finish_with(&document)).transpose()?;
    let pictured = page_file.map(|file| file.finish_with(&page(&report))).transpose()?;
    let written: Vec<PathBuf> = written.into_iter().chain(pictured).collect();
    print_all(&if common.json { document } else { print::study(&report, &written) })
}
