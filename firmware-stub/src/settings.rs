//! The settings a board starts with.

use monitor_core::guard::{self, MotorConstants};
use monitor_core::paper::Config;
use monitor_core::sample::{Bank, PerPair};

/// Rate of the sampling interrupt, Hz.
pub const SAMPLE_RATE_HZ: u32 = 1000;

/// Thresholds of the default motor (maxon RE 40 with a propeller) at 1 kHz, in units of the mean T2 in control, as
/// `monitor-sim tune` found them (`monitor-sim/limits/figure-1.toml`). Another motor wants its own.
const THRESHOLDS: Bank<f32> =
    Bank { full: 1.753, pairs: PerPair { speed_current: 1.896, current_voltage: 1.811, speed_voltage: 1.844 } };

/// The paper's settings for the default motor.
#[must_use]
pub const fn default_motor() -> Config {
    let paper = Config::paper(SAMPLE_RATE_HZ as f32, THRESHOLDS);
    if cfg!(feature = "emulated") {
        // QEMU's converters count instead of measuring, so a short run shows as much as a long one.
        return Config { settle_s: 0.5, learn_s: 1.0, ..paper };
    }
    paper
}

/// Settings of `guard` mode, for any motor: as long to settle, to seed and to learn as the default mission gives.
#[must_use]
pub const fn guard_config(sample_rate_hz: f32) -> guard::Config {
    guard::Config { settle_s: 3.0, ..guard::Config::at_rate(sample_rate_hz) }
}

/// Constants of the default motor, by its data sheet; its load does not depend on speed. Within 20 % will do.
#[must_use]
pub const fn motor_constants() -> MotorConstants {
    MotorConstants { resistance_ohm: 0.299, torque_constant_nm_per_a: 0.0302, load_slope_nm_s: 0.0 }
}
