//! Results as tables of text, for the terminal and for the page alike.

use monitor_core::paper::event::Event;
use monitor_core::sample::ModelId;

use crate::mission::paper::{MissionReport, RampRow};
use crate::names::{self, ByModel, ChannelNames, located};
use crate::page::Block;
use crate::paper::{self, PaperRow, RAMP_VALUES, TABLE_1, TABLE_2};
use crate::replay::paper::{Alarm, Learned, Quality};
use crate::score::{FaultScore, Method};
use crate::settings::FoundBy;
use crate::tune::{SweepRow, TuneReport};

pub mod fleet;
pub mod guard;

/// A table of text. The first column names its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    /// What it shows.
    pub caption: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Its cells.
    pub rows: Vec<Vec<String>>,
    /// When what its rows tell of began, s; none if it has no time.
    pub instants: Vec<f64>,
}

impl TextTable {
    pub(crate) fn new<'a>(caption: impl Into<String>, header: impl IntoIterator<Item = &'a str>) -> Self {
        let header = header.into_iter().map(str::to_owned).collect();
        TextTable { caption: caption.into(), header, rows: Vec::new(), instants: Vec::new() }
    }

    pub(crate) fn with_rows<const N: usize>(mut self, rows: impl IntoIterator<Item = [String; N]>) -> Self {
        self.rows.extend(rows.into_iter().map(Vec::from));
        self
    }

    /// Says when the rows were, s.
    fn at(mut self, instants: impl IntoIterator<Item = f64>) -> Self {
        self.instants = instants.into_iter().take(self.rows.len()).collect();
        self
    }

    /// The table as a piece of a page.
    #[must_use]
    pub fn into_block(self) -> Block {
        Block::Table { caption: self.caption, header: self.header, rows: self.rows, instants: self.instants }
    }
}

/// The tables of a mission, in the paper's order.
#[must_use]
pub fn of_mission(report: &MissionReport) -> Vec<TextTable> {
    let rows = |method| report.faults.iter().filter(move |f| f.method == method);
    vec![
        components(&report.explained, &report.retained, &ChannelNames::motor()),
        table_1(rows(Method::Pca)),
        table_2("Table 2. PPCA: times in s, the paper's Table 2 in brackets", rows(Method::Ppca), true),
        ramps(report),
        table_2(
            "Table 2 again, with a load of the same torque that grows with speed",
            report.speed_dependent_load.iter(),
            false,
        ),
    ]
}

/// The first `most` events of a flight.
#[must_use]
pub fn events(events: &[Event], rate_hz: f64, most: usize) -> TextTable {
    let at = |event: &Event| event.sample as f64 / rate_hz;
    let row = |event: &Event| [found_at(at(event)), names::event(event.kind)];
    let more = events.len().saturating_sub(most);
    let caption =
        if more > 0 { format!("The first {most} events of {}", events.len()) } else { "All events".to_owned() };
    TextTable::new(caption, ["at, s", "event"]).with_rows(events.iter().take(most).map(row)).at(events.iter().map(at))
}

/// Figures 5 and 8 as a table.
#[must_use]
pub fn components(explained: &ByModel<Vec<f64>>, retained: &ByModel<usize>, names: &ChannelNames) -> TextTable {
    let header = ["", "PC 1", "PC 2", "PC 3", "retained"];
    let row = |model| {
        let share = |k: usize| explained.get(model).get(k).map_or_else(String::new, |e| format!("{:.1}", 100.0 * e));
        [names.model(model), share(0), share(1), share(2), retained.get(model).to_string()]
    };
    TextTable::new("Explained variance of each principal component, %", header).with_rows(ModelId::ALL.map(row))
}

fn table_1<'a>(rows: impl Iterator<Item = &'a FaultScore>) -> TextTable {
    let row = |row: &FaultScore| {
        let paper = paper::counterpart(&TABLE_1, &row.id, row.start_s);
        [located(&row.id), time(row.start_s), detected(row, paper), time(row.end_s), cleared(row, paper)]
    };
    let caption = "Table 1. PCA: times in s, the paper's Table 1 in brackets";
    TextTable::new(caption, ["", "START", "DETECTED", "END", "DETECT. END"]).with_rows(rows.map(row))
}

fn table_2<'a>(caption: &str, rows: impl Iterator<Item = &'a FaultScore>, beside_paper: bool) -> TextTable {
    let header = ["", "START", "DETECTED", "END", "DETECT. END", "LOCATED AS", "RIGHT FROM", "RIGHT FOR"];
    let row = |row: &FaultScore| {
        let paper = paper::counterpart(&TABLE_2, &row.id, row.start_s).filter(|_| beside_paper);
        [
            located(&row.id),
            time(row.start_s),
            detected(row, paper),
            time(row.end_s),
            cleared(row, paper),
            row.located.as_deref().map_or_else(|| "-".to_owned(), located),
            row.located_s.map_or_else(|| "never".to_owned(), found_at),
            format!("{:.1} %", 100.0 * row.located_share.unwrap_or_default()),
        ]
    };
    TextTable::new(caption, header).with_rows(rows.map(row))
}

fn detected(row: &FaultScore, paper: Option<PaperRow>) -> String {
    beside(row.detected_s, "missed", paper.map(|p| p.detected_s))
}

fn cleared(row: &FaultScore, paper: Option<PaperRow>) -> String {
    let never = if row.detected_s.is_some() { "not cleared" } else { "-" };
    beside(row.cleared_s, never, paper.map(|p| p.cleared_s))
}

fn beside(ours: Option<f64>, absent: &str, paper: Option<f64>) -> String {
    let ours = ours.map_or_else(|| absent.to_owned(), found_at);
    paper.map_or_else(|| ours.clone(), |paper| format!("{ours} ({paper:.2})"))
}

fn ramps(report: &MissionReport) -> TextTable {
    let row = |row: &RampRow| {
        let value = |v: Option<f64>| v.map_or_else(|| "missed".to_owned(), significant);
        let paper = RAMP_VALUES.iter().find(|(id, _)| *id == row.id).map_or_else(String::new, |(_, v)| v.to_string());
        let [ppca, pca] = [row.value_at_detection, row.value_at_detection_pca].map(value);
        [located(&row.id), ppca, pca, significant(row.amplitude), row.unit.to_owned(), paper]
    };
    let caption = "Ramps: value of the fault when it is detected (the paper, III.C, gives no units)";
    TextTable::new(caption, ["", "PPCA", "PCA", "full size", "unit", "the paper"])
        .with_rows(report.ramp.iter().map(row))
}

/// What a replay learned of each channel.
#[must_use]
pub fn learned(learned: &Learned, names: &ChannelNames) -> TextTable {
    let rows = learned.start_row.zip(learned.end_row).map(|(start, end)| format!("rows {start} to {}", end - 1));
    let caption = match rows {
        Some(rows) => format!("Learned from {} samples, {rows}", learned.n),
        None => format!("A stored baseline, learned from {} samples", learned.n),
    };
    let Quality { half_shift_sigma, largest_deviation_sigma, .. } = &learned.quality;
    let row = |k: usize, name: &String| {
        let of = |values: &[f64; 3]| values.get(k).copied().unwrap_or(f64::NAN);
        [
            name.clone(),
            significant(of(&learned.mean)),
            significant(of(&learned.sigma)),
            half_shift_sigma.as_ref().map_or_else(|| "-".to_owned(), |shift| format!("{:+.2}", of(shift))),
            largest_deviation_sigma.as_ref().map_or_else(|| "-".to_owned(), |furthest| format!("{:.1}", of(furthest))),
        ]
    };
    let rows = names.0.iter().enumerate().map(|(k, name)| row(k, name));
    TextTable::new(caption, ["", "mean", "sigma", "shift, sigma", "furthest, sigma"]).with_rows(rows)
}

/// The first `most` alarms of a replay.
#[must_use]
pub fn alarms(alarms: &[Alarm], names: &ChannelNames, most: usize) -> TextTable {
    let [a, b, c] = names.0.each_ref().map(|name| format!("{name}, %"));
    let caption = format!("Alarms: {} (with the share of each channel in T2 at the peak)", alarms.len());
    let header = ["rows", "seconds", "located as", "peak / limit", &a, &b, &c];
    let row = |alarm: &Alarm| {
        let end = if alarm.ongoing { "end".to_owned() } else { alarm.end_row.to_string() };
        let [a, b, c] = alarm.contributions.map(|share| format!("{:.0}", 100.0 * share));
        let rows = format!("{}..{end}", alarm.start_row);
        let seconds = format!("{:.2}..{:.2}", alarm.start_s, alarm.end_s);
        let name = alarm.located.as_deref().map_or_else(|| "-".to_owned(), |id| names.located(id));
        [rows, seconds, name, significant(alarm.peak), a, b, c]
    };
    TextTable::new(caption, header)
        .with_rows(alarms.iter().take(most).map(row))
        .at(alarms.iter().map(|alarm| alarm.start_s))
}

/// The thresholds that tuning found, and what stands on either side of them.
#[must_use]
pub fn thresholds(report: &TuneReport) -> TextTable {
    let header = ["", "largest fault-free", "threshold", "smallest under a borderline fault"];
    let row = |model| {
        let of = |pick: fn(&FoundBy) -> &ByModel<f64>| {
            report.settings.found_by.as_ref().map_or(f64::NAN, |found| *pick(found).get(model))
        };
        [
            ChannelNames::motor().model(model),
            format!("{:.3}", of(|f| &f.largest_fault_free)),
            format!("{:.3}", report.settings.thresholds.get(model)),
            format!("{:.2}", of(|f| &f.smallest_borderline)),
        ]
    };
    TextTable::new("Residuals, in units of the mean T2 in control", header).with_rows(ModelId::ALL.map(row))
}

/// The trade-off between false alarms and delay; the chosen margin is marked.
#[must_use]
pub fn sweep(report: &TuneReport, chosen: f64) -> TextTable {
    let ids: Vec<&str> =
        report.sweep.first().map(|row| row.faults.iter().map(|f| f.id.as_str()).collect()).unwrap_or_default();
    let of_fault: Vec<String> =
        ids.iter().flat_map(|id| [format!("{id} delay, s"), format!("{id} named, %")]).collect();
    let header = ["margin", "false alarms", "per hour"].into_iter().chain(of_fault.iter().map(String::as_str));
    let caption =
        format!("Trade-off on fresh seeds, {:.2} h fault-free: false alarms against the longest delay", report.hours);
    let mut table = TextTable::new(caption, header);
    table.rows.extend(report.sweep.iter().map(|row| sweep_row(row, chosen)));
    table
}

fn sweep_row(row: &SweepRow, chosen: f64) -> Vec<String> {
    let mark = if row.is_at(chosen) { " *" } else { "" };
    let fixed =
        [format!("{}{mark}", row.margin), row.false_alarms.to_string(), format!("{:.1}", row.false_alarms_per_hour)];
    let of_faults = row.faults.iter().flat_map(|fault| {
        let missed = || format!("missed {}/{}", fault.runs - fault.detected, fault.runs);
        let delay = fault.worst_delay_s.map_or_else(missed, |delay| format!("{delay:.3}"));
        [delay, format!("{:.1}", 100.0 * fault.right_name_share)]
    });
    fixed.into_iter().chain(of_faults).collect()
}

/// An instant we found, to the sample of a 1 kHz log.
fn found_at(seconds: f64) -> String {
    format!("{seconds:.3}")
}

fn time(seconds: f64) -> String {
    format!("{seconds:.2}")
}

/// Four significant digits, without an exponent where a person would not write one.
#[must_use]
pub fn significant(value: f64) -> String {
    to_digits(value, 4)
}

/// The same to two digits, for what is an estimate itself.
#[must_use]
pub fn about(value: f64) -> String {
    to_digits(value, 2)
}

fn to_digits(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    // Of what is shown: 9.9996 is 10.00.
    let rounded = format!("{value:.*e}", (digits - 1) as usize);
    match rounded.rsplit_once('e').and_then(|(_, magnitude)| magnitude.parse::<i32>().ok()) {
        Some(magnitude @ -5..6) => format!("{value:.*}", (digits - 1 - magnitude).max(0) as usize),
        _ => rounded,
    }
}

/// A number for a table; a dash where there is none.
#[must_use]
pub fn shown(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), significant)
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_are_shown_with_four_digits_and_an_exponent_only_where_it_helps() {
        let shown = [0.0, 300.0012, 0.0231779, -9.65391, 9.99996, 1_234_567.0, 1.2e-7].map(significant);
        assert_eq!(shown, ["0", "300.0", "0.02318", "-9.654", "10.00", "1.235e6", "1.200e-7"]);
    }
}
