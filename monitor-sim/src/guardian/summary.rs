//! The monitor's settings and what it has learned, as reports give them.

use monitor_core::guard::{Config, Quality, SCALES};
use serde::Serialize;

/// A limit of each time scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScaleLimits {
    /// Of the fast scale.
    pub fast: f64,
    /// Of the middle scale.
    pub middle: f64,
    /// Of the slow scale.
    pub slow: f64,
    /// Of the slowest, the trend.
    pub trend: f64,
}

impl ScaleLimits {
    /// As the core has them.
    #[must_use]
    pub fn of(limits: [f32; SCALES]) -> Self {
        let [fast, middle, slow, trend] = limits.map(f64::from);
        ScaleLimits { fast, middle, slow, trend }
    }
}

/// The monitor's settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Samples per second.
    pub sample_rate_hz: f32,
    /// False alarms that are tolerable per hour.
    pub false_alarms_per_hour: f32,
    /// How long after a change of the set point nothing is learned, s.
    pub settle_s: f32,
    /// Length of each of two seeding windows, s.
    pub seed_s: f32,
    /// Length of the learning window, s.
    pub learn_s: f32,
    /// Largest movement of the set point that is not a change.
    pub set_point_tolerance: f32,
    /// Time constants of the three time scales, s.
    pub time_constants_s: [f32; SCALES],
    /// Step of the converter of each channel.
    pub converter_steps: [f32; 3],
    /// How long the mean remembers, s.
    pub memory_s: f32,
    /// How far the mean may follow in all, in sigmas.
    pub drift_sigmas: f32,
    /// How long something must be wrong before an alarm is raised, s.
    pub raise_hold_s: f32,
    /// How long the motor must look healthy before an alarm is withdrawn, s.
    pub clear_hold_s: f32,
}

impl From<&Config> for Settings {
    fn from(config: &Config) -> Self {
        Settings {
            sample_rate_hz: config.sample_rate_hz,
            false_alarms_per_hour: config.false_alarms_per_hour,
            settle_s: config.settle_s,
            seed_s: config.seed_s,
            learn_s: config.learn_s,
            set_point_tolerance: config.set_point_tolerance,
            time_constants_s: config.time_constants_s,
            converter_steps: config.converter_steps,
            memory_s: config.memory_s,
            drift_sigmas: config.drift_sigmas,
            raise_hold_s: config.raise_hold_s,
            clear_hold_s: config.clear_hold_s,
        }
    }
}

/// How good a learning window was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WindowQuality {
    /// Samples in the window.
    pub samples: u32,
    /// Share of the samples of which a reading was clipped.
    pub clipped_share: f64,
    /// Largest over smallest eigenvalue of the correlation matrix.
    pub condition_number: f64,
    /// Largest movement of a channel's mean from the first half to the second, in its sigmas.
    pub half_shift_sigma: f64,
    /// How much larger the slow scale's variance is than that of noise without memory.
    pub slow_variance_ratio: f64,
}

impl WindowQuality {
    /// Of the last window that a monitor accepted; none if there was none.
    #[must_use]
    pub fn of(quality: &Quality) -> Option<Self> {
        (quality.samples > 0).then(|| WindowQuality {
            samples: quality.samples,
            clipped_share: f64::from(quality.clipped_share),
            condition_number: f64::from(quality.condition),
            half_shift_sigma: f64::from(quality.drift_sigmas),
            slow_variance_ratio: f64::from(quality.slow_variance_ratio),
        })
    }
}
