//! The settings a board starts with.

use monitor_core::Config;
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
    Config::paper(SAMPLE_RATE_HZ as f32, THRESHOLDS)
}
