//! Faults as data. Those of the paper's section III.A are injected where its figure 2 injects them: at the load torque, at
//! the speed sensor, at the current sensor. Beyond the paper: constants of the motor that change, the voltage actuator,
//! the voltage sensor, and what happens to readings (stuck, coarse, spikes, slots without a sample). Faults of speed and
//! current sensor are inside the loop: the controllers act on the faulty reading.

mod acting;

pub use acting::{ActingFaults, Actions};

use crate::noise::quantize;
use serde::{Deserialize, Serialize};

/// Where a fault enters the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultPoint {
    /// Load torque, N m. The paper calls its fault 1 "increase of the load inertia" (debris in the propeller), but adds
    /// it at the load torque, as done here.
    LoadTorque,
    /// Speed sensor, rad/s.
    SpeedSensor,
    /// Armature current sensor, A.
    CurrentSensor,
    /// Armature voltage sensor, V. Outside of the loop.
    VoltageSensor,
    /// Supply or power stage, V: between the voltage that the current controller asks for, which is the one that is
    /// read (figure 2), and the one that the armature gets.
    VoltageActuator,
    /// Inertia of everything that turns, kg m^2. What comes or goes has the shaft's speed: no impulse with it.
    LoadInertia,
    /// Armature resistance, ohm: winding, brushes, connector. The inductance stays.
    ArmatureResistance,
    /// Torque constant, N m/A, and with it the speed constant: loss of the magnet.
    TorqueConstant,
    /// The sampling of all channels: slots without a sample for the monitor. The drive still has its readings.
    Sampling,
}

impl FaultPoint {
    /// How many there are.
    pub const COUNT: usize = 9;

    /// Whether a reading is what the fault changes.
    #[must_use]
    pub const fn is_sensor(self) -> bool {
        matches!(self, Self::SpeedSensor | Self::CurrentSensor | Self::VoltageSensor)
    }

    /// Unit of what is there.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::LoadTorque => "N m",
            Self::SpeedSensor => "rad/s",
            Self::CurrentSensor => "A",
            Self::VoltageSensor | Self::VoltageActuator => "V",
            Self::LoadInertia => "kg m^2",
            Self::ArmatureResistance => "ohm",
            Self::TorqueConstant => "N m/A",
            Self::Sampling => "1",
        }
    }
}

/// How a fault changes the signal at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// Added to the signal (all faults of the paper).
    Offset,
    /// Multiplies the signal by 1 + value (the paper's conclusion mentions multiplicative faults).
    Gain,
    /// A sensor that repeats its last reading; the value is the probability of that, anew in each control period: 1 is
    /// a sensor that has died.
    Stuck,
    /// A sensor whose readings are rounded to multiples of the value.
    Coarse,
    /// No sample in a slot; the value is the probability of that, anew in each control period. At the sampling only.
    Missing,
}

impl FaultKind {
    /// Whether the value is a probability.
    #[must_use]
    pub const fn is_chance(self) -> bool {
        matches!(self, Self::Stuck | Self::Missing)
    }
}

/// How a fault's value moves from its start to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultProfile {
    /// The amplitude at once (the paper's figure 1).
    Step,
    /// From 0 at the start in a straight line to the amplitude at the end (the paper's last figure).
    Ramp,
}

/// One timed fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Short name, unique in a scenario: "F1".
    pub id: String,
    /// Name for people: "load torque".
    pub name: String,
    /// Where it enters.
    pub point: FaultPoint,
    /// How it acts.
    pub kind: FaultKind,
    /// How it comes.
    pub profile: FaultProfile,
    /// Step height, or the ramp's last value; in [`unit`](Self::unit).
    pub amplitude: f64,
    /// First instant of the fault, s.
    pub start_s: f64,
    /// First instant without it, s: the interval is half-open.
    pub end_s: f64,
    /// Probability that the fault acts, anew in each control period. Default 1. An offset that acts seldom makes spikes,
    /// a gain an intermittent contact.
    #[serde(default = "always", skip_serializing_if = "is_always")]
    pub share: f64,
}

fn always() -> f64 {
    1.0
}

fn is_always(share: &f64) -> bool {
    *share == 1.0
}

impl Fault {
    /// The fault's value at `t_s` seconds, in [`unit`](Self::unit); 0 outside its interval.
    #[must_use]
    pub fn value(&self, t_s: f64) -> f64 {
        if !self.is_active(t_s) {
            return 0.0;
        }
        match self.profile {
            FaultProfile::Step => self.amplitude,
            FaultProfile::Ramp => self.amplitude * (t_s - self.start_s) / (self.end_s - self.start_s),
        }
    }

    /// Whether `t_s` (seconds) lies in the half-open interval from start to end.
    #[must_use]
    pub fn is_active(&self, t_s: f64) -> bool {
        self.start_s <= t_s && t_s < self.end_s
    }

    /// Unit of the amplitude and of [`value`](Self::value); "1" for a gain and for a probability.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self.kind {
            FaultKind::Gain | FaultKind::Stuck | FaultKind::Missing => "1",
            FaultKind::Offset | FaultKind::Coarse => self.point.unit(),
        }
    }
}

/// All faults at one point at one instant: `signal * factor + offset`, rounded, or the reading before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Injection {
    /// 1 plus the values of all gain faults.
    pub factor: f64,
    /// Sum of the values of all offset faults, in the point's unit.
    pub offset: f64,
    /// Coarsest step, in the point's unit; 0 is none.
    pub step: f64,
    /// The reading before is repeated.
    pub stuck: bool,
}

impl Injection {
    /// No fault.
    pub const NONE: Self = Self { factor: 1.0, offset: 0.0, step: 0.0, stuck: false };

    /// This and one more fault of `kind` with `value`.
    #[must_use]
    fn and(self, kind: FaultKind, value: f64) -> Self {
        match kind {
            FaultKind::Offset => Self { offset: self.offset + value, ..self },
            FaultKind::Gain => Self { factor: self.factor + value, ..self },
            FaultKind::Coarse => Self { step: self.step.max(value), ..self },
            FaultKind::Stuck => Self { stuck: true, ..self },
            FaultKind::Missing => self,
        }
    }

    /// The faulty signal, but for being stuck.
    #[must_use]
    pub fn apply(&self, signal: f64) -> f64 {
        quantize(signal * self.factor + self.offset, self.step)
    }

    /// The `reading`, or the one before (`last`) if stuck. Remembers it in `last`.
    pub fn hold(&self, reading: f64, last: &mut f64) -> f64 {
        if !self.stuck {
            *last = reading;
        }
        *last
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fault(kind: FaultKind, profile: FaultProfile) -> Fault {
        Fault {
            id: "F".to_owned(),
            name: "fault".to_owned(),
            point: FaultPoint::SpeedSensor,
            kind,
            profile,
            amplitude: 8.0,
            start_s: 60.0,
            end_s: 80.0,
            share: 1.0,
        }
    }

    #[test]
    fn a_step_has_its_amplitude_from_its_start_until_just_before_its_end() {
        let step = fault(FaultKind::Offset, FaultProfile::Step);
        assert_eq!(step.value(59.999), 0.0);
        assert_eq!(step.value(60.0), 8.0);
        assert_eq!(step.value(79.999), 8.0);
        assert_eq!(step.value(80.0), 0.0);
    }

    #[test]
    fn a_ramp_grows_from_nothing_to_its_amplitude_in_a_straight_line() {
        let ramp = fault(FaultKind::Offset, FaultProfile::Ramp);
        assert_eq!(ramp.value(60.0), 0.0);
        assert_eq!(ramp.value(65.0), 2.0);
        assert_eq!(ramp.value(70.0), 4.0);
        assert!((ramp.value(79.999) - 8.0).abs() < 1e-3);
        assert_eq!(ramp.value(80.0), 0.0);
    }

    #[test]
    fn offsets_add_and_gains_multiply_by_one_plus_their_value() {
        let offset = fault(FaultKind::Offset, FaultProfile::Step);
        let gain = Fault { amplitude: 0.5, ..fault(FaultKind::Gain, FaultProfile::Step) };
        let at = |faults: &[Fault], t| ActingFaults::new(1, faults).at(t).on(FaultPoint::SpeedSensor).apply(100.0);
        assert_eq!(at(std::slice::from_ref(&offset), 70.0), 108.0);
        assert_eq!(at(std::slice::from_ref(&gain), 70.0), 150.0);
        assert_eq!(at(&[offset.clone(), gain.clone(), offset.clone()], 70.0), 166.0);
        assert_eq!(at(&[offset, gain], 80.0), 100.0);
    }

    #[test]
    fn a_fault_acts_at_its_own_point_only() {
        let faults = [fault(FaultKind::Offset, FaultProfile::Step)];
        let mut acting = ActingFaults::new(1, &faults);
        assert_eq!(*acting.at(70.0).on(FaultPoint::LoadTorque), Injection::NONE);
        assert_eq!(*acting.at(70.0).on(FaultPoint::CurrentSensor), Injection::NONE);
    }

    #[test]
    fn the_unit_is_that_of_the_point_or_one_for_a_gain() {
        let unit = |point, kind| Fault { point, ..fault(kind, FaultProfile::Step) }.unit();
        assert_eq!(unit(FaultPoint::LoadTorque, FaultKind::Offset), "N m");
        assert_eq!(unit(FaultPoint::SpeedSensor, FaultKind::Offset), "rad/s");
        assert_eq!(unit(FaultPoint::CurrentSensor, FaultKind::Offset), "A");
        assert_eq!(unit(FaultPoint::LoadTorque, FaultKind::Gain), "1");
        assert_eq!(unit(FaultPoint::ArmatureResistance, FaultKind::Offset), "ohm");
        assert_eq!(unit(FaultPoint::VoltageSensor, FaultKind::Coarse), "V");
        assert_eq!(unit(FaultPoint::VoltageSensor, FaultKind::Stuck), "1");
    }

    proptest! {
        #[test]
        fn no_fault_exceeds_its_amplitude_or_acts_outside_its_interval(
            start_s in 0.0..100.0_f64,
            length_s in 0.001..100.0_f64,
            amplitude in -10.0..10.0_f64,
            t_s in -10.0..210.0_f64,
            is_ramp: bool,
        ) {
            let profile = if is_ramp { FaultProfile::Ramp } else { FaultProfile::Step };
            let end_s = start_s + length_s;
            let fault = Fault { start_s, end_s, amplitude, ..fault(FaultKind::Offset, profile) };
            let value = fault.value(t_s);
            prop_assert!(value.abs() <= amplitude.abs());
            prop_assert!((start_s..end_s).contains(&t_s) || value == 0.0);
        }
    }
}
