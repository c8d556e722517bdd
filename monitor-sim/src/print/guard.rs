//! Results of `guard` mode.

use std::fmt::Write as _;

use monitor_sim::mission::Faults;
use monitor_sim::mission::guard::{GuardReport, Mission};
use monitor_sim::replay::guard::Replayed;
use monitor_sim::tables;

use super::{LISTED_ALARMS, shown, written};

/// The tables of a mission.
pub(crate) fn mission(mission: &Mission, report: &GuardReport) -> String {
    let mut text = format!(
        "Mission \"{}\": {:.0} s at {:.0} Hz, {} faults, seed {}, {} mode, {} false alarms an hour asked for\n\n",
        report.scenario,
        mission.scenario.duration_s,
        report.rate_hz,
        if report.fault_profile == Faults::Step { "step" } else { "ramp" },
        report.seed,
        report.mode,
        mission.alarming.false_alarms_per_hour,
    );
    tables::guard::of_mission(report).into_iter().for_each(|table| text += &shown(table));
    let right = report.faults.iter().filter(|fault| fault.is_located_right()).count();
    let _ = writeln!(text, "Named right: {right} of {}. False alarms: {}.", report.faults.len(), report.false_alarms);
    let _ = writeln!(
        text,
        "Three flights, {} samples, in {:.2} s. The monitor takes {} bytes.",
        report.samples, report.wall_s, report.monitor_bytes
    );
    for note in &report.notes {
        let _ = writeln!(text, "note: {note}");
    }
    text + &written(&report.files)
}

/// The tables of a replay.
pub(crate) fn replay(replayed: &Replayed) -> String {
    let Replayed { report, names, .. } = replayed;
    let mut text =
        format!("Replay of {}: {} rows at {} Hz, guard mode\n\n", report.log.display(), report.samples, report.rate_hz);
    text += &shown(tables::guard::learned(&report.learned, names));
    if report.learned.quality.is_some() {
        text += &shown(tables::guard::quality(&report.learned.quality));
    }
    text += &shown(tables::guard::limits(&report.limits, &report.settings.time_constants_s));
    for remark in replayed.remarks() {
        let _ = writeln!(text, "{remark}");
    }
    let _ = writeln!(text, "{}\n", replayed.coverage());
    if report.alarms.is_empty() {
        text += "No fault found.\n";
    } else {
        text += &shown(tables::guard::alarms(&report.alarms, names, LISTED_ALARMS));
        let more = report.alarms.len().saturating_sub(LISTED_ALARMS);
        if more > 0 {
            let _ = writeln!(text, "and {more} more; --json lists them all");
        }
    }
    text + &written(&report.files)
}
