//! What the examples sample: a motor at 300 rad/s whose speed sensor begins to drift once it has been learned.

use firmware_stub::background::Named;
use firmware_stub::{Guarded, Reading, settings};
use monitor_core::guard::{Cause, Config, ConfigError, Finding, Monitor};
use monitor_core::sample::Sample;
use monitor_core::units::{Amperes, RadPerSec, Volts};

/// Rate of the sampling interrupt, Hz.
pub(crate) const RATE_HZ: u32 = 1000;
/// The set point of the motor.
pub(crate) const SET_POINT: RadPerSec = RadPerSec(300.0);
/// The slot with which the drift begins: half a second after the learning window.
const DRIFTS_FROM: u32 = 3500;
/// Slots after which the fault must have been named.
pub(crate) const SLOTS: u32 = 5500;
/// The watchdog stops the run when it was not fed for so long, ms.
pub(crate) const WATCHDOG_MS: u32 = settings::WATCHDOG_MS;

/// A monitor of that motor, with times as short as they may be.
pub(crate) fn guarded() -> Result<Guarded, ConfigError> {
    let config = Config { settle_s: 0.5, seed_s: 0.25, learn_s: 2.0, ..Config::at_rate(RATE_HZ as f32) };
    Ok(Guarded::new(Monitor::new(&config)?, settings::motor_constants()))
}

/// What a board's converters and timer would give in slot `k`.
pub(crate) fn reading(k: u32) -> Reading {
    let drift = if k >= DRIFTS_FROM { 5.0 } else { 0.0 };
    Reading::Taken(Sample {
        speed: RadPerSec(300.0 + 0.2 * noise(k, 1)),
        armature_current: Amperes(2.0 + 0.02 * noise(k, 2)),
        // The speed loop holds the reading, so the drift shows in the voltage: 30.2 mV per rad/s.
        armature_voltage: Volts(9.7 + 0.02 * noise(k, 3) - 0.0302 * drift),
    })
}

/// White noise between -0.5 and 0.5: the bits of slot and channel, well mixed (the finalizer of MurmurHash3).
fn noise(k: u32, channel: u32) -> f32 {
    let mixed = (k ^ channel << 28).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35);
    (mixed ^ mixed >> 16) as f32 / u32::MAX as f32 - 0.5
}

/// Whether a name is that of the fault.
pub(crate) fn is_the_fault(named: &Named<Finding>) -> bool {
    let of_sensor = matches!(&named.finding, Finding::Fault(found) if found.cause == Cause::SpeedSensor);
    of_sensor && named.since.is_some_and(|since| since >= u64::from(DRIFTS_FROM))
}
