//! The settings a board starts with, and the mode it flies.

use monitor_core::guard::{self, MotorConstants};
use monitor_core::paper;
use monitor_core::sample::{Bank, PerPair};

use crate::scale;

/// Rate of the sampling interrupt, Hz.
pub const SAMPLE_RATE_HZ: u32 = 1000;

/// The mode that the thruster controller flies.
#[cfg(not(feature = "paper"))]
pub type Flown = crate::Guarded;
/// The mode that the thruster controller flies.
#[cfg(feature = "paper")]
pub type Flown = crate::Paper;

/// The monitor that the thruster controller starts with.
///
/// # Errors
/// The setting that is out of range.
#[cfg(not(feature = "paper"))]
pub fn flown() -> Result<Flown, guard::ConfigError> {
    Ok(Flown::new(guard::Monitor::new(&board_guard())?, motor_constants()))
}

/// The monitor that the thruster controller starts with.
///
/// # Errors
/// The setting that is out of range.
#[cfg(feature = "paper")]
pub fn flown() -> Result<Flown, paper::monitor::ConfigError> {
    Ok(Flown::new(paper::Monitor::new(&default_motor())?))
}

/// Clock of the slowest core that flies, kHz: the internal oscillator's.
const SLOWEST_CORE_KHZ: u32 = 16_000;
/// Cycles of the longest turn of the main loop: the end of a learning window in `guard` mode, by its budget
/// (`time.guard_window_end.worst` in tests/budgets.toml).
const LONGEST_TURN_CYCLES: u32 = 1_146_432;

/// The watchdog resets the chip when it was not fed for so long, ms.
pub const WATCHDOG_MS: u32 = 250;

/// The longest turn takes 72 ms. The sampling interrupt may take a quarter of the core meanwhile (3,886 cycles of 16,000 where
/// phases change), which makes 96 ms; and the watchdog's oscillator may run at 47 kHz in place of 32 (data sheet), so that it
/// bites after 170 ms. What is left is for logging.
const _: () = {
    let (turn_ms, bites_ms) = (LONGEST_TURN_CYCLES.div_ceil(SLOWEST_CORE_KHZ), WATCHDOG_MS * 32 / 47);
    assert!(turn_ms * 4 / 3 < bites_ms * 2 / 3);
};

/// Thresholds of the default motor (maxon RE 40 with a propeller) at 1 kHz, in units of the mean T2 in control, as
/// `monitor-sim tune` found them (`monitor-sim/limits/figure-1.toml`). Another motor wants its own.
const THRESHOLDS: Bank<f32> =
    Bank { full: 1.753, pairs: PerPair { speed_current: 1.896, current_voltage: 1.811, speed_voltage: 1.844 } };

/// The paper's settings for the default motor.
#[must_use]
pub const fn default_motor() -> paper::Config {
    let paper = paper::Config::paper(SAMPLE_RATE_HZ as f32, THRESHOLDS);
    if cfg!(feature = "emulated") {
        // QEMU's converters count instead of measuring, so a short run shows as much as a long one.
        return paper::Config { settle_s: 0.5, learn_s: 1.0, ..paper };
    }
    paper
}

/// Settings of `guard` mode, for any motor: as long to settle, to seed and to learn as the default mission gives.
#[must_use]
pub const fn guard_config(sample_rate_hz: f32) -> guard::Config {
    guard::Config { settle_s: 3.0, ..guard::Config::at_rate(sample_rate_hz) }
}

/// The same for the thruster controller: no channel is taken to be more exact than its converter.
#[must_use]
pub const fn board_guard() -> guard::Config {
    let rate_hz = SAMPLE_RATE_HZ as f32;
    let config = guard::Config { converter_steps: scale::converter_steps(rate_hz), ..guard_config(rate_hz) };
    if cfg!(feature = "emulated") {
        // As above.
        return guard::Config { settle_s: 0.5, seed_s: 0.25, learn_s: 2.0, ..config };
    }
    config
}

/// Constants of the default motor, by its data sheet; its load does not depend on speed. Within 20 % will do.
#[must_use]
pub const fn motor_constants() -> MotorConstants {
    MotorConstants { resistance_ohm: 0.299, torque_constant_nm_per_a: 0.0302, load_slope_nm_s: 0.0 }
}
