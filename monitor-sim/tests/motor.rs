//! The motor by itself: data sheet, closed formulas, time constants, integration error.

use approx::assert_relative_eq;
use monitor_sim::motor::{Load, Motor, MotorParameters, MotorState};

const RE_40: MotorParameters = MotorParameters::MAXON_RE_40;
const FREE: Load = Load { constant_nm: 0.0, viscous_nm_s: 0.0, quadratic_nm_s2: 0.0 };
const REST: MotorState = MotorState { speed: 0.0, armature_current: 0.0 };

/// Runs the motor from `state` for `periods` control periods of `period_s`.
fn run(motor: &Motor, state: MotorState, u: f64, load: &Load, periods: usize) -> MotorState {
    (0..periods).fold(state, |x, _| motor.advance(x, u, load))
}

#[test]
fn the_parameters_give_the_data_sheet_no_load_speed_stall_values_and_time_constant() {
    // No-load speed 7580 rpm at 24 V and 137 mA: the friction is what 137 mA turns against.
    let friction = Load { constant_nm: RE_40.torque_constant_nm_per_a * 0.137, ..FREE };
    let motor = Motor::new(&RE_40, 1e-3);
    let no_load = run(&motor, REST, 24.0, &friction, 200);
    assert_relative_eq!(no_load.speed * 60.0 / std::f64::consts::TAU, 7580.0, max_relative = 1e-3);
    assert_relative_eq!(no_load.armature_current, 0.137, max_relative = 1e-6);
    // Stall 80.2 A and 2420 mN m at 24 V.
    let stall_current = 24.0 / RE_40.resistance_ohm;
    assert_relative_eq!(stall_current, 80.2, max_relative = 2e-3);
    assert_relative_eq!(stall_current * RE_40.torque_constant_nm_per_a, 2.420, max_relative = 3e-3);
    assert_relative_eq!(RE_40.mechanical_time_constant_s(), 4.67e-3, max_relative = 4e-3);
    assert_relative_eq!(RE_40.electrical_time_constant_s(), 0.275e-3, max_relative = 2e-3);
}

#[test]
fn open_loop_the_motor_settles_where_the_closed_formula_says() {
    let parameters = MotorParameters::default();
    let motor = Motor::new(&parameters, 1e-3);
    let (r, k) = (parameters.resistance_ohm, parameters.torque_constant_nm_per_a);
    let (u, t0, b) = (12.0, 0.03, 1.0e-4);
    // R (T0 + b w)/K + K w = u, solved for w.
    let speed = (k * u - r * t0) / (k * k + r * b);
    let load = Load { constant_nm: t0, viscous_nm_s: b, quadratic_nm_s2: 0.0 };
    let settled = run(&motor, REST, u, &load, 2000);
    assert_relative_eq!(settled.speed, speed, max_relative = 1e-10);
    assert_relative_eq!(settled.armature_current, (t0 + b * speed) / k, max_relative = 1e-10);
    // With a propeller q w |w|: q R/K w^2 + K w - u = 0, and the mirror image for the reverse voltage.
    let q = 1.0e-6;
    let speed = (-k + (k * k + 4.0 * q * r / k * u).sqrt()) / (2.0 * q * r / k);
    let load = Load { quadratic_nm_s2: q, ..FREE };
    assert_relative_eq!(run(&motor, REST, u, &load, 2000).speed, speed, max_relative = 1e-10);
    assert_relative_eq!(run(&motor, REST, -u, &load, 2000).speed, -speed, max_relative = 1e-10);
}

#[test]
fn steady_state_is_a_state_the_motor_does_not_leave() {
    let parameters = MotorParameters::default();
    let load = Load { constant_nm: 0.02, viscous_nm_s: 1e-5, quadratic_nm_s2: 2e-7 };
    let (state, u) = parameters.steady_state(250.0, &load);
    let later = run(&Motor::new(&parameters, 1e-3), state, u, &load, 1000);
    assert_relative_eq!(later.speed, 250.0, max_relative = 1e-10);
    assert_relative_eq!(later.armature_current, state.armature_current, max_relative = 1e-10);
}

#[test]
fn with_the_shaft_held_the_current_rises_with_l_over_r() {
    // An inertia of 1 kg m^2 holds the shaft for the few milliseconds that matter.
    let held = MotorParameters { added_inertia_kg_m2: 1.0, ..RE_40 };
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
    let (te, tm) = (parameters.electrical_time_constant_s(), parameters.mechanical_time_constant_s());
    let root = (tm * tm - 4.0 * te * tm).sqrt();
    let (s1, s2) = ((-tm + root) / (2.0 * te * tm), (-tm - root) / (2.0 * te * tm));
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
    let load = Load { constant_nm: 0.02, viscous_nm_s: 1e-5, quadratic_nm_s2: 2e-7 };
    let after_2_ms = |sub_steps| {
        let motor = Motor::with_sub_steps(&parameters, 1e-3, sub_steps);
        run(&motor, REST, 12.0, &load, 2).armature_current
    };
    let exact = after_2_ms(1000);
    let errors: Vec<f64> = [10, 20, 40].iter().map(|&n| (after_2_ms(n) - exact).abs()).collect();
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((12.0..24.0).contains(&ratio), "error ratio {ratio}");
    }
    // The sub-steps in use: relative to the 24 A that flow by then.
    assert!(errors[0] < 1e-4, "error with 10 sub-steps {} A", errors[0]);
}

#[test]
fn the_default_motor_at_1_khz_takes_ten_sub_steps() {
    assert_eq!(Motor::sub_steps_needed(&MotorParameters::default(), 1e-3), 10.0);
    let (chosen, ten) =
        (Motor::new(&MotorParameters::default(), 1e-3), Motor::with_sub_steps(&MotorParameters::default(), 1e-3, 10));
    assert_eq!(chosen.advance(REST, 12.0, &FREE), ten.advance(REST, 12.0, &FREE));
}
