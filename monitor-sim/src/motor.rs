//! The motor of the paper's figure 2: a permanent-magnet DC motor with a load on its shaft, in f64.
//!
//! ```text
//! L di/dt = u - R i - K w          armature
//! J dw/dt = K i - T(w)             shaft
//! T(w)    = constant + viscous w + quadratic w |w|
//! ```
//!
//! Voltage and load are held over a control period (the drive's PWM holds its duty cycle); in between the two equations
//! are integrated by classical Runge-Kutta of fourth order with a fixed number of sub-steps.

use serde::{Deserialize, Serialize};

/// Constants of the motor with its propeller. Default: the [maxon RE 40](Self::MAXON_RE_40) with
/// [`DEFAULT_ADDED_INERTIA_KG_M2`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MotorParameters {
    /// Armature resistance R, ohm.
    pub resistance_ohm: f64,
    /// Armature inductance L, H.
    pub inductance_h: f64,
    /// Torque constant K, N m/A; in these units it is also the speed constant in V s/rad.
    pub torque_constant_nm_per_a: f64,
    /// Inertia of the rotor alone, kg m^2.
    pub rotor_inertia_kg_m2: f64,
    /// Inertia of what turns with it: propeller and entrained water, kg m^2.
    pub added_inertia_kg_m2: f64,
}

/// Propeller and entrained water, kg m^2. Our choice of a round figure, about 7 rotor inertias
/// (1.0e-4 / 142e-7 = 7.04); no data sheet gives it.
pub const DEFAULT_ADDED_INERTIA_KG_M2: f64 = 1.0e-4;

impl MotorParameters {
    /// maxon RE 40, 150 W, 24 V winding, order no. 148867, bare (no propeller). Data sheet:
    /// terminal resistance 0.299 ohm, terminal inductance 0.0823 mH, torque constant 30.2 mN m/A, rotor inertia 142 g cm^2.
    pub const MAXON_RE_40: Self = Self {
        resistance_ohm: 0.299,
        inductance_h: 0.0823e-3,
        torque_constant_nm_per_a: 30.2e-3,
        // 1 g cm^2 = 1e-3 kg * 1e-4 m^2 = 1e-7 kg m^2.
        rotor_inertia_kg_m2: 142.0e-7,
        added_inertia_kg_m2: 0.0,
    };

    /// Total inertia J on the shaft, kg m^2.
    #[must_use]
    pub fn inertia_kg_m2(&self) -> f64 {
        self.rotor_inertia_kg_m2 + self.added_inertia_kg_m2
    }

    /// Electrical time constant L/R, s. RE 40: 0.0823e-3 / 0.299 = 0.275 ms.
    #[must_use]
    pub fn electrical_time_constant_s(&self) -> f64 {
        self.inductance_h / self.resistance_ohm
    }

    /// Mechanical time constant R J/K^2, s. Bare RE 40: 0.299 * 142e-7 / 0.0302^2 = 4.66 ms (data sheet: 4.67 ms).
    #[must_use]
    pub fn mechanical_time_constant_s(&self) -> f64 {
        self.resistance_ohm * self.inertia_kg_m2() / self.torque_constant_nm_per_a.powi(2)
    }

    /// The state in which the motor rests at `speed` (rad/s) against `load`, and the armature voltage (V) that holds it there:
    /// i = T(w)/K, u = R i + K w.
    #[must_use]
    pub fn steady_state(&self, speed: f64, load: &Load) -> (MotorState, f64) {
        let armature_current = load.torque(speed) / self.torque_constant_nm_per_a;
        let armature_voltage =
            self.resistance_ohm * armature_current + self.torque_constant_nm_per_a * speed;
        (
            MotorState {
                speed,
                armature_current,
            },
            armature_voltage,
        )
    }
}

impl Default for MotorParameters {
    fn default() -> Self {
        Self {
            added_inertia_kg_m2: DEFAULT_ADDED_INERTIA_KG_M2,
            ..Self::MAXON_RE_40
        }
    }
}

/// Load torque on the shaft as a function of speed; the motor's own friction is part of it.
///
/// A positive constant part brakes forward rotation and does not change sign with it, as the load torque input of
/// figure 2: the plant stays linear as long as `quadratic_nm_s2` is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Part that does not depend on speed, N m.
    pub constant_nm: f64,
    /// Part proportional to speed, N m s/rad.
    pub viscous_nm_s: f64,
    /// Propeller part, proportional to w |w|, N m s^2/rad^2.
    pub quadratic_nm_s2: f64,
}

impl Load {
    /// Load torque at `speed` (rad/s), N m.
    #[must_use]
    #[inline]
    pub fn torque(&self, speed: f64) -> f64 {
        self.constant_nm + (self.viscous_nm_s + self.quadratic_nm_s2 * speed.abs()) * speed
    }
}

/// Load torque and its turbulence. Default: 0.06 N m (2 A in the RE 40, a third of its nominal 6 A) that does not depend on
/// speed, without turbulence. The paper's fault table needs such a load: with a load that grows with speed, a drift of the
/// speed sensor also changes the current.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoadParameters {
    /// See [`Load::constant_nm`].
    pub constant_nm: f64,
    /// See [`Load::viscous_nm_s`].
    pub viscous_nm_s: f64,
    /// See [`Load::quadratic_nm_s2`].
    pub quadratic_nm_s2: f64,
    /// Standard deviation of the turbulent part, N m; 0 is none.
    pub turbulence_sigma_nm: f64,
    /// Bandwidth of the turbulent part (its -3 dB corner), Hz.
    pub turbulence_bandwidth_hz: f64,
}

impl LoadParameters {
    /// The load without its turbulence.
    #[must_use]
    pub fn mean(&self) -> Load {
        Load {
            constant_nm: self.constant_nm,
            viscous_nm_s: self.viscous_nm_s,
            quadratic_nm_s2: self.quadratic_nm_s2,
        }
    }
}

impl Default for LoadParameters {
    fn default() -> Self {
        Self {
            constant_nm: 0.06,
            viscous_nm_s: 0.0,
            quadratic_nm_s2: 0.0,
            turbulence_sigma_nm: 0.0,
            turbulence_bandwidth_hz: 1.0,
        }
    }
}

/// What moves: the two stored energies of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorState {
    /// Shaft speed w, rad/s.
    pub speed: f64,
    /// Armature current i, A.
    pub armature_current: f64,
}

/// Largest sub-step as a share of the fastest time constant. For h/tau = 0.4 the local error of the Runge-Kutta step on that
/// mode is 0.4^5/120 = 8.5e-5 of its amplitude, and the mode itself has died out after a few sub-steps.
const SUB_STEP_SHARE: f64 = 0.4;

/// Most sub-steps in a control period: a hundred times what the RE 40 takes at 1 kHz.
pub const MAX_SUB_STEPS: u32 = 1000;

/// The motor prepared for one control period: frozen, the state is handed in.
#[derive(Debug, Clone, Copy)]
pub struct Motor {
    resistance: f64,
    torque_constant: f64,
    /// 1/L and 1/J: the inner loop multiplies, a division there costs as much as the rest of it.
    per_inductance: f64,
    per_inertia: f64,
    sub_steps: u32,
    sub_step_s: f64,
}

impl Motor {
    /// Sub-steps that one control period of `period_s` seconds needs. The fastest mode cannot be faster than
    /// R/L + K/sqrt(L J) (armature alone, plus the exchange between current and speed). RE 40 with propeller at 1 kHz:
    /// (3633 + 311) /s * 1 ms / 0.4 = 9.9, so 10.
    #[must_use]
    pub fn sub_steps_needed(parameters: &MotorParameters, period_s: f64) -> f64 {
        let exchange = parameters.torque_constant_nm_per_a
            / (parameters.inductance_h * parameters.inertia_kg_m2()).sqrt();
        let fastest_per_s = 1.0 / parameters.electrical_time_constant_s() + exchange;
        (period_s * fastest_per_s / SUB_STEP_SHARE).ceil().max(1.0)
    }

    /// The motor integrated with as many sub-steps per control period of `period_s` seconds as
    /// [`sub_steps_needed`](Self::sub_steps_needed) says.
    #[must_use]
    pub fn new(parameters: &MotorParameters, period_s: f64) -> Self {
        let sub_steps = Self::sub_steps_needed(parameters, period_s) as u32;
        Self::with_sub_steps(parameters, period_s, sub_steps)
    }

    /// The motor integrated with `sub_steps` (1 to [`MAX_SUB_STEPS`]) sub-steps per control period, to study the integration error.
    #[must_use]
    pub fn with_sub_steps(parameters: &MotorParameters, period_s: f64, sub_steps: u32) -> Self {
        let sub_steps = sub_steps.clamp(1, MAX_SUB_STEPS);
        Self {
            resistance: parameters.resistance_ohm,
            torque_constant: parameters.torque_constant_nm_per_a,
            per_inductance: 1.0 / parameters.inductance_h,
            per_inertia: 1.0 / parameters.inertia_kg_m2(),
            sub_steps,
            sub_step_s: period_s / f64::from(sub_steps),
        }
    }

    /// The state one control period later, under `armature_voltage` (V) and `load`, both held.
    #[must_use]
    pub fn advance(&self, state: MotorState, armature_voltage: f64, load: &Load) -> MotorState {
        let h = self.sub_step_s;
        (0..self.sub_steps).fold(state, |x, _| {
            let k1 = self.derivative(x, armature_voltage, load);
            let k2 = self.derivative(along(x, k1, 0.5 * h), armature_voltage, load);
            let k3 = self.derivative(along(x, k2, 0.5 * h), armature_voltage, load);
            let k4 = self.derivative(along(x, k3, h), armature_voltage, load);
            let mean = MotorState {
                speed: k1.speed + 2.0 * (k2.speed + k3.speed) + k4.speed,
                armature_current: k1.armature_current
                    + 2.0 * (k2.armature_current + k3.armature_current)
                    + k4.armature_current,
            };
            along(x, mean, h / 6.0)
        })
    }

    /// The two differential equations: (dw/dt, di/dt).
    #[inline]
    fn derivative(&self, x: MotorState, u: f64, load: &Load) -> MotorState {
        MotorState {
            speed: (self.torque_constant * x.armature_current - load.torque(x.speed))
                * self.per_inertia,
            armature_current: (u
                - self.resistance * x.armature_current
                - self.torque_constant * x.speed)
                * self.per_inductance,
        }
    }
}

#[inline]
fn along(x: MotorState, slope: MotorState, h: f64) -> MotorState {
    MotorState {
        speed: x.speed + h * slope.speed,
        armature_current: x.armature_current + h * slope.armature_current,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const RE_40: MotorParameters = MotorParameters::MAXON_RE_40;
    const FREE: Load = Load {
        constant_nm: 0.0,
        viscous_nm_s: 0.0,
        quadratic_nm_s2: 0.0,
    };
    const REST: MotorState = MotorState {
        speed: 0.0,
        armature_current: 0.0,
    };

    /// Runs the motor from `state` for `periods` control periods of `period_s`.
    fn run(motor: &Motor, state: MotorState, u: f64, load: &Load, periods: usize) -> MotorState {
        (0..periods).fold(state, |x, _| motor.advance(x, u, load))
    }

    #[test]
    fn the_parameters_give_the_data_sheet_no_load_speed_stall_values_and_time_constant() {
        // No-load speed 7580 rpm at 24 V and 137 mA: the friction is what 137 mA turns against.
        let friction = Load {
            constant_nm: RE_40.torque_constant_nm_per_a * 0.137,
            ..FREE
        };
        let motor = Motor::new(&RE_40, 1e-3);
        let no_load = run(&motor, REST, 24.0, &friction, 200);
        assert_relative_eq!(
            no_load.speed * 60.0 / std::f64::consts::TAU,
            7580.0,
            max_relative = 1e-3
        );
        assert_relative_eq!(no_load.armature_current, 0.137, max_relative = 1e-6);
        // Stall 80.2 A and 2420 mN m at 24 V.
        let stall_current = 24.0 / RE_40.resistance_ohm;
        assert_relative_eq!(stall_current, 80.2, max_relative = 2e-3);
        assert_relative_eq!(
            stall_current * RE_40.torque_constant_nm_per_a,
            2.420,
            max_relative = 3e-3
        );
        assert_relative_eq!(
            RE_40.mechanical_time_constant_s(),
            4.67e-3,
            max_relative = 4e-3
        );
        assert_relative_eq!(
            RE_40.electrical_time_constant_s(),
            0.275e-3,
            max_relative = 2e-3
        );
    }

    #[test]
    fn open_loop_the_motor_settles_where_the_closed_formula_says() {
        let parameters = MotorParameters::default();
        let motor = Motor::new(&parameters, 1e-3);
        let (r, k) = (
            parameters.resistance_ohm,
            parameters.torque_constant_nm_per_a,
        );
        let (u, t0, b) = (12.0, 0.03, 1.0e-4);
        // R (T0 + b w)/K + K w = u, solved for w.
        let speed = (k * u - r * t0) / (k * k + r * b);
        let load = Load {
            constant_nm: t0,
            viscous_nm_s: b,
            quadratic_nm_s2: 0.0,
        };
        let settled = run(&motor, REST, u, &load, 2000);
        assert_relative_eq!(settled.speed, speed, max_relative = 1e-10);
        assert_relative_eq!(
            settled.armature_current,
            (t0 + b * speed) / k,
            max_relative = 1e-10
        );
        // With a propeller q w |w|: q R/K w^2 + K w - u = 0, and the mirror image for the reverse voltage.
        let q = 1.0e-6;
        let speed = (-k + (k * k + 4.0 * q * r / k * u).sqrt()) / (2.0 * q * r / k);
        let load = Load {
            quadratic_nm_s2: q,
            ..FREE
        };
        assert_relative_eq!(
            run(&motor, REST, u, &load, 2000).speed,
            speed,
            max_relative = 1e-10
        );
        assert_relative_eq!(
            run(&motor, REST, -u, &load, 2000).speed,
            -speed,
            max_relative = 1e-10
        );
    }

    #[test]
    fn steady_state_is_a_state_the_motor_does_not_leave() {
        let parameters = MotorParameters::default();
        let load = Load {
            constant_nm: 0.02,
            viscous_nm_s: 1e-5,
            quadratic_nm_s2: 2e-7,
        };
        let (state, u) = parameters.steady_state(250.0, &load);
        let later = run(&Motor::new(&parameters, 1e-3), state, u, &load, 1000);
        assert_relative_eq!(later.speed, 250.0, max_relative = 1e-10);
        assert_relative_eq!(
            later.armature_current,
            state.armature_current,
            max_relative = 1e-10
        );
    }

    #[test]
    fn with_the_shaft_held_the_current_rises_with_l_over_r() {
        // An inertia of 1 kg m^2 holds the shaft for the few milliseconds that matter.
        let held = MotorParameters {
            added_inertia_kg_m2: 1.0,
            ..RE_40
        };
        let tau = held.electrical_time_constant_s();
        let motor = Motor::new(&held, tau);
        let one_tau = motor.advance(REST, 1.0, &FREE).armature_current;
        let expected = (1.0 - (-1.0_f64).exp()) / held.resistance_ohm;
        assert_relative_eq!(one_tau, expected, max_relative = 1e-3);
    }

    #[test]
    fn the_speed_step_response_has_both_time_constants() {
        // Exact response of the linear motor: w(t) = u/K (1 - (s2 e^(s1 t) - s1 e^(s2 t))/(s2 - s1)), with s1, s2 the roots
        // of te tm s^2 + tm s + 1.
        let parameters = MotorParameters::default();
        let (te, tm) = (
            parameters.electrical_time_constant_s(),
            parameters.mechanical_time_constant_s(),
        );
        let root = (tm * tm - 4.0 * te * tm).sqrt();
        let (s1, s2) = (
            (-tm + root) / (2.0 * te * tm),
            (-tm - root) / (2.0 * te * tm),
        );
        let motor = Motor::new(&parameters, 1e-3);
        let mut state = REST;
        for n in 1..=200 {
            state = motor.advance(state, 12.0, &FREE);
            let t = f64::from(n) * 1e-3;
            let exact = 12.0 / parameters.torque_constant_nm_per_a
                * (1.0 - (s2 * (s1 * t).exp() - s1 * (s2 * t).exp()) / (s2 - s1));
            assert_relative_eq!(state.speed, exact, epsilon = 1e-3, max_relative = 0.0);
        }
        // The slow root is the mechanical time constant to first order in te/tm.
        assert_relative_eq!(-1.0 / s1, tm, max_relative = 1.2 * te / tm);
    }

    #[test]
    fn halving_the_sub_step_divides_the_integration_error_by_about_sixteen() {
        let parameters = MotorParameters::default();
        let load = Load {
            constant_nm: 0.02,
            viscous_nm_s: 1e-5,
            quadratic_nm_s2: 2e-7,
        };
        let after_2_ms = |sub_steps| {
            let motor = Motor::with_sub_steps(&parameters, 1e-3, sub_steps);
            run(&motor, REST, 12.0, &load, 2).armature_current
        };
        let exact = after_2_ms(1000);
        let errors: Vec<f64> = [10, 20, 40]
            .iter()
            .map(|&n| (after_2_ms(n) - exact).abs())
            .collect();
        for pair in errors.windows(2) {
            let ratio = pair[0] / pair[1];
            assert!((12.0..24.0).contains(&ratio), "error ratio {ratio}");
        }
        // The sub-steps in use: relative to the 24 A that flow by then.
        assert!(errors[0] < 1e-4, "error with 10 sub-steps {} A", errors[0]);
    }

    #[test]
    fn the_default_motor_at_1_khz_takes_ten_sub_steps() {
        assert_eq!(Motor::new(&MotorParameters::default(), 1e-3).sub_steps, 10);
    }
}
