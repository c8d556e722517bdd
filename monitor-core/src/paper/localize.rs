//! Localization: which fault explains the pattern of the pair relays (the paper, III.C).

use crate::sample::PerPair;

/// The faults of the paper (III.A).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Fault 1: the load on the propeller has changed (a cord around the shaft, debris).
    LoadTorque,
    /// Fault 2: the speed sensor drifts.
    SpeedSensor,
    /// Fault 3: the armature-current sensor drifts.
    CurrentSensor,
}

impl Fault {
    /// The faults in the paper's order.
    pub const ALL: [Fault; 3] = [Fault::LoadTorque, Fault::SpeedSensor, Fault::CurrentSensor];
}

/// What the pattern of the pair relays says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Diagnosis {
    /// No pair relay is up.
    #[default]
    Healthy,
    /// The pattern is that of one fault.
    Fault(Fault),
    /// Some pair relay is up, but the pattern is none of (1.8).
    Unknown,
}

/// The boolean table (1.8). Every pattern has a diagnosis; those that (1.8) does not list are `Unknown`.
#[inline]
#[must_use]
pub const fn localize(up: PerPair<bool>) -> Diagnosis {
    match (up.speed_current, up.current_voltage, up.speed_voltage) {
        (true, true, true) => Diagnosis::Fault(Fault::LoadTorque), // (1.8) f1 = r1 and r2 and r3
        (false, true, true) => Diagnosis::Fault(Fault::SpeedSensor), // (1.8) f2 = not r1 and r2 and r3
        (true, true, false) => Diagnosis::Fault(Fault::CurrentSensor), // (1.8) f3 = r1 and r2 and not r3
        (false, false, false) => Diagnosis::Healthy,
        _ => Diagnosis::Unknown,
    }
}

/// The matrix form (1.9): the complements of f1, f2, f3 as integers, zero where the fault stands.
///
/// The paper prints it as equal to (1.8); it is, when every value above zero is read as logical one. It exists for
/// that proof and for readers of the paper: [`localize`] is what runs.
#[must_use]
pub const fn matrix_form(up: PerPair<bool>) -> [i8; 3] {
    let r1 = !up.speed_current as i8;
    let r2 = !up.current_voltage as i8;
    let r3 = !up.speed_voltage as i8;
    [
        r1 + r2 + r3,      // (1.9) row 1
        -r1 + r2 + r3 + 1, // (1.9) row 2
        r1 + r2 - r3 + 1,  // (1.9) row 3
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(bits: u8) -> PerPair<bool> {
        PerPair { speed_current: bits & 1 != 0, current_voltage: bits & 2 != 0, speed_voltage: bits & 4 != 0 }
    }

    #[test]
    fn the_matrix_form_equals_the_boolean_table_for_all_eight_patterns() {
        for bits in 0..8 {
            let by_matrix = matrix_form(pattern(bits));
            for (fault, complement) in Fault::ALL.into_iter().zip(by_matrix) {
                assert!(complement >= 0);
                assert_eq!(localize(pattern(bits)) == Diagnosis::Fault(fault), complement == 0, "pattern {bits:03b}");
            }
        }
    }

    #[test]
    fn every_pattern_has_a_diagnosis_and_only_silence_is_healthy() {
        let named = (0..8).map(|bits| localize(pattern(bits)));
        assert_eq!(named.clone().filter(|d| matches!(d, Diagnosis::Fault(_))).count(), 3);
        assert_eq!(named.clone().filter(|d| *d == Diagnosis::Unknown).count(), 4);
        assert_eq!(localize(pattern(0)), Diagnosis::Healthy);
    }
}
