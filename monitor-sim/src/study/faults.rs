//! The faults that studies put into a motor, and how large they are.

use std::iter;

use super::raw::{Moments, RawBaseline};
use crate::fault::{Fault, FaultKind, FaultPoint, FaultProfile};
use crate::plant::Plant;
use crate::scenario::{LearnWindow, Scenario, Start};

/// A fault of the plant without its size and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Culprit {
    /// Identifier in tables: the paper's number, or a letter.
    pub id: &'static str,
    /// Where it enters.
    pub point: FaultPoint,
    /// How it acts.
    pub kind: FaultKind,
}

const fn culprit(id: &'static str, point: FaultPoint, kind: FaultKind) -> Culprit {
    Culprit { id, point, kind }
}

impl Culprit {
    /// The paper's three, then those of the motor's constants and its supply.
    pub const ALL: [Self; 7] = [
        culprit("F1", FaultPoint::LoadTorque, FaultKind::Offset),
        culprit("F2", FaultPoint::SpeedSensor, FaultKind::Offset),
        culprit("F3", FaultPoint::CurrentSensor, FaultKind::Offset),
        culprit("R", FaultPoint::ArmatureResistance, FaultKind::Gain),
        culprit("K", FaultPoint::TorqueConstant, FaultKind::Gain),
        culprit("U", FaultPoint::VoltageActuator, FaultKind::Gain),
        culprit("J", FaultPoint::LoadInertia, FaultKind::Gain),
    ];

    /// The paper's three.
    #[must_use]
    pub const fn papers() -> &'static [Self] {
        Self::ALL.split_at(3).0
    }

    /// The amplitude of size 1 in the motor of figure 1: those of its faults (half the load, 2.7 % of the speed, a
    /// quarter of the current), and for the others what a winding or connector that warms and loosens, a magnet that
    /// ages, a supply that sags, and a propeller that is fouled may do.
    #[must_use]
    pub const fn figure_1_amplitude(&self) -> f64 {
        match self.point {
            FaultPoint::LoadTorque => 0.03,
            FaultPoint::SpeedSensor => 8.0,
            FaultPoint::ArmatureResistance | FaultPoint::CurrentSensor => 0.5,
            FaultPoint::LoadInertia => 1.0,
            _ => -0.1,
        }
    }

    /// This fault with its size and time.
    #[must_use]
    pub fn fault(&self, amplitude: f64, profile: FaultProfile, start_s: f64, end_s: f64) -> Fault {
        let Self { id, point, kind } = *self;
        let (id, name) = (id.to_owned(), super::watch::Name::of(point).words().to_owned());
        Fault { id, name, point, kind, profile, amplitude, start_s, end_s, share: 1.0 }
    }

    /// How the readings of speed, current and voltage have moved for amplitude 1 when the loop has settled again, in the
    /// linear approximation about the set point. The loop holds the speed that is read:
    ///
    /// | fault | true speed | current that is read | voltage |
    /// |---|---|---|---|
    /// | load torque | | 1/K | R/K |
    /// | speed sensor | -1 | -B/K | -(K + R B/K) |
    /// | current sensor | | 1 | |
    /// | resistance (gain) | | | R i |
    /// | torque constant (gain) | | -i | K w - R i |
    /// | voltage actuator (gain) | | | -u |
    /// | inertia | | | |
    #[must_use]
    pub fn settled_shift(&self, scenario: &Scenario) -> [f64; 3] {
        let (motor, speed) = (&scenario.motor, scenario.set_point(0.0));
        let (r, k) = (motor.resistance_ohm, motor.torque_constant_nm_per_a);
        let b = super::watch::Known::of(scenario).load_slope_nm_s;
        let (state, u) = motor.steady_state(speed, &scenario.load.mean());
        let i = state.armature_current;
        match self.point {
            FaultPoint::LoadTorque => [0.0, 1.0 / k, r / k],
            FaultPoint::SpeedSensor => [0.0, -b / k, -(k + r * b / k)],
            FaultPoint::CurrentSensor => [0.0, 1.0, 0.0],
            FaultPoint::ArmatureResistance => [0.0, 0.0, r * i],
            FaultPoint::TorqueConstant => [0.0, -i, k * speed - r * i],
            FaultPoint::VoltageActuator => [0.0, 0.0, -u],
            _ => [0.0; 3],
        }
    }

    /// Whether the settled readings of this fault and another are those of one direction in every motor: resistance and
    /// supply move the voltage alone. No monitor of settled readings tells them apart, and either name is right.
    #[must_use]
    pub fn is_in_group_with(&self, other: &Self) -> bool {
        let voltage_alone = |point| {
            matches!(point, FaultPoint::ArmatureResistance | FaultPoint::VoltageActuator | FaultPoint::VoltageSensor)
        };
        self.point == other.point || voltage_alone(self.point) && voltage_alone(other.point)
    }

    /// How much of one sigma of this fault's settled shift none of the `candidates` outside of its group can look like, by
    /// a learned baseline: 0 if one is in the same direction, 1 if all are at right angles.
    #[must_use]
    pub fn isolation(&self, candidates: &[Self], scenario: &Scenario, baseline: &RawBaseline) -> f64 {
        let own = self.settled_shift(scenario);
        let others = candidates.iter().filter(|other| !self.is_in_group_with(other));
        let shifts = others.map(|other| other.settled_shift(scenario)).filter(|shift| baseline.length(*shift) > 0.0);
        shifts.map(|shift| baseline.sine_between(own, shift)).fold(1.0, f64::min)
    }

    /// The amplitude whose settled shift is `sigmas` long by a learned baseline, but not beyond the largest, and the
    /// length that it has. Inertia shifts nothing: its amplitude grows with `sigmas` up to the largest at 16.
    #[must_use]
    pub fn amplitude(&self, scenario: &Scenario, baseline: &RawBaseline, sigmas: f64) -> (f64, f64) {
        let largest = self.largest(scenario);
        let per_amplitude = baseline.length(self.settled_shift(scenario));
        if per_amplitude == 0.0 {
            return ((largest * sigmas / 16.0).min(largest), 0.0);
        }
        let amplitude = (sigmas / per_amplitude).min(largest);
        (amplitude, amplitude * per_amplitude)
    }

    /// Whether it may go either way: a winding warms, a magnet weakens and debris comes, but loads, sensors and supplies
    /// are off in both directions.
    #[must_use]
    pub const fn has_both_signs(&self) -> bool {
        matches!(
            self.point,
            FaultPoint::LoadTorque | FaultPoint::SpeedSensor | FaultPoint::CurrentSensor | FaultPoint::VoltageActuator
        )
    }

    /// The largest amplitude that leaves a random motor inside its supply: half of the load or current, a fifth of the
    /// speed, half of a constant; twice the inertia more.
    #[must_use]
    pub fn largest(&self, scenario: &Scenario) -> f64 {
        let speed = scenario.set_point(0.0);
        let load = scenario.load.mean().torque(speed);
        match self.point {
            FaultPoint::LoadTorque => 0.5 * load,
            FaultPoint::SpeedSensor => 0.2 * speed,
            FaultPoint::CurrentSensor => 0.5 * load / scenario.motor.torque_constant_nm_per_a,
            FaultPoint::LoadInertia => 2.0,
            // A supply that halves asks for twice the voltage, which is all there is.
            FaultPoint::VoltageActuator | FaultPoint::TorqueConstant => 0.3,
            _ => 0.5,
        }
    }
}

/// The motor of figure 1, turning from the beginning, learning over the paper's 15 s, for `duration_s` seconds.
#[must_use]
pub fn figure_1_motor(duration_s: f64) -> Scenario {
    steady(&Scenario::figure_1(), duration_s)
}

/// The motor of a scenario without its faults, turning at its first set point from the beginning, learning for as long as
/// the scenario says from half a second on, for `duration_s` seconds.
#[must_use]
pub fn steady(scenario: &Scenario, duration_s: f64) -> Scenario {
    let LearnWindow { start_s, end_s } = scenario.learn;
    Scenario {
        duration_s,
        start: Start::Steady,
        learn: LearnWindow { start_s: BEGIN_S, end_s: BEGIN_S + (end_s - start_s) },
        set_points: scenario.set_points.iter().take(1).copied().collect(),
        ..scenario.without_faults()
    }
}

/// When a motor that is settled from the beginning is learned, s.
const BEGIN_S: f64 = 0.5;

/// The learned baseline of a fault-free run of a motor, without a monitor.
#[must_use]
pub fn raw_baseline(scenario: &Scenario, seed: u64) -> Option<RawBaseline> {
    let window = Scenario { duration_s: scenario.learn.end_s, ..scenario.without_faults() };
    let mut moments = Moments::default();
    let mut plant = Plant::exponential(&window, seed);
    iter::from_fn(|| plant.next()).filter(|s| s.t_s >= window.learn.start_s).for_each(|s| moments.push(s.channels()));
    moments.baseline()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_motor::random_motor;

    #[test]
    fn readings_settle_where_the_table_says() {
        for (seed, culprit) in (0..4).flat_map(|seed| Culprit::ALL.map(|culprit| (seed, culprit))) {
            let mut scenario = Scenario { duration_s: 60.0, ..random_motor(seed) };
            scenario.noise.speed_sigma_rad_per_s = 0.0;
            scenario.noise.current_sigma_a = 0.0;
            scenario.noise.voltage_sigma_v = 0.0;
            // A hundredth of the largest, so that the approximation holds to a few per cent.
            let amplitude = 0.01 * culprit.largest(&scenario);
            scenario.faults = vec![culprit.fault(amplitude, FaultProfile::Step, 20.0, 60.0)];
            let samples: Vec<_> = Plant::new(&scenario, seed).map(|s| s.channels()).collect();
            let (before, after) = (samples[19_999], samples[59_999]);
            let expected = culprit.settled_shift(&scenario);
            for channel in 0..3 {
                let moved = (after[channel] - before[channel]) / amplitude;
                let scale = expected[1].abs().max(expected[2].abs()).max(before[channel]);
                let error = (moved - expected[channel]).abs();
                assert!(
                    error < 0.02 * expected[channel].abs() + 1e-3 * scale,
                    "{} of motor {seed}, channel {channel}: {moved}, not {}",
                    culprit.id,
                    expected[channel]
                );
            }
        }
    }
}
