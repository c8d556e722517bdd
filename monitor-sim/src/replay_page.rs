//! The page of a replay: what was learned, the channels, the residuals and what was found.

use crate::chart::{
    Band, ChartError, LogicRow, Picture, Series, Swatch, TimeAxis, TimeChart, in_seconds, logic_chart, time_chart,
};
use crate::envelope::Envelope;
use crate::mission_page::{components, pair_pictures};
use crate::page::{Block, Page, Section};
use crate::replay::{Replay, Replayed};
use crate::tables;

/// More alarms than this are counted, not listed; the JSON document has them all.
const LISTED_ALARMS: usize = 200;

/// The page of a replay.
///
/// # Errors
/// [`ChartError`] when a picture cannot be drawn.
pub fn page(replay: &Replay, replayed: &Replayed) -> Result<String, ChartError> {
    let Replayed { report, recording, names, .. } = replayed;
    let axis = axis(replay, replayed);
    let found = match report.alarms.len() {
        0 => "No fault found".to_owned(),
        1 => "1 alarm".to_owned(),
        n => format!("{n} alarms"),
    };
    let summary = format!("{found} in {} rows at {} Hz. {}", report.samples, report.rate_hz, replayed.coverage());
    let mut learned = vec![tables::learned(&report.learned, names).into_block()];
    learned.extend(replayed.remarks().into_iter().map(Block::Paragraph));
    learned.push(components(&report.learned.quality.explained, names)?);

    let mut channels = Vec::new();
    if report.has_set_point {
        channels.push(signal("set point", &recording.set_point, true, &axis)?);
    }
    for (k, (name, envelope)) in names.0.iter().zip(&recording.channels).enumerate() {
        channels.push(signal(name, envelope, k < 2, &axis)?);
    }
    let full = TimeChart {
        y_label: "T², 1",
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
    let mut pairs = pair_pictures(recording, &report.limits, names, report.rate_hz, &axis)?;
    let mut pictures = vec![time_chart(&full, &axis)?, logic_chart(&[relay], &axis)?];
    // Injected faults are shaded; the word of the legend says so.
    for picture in channels.iter_mut().chain(&mut pictures).chain(&mut pairs) {
        for (_, name) in picture.legend.iter_mut().filter(|(_, name)| name == "true fault") {
            *name = "learning window or injected fault".to_owned();
        }
    }
    let sections = vec![
        section("Alarms", vec![tables::alarms(&report.alarms, names, LISTED_ALARMS).into_block()]),
        section("Learned", learned),
        section("Channels", vec![figure("The recorded channels, with the faults that were added to them.", channels)]),
        section(
            "All channels: residual and detection",
            vec![figure("The residual of the full model, its threshold and its relay.", pictures)],
        ),
        section(
            "Pairs: residuals and localization",
            vec![figure("The residuals of the pairs, their relays, and what (1.8) makes of them.", pairs)],
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
    Ok(Page { title, summary, sections, footer }.to_html())
}

fn section(heading: &str, blocks: Vec<Block>) -> Section {
    Section { heading: heading.to_owned(), blocks }
}

fn figure(caption: &str, pictures: Vec<Picture>) -> Block {
    Block::Figure { caption: caption.to_owned(), pictures }
}

fn axis(replay: &Replay, replayed: &Replayed) -> TimeAxis {
    let Replayed { report, recording, .. } = replayed;
    let end = recording.seconds(report.samples);
    let window = report.learned.start_row.zip(report.learned.end_row);
    let learning = window.map(|(start, end)| Band {
        from: recording.seconds(start),
        to: recording.seconds(end),
        label: "learning".to_owned(),
    });
    let injected = replay.injections.iter().map(|injection| Band {
        from: recording.seconds(injection.first_row()),
        to: injection.end_row().map_or(end, |row| recording.seconds(row)),
        label: injection.to_string(),
    });
    TimeAxis { range: (0.0, end), scaled_from: 0.0, bands: learning.into_iter().chain(injected).collect() }
}

fn signal(name: &str, signal: &Envelope, stacked: bool, axis: &TimeAxis) -> Result<Picture, ChartError> {
    let series = vec![Series { name, signal }];
    let mut picture = time_chart(&TimeChart { y_label: name, log_y: false, series, limits: vec![], stacked }, axis)?;
    // The axis names the signal already.
    picture.legend.retain(|(swatch, _)| *swatch == Swatch::Band);
    Ok(picture)
}
