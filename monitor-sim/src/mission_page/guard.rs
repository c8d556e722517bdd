//! The page of a mission in `guard` mode: distances over their limits, alarms and names, under what is injected and measured.

use std::iter;

use super::{LISTED_EVENTS, axis, contributions, phases, scenario_figure, signals};
use crate::chart::{LogicRow, Picture, Series, TimeAxis, TimeChart, in_seconds, logic_chart, time_chart};
use crate::guardian::SCALE_NAMES;
use crate::intervals::Interval;
use crate::mission::Faults;
use crate::mission::guard::{Flight, Flights, GuardReport, Mission};
use crate::names::ChannelNames;
use crate::names::name::Name;
use crate::page::{Block, Page, Section};
use crate::record::guard::Recording;
use crate::tables::{self, TextTable};

/// The faults of the paper.
const PAPERS: [Name; 3] = [Name::LoadTorque, Name::SpeedSensor, Name::CurrentSensor];

/// The page of a mission.
#[must_use]
pub fn page(mission: &Mission, flights: &Flights, report: &GuardReport) -> String {
    let right = report.faults.iter().filter(|fault| fault.is_located_right()).count();
    let summary = format!(
        "{right} of {} faults named right, {} false alarms; {:.0} s at {:.0} Hz with {} faults, seed {}, {} mode.",
        report.faults.len(),
        report.false_alarms,
        mission.scenario.duration_s,
        report.rate_hz,
        if report.fault_profile == Faults::Step { "step" } else { "ramp" },
        report.seed,
        report.mode,
    );
    let tables = tables::guard::of_mission(report).into_iter().map(TextTable::into_block).collect();
    let Flights { tables: flown, ramps, speed_dependent, .. } = flights;
    let shown = |flight: &Flight| {
        let figure = watched(&flight.recording, report.rate_hz, &axis(&flight.scenario));
        let shares = flight.alarms.iter().filter_map(|alarm| Some((alarm.start_s, alarm.contributions?)));
        iter::once(figure).chain(contributions(shares, &ChannelNames::motor())).collect()
    };
    let configuration = toml::to_string(&flown.scenario).unwrap_or_default();
    let settings = toml::to_string(&report.settings).unwrap_or_default();
    let events = tables::guard::events(flown, LISTED_EVENTS).into_block();
    let sections = vec![
        Section::new("Tables", tables),
        Section::new(
            "What is injected and measured",
            vec![scenario_figure(&flown.scenario), signals(&flown.scenario, &flown.recording.signals)],
        ),
        Section::new("Distances, alarms and names", shown(flown)),
        Section::new("Growing faults", shown(ramps)),
        Section::new("A load that grows with speed", shown(speed_dependent)),
        Section::new("What was learned", vec![tables::guard::quality(&report.quality).into_block()]),
        Section::new("Events", vec![events]),
        Section::new(
            "Configuration",
            vec![
                Block::Verbatim { caption: "Scenario".to_owned(), text: configuration },
                Block::Verbatim { caption: "Monitor".to_owned(), text: settings },
            ],
        ),
    ];
    let title = format!("Thruster fault monitor: mission \"{}\"", mission.scenario.name);
    let footer = format!("monitor-sim {}. A simulated motor; nothing here ran on silicon.", env!("CARGO_PKG_VERSION"));
    Page { title, summary, sections, footer }.to_html()
}

/// The distances of the time scales over their limits, and under them what the monitor makes of them.
fn watched(recording: &Recording, rate_hz: f64, axis: &TimeAxis) -> Block {
    let mut pictures = severities(recording, axis);
    pictures.push(timeline(recording, rate_hz, &PAPERS, axis));
    let caption = "The distance of each time scale from healthy, over its limit; under it the monitor's phases, the alarm, \
                   the loop's recovery, and the names that stood.";
    Block::Figure { caption: caption.to_owned(), pictures }
}

/// The distances of the three time scales over their limits, on a logarithmic axis.
#[must_use]
pub fn severities(recording: &Recording, axis: &TimeAxis) -> Vec<Picture> {
    let mut pictures = Vec::new();
    for (name, signal) in SCALE_NAMES.into_iter().zip(&recording.severity) {
        let label = format!("{name}: T²/limit");
        let chart = TimeChart {
            name: &label,
            unit: "",
            log_y: true,
            series: vec![Series { name, signal }],
            limits: vec![("limit".to_owned(), 1.0)],
            stacked: true,
        };
        pictures.push(time_chart(&chart, axis).without_series());
    }
    pictures
}

/// When the monitor was in each phase, where an alarm stood, where the loop recovered, and where each name stood; some have a row even if they never did.
#[must_use]
pub fn timeline(recording: &Recording, rate_hz: f64, always: &[Name], axis: &TimeAxis) -> Picture {
    let outputs = &recording.outputs;
    let row = |name: &str, colour, stood: &[Interval]| LogicRow {
        name: name.to_owned(),
        colour,
        intervals: in_seconds(stood, rate_hz),
    };
    let mut rows = phases(&recording.phases, rate_hz);
    rows.extend([row("alarm", 0, &outputs.alarm.all()), row("recovering", 2, &outputs.recovering.all())]);
    for name in Name::ALL {
        let stood = outputs.of(name);
        if !stood.is_empty() || always.contains(&name) {
            rows.push(row(&name.shown(), 1, &stood));
        }
    }
    logic_chart(&rows, axis)
}
