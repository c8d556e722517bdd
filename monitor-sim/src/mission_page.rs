//! The page of a mission: what is injected and what is measured; each mode adds what it makes of it.

use crate::chart::{Band, BarGroup, LogicRow, Series, TimeAxis, TimeChart, bar_chart, in_seconds, time_chart};
use crate::envelope::Envelope;
use crate::names::ChannelNames;
use crate::page::Block;
use crate::record::{Phases, Signals};
use crate::scenario::Scenario;

pub mod guard;
pub mod paper;

/// Names and units of the motor's channels.
const CHANNELS: [(&str, &str); 3] = [("speed", "rad/s"), ("current", "A"), ("voltage", "V")];

/// More events than this are counted, not listed.
const LISTED_EVENTS: usize = 200;

/// More alarms than this have no room in one picture of contributions.
const PICTURED_ALARMS: usize = 8;

fn axis(scenario: &Scenario) -> TimeAxis {
    let bands = scenario.faults.iter().map(|f| Band { from: f.start_s, to: f.end_s, label: f.id.clone() }).collect();
    TimeAxis { range: (0.0, scenario.duration_s), scaled_from: scenario.learn.start_s, bands, shaded: "true fault" }
}

/// Figure 1: the value of each fault over time, in its unit.
fn scenario_figure(scenario: &Scenario) -> Block {
    let mut pictures = Vec::new();
    for (fault, below) in scenario.faults.iter().zip((0..scenario.faults.len()).rev()) {
        let mut value = Envelope::default();
        let mut acts = false;
        for sample in 0..(scenario.duration_s * scenario.rate_hz()).round() as u64 {
            let t_s = sample as f64 / scenario.rate_hz();
            value.push(t_s, fault.value(t_s));
            if fault.is_active(t_s) != acts {
                acts = !acts;
                value.mark();
            }
        }
        let series = vec![Series { name: &fault.name, signal: &value }];
        let (name, unit, stacked) = (&fault.id, fault.unit(), below > 0);
        let chart = TimeChart { name, unit, log_y: false, series, limits: vec![], stacked };
        pictures.push(time_chart(&chart, &axis(scenario)).without_series());
    }
    Block::Figure { caption: "What is injected, and when: one picture a fault.".to_owned(), pictures }
}

fn signals(scenario: &Scenario, signals: &Signals) -> Block {
    let mut pictures = Vec::new();
    for (k, ((name, unit), signal)) in CHANNELS.into_iter().zip(&signals.channels).enumerate() {
        let mut series = vec![Series { name: "measured", signal }];
        if k == 0 {
            series.push(Series { name: "set point", signal: &signals.set_point });
        }
        let chart = TimeChart { name, unit, log_y: false, series, limits: vec![], stacked: k < 2 };
        pictures.push(time_chart(&chart, &axis(scenario)));
    }
    Block::Figure { caption: "What the monitor is given: the three measured channels.".to_owned(), pictures }
}

/// Share of each channel in the first alarms, which began at these instants, s; none without an alarm.
pub(crate) fn contributions(alarms: impl Iterator<Item = (f64, [f64; 3])>, names: &ChannelNames) -> Option<Block> {
    let group = |(start_s, shares): (f64, [f64; 3])| BarGroup {
        name: format!("{start_s:.2} s"),
        values: shares.map(|share| 100.0 * share).to_vec(),
    };
    let groups: Vec<BarGroup> = alarms.take(PICTURED_ALARMS).map(group).collect();
    let picture = bar_chart(&groups, &names.0, "contribution", None);
    let caption = "Share of each channel in the first alarms, by their beginning.".to_owned();
    (!groups.is_empty()).then(|| Block::Figure { caption, pictures: vec![picture] })
}

/// When the monitor was in each phase, one row each.
fn phases(phases: &Phases, rate_hz: f64) -> Vec<LogicRow> {
    let row = |(phase, stood): (&str, Vec<_>)| LogicRow {
        name: phase.to_owned(),
        colour: 3,
        intervals: in_seconds(&stood, rate_hz),
    };
    phases.all().map(row).collect()
}
