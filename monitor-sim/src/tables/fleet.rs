//! The summary of many logs as a table of text.

use super::{TextTable, found_at, significant};
use crate::fleet::row::Row;

/// The first `most` logs: those that were refused or have a fault come first.
#[must_use]
pub fn logs(rows: &[Row], most: usize) -> TextTable {
    let rank = |row: &&Row| (row.error.is_none(), row.alarms == Some(0));
    let mut rows: Vec<&Row> = rows.iter().collect();
    rows.sort_by_key(rank);
    let row = |row: &Row| {
        let none = || "-".to_owned();
        [
            row.file.clone(),
            row.rows.map_or_else(none, |rows| rows.to_string()),
            row.covered_share.map_or_else(none, |share| format!("{:.1}", 100.0 * share)),
            if row.error.is_some() {
                "refused".to_owned()
            } else {
                row.alarms.map_or_else(none, |alarms| alarms.to_string())
            },
            row.first_alarm_s.map_or_else(none, found_at),
            row.name.clone().unwrap_or_else(none),
            row.size.map_or_else(none, |size| format!("{} {}", significant(size), row.unit.unwrap_or_default())),
        ]
    };
    let header = ["log", "rows", "judged, %", "alarms", "first at, s", "named", "size"];
    TextTable::new("Logs, with the first alarm of each", header).with_rows(rows.into_iter().take(most).map(row))
}
