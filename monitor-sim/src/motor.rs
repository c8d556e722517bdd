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
    /// terminal resistance 0.299 ohm, terminal inductance 0.0823 mH, torque constant 30.2 mN m/A, rotor inertia 142 g
    /// cm^2.
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

    /// The state in which the motor rests at `speed` (rad/s) against `load`, and the armature voltage (V) that holds it
    /// there: i = T(w)/K, u = R i + K w.
    #[must_use]
    pub fn steady_state(&self, speed: f64, load: &Load) -> (MotorState, f64) {
        let armature_current = load.torque(speed) / self.torque_constant_nm_per_a;
        let armature_voltage = self.resistance_ohm * armature_current + self.torque_constant_nm_per_a * speed;
        (MotorState { speed, armature_current }, armature_voltage)
    }
}

impl Default for MotorParameters {
    fn default() -> Self {
        Self { added_inertia_kg_m2: DEFAULT_ADDED_INERTIA_KG_M2, ..Self::MAXON_RE_40 }
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

/// Load torque and its turbulence. Default: 0.06 N m (2 A in the RE 40, a third of its nominal 6 A) that does not
/// depend on speed, without turbulence. The paper's fault table needs such a load: with a load that grows with speed, a
/// drift of the speed sensor also changes the current.
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
        Load { constant_nm: self.constant_nm, viscous_nm_s: self.viscous_nm_s, quadratic_nm_s2: self.quadratic_nm_s2 }
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

/// Largest sub-step as a share of the fastest time constant. For h/tau = 0.4 the local error of the Runge-Kutta step on
/// that mode is 0.4^5/120 = 8.5e-5 of its amplitude, and the mode itself has died out after a few sub-steps.
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
        let exchange =
            parameters.torque_constant_nm_per_a / (parameters.inductance_h * parameters.inertia_kg_m2()).sqrt();
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

    /// The motor integrated with `sub_steps` (1 to [`MAX_SUB_STEPS`]) sub-steps per control period, to study the
    /// integration error.
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
            speed: (self.torque_constant * x.armature_current - load.torque(x.speed)) * self.per_inertia,
            armature_current: (u - self.resistance * x.armature_current - self.torque_constant * x.speed)
                * self.per_inductance,
        }
    }
}

#[inline]
fn along(x: MotorState, slope: MotorState, h: f64) -> MotorState {
    MotorState { speed: x.speed + h * slope.speed, armature_current: x.armature_current + h * slope.armature_current }
}
