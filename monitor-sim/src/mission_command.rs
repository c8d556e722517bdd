//! `monitor-sim` without a command: flies a mission.

use std::process::ExitCode;

use monitor_sim::mission::guard;
use monitor_sim::mission::paper::Mission;
use monitor_sim::mission_page;
use monitor_sim::models::{Models, SAVE_MODELS};
use monitor_sim::output::{OutputDir, PendingFile};

use crate::args::{MissionArgs, Mode};
use crate::{Failure, json, only_in_guard_mode, only_in_paper_mode, print, print_all, progress, scenario, settings};

/// The main job.
pub(crate) fn run(args: &MissionArgs) -> Result<ExitCode, Failure> {
    match args.mode {
        Mode::Guard => guard(args),
        Mode::Paper => paper(args),
    }
}

fn guard(args: &MissionArgs) -> Result<ExitCode, Failure> {
    only_in_paper_mode("--limits", args.limits.is_some())?;
    let save = args.save_models.as_deref().map(|path| PendingFile::create(path, SAVE_MODELS)).transpose()?;
    let mission = guard::Mission {
        scenario: scenario(args.scenario.as_deref())?,
        alarming: args.alarming.alarming(),
        seed: args.seed,
        faults: args.faults,
        models: args.models.as_deref().map(Models::read).transpose()?,
    };
    let out = OutputDir::prepare(&args.out)?;
    let bar = progress(Some(mission.samples()), "samples");
    let flights = mission.fly(&out, |samples| bar.inc(samples))?;
    bar.finish_and_clear();
    let mut report = flights.report(&mission);
    let page = mission_page::guard::page(&mission, &flights, &report);
    report.files.insert(0, out.write("mission.html", &page)?);
    report.files.extend(save.map(|file| flights.tables.models.write(file)).transpose()?);
    print_all(&if args.json { json(&report)? } else { print::guard::mission(&mission, &report) })
}

fn paper(args: &MissionArgs) -> Result<ExitCode, Failure> {
    args.alarming.only_in_guard_mode()?;
    only_in_guard_mode("--models", args.models.is_some())?;
    only_in_guard_mode(SAVE_MODELS, args.save_models.is_some())?;
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
    let page = mission_page::paper::page(&mission, &flights, &report);
    report.files.insert(0, out.write("mission.html", &page)?);
    print_all(&if args.json { json(&report)? } else { print::mission(&mission, &report) })
}
