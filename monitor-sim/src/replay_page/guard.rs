//! The page of a replay in `guard` mode: what was found and learned, the channels, the distances.

use std::iter;

use super::{LISTED_ALARMS, axis, channels, figure, how_it_was_read};
use crate::mission_page::contributions;
use crate::mission_page::guard::{severities, timeline};
use crate::page::{Block, Page, Section};
use crate::replay::guard::{Replay, Replayed};
use crate::tables::guard as tables;

/// The page of a replay.
#[must_use]
pub fn page(replay: &Replay, replayed: &Replayed) -> String {
    let Replayed { report, recording, names } = replayed;
    let axis = axis(&replay.source, &recording.signals, Some((report.learned.start_row, report.learned.end_row)));
    let found = match report.alarms.len() {
        0 => "No fault found".to_owned(),
        1 => "1 alarm".to_owned(),
        n => format!("{n} alarms"),
    };
    let summary = format!("{found} in {} rows at {} Hz. {}", report.samples, report.rate_hz, replayed.coverage());
    let mut learned = vec![tables::learned(&report.learned, names).into_block()];
    learned.extend(replayed.remarks().into_iter().map(Block::Paragraph));
    learned.push(tables::quality(&report.learned.quality).into_block());
    learned.push(tables::limits(&report.limits, &report.settings.time_constants_s).into_block());
    let channels = channels(&replay.source, &recording.signals, &axis);
    let mut watched = severities(recording, &axis);
    watched.push(timeline(recording, report.rate_hz, &[], &axis));
    let shares = report.alarms.iter().filter_map(|alarm| Some((alarm.start_s, alarm.contributions?)));
    let listed = tables::alarms(&report.alarms, names, LISTED_ALARMS).into_block();
    let alarms = iter::once(listed).chain(contributions(shares, names)).collect();
    let settings = toml::to_string(&report.settings).unwrap_or_default();
    let sections = vec![
        Section::new("Alarms", alarms),
        Section::new("Learned", learned),
        Section::new(
            "Channels",
            vec![figure("The recorded channels, with the faults that were added to them.", channels)],
        ),
        Section::new(
            "Distances, alarms and names",
            vec![figure(
                "The distance of each time scale from healthy, over its limit; under it the monitor's phases, the alarm, \
                 the loop's recovery, and the names that stood.",
                watched,
            )],
        ),
        Section::new(
            "Configuration",
            vec![how_it_was_read(&replay.source), Block::Verbatim { caption: "Monitor".to_owned(), text: settings }],
        ),
    ];
    let title = format!("Thruster fault monitor: replay of {}", report.log.display());
    let footer = format!(
        "monitor-sim {}, {} mode, {} false alarms an hour asked for.",
        env!("CARGO_PKG_VERSION"),
        report.mode,
        replay.alarming.false_alarms_per_hour
    );
    Page { title, summary, sections, footer }.to_html()
}
