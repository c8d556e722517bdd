//! What the faults of a scenario must fulfil.

use super::{Checked, finite, not_negative, require, within_mission};
use crate::fault::{Fault, FaultKind, FaultPoint};
use crate::motor::{MAX_SUB_STEPS, Motor, MotorParameters};
use crate::scenario::Scenario;

pub(super) fn check(s: &Scenario) -> Checked {
    for (n, fault) in s.faults.iter().enumerate() {
        let key = |name: &str| format!("fault[{n}].{name}");
        let Fault { id, amplitude, start_s, end_s, .. } = fault;
        require(!id.is_empty(), key("id"), "is empty", "name the fault, as in \"F1\"")?;
        require(
            !s.faults.iter().take(n).any(|earlier| earlier.id == *id),
            key("id"),
            format!("= \"{id}\" names an earlier fault too"),
            "give each fault its own id",
        )?;
        check_kind(fault, key("kind"))?;
        finite(key("amplitude"), *amplitude)?;
        check_amplitude(s, fault, key("amplitude"))?;
        check_share(fault, key("share"))?;
        not_negative(key("start_s"), *start_s)?;
        require(
            end_s > start_s,
            key("end_s"),
            format!("= {end_s} is not after start_s = {start_s}"),
            "let the fault end after it starts",
        )?;
        within_mission(key("end_s"), *end_s, s.duration_s)?;
    }
    Ok(())
}

/// Readings stick and get coarse, slots go missing; everything else is added to or multiplied.
fn check_kind(fault: &Fault, key: String) -> Checked {
    let fits = match fault.kind {
        FaultKind::Offset | FaultKind::Gain => fault.point != FaultPoint::Sampling,
        FaultKind::Stuck | FaultKind::Coarse => fault.point.is_sensor(),
        FaultKind::Missing => fault.point == FaultPoint::Sampling,
    };
    require(
        fits,
        key,
        "does not go with the fault's point",
        "use \"missing\" with point = \"sampling\" and nothing else, \"stuck\" and \"coarse\" with one of the three \
         sensors, \"offset\" and \"gain\" with any point but the sampling",
    )
}

fn check_amplitude(s: &Scenario, fault: &Fault, key: String) -> Checked {
    let amplitude = fault.amplitude;
    match fault.kind {
        FaultKind::Stuck | FaultKind::Missing => require(
            (0.0..=1.0).contains(&amplitude),
            key,
            format!("= {amplitude} is no probability"),
            "use a number from 0 to 1: the chance in each control period",
        ),
        FaultKind::Coarse => not_negative(key, amplitude),
        FaultKind::Offset | FaultKind::Gain => {
            require(
                fault.kind == FaultKind::Offset || amplitude >= -1.0,
                key.clone(),
                format!("= {amplitude} turns the signal's sign, so the loop would run away"),
                "a gain fault multiplies by 1 + amplitude: use at least -1",
            )?;
            check_constant(s, fault, key)
        }
    }
}

/// A motor whose constants change must still be one, and one that can be integrated.
fn check_constant(s: &Scenario, fault: &Fault, key: String) -> Checked {
    let changed = |constant: f64| match fault.kind {
        FaultKind::Gain => constant * (1.0 + fault.amplitude),
        _ => constant + fault.amplitude,
    };
    let MotorParameters { resistance_ohm: resistance, torque_constant_nm_per_a: torque_constant, .. } = s.motor;
    let mut motor =
        MotorParameters { rotor_inertia_kg_m2: s.motor.inertia_kg_m2(), added_inertia_kg_m2: 0.0, ..s.motor };
    let left = match fault.point {
        FaultPoint::ArmatureResistance => {
            motor.resistance_ohm = changed(resistance);
            motor.resistance_ohm
        }
        FaultPoint::TorqueConstant => {
            motor.torque_constant_nm_per_a = changed(torque_constant);
            motor.torque_constant_nm_per_a
        }
        FaultPoint::LoadInertia => {
            motor.rotor_inertia_kg_m2 = changed(motor.rotor_inertia_kg_m2);
            motor.rotor_inertia_kg_m2
        }
        _ => return Ok(()),
    };
    let (amplitude, unit) = (fault.amplitude, fault.point.unit());
    require(
        left > 0.0,
        key.clone(),
        format!("= {amplitude} leaves {left} {unit} of a constant of the motor"),
        "leave more than 0 of it",
    )?;
    require(
        Motor::sub_steps_needed(&motor, 1.0 / s.control_rate_hz) <= f64::from(MAX_SUB_STEPS),
        key,
        format!("= {amplitude} makes the motor too fast for {MAX_SUB_STEPS} sub-steps a control period"),
        "choose a smaller fault",
    )
}

fn check_share(fault: &Fault, key: String) -> Checked {
    let share = fault.share;
    require(
        share > 0.0 && share <= 1.0,
        key.clone(),
        format!("= {share} is not above 0 and at most 1"),
        "use the probability that the fault acts in a control period",
    )?;
    require(
        share == 1.0 || !fault.kind.is_chance(),
        key,
        format!("= {share} says again what the amplitude says"),
        "leave share out: the amplitude of this kind is its probability",
    )
}
