//! A baseline as a file: a row of the offline table the paper names as the alternative to learning online (II.C).

use monitor_core::paper::Baseline;
use monitor_core::paper::baseline::Stored;
use serde::{Deserialize, Serialize};

use crate::names::{ByModel, ChannelNames};

/// A baseline with the thresholds that go with it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredBaseline {
    /// Names of the channels.
    pub channels: [String; 3],
    /// Samples per second of the log it was learned from.
    pub rate_hz: f64,
    /// Set point at which it holds.
    pub set_point: f64,
    /// Cutoff of the residuals' low-pass that the thresholds go with, Hz.
    pub cutoff_hz: f64,
    /// Samples it was learned from.
    pub samples: u32,
    /// Mean of each channel.
    pub mean: [f32; 3],
    /// Standard deviation of each channel.
    pub sigma: [f32; 3],
    /// Loadings of the standardized channels, one component a row.
    pub loadings: [[f32; 3]; 3],
    /// Variance of each component, descending.
    pub eigenvalues: [f32; 3],
    /// Threshold of each residual.
    pub thresholds: ByModel<f64>,
}

impl StoredBaseline {
    /// The numbers of a baseline; names, rate, set point, cutoff and thresholds are the caller's to fill in.
    #[must_use]
    pub fn of(baseline: &Baseline) -> Self {
        let Stored { mean, sigma, loadings, eigenvalues, samples } = baseline.stored();
        StoredBaseline { samples, mean, sigma, loadings, eigenvalues, ..StoredBaseline::default() }
    }

    /// The numbers as the core takes them.
    #[must_use]
    pub fn numbers(&self) -> Stored {
        let StoredBaseline { samples, mean, sigma, loadings, eigenvalues, .. } = *self;
        Stored { mean, sigma, loadings, eigenvalues, samples }
    }

    /// Whether the baseline is of the same channels and rate.
    ///
    /// # Errors
    /// What does not fit, and what helps.
    pub fn check(&self, names: &ChannelNames, rate_hz: f64) -> Result<(), String> {
        if self.channels != names.0 {
            let (ours, theirs) = (names.0.join(", "), self.channels.join(", "));
            return Err(format!(
                "it is of the channels {theirs}, not {ours}: name the channels alike, in the same order"
            ));
        }
        if (self.rate_hz - rate_hz).abs() > 1e-9 * rate_hz {
            return Err(format!(
                "it was learned at {} Hz and the log has {rate_hz} Hz, where residuals scatter differently: learn anew",
                self.rate_hz
            ));
        }
        Ok(())
    }

    /// The baseline as a file for `--baseline`.
    ///
    /// # Errors
    /// When a number has no form in TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        Ok(format!(
            "# What healthy means at one set point: give it to `replay --baseline`.\n{}",
            toml::to_string(self)?
        ))
    }
}
