//! The page of a replay: the recorded channels; each mode adds what it makes of them.

use crate::chart::{Band, Picture, Series, TimeAxis, TimeChart, time_chart};
use crate::envelope::Envelope;
use crate::log::ColumnRef;
use crate::page::Block;
use crate::record::Signals;
use crate::replay::Source;

pub mod guard;
pub mod paper;

/// More alarms than this are counted, not listed; the JSON document has them all.
const LISTED_ALARMS: usize = 200;

fn figure(caption: &str, pictures: Vec<Picture>) -> Block {
    Block::Figure { caption: caption.to_owned(), pictures }
}

/// How the log was read, in the words of the command line.
fn how_it_was_read(source: &Source) -> Block {
    let channel = |(name, column): &(String, ColumnRef)| format!("--channel {name}={column}");
    let set_point = source.set_point.iter().map(|column| format!("--set-point {column}"));
    let injections = source.injections.iter().map(|injection| format!("--inject {injection}"));
    let given = [source.path.display().to_string(), format!("--rate-hz {}", source.rate_hz)].into_iter();
    let lines: Vec<String> =
        given.chain(source.channels.iter().map(channel)).chain(set_point).chain(injections).collect();
    Block::Verbatim { caption: "Log".to_owned(), text: lines.join("\n") }
}

/// The axis of a log, with what was learned from and what was added to it.
fn axis(source: &Source, signals: &Signals, window: Option<(u64, u64)>) -> TimeAxis {
    let end = signals.seconds(signals.samples);
    let learning = window.map(|(start, end)| Band {
        from: signals.seconds(start),
        to: signals.seconds(end),
        label: "learning".to_owned(),
    });
    let injected = source.injections.iter().map(|injection| Band {
        from: signals.seconds(injection.first_row()),
        to: injection.end_row().map_or(end, |row| signals.seconds(row)),
        label: injection.to_string(),
    });
    let scaled_from = window.map_or(0.0, |(start, _)| signals.seconds(start));
    let bands = learning.into_iter().chain(injected).collect();
    TimeAxis { range: (0.0, end), scaled_from, bands, shaded: "learning window or injected fault" }
}

/// The set point, if it was recorded, and the three channels.
fn channels(source: &Source, signals: &Signals, axis: &TimeAxis) -> Vec<Picture> {
    let mut pictures = Vec::new();
    if source.set_point.is_some() {
        pictures.push(signal("set point", &signals.set_point, true, axis));
    }
    for (k, (name, envelope)) in source.names().0.iter().zip(&signals.channels).enumerate() {
        pictures.push(signal(name, envelope, k < 2, axis));
    }
    pictures
}

fn signal(name: &str, signal: &Envelope, stacked: bool, axis: &TimeAxis) -> Picture {
    let series = vec![Series { name, signal }];
    time_chart(&TimeChart { name, unit: "", log_y: false, series, limits: vec![], stacked }, axis).without_series()
}
