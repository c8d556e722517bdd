//! The summary of many logs.

use std::fmt::Write as _;
use std::path::PathBuf;

use monitor_sim::fleet::Outcome;
use monitor_sim::fleet::row::Row;
use monitor_sim::tables;

use super::{shown, written};

/// More rows than this are counted, not listed; the files have them all.
const LISTED: usize = 40;

/// A table of the logs in which something was found, and what there is to say of all.
pub(crate) fn summary(rows: &[Row], outcome: Outcome, files: &[PathBuf]) -> String {
    let Outcome { healthy, faulty, refused } = outcome;
    let mut text = shown(tables::fleet::logs(rows, LISTED));
    if rows.len() > LISTED {
        let _ = writeln!(text, "and {} more, which the summary has", rows.len() - LISTED);
    }
    for row in rows.iter().filter(|row| row.error.is_some()).take(LISTED) {
        let _ = writeln!(text, "refused: {}: {}", row.file, row.error.as_deref().unwrap_or_default());
    }
    let _ = writeln!(
        text,
        "Logs: {}; without a fault: {healthy}, with one or more: {faulty}, refused: {refused}.",
        rows.len()
    );
    text + &written(files)
}
