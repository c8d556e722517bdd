//! Random motors are motors, and the fast solution of their equations is the slow one's.

use monitor_sim::exponential::ExponentialMotor;
use monitor_sim::fault::{Fault, FaultKind, FaultPoint, FaultProfile};
use monitor_sim::motor::{LoadParameters, Motor, MotorState};
use monitor_sim::plant::Plant;
use monitor_sim::random_motor::{largest_pole, random_motor};
use monitor_sim::scenario::Scenario;

#[test]
fn two_hundred_random_motors_hold_their_set_point_inside_their_supply() {
    for seed in 0..200 {
        let scenario = Scenario { duration_s: 16.0, ..random_motor(seed) };
        let (limit_a, supply_v) = (scenario.controller.current_limit_a, scenario.controller.supply_v);
        let mut plant = Plant::exponential(&scenario, seed);
        let (mut sum, mut n, mut voltage, mut current) = (0.0, 0.0, 0.0_f64, 0.0_f64);
        while plant.next().is_some() {
            let state = plant.true_state();
            (sum, n) = (sum + state.speed, n + 1.0);
            voltage = voltage.max(state.armature_voltage.abs());
            current = current.max(state.armature_current.abs());
        }
        let speed = scenario.set_point(0.0);
        assert!((sum / n / speed - 1.0).abs() < 1e-3, "seed {seed}: mean speed {} of {speed}", sum / n);
        assert!(voltage < supply_v, "seed {seed}: {voltage} V of {supply_v}");
        assert!(current < limit_a, "seed {seed}: {current} A of {limit_a}");
        assert!(largest_pole(&scenario) < 1.0, "seed {seed}");
    }
}

#[test]
fn a_seed_is_one_motor_and_seeds_cover_their_decades() {
    assert_eq!(random_motor(7), random_motor(7));
    let constants: Vec<f64> = (0..200).map(|s| random_motor(s).motor.torque_constant_nm_per_a).collect();
    let below = |limit: f64| constants.iter().filter(|k| **k < limit).count();
    // Log-uniform over 0.03 to 0.3 N m/A: a quarter of 200 below each quarter of the decade; rejection shifts it a little.
    assert!(below(0.03) == 0 && below(0.3) == 200);
    assert!((30..70).contains(&below(0.03 * 10.0_f64.powf(0.25))), "{}", below(0.03 * 10.0_f64.powf(0.25)));
}

/// Largest difference over a mission, relative to set point and steady current, between the fast plant and Runge-Kutta
/// with fifty times its sub-steps, both under the voltages and loads of the fast one.
fn largest_difference(scenario: &Scenario) -> f64 {
    let period_s = 1.0 / scenario.control_rate_hz;
    let sub_steps = 50.0 * Motor::sub_steps_needed(&scenario.motor, period_s);
    let fine = Motor::with_sub_steps(&scenario.motor, period_s, sub_steps as u32);
    let load = scenario.load.mean();
    let (steady, _) = scenario.motor.steady_state(scenario.set_point(0.0), &load);
    let mut plant = Plant::exponential(scenario, 3);
    let mut exact: Option<MotorState> = None;
    let mut largest = 0.0_f64;
    let mut voltage = 0.0;
    while plant.next().is_some() {
        let state = plant.true_state();
        let here = MotorState { speed: state.speed, armature_current: state.armature_current };
        let there = exact.map_or(here, |x| fine.advance(x, voltage, &load));
        largest = largest
            .max(((here.speed - there.speed) / steady.speed).abs())
            .max(((here.armature_current - there.armature_current) / steady.armature_current).abs());
        (exact, voltage) = (Some(there), state.armature_voltage);
    }
    largest
}

#[test]
fn the_fast_plant_agrees_with_a_fine_runge_kutta_to_1e_9() {
    let off = Fault {
        id: "F2".to_owned(),
        name: "speed sensor".to_owned(),
        point: FaultPoint::SpeedSensor,
        kind: FaultKind::Gain,
        profile: FaultProfile::Step,
        amplitude: 0.05,
        start_s: 1.0,
        end_s: 3.0,
        share: 1.0,
    };
    for seed in 0..10 {
        let mut scenario = Scenario { duration_s: 16.0, faults: vec![off.clone()], ..random_motor(seed) };
        scenario.duration_s = 5.0;
        let difference = largest_difference(&scenario);
        assert!(difference < 1e-9, "seed {seed}: {difference:e}");
    }
}

#[test]
fn without_a_propeller_the_fast_solution_is_exact() {
    let scenario = Scenario { duration_s: 5.0, ..Scenario::figure_1() };
    let load = LoadParameters::default().mean();
    let fast = ExponentialMotor::new(&scenario.motor, &load, 300.0, 1e-3);
    let fine = Motor::with_sub_steps(&scenario.motor, 1e-3, 1000);
    let (mut a, mut b) = (MotorState::default(), MotorState::default());
    for _ in 0..1000 {
        (a, b) = (fast.advance(a, 12.0, &load), fine.advance(b, 12.0, &load));
        assert!(
            (a.speed - b.speed).abs() < 1e-9 && (a.armature_current - b.armature_current).abs() < 1e-9,
            "{a:?} {b:?}"
        );
    }
}
