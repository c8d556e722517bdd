//! What the audits found, for people at a terminal.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, LineStyle, Table as Drawn, TableStyle};

use super::budgets::Judged;
use super::command::Outcome;
use super::report::{Report, Table};

/// Longer names are cut: the linker's names of generic functions fill lines.
const LONGEST_CELL: usize = 72;

/// Everything, in the order of the audits; budgets and faults last, where a terminal shows them.
#[must_use]
pub(super) fn outcome(outcome: &Outcome) -> String {
    let mut text = String::new();
    for report in &outcome.reports {
        text += &of_report(report);
    }
    if !outcome.figures.is_empty() {
        let compiler = outcome.compiler.as_deref().unwrap_or("an unknown compiler");
        text += &shown(&budgets(&format!("Figures against their budgets, built by {compiler}"), &outcome.figures));
    }
    let faults: Vec<String> = outcome.reports.iter().flat_map(|report| report.faults.clone()).collect();
    for fault in &faults {
        let _ = writeln!(text, "fault: {fault}");
    }
    for figure in outcome.remarkable() {
        let word = if figure.standing.fails() { "fault" } else { "note" };
        let _ = writeln!(text, "{word}: {} {}{}", figure.name, figure.standing.words(), measured(figure));
    }
    let verdict = if outcome.passed { "The audits pass" } else { "The audits do not pass" };
    let _ = writeln!(text, "{verdict}. Nothing here ran on silicon.");
    text
}

fn of_report(report: &Report) -> String {
    let mut text = format!("== {}\n", report.title);
    for table in &report.tables {
        text += &shown(table);
    }
    for note in &report.notes {
        let _ = writeln!(text, "note: {note}");
    }
    for blind in &report.blind_spots {
        let _ = writeln!(text, "not seen: {blind}");
    }
    text + "\n"
}

fn measured(figure: &Judged) -> String {
    match (figure.value, &figure.budget) {
        (Some(value), Some(budget)) => {
            format!(": {value} {} (accepted {}, limit {}: {})", figure.unit, budget.figure, budget.limit, budget.reason)
        }
        (Some(value), None) => format!(
            "\n    \"{}\" = {{ figure = {value}, limit = {value}, unit = \"{}\", reason = \"\" }}",
            figure.name, figure.unit
        ),
        _ => String::new(),
    }
}

fn budgets(caption: &str, figures: &[Judged]) -> Table {
    let mut table = Table::new(caption, &["", "measured", "accepted", "limit", "unit", ""]);
    for figure in figures {
        let of_budget = |number: fn(&super::budgets::Budget) -> u64| {
            figure.budget.as_ref().map_or_else(String::new, |budget| number(budget).to_string())
        };
        table.row([
            figure.name.clone(),
            figure.value.map_or_else(String::new, |value| value.to_string()),
            of_budget(|budget| budget.figure),
            of_budget(|budget| budget.limit),
            figure.unit.clone(),
            figure.standing.words().to_owned(),
        ]);
    }
    table
}

fn shown(table: &Table) -> String {
    let mut drawn = Drawn::new();
    // A line under the header is enough: numbers need no boxes.
    drawn.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
    drawn.set_header(&table.header);
    let is_number = |cell: &String| !cell.is_empty() && cell.chars().all(|c| c.is_ascii_digit());
    for row in &table.rows {
        drawn.add_row(row.iter().map(|cell| cut(cell)));
    }
    for (place, column) in drawn.column_iter_mut().enumerate() {
        if table.rows.iter().filter_map(|row| row.get(place)).any(is_number) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{}\n{drawn}\n\n", table.caption)
}

fn cut(cell: &str) -> String {
    if cell.chars().count() <= LONGEST_CELL {
        return cell.to_owned();
    }
    // The end of a path tells more than its start.
    let kept: Vec<char> = cell.chars().rev().take(LONGEST_CELL - 1).collect();
    ['…'].into_iter().chain(kept.into_iter().rev()).collect()
}
