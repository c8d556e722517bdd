//! Results of `guard` mode as tables of text.

use monitor_core::guard::SCALES;

use super::{TextTable, about, found_at, shown, significant, time};
use crate::guardian::SCALE_NAMES;
use crate::guardian::summary::{ScaleLimits, WindowQuality};
use crate::intervals::Interval;
use crate::mission::guard::{Flight, GuardReport, RampRow};
use crate::names::ChannelNames;
use crate::replay::guard::{Alarm, Learned};
use crate::score::guard::FaultScore;

/// The tables of a mission.
#[must_use]
pub fn of_mission(report: &GuardReport) -> Vec<TextTable> {
    vec![
        times("Faults: seconds from the fault's start, and behind its end", &report.faults),
        names("Names: which stood longest, when the right one first stood, for how much of the time", &report.faults),
        ramps(report),
        times("Times again, with a load of the same torque that grows with speed", &report.speed_dependent_load),
        names("Names again, with that load", &report.speed_dependent_load),
        limits(&report.limits, &report.settings.time_constants_s),
    ]
}

fn injected(row: &FaultScore) -> String {
    format!("{} {}", row.id, row.fault)
}

fn times(caption: &str, rows: &[FaultScore]) -> TextTable {
    let row = |row: &FaultScore| {
        let since = |t_s: Option<f64>, from_s: f64, none: &str| {
            t_s.map_or_else(|| none.to_owned(), |t_s| found_at((t_s - from_s).max(0.0)))
        };
        let never = if row.detected_s.is_some() { "never" } else { "-" };
        [
            injected(row),
            time(row.start_s),
            since(row.detected_s, row.start_s, "missed"),
            time(row.end_s),
            found_at(row.recovered_s - row.end_s),
            since(row.cleared_s, row.end_s, never),
            since(row.cleared_s, row.recovered_s, never),
        ]
    };
    let header = ["", "starts", "detected after", "ends", "loop back after", "cleared after", "behind the loop"];
    TextTable::new(caption, header).with_rows(rows.iter().map(row))
}

fn names(caption: &str, rows: &[FaultScore]) -> TextTable {
    let row = |row: &FaultScore| {
        let name = match (&row.located, row.located_as) {
            (Some(id), Some(words)) if id != words => format!("{id} {words}"),
            (Some(id), _) => id.clone(),
            _ => "-".to_owned(),
        };
        let size = row.size.zip(row.size_sigma).zip(row.size_unit);
        [
            injected(row),
            name,
            row.located_s.map_or_else(|| "never".to_owned(), |t_s| found_at(t_s - row.start_s)),
            row.located_share.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share)),
            size.map_or_else(|| "-".to_owned(), |((size, _), unit)| format!("{} {unit}", significant(size))),
            size.map_or_else(|| "-".to_owned(), |((_, sigma), _)| about(sigma)),
        ]
    };
    let header = ["", "named", "right after", "right for", "size", "its sigma"];
    TextTable::new(caption, header).with_rows(rows.iter().map(row))
}

fn ramps(report: &GuardReport) -> TextTable {
    let fault = |id: &str| report.faults.iter().find(|row| row.id == id).map_or_else(|| id.to_owned(), injected);
    let row = |row: &RampRow| {
        let value = row.value_at_detection.map_or_else(|| "missed".to_owned(), significant);
        [fault(&row.id), value, significant(row.amplitude), row.unit.to_owned()]
    };
    TextTable::new("Ramps: value of the fault when it is detected", ["", "detected at", "full size", "unit"])
        .with_rows(report.ramp.iter().map(row))
}

/// The time scales.
#[must_use]
pub fn limits(limits: &ScaleLimits, time_constants_s: &[f32; SCALES]) -> TextTable {
    let limits = [limits.fast, limits.middle, limits.slow, limits.trend];
    let rows = SCALE_NAMES.into_iter().zip(time_constants_s).zip(limits);
    let row = |((name, time_s), limit): ((&str, &f32), f64)| {
        [name.to_owned(), significant(f64::from(*time_s)), shown(limit.is_finite().then_some(limit))]
    };
    let title = if limits.iter().all(|limit| limit.is_finite()) {
        "Time scales, with their limits as sharp as they were at the end"
    } else {
        "Time scales; at the end no set point was judged, so no limit stands"
    };
    TextTable::new(title, ["", "time constant, s", "limit"]).with_rows(rows.map(row))
}

/// What a learning window was like; without a row if models were stored.
#[must_use]
pub fn quality(quality: &Option<WindowQuality>) -> TextTable {
    let row = |quality: &WindowQuality| {
        [
            quality.samples.to_string(),
            format!("{:.2} %", 100.0 * quality.clipped_share),
            significant(quality.condition_number),
            format!("{:.2} sigma", quality.half_shift_sigma),
            significant(quality.slow_variance_ratio),
        ]
    };
    let header = ["samples", "clipped", "condition number", "moved by", "memory of the noise (1: none)"];
    TextTable::new("The learning window", header).with_rows(quality.iter().map(row))
}

/// What happened in a flight, in order, the first `most`.
#[must_use]
pub fn events(flight: &Flight, most: usize) -> TextTable {
    let outputs = &flight.recording.outputs;
    let both = |intervals: Vec<Interval>, begins: String, ends: String| {
        intervals.into_iter().flat_map(move |at| [(at.start, begins.clone()), (at.end, ends.clone())])
    };
    let mut all: Vec<(u64, String)> =
        both(outputs.alarm.all(), "alarm raised".to_owned(), "alarm withdrawn".to_owned()).collect();
    for (name, stood) in outputs.names() {
        let name = name.shown();
        all.extend(both(stood, format!("named: {name}"), format!("no longer named: {name}")));
    }
    all.extend(both(outputs.recovering.all(), "the loop recovers".to_owned(), "the loop has recovered".to_owned()));
    all.sort_by_key(|(at, _)| *at);
    let count = all.len();
    let caption = if count > most { format!("The first {most} events of {count}") } else { "All events".to_owned() };
    let instants: Vec<f64> = all.iter().map(|(at, _)| flight.recording.signals.seconds(*at)).collect();
    let row = |((_, what), t_s): ((u64, String), &f64)| [found_at(*t_s), what];
    let rows = all.into_iter().zip(&instants).take(most).map(row);
    TextTable::new(caption, ["at, s", "event"]).with_rows(rows).at(instants)
}

/// What a replay learned of each channel.
#[must_use]
pub fn learned(learned: &Learned, names: &ChannelNames) -> TextTable {
    let caption = match learned.quality {
        Some(_) => format!("Learned from rows {} to {}", learned.start_row, learned.end_row.saturating_sub(1)),
        None => "Learned before, of the first set point that was judged".to_owned(),
    };
    let of = names.0.iter().zip(learned.mean).zip(learned.sigma);
    let row = |((name, mean), sigma): ((&String, f64), f64)| [name.clone(), significant(mean), significant(sigma)];
    TextTable::new(caption, ["", "mean", "sigma"]).with_rows(of.map(row))
}

/// The first `most` alarms of a replay.
#[must_use]
pub fn alarms(alarms: &[Alarm], names: &ChannelNames, most: usize) -> TextTable {
    let [a, b, c] = names.0.each_ref().map(|name| format!("{name}, %"));
    let caption = format!("Alarms: {} (with the share of each channel in the deviation)", alarms.len());
    let header = ["rows", "seconds", "named", "size", "peak / limit", "scale", &a, &b, &c];
    let row = |alarm: &Alarm| {
        let end = if alarm.ongoing { "end".to_owned() } else { alarm.end_row.to_string() };
        let [a, b, c] = match alarm.contributions {
            Some(shares) => shares.map(|share| format!("{:.0}", 100.0 * share)),
            None => ["-"; 3].map(str::to_owned),
        };
        let lost = if alarm.lost.is_empty() { String::new() } else { format!(" ({})", alarm.lost.join(", ")) };
        [
            format!("{}..{end}", alarm.start_row),
            format!("{:.2}..{:.2}", alarm.start_s, alarm.end_s),
            format!("{}{lost}", alarm.located_as()),
            alarm.size.map_or_else(|| "-".to_owned(), |size| format!("{} {}", significant(size.value), size.unit)),
            alarm.peak.map_or_else(|| "-".to_owned(), significant),
            alarm.peak_scale.unwrap_or("-").to_owned(),
            a,
            b,
            c,
        ]
    };
    TextTable::new(caption, header)
        .with_rows(alarms.iter().take(most).map(row))
        .at(alarms.iter().map(|alarm| alarm.start_s))
}
