//! The page of a study: what it found, as pictures and in tables, and all that it depends on.

use super::Report;
use crate::page::{Block, Page, Section};
use crate::tables::TextTable;

/// The page.
#[must_use]
pub fn page(report: &Report) -> String {
    let settings = serde_json::to_string_pretty(&report.settings).unwrap_or_default();
    let tables = report.tables.iter().cloned().map(TextTable::into_block).collect();
    let mut sections = vec![
        Section::new("Result", report.figures.clone()),
        Section::new("Tables", tables),
        Section::new("Configuration", vec![Block::Verbatim { caption: "Settings".to_owned(), text: settings }]),
    ];
    sections.retain(|section| !section.blocks.is_empty());
    let footer = format!(
        "monitor-sim {}, {} units, {:.2e} control periods. Simulated motors; nothing here ran on silicon.",
        report.version, report.units, report.steps as f64
    );
    let in_tables = || format!("{} units of work; the tables tell what they found.", report.units);
    let summary = if report.summary.is_empty() { in_tables() } else { report.summary.clone() };
    let title = format!("Thruster fault monitor: study {}", report.study);
    Page { title, summary, sections, footer }.to_html()
}
