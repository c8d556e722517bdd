//! One log in the summary.

use serde::Serialize;
use serde::ser::SerializeMap;

use crate::names::ChannelNames;
use crate::record::PhaseCounts;
use crate::replay::ReplayError;
use crate::replay::guard::GuardReplayReport;
use crate::replay::paper::ReplayReport;

/// What came of one log. What is not known of it is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The log.
    pub file: String,
    /// Which monitor judged.
    pub mode: &'static str,
    /// Rows of the log.
    pub rows: Option<u64>,
    /// Rows per second.
    pub rate_hz: f64,
    /// Rows with a value that is not finite.
    pub skipped: Option<u64>,
    /// Samples learned from; not known of a log that was judged by stored models.
    pub learned: Option<u64>,
    /// Share of the samples learned from of which a reading was clipped.
    pub clipped_share: Option<f64>,
    /// Largest over smallest eigenvalue of the correlation matrix.
    pub condition_number: Option<f64>,
    /// Largest movement of a channel's mean over the learning window, in its sigmas.
    pub half_shift_sigma: Option<f64>,
    /// How much larger the slow scale's variance is than that of noise without memory.
    pub slow_variance_ratio: Option<f64>,
    /// Share of the rows behind the learning window that were judged.
    pub covered_share: Option<f64>,
    /// Alarms.
    pub alarms: Option<u64>,
    /// When the first of them was raised, s from the first row.
    pub first_alarm_s: Option<f64>,
    /// What the first of them was called.
    pub name: Option<String>,
    /// How large that is, in `unit`.
    pub size: Option<f64>,
    /// Unit of size and sigma.
    pub unit: Option<&'static str>,
    /// Standard deviation of the size, by noise.
    pub sigma: Option<f64>,
    /// Why the log was refused.
    pub error: Option<String>,
}

/// What a column of the summary holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text.
    Text,
    /// A whole number.
    Whole,
    /// A number.
    Real,
}

/// A value of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// See [`Kind::Text`].
    Text(Option<String>),
    /// See [`Kind::Whole`].
    Whole(Option<i64>),
    /// See [`Kind::Real`]; finite.
    Real(Option<f64>),
}

/// Names of the columns, and what they hold.
pub const COLUMNS: [(&str, Kind); 18] = [
    ("file", Kind::Text),
    ("mode", Kind::Text),
    ("rows", Kind::Whole),
    ("rate_hz", Kind::Real),
    ("skipped", Kind::Whole),
    ("learned", Kind::Whole),
    ("clipped_share", Kind::Real),
    ("condition_number", Kind::Real),
    ("half_shift_sigma", Kind::Real),
    ("slow_variance_ratio", Kind::Real),
    ("covered_share", Kind::Real),
    ("alarms", Kind::Whole),
    ("first_alarm_s", Kind::Real),
    ("name", Kind::Text),
    ("size", Kind::Real),
    ("unit", Kind::Text),
    ("sigma", Kind::Real),
    ("error", Kind::Text),
];

impl Row {
    /// A log that was judged in `guard` mode.
    #[must_use]
    pub fn of_guard(file: String, report: &GuardReplayReport) -> Self {
        let (quality, first) = (report.learned.quality, report.alarms.first());
        let size = first.and_then(|alarm| alarm.size);
        Row {
            file,
            mode: report.mode,
            rows: Some(report.samples),
            rate_hz: report.rate_hz,
            skipped: Some(report.skipped),
            learned: quality.map(|quality| quality.samples.into()),
            clipped_share: quality.map(|quality| quality.clipped_share),
            condition_number: quality.map(|quality| quality.condition_number),
            half_shift_sigma: quality.map(|quality| quality.half_shift_sigma),
            slow_variance_ratio: quality.map(|quality| quality.slow_variance_ratio),
            covered_share: covered(report.coverage.phases, report.coverage.withheld),
            alarms: Some(report.alarms.len() as u64),
            first_alarm_s: first.map(|alarm| alarm.start_s),
            name: first.filter(|alarm| alarm.located.is_some()).map(|alarm| alarm.located_as()),
            size: size.map(|size| size.value),
            unit: size.map(|size| size.unit),
            sigma: size.map(|size| size.sigma),
            error: None,
        }
    }

    /// A log that was judged in `paper` mode, which gives faults no size.
    #[must_use]
    pub fn of_paper(file: String, report: &ReplayReport, names: &ChannelNames) -> Self {
        let (quality, first) = (&report.learned.quality, report.alarms.first());
        Row {
            file,
            mode: report.mode,
            rows: Some(report.samples),
            rate_hz: report.rate_hz,
            skipped: Some(report.skipped),
            learned: Some(report.learned.n.into()),
            condition_number: quality.condition_number,
            covered_share: covered(report.coverage, 0),
            alarms: Some(report.alarms.len() as u64),
            first_alarm_s: first.map(|alarm| alarm.start_s),
            name: first.and_then(|alarm| alarm.located.as_ref()).map(|id| names.located(id)),
            ..Row::default()
        }
    }

    /// A log that was refused.
    #[must_use]
    pub fn refused(file: String, mode: &'static str, rate_hz: f64, error: &ReplayError) -> Self {
        Row { file, mode, rate_hz, error: Some(error.to_string()), ..Row::default() }
    }

    /// The values, in the order of [`COLUMNS`].
    #[must_use]
    pub fn cells(&self) -> [Cell; COLUMNS.len()] {
        let text = |text: Option<&str>| Cell::Text(text.map(str::to_owned));
        let whole = |number: Option<u64>| Cell::Whole(number.and_then(|number| i64::try_from(number).ok()));
        let real = |number: Option<f64>| Cell::Real(number.filter(|number| number.is_finite()));
        [
            text(Some(&self.file)),
            text(Some(self.mode)),
            whole(self.rows),
            real(Some(self.rate_hz)),
            whole(self.skipped),
            whole(self.learned),
            real(self.clipped_share),
            real(self.condition_number),
            real(self.half_shift_sigma),
            real(self.slow_variance_ratio),
            real(self.covered_share),
            whole(self.alarms),
            real(self.first_alarm_s),
            text(self.name.as_deref()),
            real(self.size),
            text(self.unit),
            real(self.sigma),
            text(self.error.as_deref()),
        ]
    }
}

fn covered(PhaseCounts { settling, learning, monitoring }: PhaseCounts, withheld: u64) -> Option<f64> {
    let behind = settling + learning + monitoring + withheld;
    (behind > 0).then(|| monitoring as f64 / behind as f64)
}

impl Serialize for Row {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(COLUMNS.len()))?;
        for ((name, _), cell) in COLUMNS.iter().zip(self.cells()) {
            match cell {
                Cell::Text(text) => map.serialize_entry(name, &text)?,
                Cell::Whole(number) => map.serialize_entry(name, &number)?,
                Cell::Real(number) => map.serialize_entry(name, &number)?,
            }
        }
        map.end()
    }
}
