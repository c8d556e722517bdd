//! The monitor in `guard` mode as studies drive it.

use monitor_core::guard::{Cause, Config, Directions, Finding, Guard, MotorConstants, Phase};
use monitor_core::verdict::Absence;

use super::StudyError;
use super::watch::{Known, Limits, Name, Said, Watch};
use crate::names::ChannelNames;

/// Longest seeding window, s; two of them stand before the learning window.
const SEED_S: f64 = 1.0;

/// The monitor, and the directions by which it names faults once it has learned.
pub(super) struct GuardWatch {
    guard: Guard,
    motor: MotorConstants,
    directions: Directions,
}

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
        let guard = Guard::new(&config).map_err(|error| StudyError::Settings(format!("{error:?}")))?;
        let motor = MotorConstants {
            resistance_ohm: known.resistance_ohm as f32,
            torque_constant_nm_per_a: known.torque_constant_nm_per_a as f32,
            load_slope_nm_s: known.load_slope_nm_s as f32,
        };
        Ok(Self { guard, motor, directions: Directions::none() })
    }

    fn said(&mut self) -> Said {
        let verdict = self.guard.verdict();
        if verdict.phase() == Phase::ModelDue {
            // A refusal stays with the monitor, which begins again.
            let _refused = self.guard.finish_learning();
            let mean = self.guard.model().map(monitor_core::guard::Model::mean);
            self.directions = mean.and_then(|mean| Directions::of_motor(&self.motor, mean).ok()).unwrap_or_default();
            return Said::default();
        }
        let (judged, alarm) = (verdict.severity().is_some(), verdict.alarm());
        if verdict.deviates() {
            let (name, size) = named(&self.guard.finding(&self.directions));
            return Said { judged, alarm, name, size };
        }
        let lost = verdict.gap() || verdict.losses().next().is_some();
        Said { judged, alarm, name: lost.then_some(Name::SensorLoss), size: None }
    }
}

fn named(finding: &Finding) -> (Option<Name>, Option<f32>) {
    match finding {
        Finding::Healthy | Finding::Locating => (None, None),
        Finding::Fault(found) => (Some(name_of(found.cause)), Some(found.size)),
        Finding::Ambiguous(..) => (Some(Name::Ambiguous), None),
        Finding::Unknown => (Some(Name::Unknown), None),
    }
}

const fn name_of(cause: Cause) -> Name {
    match cause {
        Cause::LoadTorque => Name::LoadTorque,
        Cause::SpeedSensor => Name::SpeedSensor,
        Cause::CurrentSensor => Name::CurrentSensor,
        Cause::Resistance => Name::ArmatureResistance,
        Cause::TorqueConstant => Name::TorqueConstant,
        Cause::Supply => Name::VoltageActuator,
        _ => Name::Unknown,
    }
}

impl Watch for GuardWatch {
    fn step(&mut self, set_point: f32, sample: [f32; 3]) -> Said {
        self.guard.step_channels(set_point, sample);
        self.said()
    }

    fn skip(&mut self) -> Said {
        self.guard.skip(Absence::Missing);
        self.said()
    }

    fn refused(&self) -> Option<String> {
        self.guard.refused().map(|error| ChannelNames::motor().explain_learning(error))
    }
}
