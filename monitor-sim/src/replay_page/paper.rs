//! The page of a replay in `paper` mode: what was learned, the channels, the residuals and what was found.

use std::iter;

use super::{LISTED_ALARMS, axis, channels, figure, how_it_was_read};
use crate::chart::{LogicRow, Series, TimeChart, in_seconds, logic_chart, time_chart};
use crate::mission_page::contributions;
use crate::mission_page::paper::{components, pair_pictures};
use crate::page::{Block, Page, Section};
use crate::replay::paper::{Replay, Replayed};
use crate::tables;

/// The page of a replay.
#[must_use]
pub fn page(replay: &Replay, replayed: &Replayed) -> String {
    let Replayed { report, recording, names, .. } = replayed;
    let window = report.learned.start_row.zip(report.learned.end_row);
    let axis = axis(&replay.source, &recording.signals, window);
    let found = match report.alarms.len() {
        0 => "No fault found".to_owned(),
        1 => "1 alarm".to_owned(),
        n => format!("{n} alarms"),
    };
    let summary = format!("{found} in {} rows at {} Hz. {}", report.samples, report.rate_hz, replayed.coverage());
    let mut learned = vec![tables::learned(&report.learned, names).into_block()];
    learned.extend(replayed.remarks().into_iter().map(Block::Paragraph));
    learned.push(components(&report.learned.quality.explained, names));

    let channels = channels(&replay.source, &recording.signals, &axis);
    let full = TimeChart {
        name: "T²",
        unit: "1",
        log_y: true,
        series: vec![Series { name: "smoothed T² of all channels", signal: &recording.residuals.full }],
        limits: vec![("threshold".to_owned(), report.limits.full)],
        stacked: true,
    };
    let relay = LogicRow {
        name: "fault detected".to_owned(),
        colour: 0,
        intervals: in_seconds(&recording.outputs.relays.full.all(), report.rate_hz),
    };
    let pairs = pair_pictures(recording, &report.limits, names, report.rate_hz, &axis);
    let pictures = vec![time_chart(&full, &axis), logic_chart(&[relay], &axis)];
    let shares = report.alarms.iter().map(|alarm| (alarm.start_s, alarm.contributions));
    let listed = tables::alarms(&report.alarms, names, LISTED_ALARMS).into_block();
    let alarms = iter::once(listed).chain(contributions(shares, names)).collect();
    let sections = vec![
        Section::new("Alarms", alarms),
        Section::new("Learned", learned),
        Section::new(
            "Channels",
            vec![figure("The recorded channels, with the faults that were added to them.", channels)],
        ),
        Section::new(
            "All channels: residual and detection",
            vec![figure("The residual of the full model, its threshold and its relay.", pictures)],
        ),
        Section::new(
            "Pairs: residuals and localization",
            vec![figure("The residuals of the pairs, their relays, and what (1.8) makes of them.", pairs)],
        ),
        Section::new(
            "Configuration",
            vec![
                how_it_was_read(&replay.source),
                Block::Verbatim {
                    caption: "What was learned, as --baseline takes it".to_owned(),
                    text: replayed.baseline.to_toml().unwrap_or_default(),
                },
            ],
        ),
    ];
    let title = format!("Thruster fault monitor: replay of {}", report.log.display());
    let footer = format!(
        "monitor-sim {}, {} mode, residuals smoothed at {} Hz. The names F1 to F3 assume speed, current and voltage of a \
         motor under a speed loop.",
        env!("CARGO_PKG_VERSION"),
        report.mode,
        report.cutoff_hz
    );
    Page { title, summary, sections, footer }.to_html()
}
