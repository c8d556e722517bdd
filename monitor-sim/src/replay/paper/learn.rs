//! Where judging starts from: a window of the log that is learned, or a baseline learned before.

use std::ops::Range;

use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::{Baseline, Monitor};
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::Bank;

use super::report::{Learned, learned};
use super::{Limits, NO_LIMIT, Replay, learning_refused, settings};
use crate::inject::ResolvedInjection;
use crate::names::{ByModel, ChannelNames};
use crate::record::paper::Peak;
use crate::replay::{Reading, ReplayError, next_reading};
use crate::stored::StoredBaseline;

/// What judging starts from.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// First row that is judged.
    pub(super) row: u64,
    /// Set point of the baseline.
    pub(super) set_point: f64,
    pub(super) baseline: Baseline,
    pub(super) thresholds: ByModel<f64>,
    pub(super) learned: Learned,
}

/// What the first pass gathered.
#[derive(Clone, Debug)]
pub(super) struct Learning {
    pub(super) moments: Moments<3>,
    pub(super) first_half: Moments<3>,
    pub(super) second_half: Moments<3>,
    pub(super) set_point: f64,
    pub(super) skipped: u64,
}

impl Learning {
    /// Before its first reading.
    fn at(reading: &Reading) -> Self {
        let window = Moments::around(reading.channels());
        Learning { moments: window, first_half: window, second_half: window, set_point: reading.set_point, skipped: 0 }
    }
}

/// What the second pass saw.
#[derive(Clone, Debug, Default)]
pub(super) struct Calibration {
    pub(super) peak: Peak,
    pub(super) largest_deviation: [f64; 3],
}

impl Replay {
    /// Learns a window of the log and finds the thresholds.
    pub(super) fn start_from_window(
        &self,
        window: &Range<u64>,
        injections: &[ResolvedInjection],
        names: &ChannelNames,
        share: ExplainedShare,
    ) -> Result<Start, ReplayError> {
        let learning = self.learn_window(window, injections, names)?;
        let baseline = Baseline::learn(&learning.moments, share).map_err(|e| learning_refused(names, e))?;
        let calibration = self.calibrate(window, injections, &baseline, learning.set_point)?;
        let thresholds = match self.limits {
            Limits::Fixed(thresholds) => thresholds,
            Limits::FromLearning { margin } => {
                ByModel::from_fn(|model| margin * f64::from(*calibration.peak.residuals.get(model)))
            }
        };
        let learned = learned(&baseline, Some((window, &learning, &calibration)), names);
        Ok(Start { row: window.end, set_point: learning.set_point, baseline, thresholds, learned })
    }

    /// Takes a baseline and its thresholds from a file; the log is judged from its first row.
    pub(super) fn start_from_stored(
        &self,
        stored: &StoredBaseline,
        names: &ChannelNames,
        share: ExplainedShare,
    ) -> Result<Start, ReplayError> {
        stored.check(names, self.source.rate_hz).map_err(ReplayError::Baseline)?;
        let baseline = Baseline::from_stored(&stored.numbers(), share)
            .map_err(|error| ReplayError::Baseline(names.explain_baseline(error)))?;
        let learned = learned(&baseline, None, names);
        Ok(Start { row: 0, set_point: stored.set_point, baseline, thresholds: stored.thresholds, learned })
    }

    /// First pass: the moments of the window, and those of its two halves.
    fn learn_window(
        &self,
        window: &Range<u64>,
        injections: &[ResolvedInjection],
        names: &ChannelNames,
    ) -> Result<Learning, ReplayError> {
        let mut log = self.source.open()?;
        let (mut learning, mut skipped) = (None::<Learning>, 0);
        let middle = window.start + (window.end - window.start) / 2;
        let mut rows = 0;
        while rows < window.end {
            let Some(reading) = next_reading(&mut log, injections)? else {
                return Err(ReplayError::WindowOutside { window: window.clone(), rows });
            };
            rows = reading.row + 1;
            if !window.contains(&reading.row) {
                continue;
            }
            if !reading.is_finite() {
                skipped += 1;
                continue;
            }
            let learning = learning.get_or_insert_with(|| Learning::at(&reading));
            let from = learning.set_point;
            if (reading.set_point - from).abs() > self.set_point_tolerance {
                return Err(ReplayError::SetPointChanges { row: reading.row, from, to: reading.set_point });
            }
            learning.moments.push(reading.channels());
            let half = if reading.row < middle { &mut learning.first_half } else { &mut learning.second_half };
            half.push(reading.channels());
        }
        let learning = learning.ok_or_else(|| learning_refused(names, LearnError::TooShort { samples: 0 }))?;
        Ok(Learning { skipped, ..learning })
    }

    /// Second pass: how far the residuals of the window itself go.
    fn calibrate(
        &self,
        window: &Range<u64>,
        injections: &[ResolvedInjection],
        baseline: &Baseline,
        set_point: f64,
    ) -> Result<Calibration, ReplayError> {
        let config = self.config(Bank::from_fn(|_| NO_LIMIT))?;
        let mut monitor = Monitor::new(&config).map_err(settings)?.starting_from(*baseline, set_point as f32);
        let mut calibration = Calibration::default();
        let mut log = self.source.open()?;
        while let Some(reading) = next_reading(&mut log, injections)? {
            if reading.row >= window.end {
                break;
            }
            if reading.row < window.start || !reading.is_finite() {
                continue;
            }
            let verdict = *monitor.step_channels(reading.set_point as f32, reading.channels());
            if let Some(residuals) = verdict.residuals() {
                calibration.peak.push(residuals);
            }
            let z = baseline
                .deviation(reading.channels())
                .into_iter()
                .zip(baseline.sigma())
                .map(|(d, s)| f64::from((d / s).abs()));
            for (largest, z) in calibration.largest_deviation.iter_mut().zip(z) {
                *largest = f64::max(*largest, z);
            }
        }
        Ok(calibration)
    }
}
