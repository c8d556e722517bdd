//! From converter codes to units, for the STM32F405 board. Every constant of the analogue front end stands here.
//!
//! The values are those of a brushed thruster controller of the VESC class and belong to one's own circuit: check them
//! against the schematic before anything else.

use core::f32::consts::TAU;

use monitor_core::range::RangeError;
use monitor_core::units::{Amperes, RadPerSec, Volts};
use monitor_core::{Range, Ranges};

/// Largest code of the 12-bit converter.
pub const ADC_TOP: u16 = 4095;
/// Reference of the converter, V.
const ADC_REFERENCE_V: f32 = 3.3;
/// Volts at the pin for each code.
const V_PER_CODE: f32 = ADC_REFERENCE_V / (ADC_TOP as f32 + 1.0);
/// Both amplifiers sit at half the reference when there is nothing to measure.
const ZERO_CODE: f32 = 2048.0;

/// Shunt of the armature current, ohm.
const SHUNT_OHM: f32 = 0.005;
/// Gain of the current-sense amplifier.
const SHUNT_GAIN: f32 = 20.0;
/// Amperes for each code: 3.3 V / 4096 / (5 mohm * 20) = 8.06 mA.
const A_PER_CODE: f32 = V_PER_CODE / (SHUNT_OHM * SHUNT_GAIN);

/// Divider of the armature voltage: 39 kohm over 2.2 kohm.
const DIVIDER: f32 = (39.0 + 2.2) / 2.2;
/// Volts for each code: 3.3 V / 4096 * 18.7 = 15.1 mV.
const ARMATURE_V_PER_CODE: f32 = V_PER_CODE * DIVIDER;

/// Edges for each turn of the shaft: 1,024 lines, four edges each.
const EDGES_PER_TURN: f32 = 4096.0;
/// A shaft faster than this is no reading of a shaft, rad/s: 10,000 rpm.
const CREDIBLE_SPEED: f32 = 1047.2;

/// Speed for each edge in a slot, rad/s: 2 pi / 4096 * 1000 Hz = 1.53 rad/s.
const fn speed_per_edge(rate_hz: f32) -> f32 {
    TAU / EDGES_PER_TURN * rate_hz
}

/// The least step of each channel, in its unit: no reading is more exact.
#[must_use]
pub const fn converter_steps(rate_hz: f32) -> [f32; 3] {
    [speed_per_edge(rate_hz), A_PER_CODE, ARMATURE_V_PER_CODE]
}

/// Armature current of a code.
#[must_use]
pub fn current(code: u16) -> Amperes {
    Amperes((f32::from(code) - ZERO_CODE) * A_PER_CODE)
}

/// Armature voltage of a code.
#[must_use]
pub fn voltage(code: u16) -> Volts {
    Volts((f32::from(code) - ZERO_CODE) * ARMATURE_V_PER_CODE)
}

/// Speed from the encoder's edges in one slot of the sampling clock.
#[must_use]
pub fn speed(edges: i16, rate_hz: f32) -> RadPerSec {
    RadPerSec(f32::from(edges) * speed_per_edge(rate_hz))
}

/// What the channels can credibly read: codes between the rails. A code at a rail (0 or 4095) says only that the pin is
/// at it or beyond.
///
/// # Errors
/// None while the constants above make sense: then each lower end lies below its higher one.
pub fn ranges() -> Result<Ranges, RangeError> {
    Ok(Ranges {
        speed: Range::new(-CREDIBLE_SPEED, CREDIBLE_SPEED)?,
        armature_current: Range::new(current(0).0, current(ADC_TOP).0)?,
        armature_voltage: Range::new(voltage(0).0, voltage(ADC_TOP).0)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use monitor_core::paper::verdict::Rejected;
    use monitor_core::paper::{Config, Monitor};
    use monitor_core::sample::{Bank, Channel, PerPair, Sample};

    fn rejected(edges: i16, current_code: u16, voltage_code: u16) -> Option<Rejected> {
        let pairs = PerPair { speed_current: 2.0, current_voltage: 2.0, speed_voltage: 2.0 };
        let mut monitor = Monitor::new(&Config::paper(1000.0, Bank { full: 2.0, pairs })).unwrap();
        let sample = Sample {
            speed: speed(edges, 1000.0),
            armature_current: current(current_code),
            armature_voltage: voltage(voltage_code),
        };
        monitor.step(RadPerSec(0.0), ranges().unwrap().admit(sample)).rejected()
    }

    #[test]
    fn codes_at_a_rail_are_out_of_range_and_the_codes_beside_them_are_not() {
        for code in [1, 2048, 4094] {
            assert_eq!(rejected(0, code, code), None, "{code}");
        }
        for rail in [0, ADC_TOP] {
            assert_eq!(rejected(0, rail, 2048), Some(Rejected::OutOfRange(Channel::ArmatureCurrent)));
            assert_eq!(rejected(0, 2048, rail), Some(Rejected::OutOfRange(Channel::ArmatureVoltage)));
        }
        assert_eq!(rejected(i16::MAX, 2048, 2048), Some(Rejected::OutOfRange(Channel::Speed)));
    }

    #[test]
    fn a_step_of_each_channel_is_one_code_or_one_edge() {
        let [speed_step, current_step, voltage_step] = converter_steps(1000.0);
        assert!((speed(7, 1000.0).0 - speed(6, 1000.0).0 - speed_step).abs() < 1e-5);
        assert!((current(3001).0 - current(3000).0 - current_step).abs() < 1e-5);
        assert!((voltage(3001).0 - voltage(3000).0 - voltage_step).abs() < 1e-5);
    }

    #[test]
    fn codes_and_edges_have_the_units_of_the_circuit() {
        // 2 A through 5 mohm, times 20, are 0.2 V: 248 codes above the middle.
        assert!((current(2048 + 248).0 - 2.0).abs() < 0.01);
        assert!((voltage(2048).0).abs() < 1e-6);
        assert!((voltage(2048 + 662).0 - 10.0).abs() < 0.02);
        // 300 rad/s are 47.7 turns/s: 196 edges in 1 ms.
        assert!((speed(196, 1000.0).0 - 300.0).abs() < 1.0);
    }
}
