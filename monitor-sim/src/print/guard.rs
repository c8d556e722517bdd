//! Results of `guard` mode.

use std::fmt::Write as _;

use monitor_sim::mission::Faults;
use monitor_sim::mission::guard::{GuardReport, Mission};
use monitor_sim::tables;

use super::{shown, written};

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
        mission.false_alarms_per_hour,
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
