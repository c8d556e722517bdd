//! Settings of the paper's monitor for a motor: thresholds found by `monitor-sim tune`, and where they come from.

use monitor_core::paper::Config;
use serde::{Deserialize, Serialize};

use crate::names::ByModel;

/// The settings file of the default motor, as `monitor-sim tune` wrote it.
const DEFAULT_MOTOR: &str = include_str!("../limits/figure-1.toml");

/// Settings of the paper's monitor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperSettings {
    /// Cutoff of the residuals' low-pass, Hz.
    pub cutoff_hz: f64,
    /// How far below its threshold a residual must fall to bring its relay down, as a share of it.
    pub hysteresis: f64,
    /// Share of the variance that the retained components explain (1.3).
    pub explained_share: f64,
    /// Threshold of each residual, in units of the mean T2 in control.
    pub thresholds: ByModel<f64>,
    /// Why these thresholds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub found_by: Option<FoundBy>,
}

/// The procedure that found a set of thresholds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FoundBy {
    /// The scenario whose motor was flown.
    pub scenario: String,
    /// Its sampling rate, Hz.
    pub rate_hz: f64,
    /// Fault-free runs, and as many borderline faulty ones.
    pub runs: u64,
    /// Seed of the first run.
    pub first_seed: u64,
    /// Thresholds are this many times the largest fault-free residual.
    pub margin: f64,
    /// Largest fault-free residual of any run.
    pub largest_fault_free: ByModel<f64>,
    /// How large the borderline faults were, as a share of the scenario's.
    pub borderline_size: f64,
    /// Smallest residual that a borderline fault held, of those that must be up under it.
    pub smallest_borderline: ByModel<f64>,
}

impl PaperSettings {
    /// The settings of the default motor.
    ///
    /// # Errors
    /// When the file that was built in does not parse; a test keeps it parsing.
    pub fn default_motor() -> Result<Self, toml::de::Error> {
        toml::from_str(DEFAULT_MOTOR)
    }

    /// What speaks against using these thresholds for a scenario sampled at `rate_hz`.
    #[must_use]
    pub fn doubt(&self, rate_hz: f64) -> Option<String> {
        let found = self.found_by.as_ref().filter(|found| (found.rate_hz - rate_hz).abs() > 1e-9 * rate_hz)?;
        Some(format!(
            "the thresholds were found at {} Hz and the mission is sampled at {rate_hz} Hz, where smoothed residuals \
             scatter differently: find its own with `tune --scenario FILE --out LIMITS` and give them to --limits",
            found.rate_hz
        ))
    }

    /// These settings as a file for `--limits`.
    ///
    /// # Errors
    /// When a number has no form in TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let header = "# Thresholds of the residuals, in units of the mean T2 in control, and how they were found.\n";
        Ok(format!("{header}{}", toml::to_string(self)?))
    }

    /// The core's configuration for these settings.
    #[must_use]
    pub fn config(&self, rate_hz: f64, settle_s: f64, learn_s: f64, set_point_tolerance: f64) -> Config {
        Config {
            settle_s: settle_s as f32,
            learn_s: learn_s as f32,
            set_point_tolerance: set_point_tolerance as f32,
            explained_share: self.explained_share as f32,
            cutoff_hz: self.cutoff_hz as f32,
            hysteresis: self.hysteresis as f32,
            ..Config::paper(rate_hz as f32, ByModel::from_fn(|model| *self.thresholds.get(model) as f32).bank())
        }
    }
}
