//! Thresholds for the paper's monitor by its own empirical way (III.B), as `tune` goes it: fly fault-free runs of the
//! motor, see how far each residual goes by itself. `tune` puts a margin on the largest; here the threshold is where the
//! tail of the same runs, continued, is passed as seldom as asked, so that two monitors can be compared at the same rate
//! of false alarms.
//!
//! The cube root of a smoothed T2 is nearly normal (Wilson, Hilferty 1931), and a normal z is passed upwards at a rate
//! that falls as exp(-z^2/2) (Rice 1944). So the largest z^2/2 of each block of two seconds has an exponential tail; its
//! scale is measured (1 for a normal residual) from the upper tenth of the blocks, and the tail continued to the rate.

use monitor_core::sample::ModelId;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::StudyError;
use super::paper_watch::PaperWatch;
use super::watch::{Known, Limits, Watch, give};
use crate::names::ByModel;
use crate::plant::PlantSample;

/// Longer than the 1 Hz low-pass remembers, so that the largest values of neighbours are of different excursions.
const BLOCK_S: f64 = 2.0;

/// Share of the blocks that the tail is measured on, and their least number.
const TAIL_SHARE: f64 = 0.1;
const FEWEST_TAIL_BLOCKS: usize = 8;

/// A residual at 1 kHz through 1 Hz hardly moves in ten samples.
const DECIMATION: u64 = 10;

/// Four relays share the rate that is asked for.
const MODELS: f64 = ModelId::ALL.len() as f64;

/// How often a monitor may be wrong, and the fault-free runs that show what that takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// False alarms per hour.
    pub false_alarms_per_hour: f64,
    /// Fault-free runs.
    pub calibration_runs: u64,
    /// How much of each is judged, s.
    pub calibration_judged_s: f64,
}

impl Asked {
    /// Length of a run for a motor of which this is known, s.
    #[must_use]
    pub fn run_s(&self, known: &Known) -> f64 {
        known.settle_s + known.learn_s + self.calibration_judged_s
    }
}

/// How far one residual goes by itself.
#[derive(Clone, Debug, Default)]
struct Excursions {
    /// Largest residual of each block.
    largest: Vec<f64>,
    /// Count, sum and sum of squares of the cube roots' distances from 1: they are near 1.
    n: f64,
    sum: f64,
    squares: f64,
}

/// Finds the thresholds.
///
/// # Errors
/// [`StudyError`] when the monitor refuses its settings, or learns nothing in a run.
pub(super) fn calibrate<I>(known: &Known, asked: &Asked, source: impl Fn(u64) -> I + Sync) -> Result<Limits, StudyError>
where
    I: Iterator<Item = PlantSample>,
{
    let runs: Vec<_> = (0..asked.calibration_runs)
        .into_par_iter()
        .map(|run| fly(known, asked, source(run)))
        .collect::<Result<_, _>>()?;
    let hours = asked.calibration_runs as f64 * asked.calibration_judged_s / 3600.0;
    let threshold = |model| {
        let all = runs.iter().fold(Excursions::default(), |all, run| all.and(run.get(model)));
        all.limit(hours, asked.false_alarms_per_hour / MODELS)
    };
    Ok(Limits { asked_per_hour: asked.false_alarms_per_hour, thresholds: Some(ByModel::from_fn(threshold)) })
}

fn fly(
    known: &Known,
    asked: &Asked,
    samples: impl Iterator<Item = PlantSample>,
) -> Result<ByModel<Excursions>, StudyError> {
    let unlimited = Limits { asked_per_hour: asked.false_alarms_per_hour, thresholds: None };
    let mut watch = PaperWatch::new(known, &unlimited)?;
    let mut excursions = ByModel::from_fn(|_| Excursions::default());
    let block = (BLOCK_S * known.rate_hz).round().max(1.0) as u64;
    let mut judged = 0_u64;
    for measured in samples {
        give(&mut watch, &measured);
        let Some(residuals) = watch.verdict().residuals() else { continue };
        for model in ModelId::ALL {
            let residual = f64::from(*residuals.get(model));
            excursions.get_mut(model).push(residual, judged.is_multiple_of(block), judged.is_multiple_of(DECIMATION));
        }
        judged += 1;
    }
    if judged < block {
        return Err(StudyError::NothingLearned(watch.refused()));
    }
    Ok(excursions)
}

impl Excursions {
    #[inline]
    fn push(&mut self, residual: f64, begins_block: bool, counts: bool) {
        match self.largest.last_mut() {
            Some(largest) if !begins_block => *largest = largest.max(residual),
            _ => self.largest.push(residual),
        }
        if counts {
            let x = residual.cbrt() - 1.0;
            (self.n, self.sum, self.squares) = (self.n + 1.0, self.sum + x, self.squares + x * x);
        }
    }

    fn and(mut self, other: &Self) -> Self {
        self.largest.extend(&other.largest);
        self.n += other.n;
        self.sum += other.sum;
        self.squares += other.squares;
        self
    }

    /// The residual that is passed `per_hour` times an hour, from `hours` of blocks.
    fn limit(&self, hours: f64, per_hour: f64) -> f64 {
        let mean = self.sum / self.n;
        let sigma = (self.squares / self.n - mean * mean).max(f64::MIN_POSITIVE).sqrt();
        let energy = |largest: &f64| 0.5 * ((largest.cbrt() - 1.0 - mean) / sigma).max(0.0).powi(2);
        let mut energies: Vec<f64> = self.largest.iter().map(energy).collect();
        energies.sort_by(|a, b| b.total_cmp(a));
        let tail = ((TAIL_SHARE * energies.len() as f64) as usize).max(FEWEST_TAIL_BLOCKS).min(energies.len() - 1);
        let from = energies[tail];
        let scale = energies[..tail].iter().map(|e| e - from).sum::<f64>() / tail as f64;
        let passed_per_hour = tail as f64 / hours;
        let energy = from + scale * (passed_per_hour / per_hour).ln().max(0.0);
        (1.0 + mean + sigma * (2.0 * energy).sqrt()).powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    #[test]
    fn the_tail_of_a_normal_cube_root_is_continued_to_the_rate_that_was_asked_for() {
        // Blocks of one sample each, so that the rate is known: 3,600 draws an hour for four hours.
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let mut excursions = Excursions::default();
        for _ in 0..4 * 3600 {
            let z: f64 = generator.sample(StandardNormal);
            excursions.push((1.0 + 0.05 * z).powi(3), true, true);
        }
        // P(z > 4.89) = 5.0e-7: one in 555 hours of 3,600 draws.
        let limit = excursions.limit(4.0, 1.0 / 555.0);
        let z = (limit.cbrt() - 1.0) / 0.05;
        assert!((z - 4.89).abs() < 0.25, "z = {z}");
        // What has been seen often enough needs no continuation: P(z > 1) = 0.159.
        let z = (excursions.limit(4.0, 360.0).cbrt() - 1.0) / 0.05;
        assert!((z - 1.28).abs() < 0.04, "one of ten is passed at 1.28, not at {z}");
    }
}
