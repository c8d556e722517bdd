//! What a scenario must fulfil. Conditions are written so that NaN fails them.

use super::{Scenario, ScenarioError};
use crate::motor::{MAX_SUB_STEPS, Motor};

mod faults;

type Checked = Result<(), ScenarioError>;

/// Shortest learning window, s: 100 samples at 1 kHz, fewer make no covariance worth the name.
const SHORTEST_LEARN_S: f64 = 0.1;

/// Longest mission, in control periods: what the monitor's 32-bit sample counts can hold, seven weeks at 1 kHz.
const MOST_CONTROL_PERIODS: f64 = 4_294_967_295.0;

/// The discrete current loop multiplies its error by 1 - wc T each period: 0.5 leaves it well damped, 2 is its
/// stability limit.
const LARGEST_BANDWIDTH_TIMES_PERIOD: f64 = 0.5;

/// A cascade needs an inner loop that is clearly faster than the outer one.
const SMALLEST_BANDWIDTH_RATIO: f64 = 4.0;

pub(super) fn check(scenario: &Scenario) -> Checked {
    check_times(scenario)?;
    check_motor(scenario)?;
    check_load(scenario)?;
    check_controller(scenario)?;
    check_noise(scenario)?;
    check_set_points(scenario)?;
    faults::check(scenario)
}

fn check_times(s: &Scenario) -> Checked {
    positive("duration_s", s.duration_s)?;
    positive("control_rate_hz", s.control_rate_hz)?;
    let periods = s.duration_s * s.control_rate_hz;
    require(
        periods <= MOST_CONTROL_PERIODS,
        "duration_s",
        format!("= {} makes {periods} control periods", s.duration_s),
        format!("shorten the mission to at most {MOST_CONTROL_PERIODS} of them, or lower control_rate_hz"),
    )?;
    require(s.record_every >= 1, "record_every", "is 0", "set it to 1 to record every control period")?;
    let learn = s.learn;
    not_negative("learn.start_s", learn.start_s)?;
    require(
        learn.end_s - learn.start_s >= SHORTEST_LEARN_S,
        "learn.end_s",
        format!("= {} leaves less than {SHORTEST_LEARN_S} s after learn.start_s = {}", learn.end_s, learn.start_s),
        "lengthen the learning window",
    )?;
    within_mission("learn.end_s", learn.end_s, s.duration_s)
}

fn check_motor(s: &Scenario) -> Checked {
    let motor = &s.motor;
    positive("motor.resistance_ohm", motor.resistance_ohm)?;
    positive("motor.inductance_h", motor.inductance_h)?;
    positive("motor.torque_constant_nm_per_a", motor.torque_constant_nm_per_a)?;
    positive("motor.rotor_inertia_kg_m2", motor.rotor_inertia_kg_m2)?;
    not_negative("motor.added_inertia_kg_m2", motor.added_inertia_kg_m2)?;
    let sub_steps = Motor::sub_steps_needed(motor, 1.0 / s.control_rate_hz);
    require(
        sub_steps <= f64::from(MAX_SUB_STEPS),
        "motor.inductance_h",
        format!(
            "= {} makes the motor so fast that it needs {sub_steps} sub-steps a control period",
            motor.inductance_h
        ),
        format!("check the units, or raise control_rate_hz: the limit is {MAX_SUB_STEPS}"),
    )
}

fn check_load(s: &Scenario) -> Checked {
    let load = &s.load;
    not_negative("load.constant_nm", load.constant_nm)?;
    not_negative("load.viscous_nm_s", load.viscous_nm_s)?;
    not_negative("load.quadratic_nm_s2", load.quadratic_nm_s2)?;
    not_negative("load.turbulence_sigma_nm", load.turbulence_sigma_nm)?;
    positive("load.turbulence_bandwidth_hz", load.turbulence_bandwidth_hz)?;
    let nyquist_hz = 0.5 * s.control_rate_hz;
    require(
        load.turbulence_bandwidth_hz < nyquist_hz,
        "load.turbulence_bandwidth_hz",
        format!("= {} is not below half the control rate", load.turbulence_bandwidth_hz),
        format!("choose less than {nyquist_hz} Hz"),
    )
}

fn check_controller(s: &Scenario) -> Checked {
    let controller = &s.controller;
    let (wc, ws) = (controller.current_bandwidth_rad_per_s, controller.speed_bandwidth_rad_per_s);
    positive("controller.current_bandwidth_rad_per_s", wc)?;
    positive("controller.speed_bandwidth_rad_per_s", ws)?;
    positive("controller.current_limit_a", controller.current_limit_a)?;
    positive("controller.supply_v", controller.supply_v)?;
    let highest = LARGEST_BANDWIDTH_TIMES_PERIOD * s.control_rate_hz;
    require(
        wc <= highest,
        "controller.current_bandwidth_rad_per_s",
        format!("= {wc} is too fast for control_rate_hz = {}", s.control_rate_hz),
        format!("choose at most {highest} rad/s or raise the rate"),
    )?;
    let highest = wc / SMALLEST_BANDWIDTH_RATIO;
    require(
        ws <= highest,
        "controller.speed_bandwidth_rad_per_s",
        format!("= {ws} is too close to the current loop's {wc} rad/s"),
        format!("choose at most {highest} rad/s"),
    )
}

fn check_noise(s: &Scenario) -> Checked {
    let noise = &s.noise;
    not_negative("noise.speed_sigma_rad_per_s", noise.speed_sigma_rad_per_s)?;
    not_negative("noise.current_sigma_a", noise.current_sigma_a)?;
    not_negative("noise.voltage_sigma_v", noise.voltage_sigma_v)?;
    not_negative("noise.speed_step_rad_per_s", noise.speed_step_rad_per_s)?;
    not_negative("noise.current_step_a", noise.current_step_a)?;
    not_negative("noise.voltage_step_v", noise.voltage_step_v)
}

fn check_set_points(s: &Scenario) -> Checked {
    require(!s.set_points.is_empty(), "set_point", "has no entry", "add one at 0 s, or leave set_point out")?;
    let mut earliest_s = 0.0;
    for (n, step) in s.set_points.iter().enumerate() {
        let (at_s, speed) = (step.at_s, step.rad_per_s);
        let key = format!("set_point[{n}].at_s");
        if n == 0 {
            require(at_s == 0.0, key, format!("= {at_s} is not 0"), "the first set point holds from the start: use 0")?;
        } else {
            require(
                at_s > earliest_s && at_s < s.duration_s,
                key,
                format!("= {at_s} is not between its predecessor's {earliest_s} s and the mission's end"),
                "sort the set points by time",
            )?;
        }
        earliest_s = at_s;

        let key = format!("set_point[{n}].rad_per_s");
        finite(key.clone(), speed)?;
        let (state, voltage) = s.motor.steady_state(speed, &s.load.mean());
        require(
            voltage.abs() <= s.controller.supply_v,
            key.clone(),
            format!("= {speed} needs {voltage:.2} V"),
            format!("lower it or raise controller.supply_v = {}", s.controller.supply_v),
        )?;
        require(
            state.armature_current.abs() <= s.controller.current_limit_a,
            key,
            format!("= {speed} needs {:.2} A against the load", state.armature_current),
            format!("lower the load or raise controller.current_limit_a = {}", s.controller.current_limit_a),
        )?;
    }
    Ok(())
}

fn positive(key: &str, value: f64) -> Checked {
    require(
        value > 0.0 && value.is_finite(),
        key,
        format!("= {value} is not positive and finite"),
        "use a number above 0",
    )
}

fn not_negative(key: impl Into<String>, value: f64) -> Checked {
    require(
        value >= 0.0 && value.is_finite(),
        key,
        format!("= {value} is negative or not finite"),
        "use 0 or a number above",
    )
}

fn finite(key: impl Into<String>, value: f64) -> Checked {
    require(value.is_finite(), key, format!("= {value} is not finite"), "use a finite number")
}

fn within_mission(key: impl Into<String>, end_s: f64, duration_s: f64) -> Checked {
    require(
        end_s <= duration_s,
        key,
        format!("= {end_s} is after the mission's end"),
        format!("use at most duration_s = {duration_s}, or lengthen the mission"),
    )
}

fn require(fulfilled: bool, key: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Checked {
    if fulfilled {
        return Ok(());
    }
    Err(ScenarioError::Value { key: key.into(), line: None, problem: problem.into(), remedy: remedy.into() })
}
