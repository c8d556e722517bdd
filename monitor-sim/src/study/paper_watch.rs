//! The paper's monitor as studies drive it.

use monitor_core::paper::localize::{Diagnosis, Fault};
use monitor_core::paper::{Monitor, Phase, Verdict};
use monitor_core::sample::Absence;
use monitor_core::sample::Sample;
use monitor_core::units::{Amperes, RadPerSec, Volts};

use super::StudyError;
use super::watch::{Known, Limits, Name, Said, Watch};
use crate::names::{ByModel, ChannelNames, explain_config};
use crate::settings::PaperSettings;

/// The paper's monitor.
#[derive(Clone)]
pub(super) struct PaperWatch(Monitor);

impl PaperWatch {
    pub(super) fn new(known: &Known, limits: &Limits) -> Result<Self, StudyError> {
        let unlimited = || ByModel::from_fn(|_| f64::from(f32::MAX));
        let thresholds = limits.thresholds.unwrap_or_else(unlimited);
        let settings = PaperSettings { thresholds, ..PaperSettings::default_motor()? };
        // A tolerance of zero: the simulated set point is exact.
        let config = settings.config(known.rate_hz, known.settle_s, known.learn_s, 0.0);
        Monitor::new(&config).map(Self).map_err(|error| StudyError::Settings(explain_config(error)))
    }

    /// The verdict on the last slot.
    pub(super) fn verdict(&self) -> &Verdict {
        self.0.verdict()
    }

    fn said(&mut self) -> Said {
        let verdict = self.0.verdict();
        if verdict.phase() == Phase::ModelDue {
            // A refusal stays with the monitor, which begins a new window.
            let _refused = self.0.finish_learning();
            return Said::default();
        }
        let judged = verdict.phase() == Phase::Monitoring && verdict.rejected().is_none();
        let alarm = verdict.alarm();
        Said { judged, alarm, name: if alarm { name(verdict.diagnosis()) } else { None }, size: None }
    }
}

const fn name(diagnosis: Diagnosis) -> Option<Name> {
    match diagnosis {
        Diagnosis::Healthy => None,
        Diagnosis::Fault(Fault::LoadTorque) => Some(Name::LoadTorque),
        Diagnosis::Fault(Fault::SpeedSensor) => Some(Name::SpeedSensor),
        Diagnosis::Fault(Fault::CurrentSensor) => Some(Name::CurrentSensor),
        Diagnosis::Unknown => Some(Name::Unknown),
    }
}

impl Watch for PaperWatch {
    fn step(&mut self, set_point: f32, [speed, current, voltage]: [f32; 3]) -> Said {
        let sample =
            Sample { speed: RadPerSec(speed), armature_current: Amperes(current), armature_voltage: Volts(voltage) };
        self.0.step(RadPerSec(set_point), sample);
        self.said()
    }

    fn skip(&mut self) -> Said {
        self.0.skip(Absence::Missing);
        self.said()
    }

    fn copy(&self) -> Box<dyn Watch> {
        Box::new(self.clone())
    }

    fn refused(&self) -> Option<String> {
        self.0.refused().map(|error| ChannelNames::motor().explain_learning(error))
    }
}
