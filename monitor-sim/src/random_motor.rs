//! Motors, loads, loops and sensors drawn from a seed, so that a claim is tested on more than one motor.
//!
//! | drawn, log-uniform | from | to | |
//! |---|---|---|---|
//! | torque constant K | 0.03 | 0.3 | N m/A |
//! | armature resistance R | 0.2 | 2 | ohm |
//! | electrical time constant L/R | 1 | 10 | ms |
//! | mechanical time constant R J/K^2 | 50 | 500 | ms |
//! | set point | 30 | 300 | rad/s |
//! | currents for constant, viscous and propeller torque, each | 0.3 | 3 | A |
//! | speed loop | 5 | 25 | rad/s |
//! | noise of speed, share of the set point | 3e-4 | 3e-3 | |
//! | noise of current, share of the current | 2e-3 | 2e-2 | |
//! | noise of voltage, share of the voltage | 3e-4 | 3e-3 | |
//!
//! A current loop of 200 rad/s at 1 kHz. Small servo and thruster motors lie in these ranges; they are a choice, fixed
//! before anything was scored. Supply and current limit leave room for what noise and faults of half the signal demand,
//! so that no controller saturates in control.

use nalgebra::{Matrix2, Matrix4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::controller::{Cascade, ControllerParameters};
use crate::motor::{LoadParameters, MotorParameters};
use crate::noise::NoiseParameters;
use crate::scenario::{LearnWindow, Scenario, SetPoint, Start};

const CONTROL_RATE_HZ: f64 = 1000.0;

const CURRENT_BANDWIDTH_RAD_PER_S: f64 = 200.0;

/// Voltage and current limits over what the steady state takes.
const HEADROOM: f64 = 2.0;

/// How many sigmas of the noise that the controllers pass on fit under the limits besides.
const NOISE_SIGMAS: f64 = 8.0;

/// Largest magnitude of a closed-loop pole. The slowest wanted one is that of a speed loop of 5 rad/s with Ti = 5/ws:
/// exp(-1 rad/s * 1 ms) = 0.9990.
const LARGEST_POLE: f64 = 0.9995;

/// Share of its steady current that a motor's noise may make the current reference jitter by: beyond it, the loop is
/// tuned as nobody would.
const LARGEST_REFERENCE_NOISE: f64 = 0.5;

/// A fault-free mission of a random motor that turns from the beginning, learning from 0.5 s to 15.5 s: `duration_s` is
/// the caller's to set. The same seed gives the same motor.
#[must_use]
pub fn random_motor(seed: u64) -> Scenario {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    loop {
        let scenario = draw(&mut generator, seed);
        if scenario.validate().is_ok() && is_sound(&scenario) {
            return scenario;
        }
    }
}

fn draw(generator: &mut ChaCha8Rng, seed: u64) -> Scenario {
    let mut between = |low: f64, high: f64| low * (high / low).powf(generator.random::<f64>());
    let torque_constant = between(0.03, 0.3);
    let resistance = between(0.2, 2.0);
    let inductance = resistance * between(1e-3, 1e-2);
    let inertia = torque_constant.powi(2) / resistance * between(0.05, 0.5);
    let speed = between(30.0, 300.0);
    let [constant, viscous, propeller] = [(); 3].map(|()| torque_constant * between(0.3, 3.0));
    let motor = MotorParameters {
        resistance_ohm: resistance,
        inductance_h: inductance,
        torque_constant_nm_per_a: torque_constant,
        rotor_inertia_kg_m2: inertia,
        added_inertia_kg_m2: 0.0,
    };
    let load = LoadParameters {
        constant_nm: constant,
        viscous_nm_s: viscous / speed,
        quadratic_nm_s2: propeller / speed.powi(2),
        ..LoadParameters::default()
    };
    let speed_bandwidth_rad_per_s = between(5.0, 25.0);
    let (state, voltage) = motor.steady_state(speed, &load.mean());
    let noise = NoiseParameters {
        speed_sigma_rad_per_s: speed * between(3e-4, 3e-3),
        current_sigma_a: state.armature_current * between(2e-3, 2e-2),
        voltage_sigma_v: voltage * between(3e-4, 3e-3),
        ..NoiseParameters::default()
    };
    let unlimited = ControllerParameters {
        current_bandwidth_rad_per_s: CURRENT_BANDWIDTH_RAD_PER_S,
        speed_bandwidth_rad_per_s,
        current_limit_a: f64::MAX,
        supply_v: f64::MAX,
    };
    let jitter = reference_noise(&motor, &unlimited, &noise);
    let controller = ControllerParameters {
        current_limit_a: HEADROOM * state.armature_current + NOISE_SIGMAS * jitter,
        supply_v: HEADROOM * voltage
            + NOISE_SIGMAS * inductance * CURRENT_BANDWIDTH_RAD_PER_S * jitter.hypot(noise.current_sigma_a),
        ..unlimited
    };
    Scenario {
        name: format!("random motor {seed}"),
        duration_s: 60.0,
        control_rate_hz: CONTROL_RATE_HZ,
        record_every: 1,
        start: Start::Steady,
        learn: LearnWindow { start_s: 0.5, end_s: 15.5 },
        motor,
        load,
        controller,
        noise,
        set_points: vec![SetPoint { at_s: 0.0, rad_per_s: speed }],
        faults: Vec::new(),
    }
}

/// Sigma of the current reference for the noise of the speed sensor, A: the speed controller's gain times it.
fn reference_noise(motor: &MotorParameters, controller: &ControllerParameters, noise: &NoiseParameters) -> f64 {
    let cascade = Cascade::new(controller, motor, 1.0 / CONTROL_RATE_HZ);
    cascade.speed.proportional * noise.speed_sigma_rad_per_s
}

/// Whether the loop is stable about its set point, and quiet enough to be one.
fn is_sound(scenario: &Scenario) -> bool {
    let Scenario { motor, load, controller, noise, .. } = scenario;
    let (state, _) = motor.steady_state(scenario.set_point(0.0), &load.mean());
    reference_noise(motor, controller, noise) <= LARGEST_REFERENCE_NOISE * state.armature_current
        && largest_pole(scenario) <= LARGEST_POLE
}

/// Largest magnitude of the poles of the sampled closed loop, linear about the set point. States: speed, current, and
/// the integrals of the two controllers.
#[must_use]
pub fn largest_pole(scenario: &Scenario) -> f64 {
    let h = 1.0 / scenario.control_rate_hz;
    let motor = &scenario.motor;
    let (r, l, k, j) =
        (motor.resistance_ohm, motor.inductance_h, motor.torque_constant_nm_per_a, motor.inertia_kg_m2());
    let slope = scenario.load.viscous_nm_s + 2.0 * scenario.load.quadratic_nm_s2 * scenario.set_point(0.0).abs();
    // Zero-order hold: exp of ((A, b), (0, 0)) times the period holds the state's and the voltage's effect.
    let mut held = nalgebra::Matrix3::zeros();
    held.fixed_view_mut::<2, 2>(0, 0).copy_from(&(Matrix2::new(-slope / j, k / j, -k / l, -r / l) * h));
    held[(1, 2)] = h / l;
    let held = held.exp();
    let Cascade { speed, current } = Cascade::new(&scenario.controller, motor, h);
    let (ks, kc) = (speed.proportional + speed.integral_per_s * h, current.proportional + current.integral_per_s * h);
    // i_ref = ks (0 - w) + xs; u = kc (i_ref - i) + xc; xs and xc integrate their errors.
    let error = [-ks, -1.0, 1.0, 0.0];
    let voltage = std::array::from_fn::<f64, 4, _>(|n| kc * error[n] + if n == 3 { 1.0 } else { 0.0 });
    let closed = Matrix4::from_fn(|row, column| match row {
        0 | 1 => (if column < 2 { held[(row, column)] } else { 0.0 }) + held[(row, 2)] * voltage[column],
        2 => [-speed.integral_per_s * h, 0.0, 1.0, 0.0][column],
        _ => current.integral_per_s * h * error[column] + if column == 3 { 1.0 } else { 0.0 },
    });
    closed.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max)
}
