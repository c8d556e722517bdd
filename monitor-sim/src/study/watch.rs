//! What every study drives: a monitor seen from outside, whichever it is.
//!
//! A mode is added here and nowhere else: a variant of [`Mode`], its arm in [`Mode::limits`] and in [`Mode::watch`], and
//! an implementation of [`Watch`] in a file of its own.

use monitor_core::guard::MotorConstants;
use serde::{Deserialize, Serialize};

use super::StudyError;
use super::calibrate::{Asked, calibrate};
use super::guard_watch::GuardWatch;
use super::paper_watch::PaperWatch;
use crate::fault::FaultPoint;
use crate::names::ByModel;
pub use crate::names::name::Name;
use crate::plant::PlantSample;
use crate::scenario::Scenario;

/// What a monitor says of one slot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Said {
    /// The sample was judged: not settling, learning or turned away.
    pub judged: bool,
    /// Something is wrong.
    pub alarm: bool,
    /// What it is called, once it has a name.
    pub name: Option<Name>,
    /// How large it is, in the unit of the named fault's point, where the monitor says so.
    pub size: Option<f32>,
}

/// A monitor under way. Object calls cost nanoseconds, the plant a hundred: no generics are needed around it.
pub trait Watch: Send {
    /// Takes the sample of one slot: set point (rad/s), then speed (rad/s), armature current (A), armature voltage (V).
    fn step(&mut self, set_point: f32, sample: [f32; 3]) -> Said;

    /// Lets a slot go by that has no sample.
    fn skip(&mut self) -> Said;

    /// Another one that has seen the same.
    fn copy(&self) -> Box<dyn Watch>;

    /// Why the last learning window was refused, if it was and no other has been accepted since.
    fn refused(&self) -> Option<String>;

    /// What it would call a fault of this amplitude, as it can tell without one; none where it cannot.
    fn foretold(&mut self, _: FaultPoint, _: f64) -> Option<Name> {
        None
    }
}

/// Gives `watch` what the plant measured.
#[inline]
pub fn give(watch: &mut dyn Watch, measured: &PlantSample) -> Said {
    if measured.missing {
        return watch.skip();
    }
    watch.step(measured.set_point as f32, measured.channels().map(|x| x as f32))
}

/// What the user knows of a motor and tells its monitor. The paper's mode needs the times only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Samples per second.
    pub rate_hz: f64,
    /// Nothing is learned before this time, s.
    pub settle_s: f64,
    /// Length of the learning window, s.
    pub learn_s: f64,
    /// Armature resistance, ohm.
    pub resistance_ohm: f64,
    /// Torque constant, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Slope of the load torque at the set point, N m s/rad.
    pub load_slope_nm_s: f64,
    /// ADC step of each channel, 0 where there is none.
    pub adc_steps: [f64; 3],
}

impl Known {
    /// Everything as it is.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let Scenario { motor, load, noise, learn, .. } = scenario;
        Self {
            rate_hz: scenario.rate_hz(),
            settle_s: learn.start_s,
            learn_s: learn.end_s - learn.start_s,
            resistance_ohm: motor.resistance_ohm,
            torque_constant_nm_per_a: motor.torque_constant_nm_per_a,
            load_slope_nm_s: load.viscous_nm_s + 2.0 * load.quadratic_nm_s2 * scenario.set_point(0.0).abs(),
            adc_steps: [noise.speed_step_rad_per_s, noise.current_step_a, noise.voltage_step_v],
        }
    }

    /// The constants as the core takes them.
    #[must_use]
    pub const fn motor_constants(&self) -> MotorConstants {
        MotorConstants {
            resistance_ohm: self.resistance_ohm as f32,
            torque_constant_nm_per_a: self.torque_constant_nm_per_a as f32,
            load_slope_nm_s: self.load_slope_nm_s as f32,
        }
    }

    /// With resistance, torque constant and load slope wrong by these factors.
    #[must_use]
    pub fn off_by(self, [resistance, torque_constant, load_slope]: [f64; 3]) -> Self {
        Self {
            resistance_ohm: self.resistance_ohm * resistance,
            torque_constant_nm_per_a: self.torque_constant_nm_per_a * torque_constant,
            load_slope_nm_s: self.load_slope_nm_s * load_slope,
            ..self
        }
    }
}

/// What a monitor is limited by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// False alarms per hour that are asked for: a mode that sets its own limits needs no more.
    pub asked_per_hour: f64,
    /// Thresholds of the residuals, where the mode needs them.
    pub thresholds: Option<ByModel<f64>>,
}

/// Which monitor is studied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Small faults, limits from the false alarms that are asked for
    Guard,
    /// The method of the paper, with thresholds from fault-free runs
    Paper,
}

impl Mode {
    /// The limits for a motor: `source` gives the samples of its fault-free run of a number, for as long as it is asked.
    ///
    /// # Errors
    /// [`StudyError`] when the monitor refuses its settings or what it is to learn from.
    pub fn limits<I>(self, known: &Known, asked: &Asked, source: impl Fn(u64) -> I + Sync) -> Result<Limits, StudyError>
    where
        I: Iterator<Item = PlantSample>,
    {
        match self {
            Self::Guard => Ok(Limits { asked_per_hour: asked.false_alarms_per_hour, thresholds: None }),
            Self::Paper => calibrate(known, asked, source),
        }
    }

    /// A monitor before its first sample.
    ///
    /// # Errors
    /// [`StudyError`] when the monitor refuses its settings.
    pub fn watch(self, known: &Known, limits: &Limits) -> Result<Box<dyn Watch>, StudyError> {
        match self {
            Self::Guard => Ok(Box::new(GuardWatch::new(known, limits)?)),
            Self::Paper => Ok(Box::new(PaperWatch::new(known, limits)?)),
        }
    }
}
