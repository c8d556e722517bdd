//! The page of tuning: the trade-off as a picture, and the thresholds that are recommended.

use super::{Tune, TuneReport};
use crate::chart::{Axis, Line, line_chart};
use crate::names::located;
use crate::page::{Block, Page, Section};
use crate::tables;

/// The page.
#[must_use]
pub fn page(tune: &Tune, report: &TuneReport) -> String {
    let thresholds = report.settings.to_toml().unwrap_or_default();
    let scenario = toml::to_string(&tune.scenario).unwrap_or_default();
    let sections = vec![
        Section::new("Trade-off", vec![trade_off(tune, report), tables::sweep(report, tune.margin).into_block()]),
        Section::new("Recommended thresholds", vec![tables::thresholds(report).into_block()]),
        Section::new(
            "Configuration",
            vec![
                Block::Verbatim { caption: "Thresholds, as --limits takes them".to_owned(), text: thresholds },
                Block::Verbatim { caption: "Scenario".to_owned(), text: scenario },
            ],
        ),
    ];
    let title = format!("Thruster fault monitor: thresholds for \"{}\"", tune.scenario.name);
    let footer = format!("monitor-sim {}. A simulated motor; nothing here ran on silicon.", env!("CARGO_PKG_VERSION"));
    Page { title, summary: summary(tune, report), sections, footer }.to_html()
}

fn summary(tune: &Tune, report: &TuneReport) -> String {
    let recommended = format!("Recommended: {} times the largest fault-free residual.", tune.margin);
    let swept = report.sweep.iter().find(|row| row.is_at(tune.margin));
    let fared = swept.map(|row| format!(" {} false alarms in {:.2} h of fresh noise.", row.false_alarms, report.hours));
    let hidden = match report.not_separated.as_slice() {
        [] => " Every borderline fault lies above its threshold.".to_owned(),
        models => format!(" Borderline faults are not all above the threshold of {}.", models.join(", ")),
    };
    recommended + &fared.unwrap_or_default() + &hidden
}

/// False alarms against delay: a line for each fault, through the margins of the sweep.
fn trade_off(tune: &Tune, report: &TuneReport) -> Block {
    let faults = report.sweep.first().map_or(&[][..], |row| &row.faults);
    let line = |(k, id): (usize, &str)| {
        let of_fault = |row: &super::SweepRow| Some((row.faults.get(k)?.worst_delay_s?, row.false_alarms_per_hour));
        let seen = report.sweep.iter().filter_map(|row| Some((row.is_at(tune.margin), of_fault(row)?)));
        let (at_margin, points): (Vec<bool>, Vec<(f64, f64)>) = seen.unzip();
        Line { name: located(id), points, bound: false, ringed: at_margin.iter().position(|at| *at) }
    };
    let lines: Vec<Line> = faults.iter().map(|fault| fault.id.as_str()).enumerate().map(line).collect();
    let x = Axis { name: "longest delay, s", log: true };
    let y = Axis { name: "false alarms an hour", log: true };
    let caption = format!(
        "False alarms against the longest delay at {:.0} % of the size, at margins that grow along each line; the margin {} is \
         ringed. Points at the lower edge had no false alarm; margins at which a fault was missed have no point.",
        100.0 * tune.borderline_size,
        tune.margin
    );
    Block::Figure { caption, pictures: vec![line_chart(&lines, x, y)] }
}
