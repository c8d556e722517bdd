//! `monitor-sim` without a command: flies a mission.

use std::process::ExitCode;

use monitor_sim::mission::paper::Mission;
use monitor_sim::mission_page;
use monitor_sim::output::OutputDir;

use crate::args::MissionArgs;
use crate::{Failure, json, print, print_all, progress, scenario, settings};

/// The main job.
pub(crate) fn run(args: &MissionArgs) -> Result<ExitCode, Failure> {
    paper(args)
}

fn paper(args: &MissionArgs) -> Result<ExitCode, Failure> {
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
    let page = mission_page::paper::page(&mission, &flights, &report)?;
    report.files.insert(0, out.write("mission.html", &page)?);
    print_all(&if args.json { json(&report)? } else { print::mission(&mission, &report) })
}
