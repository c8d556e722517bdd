//! Results for people at a terminal.

pub(crate) mod fleet;
pub(crate) mod guard;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use comfy_table::{CellAlignment, Table};
use comfy_table::{LineStyle, TableStyle};
use monitor_sim::bench::BenchReport;
use monitor_sim::mission::Faults;
use monitor_sim::mission::paper::{Mission, MissionReport};
use monitor_sim::replay::paper::{ReplayReport, Replayed};
use monitor_sim::score::Method;
use monitor_sim::study::Report;
use monitor_sim::study::white::RATE_HZ;
use monitor_sim::tables::{self, TextTable};
use monitor_sim::tune::{Tune, TuneReport};

/// More alarms than this are counted, not listed; JSON has them all.
const LISTED_ALARMS: usize = 20;

/// The tables of a mission.
pub(crate) fn mission(mission: &Mission, report: &MissionReport) -> String {
    let mut text = format!(
        "Mission \"{}\": {:.0} s at {:.0} Hz, {} faults, seed {}, {} mode\n\n",
        report.scenario,
        mission.scenario.duration_s,
        report.rate_hz,
        if report.fault_profile == Faults::Step { "step" } else { "ramp" },
        report.seed,
        report.mode,
    );
    tables::of_mission(report).into_iter().for_each(|table| text += &shown(table));
    let located: Vec<bool> = report
        .faults
        .iter()
        .filter(|f| f.method == Method::Ppca)
        .map(|f| f.located.as_deref() == Some(&f.id))
        .collect();
    let right = located.iter().filter(|right| **right).count();
    let _ = writeln!(text, "Located right: {right} of {}. False alarms: {}.", located.len(), report.false_alarms);
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
    let ReplayReport { learned, alarms, .. } = report;
    let mut text = format!("Replay of {}: {} rows at {} Hz\n\n", report.log.display(), report.samples, report.rate_hz);
    text += &shown(tables::learned(learned, names));
    text += &shown(tables::components(&learned.quality.explained, &learned.quality.retained, names));
    for remark in replayed.remarks() {
        let _ = writeln!(text, "{remark}");
    }
    let _ = writeln!(text, "{}\n", replayed.coverage());
    if alarms.is_empty() {
        text += "No fault found.\n";
    } else {
        text += &shown(tables::alarms(alarms, names, LISTED_ALARMS));
        let more = alarms.len().saturating_sub(LISTED_ALARMS);
        if more > 0 {
            let _ = writeln!(text, "and {more} more; --json lists them all");
        }
    }
    text + &written(&report.files)
}

/// The trade-off and the thresholds that tuning found.
pub(crate) fn tune(
    tune: &Tune,
    report: &TuneReport,
    settings: &str,
    file: Option<&Path>,
    page: Option<&Path>,
) -> String {
    let mut text = format!(
        "Thresholds for \"{}\": {} fault-free missions, {} with faults of {:.0} % size, and as many to check, in {:.1} s\n\n",
        tune.scenario.name,
        tune.runs,
        tune.runs,
        100.0 * tune.borderline_size,
        report.wall_s
    );
    text += &shown(tables::thresholds(report));
    text += &shown(tables::sweep(report, tune.margin));
    for model in &report.not_separated {
        let _ = writeln!(
            text,
            "warning: under a borderline fault the residual of {model} does not stay above its threshold"
        );
    }
    if let Some(page) = page {
        let _ = writeln!(text, "Written: {}", page.display());
    }
    match file {
        Some(path) => {
            let _ = writeln!(text, "Written: {} (use it with --mode paper --limits)", path.display());
        }
        None => text += settings,
    }
    text
}

/// The tables of a study, and what they took.
pub(crate) fn study(report: &Report, files: &[PathBuf]) -> String {
    let mut text = String::new();
    report.tables.iter().for_each(|table| text += &shown(table.clone()));
    let (steps, wall_s, threads) = (report.steps as f64, report.wall_s, report.threads);
    let _ = write!(text, "{} units, {steps:.2e} control periods", report.units);
    if report.resumed > 0 {
        let _ = writeln!(text, ", {} units of them from the file of finished ones.", report.resumed);
    } else {
        let per_core = steps / wall_s / threads as f64;
        // Every study flies at one rate.
        let hours = steps / RATE_HZ / 3600.0 / wall_s;
        let _ = writeln!(
            text,
            " in {wall_s:.1} s on {threads} threads: {per_core:.2e} per second and thread, {hours:.2} simulated hours a second."
        );
    }
    if files.is_empty() { text } else { text + &written(files) }
}

/// The tables of a benchmark, and what a reader must know.
pub(crate) fn bench(report: &BenchReport, page: Option<&Path>) -> String {
    let mut text = format!("{}\n\n", report.about().title);
    report.tables().into_iter().for_each(|table| text += &shown(table));
    report.remarks().iter().for_each(|remark| text += &format!("{remark}\n"));
    if let Some(path) = page {
        let _ = writeln!(text, "Written: {}", path.display());
    }
    text
}

pub(crate) fn shown(table: TextTable) -> String {
    let mut drawn = Table::new();
    // A line under the header is enough: numbers need no boxes.
    drawn.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
    drawn.set_header(&table.header);
    drawn.add_rows(&table.rows);
    for column in drawn.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{}\n{drawn}\n\n", table.caption)
}

pub(crate) fn written(files: &[PathBuf]) -> String {
    let listed: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    format!("Written: {}\n", listed.join(", "))
}
