//! The result of a mission in `guard` mode, as machines read it. Keys that the paper's mode has as well mean the same.

use std::path::PathBuf;

use monitor_core::guard::Monitor;
use serde::Serialize;

use super::{Flights, Mission};
use crate::fault::Fault;
use crate::guardian::summary::{ScaleLimits, Settings, WindowQuality};
use crate::mission::Faults;
use crate::names::{self, ByModel};
use crate::score::guard::FaultScore;

/// The value a ramp had reached when it was detected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RampRow {
    /// Identifier of the fault.
    pub id: String,
    /// Value when the alarm was raised, none if it was not.
    pub value_at_detection: Option<f64>,
    /// Value at the end of the ramp.
    pub amplitude: f64,
    /// Unit of the values.
    pub unit: &'static str,
}

/// The result of a mission, as machines read it.
#[derive(Clone, Debug, Serialize)]
pub struct GuardReport {
    /// Which monitor flew.
    pub mode: &'static str,
    /// Name of the scenario.
    pub scenario: String,
    /// How faults were introduced in the tables.
    pub fault_profile: Faults,
    /// Seed of the sensor noise.
    pub seed: u64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Share of the variance each component explains, by model.
    pub explained: ByModel<Vec<f64>>,
    /// Components retained, by model: all of them.
    pub retained: ByModel<usize>,
    /// Limit of the distance at each time scale, when the flight of the tables ended.
    pub limits: ScaleLimits,
    /// What was learned from; none if models were stored.
    pub quality: Option<WindowQuality>,
    /// The faults.
    pub faults: Vec<FaultScore>,
    /// The ramp table.
    pub ramp: Vec<RampRow>,
    /// The faults again with a load that depends on speed.
    pub speed_dependent_load: Vec<FaultScore>,
    /// Alarms outside of faults and recovery, over the flights of the tables and of the ramps.
    pub false_alarms: usize,
    /// Samples given to the monitor over all flights.
    pub samples: u64,
    /// Size of the monitor, bytes.
    pub monitor_bytes: usize,
    /// Wall time of the flights, s.
    pub wall_s: f64,
    /// The monitor's settings.
    pub settings: Settings,
    /// What a person should know about the result.
    pub notes: Vec<String>,
    /// Where the page and the traces are.
    pub files: Vec<PathBuf>,
}

impl Flights {
    /// The result as machines read it.
    #[must_use]
    pub fn report(&self, mission: &Mission) -> GuardReport {
        let Flights { tables, ramps, speed_dependent, .. } = self;
        let flights = [tables, ramps, speed_dependent];
        GuardReport {
            mode: "guard",
            scenario: mission.scenario.name.clone(),
            fault_profile: mission.faults,
            seed: mission.seed,
            rate_hz: mission.scenario.rate_hz(),
            explained: names::explained(&tables.baseline),
            retained: names::retained(&tables.baseline),
            limits: ScaleLimits::of(tables.limits),
            quality: WindowQuality::of(&tables.quality),
            faults: tables.score.faults.clone(),
            ramp: self.ramp_rows(),
            speed_dependent_load: speed_dependent.score.faults.clone(),
            false_alarms: tables.score.false_alarms + ramps.score.false_alarms,
            samples: flights.iter().map(|flight| flight.recording.signals.samples).sum(),
            monitor_bytes: size_of::<Monitor>(),
            wall_s: self.wall_s,
            settings: (&mission.settings()).into(),
            notes: Vec::new(),
            files: self.traces.clone(),
        }
    }

    fn ramp_rows(&self) -> Vec<RampRow> {
        let row = |(fault, score): (&Fault, &FaultScore)| RampRow {
            id: fault.id.clone(),
            value_at_detection: score.detected_s.map(|t_s| fault.value(t_s)),
            amplitude: fault.amplitude,
            unit: fault.unit(),
        };
        self.ramps.scenario.faults.iter().zip(&self.ramps.score.faults).map(row).collect()
    }
}
