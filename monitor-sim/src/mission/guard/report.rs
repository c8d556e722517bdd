//! The result of a mission in `guard` mode, as machines read it. Keys that the paper's mode has as well mean the same.

use std::path::PathBuf;

use monitor_core::guard::{Config, Guard, Quality, SCALES};
use serde::Serialize;

use super::{Flights, Mission};
use crate::fault::Fault;
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

/// A limit of each time scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScaleLimits {
    /// Of the fast scale.
    pub fast: f64,
    /// Of the middle scale.
    pub middle: f64,
    /// Of the slow scale.
    pub slow: f64,
}

impl ScaleLimits {
    /// As the core has them.
    #[must_use]
    pub fn of([fast, middle, slow]: [f32; SCALES]) -> Self {
        let [fast, middle, slow] = [fast, middle, slow].map(f64::from);
        ScaleLimits { fast, middle, slow }
    }
}

/// The monitor's settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Samples per second.
    pub sample_rate_hz: f32,
    /// False alarms that are tolerable per hour.
    pub false_alarms_per_hour: f32,
    /// How long after a change of the set point nothing is learned, s.
    pub settle_s: f32,
    /// Length of each of two seeding windows, s.
    pub seed_s: f32,
    /// Length of the learning window, s.
    pub learn_s: f32,
    /// Largest movement of the set point that is not a change.
    pub set_point_tolerance: f32,
    /// Time constants of the three time scales, s.
    pub time_constants_s: [f32; SCALES],
    /// Step of the converter of each channel.
    pub converter_steps: [f32; 3],
    /// How long the mean remembers, s.
    pub memory_s: f32,
    /// How far the mean may follow in all, in sigmas.
    pub drift_sigmas: f32,
    /// How long the motor must look healthy before an alarm is withdrawn, s.
    pub clear_hold_s: f32,
}

impl From<&Config> for Settings {
    fn from(config: &Config) -> Self {
        Settings {
            sample_rate_hz: config.sample_rate_hz,
            false_alarms_per_hour: config.false_alarms_per_hour,
            settle_s: config.settle_s,
            seed_s: config.seed_s,
            learn_s: config.learn_s,
            set_point_tolerance: config.set_point_tolerance,
            time_constants_s: config.time_constants_s,
            converter_steps: config.converter_steps,
            memory_s: config.memory_s,
            drift_sigmas: config.drift_sigmas,
            clear_hold_s: config.clear_hold_s,
        }
    }
}

/// How good a learning window was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WindowQuality {
    /// Samples in the window.
    pub samples: u32,
    /// Share of the samples of which a reading was clipped.
    pub clipped_share: f64,
    /// Largest over smallest eigenvalue of the correlation matrix.
    pub condition_number: f64,
    /// Largest movement of a channel's mean from the first half to the second, in its sigmas.
    pub half_shift_sigma: f64,
    /// How much larger the slow scale's variance is than that of noise without memory.
    pub slow_variance_ratio: f64,
}

impl From<&Quality> for WindowQuality {
    fn from(quality: &Quality) -> Self {
        WindowQuality {
            samples: quality.samples,
            clipped_share: f64::from(quality.clipped_share),
            condition_number: f64::from(quality.condition),
            half_shift_sigma: f64::from(quality.drift_sigmas),
            slow_variance_ratio: f64::from(quality.slow_variance_ratio),
        }
    }
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
    /// What was learned from.
    pub quality: WindowQuality,
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
            quality: (&tables.quality).into(),
            faults: tables.score.faults.clone(),
            ramp: self.ramp_rows(),
            speed_dependent_load: speed_dependent.score.faults.clone(),
            false_alarms: tables.score.false_alarms + ramps.score.false_alarms,
            samples: flights.iter().map(|flight| flight.recording.signals.samples).sum(),
            monitor_bytes: size_of::<Guard>(),
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
