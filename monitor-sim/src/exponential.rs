//! The motor's two equations solved over a whole control period at once, for studies of a billion periods.
//!
//! Voltage and load are held over a period, so with the load torque in a Taylor series about the speed w0 at its
//! beginning,
//!
//! ```text
//! T(w) = T(w0) + s (w - w0) + q (w - w0)^2,   s = viscous + 2 quadratic |w0|,   q = quadratic sign(w0)
//! ```
//!
//! the deviation y from the state x0 at the beginning obeys y' = A(s) y + f(x0) - q y_w^2/J, which is solved by
//!
//! ```text
//! y(h) = F(s) f(x0) + small,   F(s) = integral of exp(A(s) t) over the period
//! ```
//!
//! (the exponential Rosenbrock-Euler method: Hochbruck, Ostermann, Acta Numerica 19, 2010, section 2.4). F is a matrix of
//! two by two, made beforehand for three slopes and interpolated between them; `small` is the integral of the quadratic
//! term along the solution without it. For a load without a quadratic part this is the exact solution.

use nalgebra::{Matrix2, Matrix4};

use crate::motor::{Load, MotorParameters, MotorState};

/// The motor prepared for one control period: frozen, the state is handed in.
#[derive(Debug, Clone, Copy)]
pub struct ExponentialMotor {
    resistance: f64,
    torque_constant: f64,
    per_inductance: f64,
    per_inertia: f64,
    period_s: f64,
    /// The slope in the middle of the three, N m s/rad, and the reciprocal of the distance to the others.
    slope: f64,
    per_distance: f64,
    /// F as a polynomial of the second degree in (s - slope) / distance.
    f: [Matrix2<f64>; 3],
}

impl ExponentialMotor {
    /// The motor for control periods of `period_s` seconds, most accurate while the load's slope is near that of `load`
    /// at `speed` (rad/s).
    #[must_use]
    pub fn new(motor: &MotorParameters, load: &Load, speed: f64, period_s: f64) -> Self {
        let slope = slope(load, speed);
        // A tenth of the slope on either side covers a tenth of the speed; the error of interpolation is of third order.
        // Without a slope there is none to interpolate.
        let distance = if slope > 0.0 { 0.1 * slope } else { motor.inertia_kg_m2() };
        let [below, at, above] = [-1.0, 0.0, 1.0].map(|k| integral(motor, slope + k * distance, period_s));
        Self {
            resistance: motor.resistance_ohm,
            torque_constant: motor.torque_constant_nm_per_a,
            per_inductance: 1.0 / motor.inductance_h,
            per_inertia: 1.0 / motor.inertia_kg_m2(),
            period_s,
            slope,
            per_distance: 1.0 / distance,
            f: [at, 0.5 * (above - below), 0.5 * (above + below) - at],
        }
    }

    /// The state one control period later, under `armature_voltage` (V) and `load`, both held.
    #[must_use]
    pub fn advance(&self, x: MotorState, armature_voltage: f64, load: &Load) -> MotorState {
        let acceleration = (self.torque_constant * x.armature_current - load.torque(x.speed)) * self.per_inertia;
        let rise = (armature_voltage - self.resistance * x.armature_current - self.torque_constant * x.speed)
            * self.per_inductance;
        let k = (slope(load, x.speed) - self.slope) * self.per_distance;
        let [f0, f1, f2] = &self.f;
        let at = |row, column| f0[(row, column)] + k * (f1[(row, column)] + k * f2[(row, column)]);
        let mut speed = at(0, 0) * acceleration + at(0, 1) * rise;
        let current = at(1, 0) * acceleration + at(1, 1) * rise;
        // y_w(t) = a t + b t^2 through its slope at the beginning and its value at the end.
        let h = self.period_s;
        let (a, b) = (acceleration * h, speed - acceleration * h);
        let squared = h * (a * a / 3.0 + a * b / 2.0 + b * b / 5.0);
        speed -= load.quadratic_nm_s2.copysign(x.speed) * squared * self.per_inertia;
        MotorState { speed: x.speed + speed, armature_current: x.armature_current + current }
    }
}

/// dT/dw at `speed` (rad/s), N m s/rad.
#[inline]
fn slope(load: &Load, speed: f64) -> f64 {
    load.viscous_nm_s + 2.0 * load.quadratic_nm_s2 * speed.abs()
}

/// The integral of exp(A t) over the period: the upper right block of exp of ((A, 1), (0, 0)) times the period.
fn integral(motor: &MotorParameters, slope: f64, period_s: f64) -> Matrix2<f64> {
    let MotorParameters { resistance_ohm: r, inductance_h: l, torque_constant_nm_per_a: k, .. } = *motor;
    let j = motor.inertia_kg_m2();
    let mut augmented = Matrix4::zeros();
    let a = Matrix2::new(-slope / j, k / j, -k / l, -r / l);
    augmented.fixed_view_mut::<2, 2>(0, 0).copy_from(&a);
    augmented.fixed_view_mut::<2, 2>(0, 2).copy_from(&Matrix2::identity());
    (augmented * period_s).exp().fixed_view::<2, 2>(0, 2).into_owned()
}
