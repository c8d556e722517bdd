//! The drive's cascade of the paper's figure 2: a speed PI whose output is the current reference, and a current PI
//! whose output is the armature voltage. Discrete, one step per control period, both with limits and anti-windup.

use serde::{Deserialize, Serialize};

use crate::motor::MotorParameters;

/// Bandwidths and limits of the cascade.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ControllerParameters {
    /// Bandwidth wc of the current loop, rad/s.
    pub current_bandwidth_rad_per_s: f64,
    /// Bandwidth ws of the speed loop, rad/s. Well below the current loop's, or the cascade is none.
    pub speed_bandwidth_rad_per_s: f64,
    /// Limit of the current reference in both directions, A.
    pub current_limit_a: f64,
    /// Supply voltage: limit of the armature voltage in both directions, V.
    pub supply_v: f64,
}

impl Default for ControllerParameters {
    /// A tenth between the loops; limits are the nominal current (6 A) and voltage (24 V) of the maxon RE 40.
    fn default() -> Self {
        Self {
            current_bandwidth_rad_per_s: 200.0,
            speed_bandwidth_rad_per_s: 20.0,
            current_limit_a: 6.0,
            supply_v: 24.0,
        }
    }
}

/// Gains, period and output limit of one PI controller. Frozen; its integral is the [`PiState`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pi {
    /// Proportional gain, output unit per error unit.
    pub proportional: f64,
    /// Integral gain, output unit per error unit and second.
    pub integral_per_s: f64,
    /// Control period, s.
    pub period_s: f64,
    /// Output limit in both directions, output unit.
    pub limit: f64,
}

/// What a PI controller remembers: its integral, in its output's unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PiState {
    /// Integral part of the output.
    pub integral: f64,
}

impl Pi {
    /// The output for `error`, within the limit.
    ///
    /// Anti-windup by clamping: the integral stands still while the output is at its limit and the error drives it
    /// further out. Chosen over back-calculation because it has no gain of its own to tune.
    pub fn step(&self, state: &mut PiState, error: f64) -> f64 {
        let integral = state.integral + self.integral_per_s * error * self.period_s;
        let wanted = self.proportional * error + integral;
        let output = wanted.min(self.limit).max(-self.limit);
        let winding_up = wanted != output && error * wanted > 0.0;
        if !winding_up {
            state.integral = integral;
        }
        output
    }
}

/// Both controllers. Frozen; the integrals are the [`CascadeState`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cascade {
    /// Speed error (rad/s) to current reference (A).
    pub speed: Pi,
    /// Current error (A) to armature voltage (V).
    pub current: Pi,
}

/// What the cascade remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CascadeState {
    /// Integral of the speed controller, A.
    pub speed: PiState,
    /// Integral of the current controller, V.
    pub current: PiState,
}

/// The speed controller's integral action takes over a fifth below its bandwidth, Ti = 5/ws: slow enough to leave
/// atan(5) = 79 degrees of phase margin before the current loop takes its share.
const SPEED_INTEGRAL_RATIO: f64 = 5.0;

impl Cascade {
    /// The cascade for a motor, by pole placement, run every `period_s` seconds.
    ///
    /// Current loop: the PI's zero cancels the armature's pole, kp = L wc, ki = R wc, which leaves wc/s.
    /// Speed loop: kp = J ws/K puts the crossing of the shaft's K/(J s) at ws; ki = kp ws/5.
    #[must_use]
    pub fn new(controller: &ControllerParameters, motor: &MotorParameters, period_s: f64) -> Self {
        let wc = controller.current_bandwidth_rad_per_s;
        let ws = controller.speed_bandwidth_rad_per_s;
        let speed_gain = motor.inertia_kg_m2() * ws / motor.torque_constant_nm_per_a;
        Self {
            speed: Pi {
                proportional: speed_gain,
                integral_per_s: speed_gain * ws / SPEED_INTEGRAL_RATIO,
                period_s,
                limit: controller.current_limit_a,
            },
            current: Pi {
                proportional: motor.inductance_h * wc,
                integral_per_s: motor.resistance_ohm * wc,
                period_s,
                limit: controller.supply_v,
            },
        }
    }

    /// One control period: set point and speed reading in rad/s, current reading in A; gives the armature voltage in V.
    pub fn step(&self, state: &mut CascadeState, set_point: f64, speed: f64, current: f64) -> f64 {
        let current_reference = self.speed.step(&mut state.speed, set_point - speed);
        self.current.step(&mut state.current, current_reference - current)
    }
}

impl CascadeState {
    /// The state in which the cascade rests with zero errors and these outputs: current reference in A, voltage in V.
    #[must_use]
    pub fn at_rest_with(current_reference: f64, armature_voltage: f64) -> Self {
        Self { speed: PiState { integral: current_reference }, current: PiState { integral: armature_voltage } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const PI: Pi = Pi { proportional: 2.0, integral_per_s: 10.0, period_s: 0.01, limit: 5.0 };

    #[test]
    fn a_pi_adds_its_gain_times_the_error_to_the_integral_of_the_error() {
        let mut state = PiState::default();
        for n in 1..=20 {
            let output = PI.step(&mut state, 1.0);
            assert_relative_eq!(output, 2.0 + 0.1 * f64::from(n), max_relative = 1e-12);
        }
    }

    #[test]
    fn the_output_stays_within_its_limits() {
        let mut state = PiState::default();
        assert_eq!(PI.step(&mut state, 1e6), 5.0);
        assert_eq!(PI.step(&mut state, -1e6), -5.0);
    }

    #[test]
    fn a_saturated_pi_does_not_wind_up_and_leaves_the_limit_when_the_error_allows() {
        let mut state = PiState::default();
        for _ in 0..1000 {
            PI.step(&mut state, 4.0);
        }
        assert_eq!(state.integral, 0.0, "integral at the limit");
        assert_relative_eq!(PI.step(&mut state, 0.5), 1.05, max_relative = 1e-12);
    }

    #[test]
    fn a_saturated_pi_still_integrates_towards_the_inside() {
        let mut state = PiState { integral: 50.0 };
        PI.step(&mut state, -1.0);
        assert_relative_eq!(state.integral, 49.9, max_relative = 1e-12);
    }

    #[test]
    fn the_gains_are_those_of_the_pole_placement() {
        let motor = MotorParameters::default();
        let cascade = Cascade::new(&ControllerParameters::default(), &motor, 1e-3);
        assert_relative_eq!(cascade.current.proportional, 0.0823e-3 * 200.0, max_relative = 1e-12);
        assert_relative_eq!(cascade.current.integral_per_s, 0.299 * 200.0, max_relative = 1e-12);
        let kp = 1.142e-4 * 20.0 / 0.0302;
        assert_relative_eq!(cascade.speed.proportional, kp, max_relative = 1e-12);
        assert_relative_eq!(cascade.speed.integral_per_s, kp * 20.0 / 5.0, max_relative = 1e-12);
    }

    #[test]
    fn at_rest_the_cascade_holds_its_outputs() {
        let cascade = Cascade::new(&ControllerParameters::default(), &MotorParameters::default(), 1e-3);
        let mut state = CascadeState::at_rest_with(2.0, 9.7);
        for _ in 0..10 {
            assert_eq!(cascade.step(&mut state, 300.0, 300.0, 2.0), 9.7);
        }
    }
}
