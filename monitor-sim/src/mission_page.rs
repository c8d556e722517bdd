//! The page of a mission: what is injected and what is measured; each mode adds what it makes of it.

use crate::chart::{Band, ChartError, Series, TimeAxis, TimeChart, time_chart};
use crate::envelope::Envelope;
use crate::page::{Block, Section};
use crate::record::Signals;
use crate::scenario::Scenario;

pub mod guard;
pub mod paper;

/// Names and units of the motor's channels.
const CHANNEL_LABELS: [&str; 3] = ["speed, rad/s", "current, A", "voltage, V"];

/// More events than this are counted, not listed.
const LISTED_EVENTS: usize = 200;

/// Instants at which the value of a fault is drawn.
const SCHEDULE_POINTS: u32 = 2000;

fn section(heading: &str, blocks: Vec<Block>) -> Section {
    Section { heading: heading.to_owned(), blocks }
}

fn axis(scenario: &Scenario) -> TimeAxis {
    let bands = scenario.faults.iter().map(|f| Band { from: f.start_s, to: f.end_s, label: f.id.clone() }).collect();
    TimeAxis { range: (0.0, scenario.duration_s), scaled_from: scenario.learn.start_s, bands }
}

/// Figure 1: the value of each fault over time, in its unit.
fn scenario_figure(scenario: &Scenario) -> Result<Block, ChartError> {
    let mut pictures = Vec::new();
    for (fault, below) in scenario.faults.iter().zip((0..scenario.faults.len()).rev()) {
        let mut value = Envelope::default();
        for k in 0..=SCHEDULE_POINTS {
            let t_s = scenario.duration_s * f64::from(k) / f64::from(SCHEDULE_POINTS);
            value.push(t_s, fault.value(t_s));
        }
        let y_label = format!("{}, {}", fault.id, fault.unit());
        let series = vec![Series { name: &fault.name, signal: &value }];
        let mut picture = time_chart(
            &TimeChart { y_label: &y_label, log_y: false, series, limits: vec![], stacked: below > 0 },
            &axis(scenario),
        )?;
        picture.legend.retain(|(_, name)| name == "true fault");
        pictures.push(picture);
    }
    Ok(Block::Figure { caption: "What is injected, and when: one picture a fault.".to_owned(), pictures })
}

fn signals(scenario: &Scenario, signals: &Signals) -> Result<Block, ChartError> {
    let mut pictures = Vec::new();
    for (k, (label, signal)) in CHANNEL_LABELS.iter().zip(&signals.channels).enumerate() {
        let mut series = vec![Series { name: "measured", signal }];
        if k == 0 {
            series.push(Series { name: "set point", signal: &signals.set_point });
        }
        pictures.push(time_chart(
            &TimeChart { y_label: label, log_y: false, series, limits: vec![], stacked: k < 2 },
            &axis(scenario),
        )?);
    }
    Ok(Block::Figure { caption: "What the monitor is given: the three measured channels.".to_owned(), pictures })
}
