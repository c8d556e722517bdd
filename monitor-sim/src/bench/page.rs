//! The page of a benchmark: scores, and labels and alarms of each run over time.

use super::BenchReport;
use super::drifts::{DriftReport, JudgedRun};
use super::labelled::{LabelledReport, RunReport};
use crate::chart::{Band, LogicRow, TimeAxis, logic_chart};
use crate::page::{Block, Page, Section};
use crate::tables::TextTable;

/// Colours, by their place among those of series.
const ALARM: usize = 0;
const LABEL: usize = 1;
const CHANGE: usize = 3;

/// The page.
#[must_use]
pub fn page(report: &BenchReport) -> String {
    let about = report.about();
    let mut tables = report.tables().into_iter().map(TextTable::into_block);
    let mut score: Vec<Block> = tables.next().into_iter().collect();
    score.extend(report.remarks().into_iter().map(Block::Paragraph));
    let timelines = match report {
        BenchReport::Labelled(report) => labelled(report),
        BenchReport::Drifts(report) => drifts(report),
    };
    let settings = serde_json::to_string_pretty(&about.settings).unwrap_or_default();
    let sections = vec![
        Section::new("Score", score),
        Section::new("Details", tables.collect()),
        Section::new("Runs over time", timelines),
        Section::new("Configuration", vec![Block::Verbatim { caption: "Monitor".to_owned(), text: settings }]),
    ];
    let title = format!("Thruster fault monitor: {}", about.title);
    let footer = format!("monitor-sim {}, benchmark {}, {} runs.", about.version, about.benchmark, about.runs);
    Page { title, summary: report.summary(), sections, footer }.to_html()
}

fn row(name: &str, colour: usize, intervals: Vec<(f64, f64)>) -> LogicRow {
    LogicRow { name: name.to_owned(), colour, intervals }
}

fn axis(end_s: f64, band: (f64, f64), shaded: &'static str) -> TimeAxis {
    let bands = vec![Band { from: band.0, to: band.1, label: shaded.to_owned() }];
    // A run of one row still has a picture.
    TimeAxis { range: (0.0, end_s.max(1e-9)), scaled_from: 0.0, bands, shaded }
}

fn figure(caption: String, rows: &[LogicRow], axis: &TimeAxis) -> Block {
    Block::Figure { caption, pictures: vec![logic_chart(rows, axis)] }
}

/// A run each: where it is anomalous, where an alarm stood, where it changes.
fn labelled(report: &LabelledReport) -> Vec<Block> {
    report.per_run.iter().map(labelled_run).collect()
}

fn labelled_run(run: &RunReport) -> Block {
    let timeline = &run.timeline;
    let mut rows = vec![row("label", LABEL, timeline.anomalous.clone()), row("alarm", ALARM, timeline.alarm.clone())];
    if !timeline.change_points.is_empty() {
        rows.push(row("change points", CHANGE, timeline.change_points.iter().map(|at| (*at, *at)).collect()));
    }
    let caption = match &run.refused {
        Some(why) => format!("{}: refused, {why}", run.run),
        None => run.run.clone(),
    };
    figure(caption, &rows, &axis(timeline.end_s, (0.0, timeline.scored_from_s), "learned"))
}

/// A pair each: where an alarm stood in the run as it is, and with each drift.
fn drifts(report: &DriftReport) -> Vec<Block> {
    report.judged.iter().map(|judged| pair(report, judged)).collect()
}

fn pair(report: &DriftReport, judged: &JudgedRun) -> Block {
    let cases = report.drifts.iter().filter(|case| case.learned == judged.learned && case.judged == judged.judged);
    let mut rows = vec![row("as it is", LABEL, judged.alarm.clone())];
    let mut begins_s = judged.end_s;
    for case in cases {
        begins_s = case.begins_s;
        rows.push(row(&format!("{} {:+} sigma", case.channel, case.sigmas), ALARM, case.alarm.clone()));
    }
    let kind = if judged.healthy { "healthy" } else { "not among the healthy" };
    let refused = if judged.alarms.is_none() { "; refused when it was learned" } else { "" };
    let caption = format!("Alarms: {} ({kind}), judged by {}{refused}", judged.judged, judged.learned);
    figure(caption, &rows, &axis(judged.end_s, (begins_s, judged.end_s), "drift"))
}
