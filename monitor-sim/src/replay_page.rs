//! The page of a replay: what was learned, the channels, the residuals and what was found.

use crate::chart::{Band, ChartError, LogicRow, Series, TimeAxis, TimeChart, in_seconds, logic_chart, time_chart};
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
    let Replayed { report, recording, names } = replayed;
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
        channels.push(signal("set point", "set point", &recording.set_point, &axis)?);
    }
    for (name, envelope) in names.0.iter().zip(&recording.channels) {
        channels.push(signal(name, name, envelope, &axis)?);
    }
    let full = TimeChart {
        y_label: "T², 1",
        log_y: true,
        series: vec![Series { name: "smoothed T² of all channels", signal: &recording.residuals.full }],
        limits: vec![("threshold".to_owned(), report.limits.full)],
    };
    let relay = LogicRow {
        name: "fault detected".to_owned(),
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

fn figure(caption: &str, pictures: Vec<crate::chart::Picture>) -> Block {
    Block::Figure { caption: caption.to_owned(), pictures }
}

fn axis(replay: &Replay, replayed: &Replayed) -> TimeAxis {
    let Replayed { report, recording, .. } = replayed;
    let end = recording.seconds(report.samples);
    let learning = Band {
        from: recording.seconds(report.learned.start_row),
        to: recording.seconds(report.learned.end_row),
        label: "learning".to_owned(),
    };
    let injected = replay.injections.iter().map(|injection| Band {
        from: recording.seconds(injection.first_row()),
        to: injection.end_row().map_or(end, |row| recording.seconds(row)),
        label: injection.to_string(),
    });
    TimeAxis { range: (0.0, end), bands: std::iter::once(learning).chain(injected).collect() }
}

fn signal(
    y_label: &str,
    name: &str,
    signal: &crate::envelope::Envelope,
    axis: &TimeAxis,
) -> Result<crate::chart::Picture, ChartError> {
    let chart = TimeChart { y_label, log_y: false, series: vec![Series { name, signal }], limits: vec![] };
    let mut picture = time_chart(&chart, axis)?;
    picture.legend.retain(|(swatch, _)| !matches!(swatch, crate::chart::Swatch::Series(_)));
    Ok(picture)
}
