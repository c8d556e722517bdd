//! The page of the measurements.

use super::SpeedReport;
use crate::chart::{Axis, Range, range_chart};
use crate::page::{Block, Page, Section};
use crate::tables::{TextTable, significant};

/// The page.
#[must_use]
pub fn page(report: &SpeedReport) -> String {
    let settings = serde_json::to_string_pretty(&report.settings).unwrap_or_default();
    let sections = vec![
        Section::new("Result", vec![periods(report), kernels(report)]),
        Section::new("Tables", report.tables().into_iter().map(TextTable::into_block).collect()),
        Section::new("Configuration", vec![Block::Verbatim { caption: "Settings".to_owned(), text: settings }]),
    ];
    let footer = format!(
        "monitor-sim {}. By the clock of one machine, the fastest of several measurements; nothing here ran on silicon.",
        env!("CARGO_PKG_VERSION")
    );
    let title = "Thruster fault monitor: study speed".to_owned();
    Page { title, summary: summary(report), sections, footer }.to_html()
}

fn summary(report: &SpeedReport) -> String {
    let watched = report.rows.iter().filter_map(|row| Some((row, row.monitor_share?)));
    let told = watched.map(|(row, share)| {
        let (millions, share) = (significant(row.steps_per_s_and_thread / 1e6), 100.0 * share);
        format!(
            "{}, one thread: {millions} million control periods a second, {share:.0} % of the time in the monitor",
            row.motor
        )
    });
    told.collect::<Vec<_>>().join("; ") + "."
}

/// A value without a spread.
fn at(name: String, value: f64) -> Range {
    Range { name, ends: (value, value), half: None, middle: value }
}

fn periods(report: &SpeedReport) -> Block {
    let row = |row: &super::SpeedRow| {
        // Names beside a picture are short: what there is besides the plant, or how that is solved.
        let what = row.what.rsplit(", ").next().unwrap_or(row.what).replace("and", "with");
        let what = if row.threads == 1 { what } else { format!("{} threads", row.threads) };
        at(format!("{}, {what}", row.motor), 1e9 / row.steps_per_s_and_thread)
    };
    let ranges: Vec<Range> = report.rows.iter().map(row).collect();
    let axis = Axis { name: "time of a control period and thread, ns", log: false };
    let caption = "What a control period takes on each thread: the plant solved in two ways; the second with the monitor, on one thread \
                   and on more.";
    Block::Figure { caption: caption.to_owned(), pictures: vec![range_chart(&ranges, axis, None)] }
}

fn kernels(report: &SpeedReport) -> Block {
    let row = |row: &super::KernelRow| {
        let kernel = row.kernel.split(',').next().unwrap_or(row.kernel);
        at(format!("{kernel}, {}", row.channels), row.ns_each)
    };
    let ranges: Vec<Range> = report.kernels.iter().map(row).collect();
    let axis = Axis { name: "time of a call, ns", log: true };
    let caption = "How the monitor's kernels grow with the number of channels.";
    Block::Figure { caption: caption.to_owned(), pictures: vec![range_chart(&ranges, axis, None)] }
}
