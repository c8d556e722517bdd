//! The result of a replay, as machines read it.

use std::ops::Range;
use std::path::PathBuf;

use monitor_core::paper::Baseline;
use serde::Serialize;

use super::alarm::Alarm;
use super::learn::{Calibration, Learning};
use crate::names::{ByModel, ChannelNames, explained, retained};
use crate::record::PhaseCounts;
use crate::replay::Refusal;

/// Half-window means further apart than this many sigma are reported: the window was not stationary.
const SHIFT_WARNING_SIGMA: f64 = 0.5;

/// Samples further out than this many sigma are reported: spikes inflate sigma and blunt the monitor.
const SPIKE_WARNING_SIGMA: f64 = 8.0;

/// What was learned from the window.
#[derive(Clone, Debug, Serialize)]
pub struct Learned {
    /// Samples learned from.
    pub n: u32,
    /// First row of the window; none if the baseline was stored.
    pub start_row: Option<u64>,
    /// First row behind it.
    pub end_row: Option<u64>,
    /// Mean of each channel, in the order of `channels`.
    pub mean: [f64; 3],
    /// Standard deviation of each channel.
    pub sigma: [f64; 3],
    /// How good the window was.
    pub quality: Quality,
}

/// How good a learning window was.
#[derive(Clone, Debug, Serialize)]
pub struct Quality {
    /// Rows of the window that were skipped because a value was not finite.
    pub skipped: u64,
    /// Share of the variance each component explains, by model.
    pub explained: ByModel<Vec<f64>>,
    /// Components retained, by model.
    pub retained: ByModel<usize>,
    /// Largest over smallest eigenvalue of the correlation matrix; none when the smallest is zero.
    pub condition_number: Option<f64>,
    /// How far each channel's mean moved from the first half of the window to the second, in sigma; none if the
    /// baseline was stored, or a half was too short to tell.
    pub half_shift_sigma: Option<[f64; 3]>,
    /// How far the furthest sample of each channel lies from the mean, in sigma; none if the baseline was stored.
    pub largest_deviation_sigma: Option<[f64; 3]>,
    /// What a person should know about it.
    pub warnings: Vec<String>,
}

/// The result of a replay, as machines read it.
#[derive(Clone, Debug, Serialize)]
pub struct ReplayReport {
    /// Which monitor judged.
    pub mode: &'static str,
    /// The log.
    pub log: PathBuf,
    /// Names of the three channels.
    pub channels: [String; 3],
    /// Whether the set point was read from the log.
    pub has_set_point: bool,
    /// Rows per second.
    pub rate_hz: f64,
    /// Rows of the log.
    pub samples: u64,
    /// Rows with a value that is not finite: reported, and kept away from every state.
    pub skipped: u64,
    /// What was learned.
    pub learned: Learned,
    /// Cutoff of the residuals' low-pass, Hz.
    pub cutoff_hz: f64,
    /// Threshold of each residual.
    pub limits: ByModel<f64>,
    /// Rows judged, and rows that were not because the set point had changed.
    pub coverage: PhaseCounts,
    /// Learning windows refused after a change of the set point.
    pub refused: Vec<Refusal>,
    /// The alarms, in order.
    pub alarms: Vec<Alarm>,
    /// The faults that were added to the log.
    pub injected: Vec<String>,
    /// What a person should know about the file.
    pub notes: Vec<String>,
    /// Where the page and the trace are.
    pub files: Vec<PathBuf>,
    /// Exit code: 0 no fault, 1 a fault was reported.
    pub exit: u8,
}

/// What is known of a baseline: of a window, by the passes over it, or of a stored one.
pub(super) fn learned(
    baseline: &Baseline,
    window: Option<(&Range<u64>, &Learning, &Calibration)>,
    names: &ChannelNames,
) -> Learned {
    let [largest, _, smallest]: [f32; 3] = (*baseline.full().pca().eigenvalues()).into();
    let half_shift_sigma = window.and_then(|(_, learning, _)| half_shift(learning, baseline));
    let largest_deviation_sigma = window.map(|(_, _, calibration)| calibration.largest_deviation);
    let mut warnings = Vec::new();
    for (name, shift) in names.0.iter().zip(half_shift_sigma.unwrap_or_default()) {
        if shift.abs() > SHIFT_WARNING_SIGMA {
            warnings.push(format!(
                "the mean of '{name}' moves by {shift:.2} sigma from the first half of the window to the second: it is \
                 not stationary"
            ));
        }
    }
    for (name, furthest) in names.0.iter().zip(largest_deviation_sigma.unwrap_or_default()) {
        if furthest > SPIKE_WARNING_SIGMA {
            warnings.push(format!(
                "'{name}' has a spike of {furthest:.1} sigma in the window: sigma is inflated and small faults are hidden"
            ));
        }
    }
    Learned {
        n: baseline.samples(),
        start_row: window.map(|(rows, ..)| rows.start),
        end_row: window.map(|(rows, ..)| rows.end),
        mean: baseline.mean().map(f64::from),
        sigma: baseline.sigma().map(f64::from),
        quality: Quality {
            skipped: window.map_or(0, |(_, learning, _)| learning.skipped),
            explained: explained(baseline),
            retained: retained(baseline),
            condition_number: (smallest > 0.0).then(|| f64::from(largest / smallest)),
            half_shift_sigma,
            largest_deviation_sigma,
            warnings,
        },
    }
}

/// How far the mean of each channel moved from one half of the window to the other, in sigma.
fn half_shift(learning: &Learning, baseline: &Baseline) -> Option<[f64; 3]> {
    let (first, second) = (learning.first_half.statistics().ok()?, learning.second_half.statistics().ok()?);
    let moved: [f32; 3] = (second.mean - first.mean).into();
    let sigma = baseline.sigma();
    Some(std::array::from_fn(|k| f64::from(moved[k] / sigma[k])))
}
