//! The monitor in `guard` mode as studies drive it.

use monitor_core::guard::{Cause, Config};

use super::StudyError;
use super::watch::{Known, Limits, Name, Said, Watch};
use crate::fault::FaultPoint;
use crate::guardian::{self, Guardian};
use crate::names::{ChannelNames, explain_guard_config};

/// Longest seeding window, s; two of them stand before the learning window.
const SEED_S: f64 = 1.0;

/// The monitor, and the directions by which it names faults once it has learned.
#[derive(Clone)]
pub(super) struct GuardWatch(Guardian);

impl GuardWatch {
    pub(super) fn new(known: &Known, limits: &Limits) -> Result<Self, StudyError> {
        let seed_s = SEED_S.min(known.settle_s / 2.0);
        let config = Config {
            false_alarms_per_hour: limits.asked_per_hour as f32,
            settle_s: (known.settle_s - 2.0 * seed_s) as f32,
            seed_s: seed_s as f32,
            learn_s: known.learn_s as f32,
            converter_steps: known.adc_steps.map(|step| step as f32),
            ..Config::at_rate(known.rate_hz as f32)
        };
        let guardian = Guardian::new(&config, Some(known.motor_constants()));
        guardian.map(Self).map_err(|error| StudyError::Settings(explain_guard_config(error)))
    }
}

impl Watch for GuardWatch {
    fn step(&mut self, set_point: f32, sample: [f32; 3]) -> Said {
        said(&self.0.step(set_point, sample))
    }

    fn skip(&mut self) -> Said {
        said(&self.0.skip())
    }

    fn copy(&self) -> Box<dyn Watch> {
        Box::new(self.clone())
    }

    fn refused(&self) -> Option<String> {
        // A refusal stays with the monitor, which begins again.
        self.0.guard().refused().map(|error| ChannelNames::motor().explain_learning(error))
    }

    fn foretold(&mut self, point: FaultPoint, amplitude: f64) -> Option<Name> {
        // The faults whose amplitude is in the unit of the monitor's size.
        let cause = match point {
            FaultPoint::LoadTorque => Cause::LoadTorque,
            FaultPoint::SpeedSensor => Cause::SpeedSensor,
            FaultPoint::CurrentSensor => Cause::CurrentSensor,
            _ => return None,
        };
        self.0.foretold(cause, amplitude as f32)
    }
}

fn said(said: &guardian::Said) -> Said {
    let verdict = &said.verdict;
    if said.learned.is_some() {
        return Said::default();
    }
    Said {
        judged: verdict.severity().is_some(),
        alarm: verdict.alarm(),
        name: said.found.map(|found| found.name),
        size: said.found.and_then(|found| found.size).map(|size| size.value as f32),
    }
}
