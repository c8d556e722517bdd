//! The page of a mission in `paper` mode: the counterparts of the paper's figures 1, 5, 6, 7, 8, 10 and 11, and its tables.

use std::iter;

use monitor_core::sample::ModelId;

use super::{LISTED_EVENTS, axis, contributions, phases, scenario_figure, signals};
use crate::chart::{
    BarGroup, LogicRow, Picture, Series, TimeAxis, TimeChart, bar_chart, in_seconds, logic_chart, time_chart,
};
use crate::intervals::Intervals;
use crate::mission::Faults;
use crate::mission::paper::{Flight, Flights, Mission, MissionReport};
use crate::names::{ByModel, ChannelNames};
use crate::page::{Block, Page, Section};
use crate::record::paper::Recording;
use crate::score::Method;
use crate::tables::{self, TextTable};

/// The page of a mission.
#[must_use]
pub fn page(mission: &Mission, flights: &Flights, report: &MissionReport) -> String {
    let names = ChannelNames::motor();
    let table_2: Vec<_> = report.faults.iter().filter(|f| f.method == Method::Ppca).collect();
    let right = table_2.iter().filter(|f| f.located.as_deref() == Some(&f.id)).count();
    let summary = format!(
        "{right} of {} faults located right, {} false alarms; {:.0} s at {:.0} Hz with {} faults, seed {}, {} mode.",
        table_2.len(),
        report.false_alarms,
        mission.scenario.duration_s,
        report.rate_hz,
        if report.fault_profile == Faults::Step { "step" } else { "ramp" },
        report.seed,
        report.mode,
    );
    let configuration = toml::to_string(&flights.tables.scenario).unwrap_or_default();
    let shares = flights.tables.alarms.iter().map(|alarm| (alarm.start_s, alarm.contributions));
    let shares = contributions(shares, &names);
    let thresholds = mission.settings.to_toml().unwrap_or_default();
    let sections = vec![
        Section::new("Tables", tables_of(report)),
        Section::new("Scenario (figure 1)", vec![scenario_figure(&flights.tables.scenario), signals(&flights.tables.scenario, &flights.tables.recording.signals)]),
        Section::new("Principal components (figures 5 and 8)", vec![components(&report.explained, &names)]),
        Section::new("PCA: residual and detection (figures 6 and 7)", vec![full_model(&flights.tables, report)]),
        Section::new("PPCA: residuals and localization (figures 10 and 11)", iter::once(pairs(&flights.tables, report, &names)).chain(shares).collect()),
        Section::new("Growing faults (the second figure 11)", vec![growing(&flights.ramps, report, &names)]),
        Section::new(
            "A load that grows with speed",
            vec![
                Block::Paragraph(
                    "The same mission with a load of the same torque that grows with speed. A drift of the speed sensor \
                     then changes the true speed, so the load, so the current: where that rises above the noise all \
                     three pairs move, and (1.8) reads it as fault 1."
                        .to_owned(),
                ),
                pairs(&flights.speed_dependent, report, &names),
            ],
        ),
        Section::new("Events", vec![tables::events(&flights.tables.events, report.rate_hz, LISTED_EVENTS).into_block()]),
        Section::new(
            "Configuration",
            vec![
                Block::Verbatim { caption: "Scenario".to_owned(), text: configuration },
                Block::Verbatim { caption: "Thresholds".to_owned(), text: thresholds },
            ],
        ),
    ];
    let title = format!("Thruster fault monitor: mission \"{}\"", mission.scenario.name);
    let footer = format!("monitor-sim {}. A simulated motor; nothing here ran on silicon.", env!("CARGO_PKG_VERSION"));
    Page { title, summary, sections, footer }.to_html()
}

fn tables_of(report: &MissionReport) -> Vec<Block> {
    let notes = report.notes.iter().map(|note| Block::Paragraph(format!("Note: {note}")));
    tables::of_mission(report).into_iter().map(TextTable::into_block).chain(notes).collect()
}

/// Figures 5 and 8.
#[must_use]
pub fn components(explained: &ByModel<Vec<f64>>, names: &ChannelNames) -> Block {
    let group = |model: &ModelId| BarGroup {
        name: names.model(*model),
        values: explained.get(*model).iter().map(|share| 100.0 * share).collect(),
    };
    let groups: Vec<BarGroup> = ModelId::ALL.iter().map(group).collect();
    let caption =
        "Share of the variance that each principal component explains (1.3): all channels, then the three pairs.";
    let bars = [1, 2, 3].map(|k| format!("component {k}"));
    let picture = bar_chart(&groups, &bars, "explained variance", Some(("80 % criterion (cumulative)", 80.0)));
    Block::Figure { caption: caption.to_owned(), pictures: vec![picture] }
}

fn full_model(flight: &Flight, report: &MissionReport) -> Block {
    let recording = &flight.recording;
    let chart = TimeChart {
        name: "T²",
        unit: "1",
        log_y: true,
        series: vec![Series { name: "smoothed T² of all channels", signal: &recording.residuals.full }],
        limits: vec![(format!("threshold {}", report.limits.full), report.limits.full)],
        stacked: true,
    };
    let up = in_seconds(&recording.outputs.relays.full.all(), report.rate_hz);
    let rows = [LogicRow { name: "fault detected".to_owned(), colour: 0, intervals: up }];
    let axis = axis(&flight.scenario);
    let caption = "The residual of the full model with its threshold, and the relay's output under it.";
    Block::Figure { caption: caption.to_owned(), pictures: vec![time_chart(&chart, &axis), logic_chart(&rows, &axis)] }
}

fn pairs(flight: &Flight, report: &MissionReport, names: &ChannelNames) -> Block {
    let axis = axis(&flight.scenario);
    let pictures = pair_pictures(&flight.recording, &report.limits, names, report.rate_hz, &axis);
    let caption = "The residuals of the three pairs with their thresholds; under them the monitor's phases, the relays r1 to r3, and what (1.8) makes of them.";
    Block::Figure { caption: caption.to_owned(), pictures }
}

fn growing(flight: &Flight, report: &MissionReport, names: &ChannelNames) -> Block {
    let axis = axis(&flight.scenario);
    let pictures = pair_pictures(&flight.recording, &report.limits, names, report.rate_hz, &axis);
    let caption = "Every fault grows linearly over its interval; the same residuals and outputs.";
    Block::Figure { caption: caption.to_owned(), pictures }
}

/// The residuals of the pairs, the relays, and the located faults.
#[must_use]
pub fn pair_pictures(
    recording: &Recording,
    limits: &ByModel<f64>,
    names: &ChannelNames,
    rate_hz: f64,
    axis: &TimeAxis,
) -> Vec<Picture> {
    let pair_models = ModelId::ALL.into_iter().filter(|model| *model != ModelId::Full);
    let named: Vec<(ModelId, String)> =
        pair_models.zip(1..).map(|(model, k)| (model, format!("r{k} {}", names.model(model)))).collect();
    let mut pictures = Vec::new();
    for (model, name) in &named {
        let limit = *limits.get(*model);
        let series = vec![Series { name, signal: recording.residuals.get(*model) }];
        let label = format!("{}: T²", name.split(' ').next().unwrap_or_default());
        let chart = TimeChart {
            name: &label,
            unit: "1",
            log_y: true,
            series,
            limits: vec![("threshold".to_owned(), limit)],
            stacked: true,
        };
        pictures.push(time_chart(&chart, axis).without_series());
    }
    let row = |name: String, colour: usize, stood: &Intervals| {
        let intervals = in_seconds(&stood.all(), rate_hz);
        LogicRow { name, colour, intervals }
    };
    let relays = named.iter().map(|(model, name)| row(name.clone(), 0, recording.outputs.relays.get(*model)));
    let diagnoses = recording.outputs.diagnoses.iter().map(|(id, stood)| row(names.located(id), 1, stood));
    let rows: Vec<LogicRow> = phases(&recording.phases, rate_hz).into_iter().chain(relays).chain(diagnoses).collect();
    pictures.push(logic_chart(&rows, axis));
    pictures
}
