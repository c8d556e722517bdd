//! What the examples sample: a motor at 300 rad/s whose speed sensor begins to drift after 3 s.

use firmware_stub::Reading;
use firmware_stub::sampling::Note;
use monitor_core::paper::event::EventKind;
use monitor_core::paper::{Config, Diagnosis, Fault};
use monitor_core::sample::{Bank, PerPair, Sample};
use monitor_core::units::{Amperes, RadPerSec, Volts};

/// Rate of the sampling interrupt, Hz.
pub(crate) const RATE_HZ: u32 = 1000;
/// The set point of the motor.
pub(crate) const SET_POINT: RadPerSec = RadPerSec(300.0);
/// Slots after which the fault must have been named.
pub(crate) const SLOTS: u32 = 4000;

/// Settings for that motor.
pub(crate) fn config() -> Config {
    let pairs = PerPair { speed_current: 2.0, current_voltage: 2.0, speed_voltage: 2.0 };
    Config { settle_s: 0.5, learn_s: 1.0, ..Config::paper(RATE_HZ as f32, Bank { full: 2.0, pairs }) }
}

/// What a board's converters and timer would give in slot `k`.
pub(crate) fn reading(k: u32) -> Reading {
    let wobble = |period: u32| (k % period) as f32 / period as f32 - 0.5;
    let drift = if k >= 3000 { 5.0 } else { 0.0 };
    Reading::Taken(Sample {
        speed: RadPerSec(300.0 + 0.2 * wobble(7)),
        armature_current: Amperes(2.0 + 0.02 * wobble(11)),
        // The speed loop holds the reading, so the drift shows in the voltage: 30.2 mV per rad/s.
        armature_voltage: Volts(9.7 + 0.02 * wobble(13) - 0.0302 * drift),
    })
}

/// Whether a note names the fault.
pub(crate) fn names_the_fault(note: &Note) -> bool {
    let speed_sensor = EventKind::Located(Diagnosis::Fault(Fault::SpeedSensor));
    matches!(note, Note::Event { event, .. } if event.kind == speed_sensor && event.sample >= 3000)
}
