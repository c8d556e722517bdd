//! What healthy means at one set point: mean and sigma of each channel, the full model and the three partial ones.
//!
//! Learned online from a fault-free window, or taken from a table made beforehand (the paper, II.C).

use nalgebra::{Matrix2, SMatrix, SVector};

use crate::hotelling::Model;
use crate::moments::{LearnError, Moments};
use crate::pca::{ExplainedShare, Pca, PcaError};
use crate::sample::{Bank, Channel, ModelId, Pair, PerPair};

/// How far stored loadings may be from orthonormal, and stored eigenvalues from a total of three: four decimals.
const STORED_TOLERANCE: f32 = 1e-3;

/// Why a stored baseline was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BaselineError {
    /// The mean of a channel is not finite.
    Mean(Channel),
    /// The sigma of a channel is not a finite number above zero.
    Sigma(Channel),
    /// The columns of the loadings are not orthonormal.
    Loadings,
    /// The eigenvalues do not descend, are negative, or do not sum to the number of channels.
    Eigenvalues,
    /// Fewer samples than [`Moments::MIN_SAMPLES`] stand behind it.
    Samples,
    /// The model could not be built.
    Pca(PcaError),
}

impl From<PcaError> for BaselineError {
    fn from(error: PcaError) -> Self {
        BaselineError::Pca(error)
    }
}

/// The numbers a baseline is stored as: one row of the offline table of the paper (II.C).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// Mean of each channel, in its unit.
    pub mean: [f32; 3],
    /// Standard deviation of each channel, in its unit.
    pub sigma: [f32; 3],
    /// Loadings of the standardized channels: `loadings[k]` is the direction of component k.
    pub loadings: [[f32; 3]; 3],
    /// Variance of each component, descending; they sum to three.
    pub eigenvalues: [f32; 3],
    /// Samples of the window it was learned from.
    pub samples: u32,
}

/// Mean, sigma and the bank of models at one set point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    mean: [f32; 3],
    sigma: [f32; 3],
    samples: u32,
    full: Model<3>,
    pairs: PerPair<Model<2>>,
}

impl Baseline {
    /// Learns a baseline from a window.
    ///
    /// This is where the eigen-solver runs, so on a target it belongs outside the sampling interrupt.
    ///
    /// # Errors
    /// [`LearnError`] when the window cannot be learned from.
    #[inline(never)] // Large, and called once in a while: it keeps its stack and its code to itself.
    pub fn learn(window: &Moments<3>, share: ExplainedShare) -> Result<Self, LearnError> {
        let statistics = window.statistics()?;
        let correlation = statistics.correlation();
        let full = Pca::of_correlation(&correlation, share)?;
        Ok(Self::new(statistics.mean, statistics.sigma(), statistics.samples, full, &correlation, share)?)
    }

    /// Takes a baseline from a table, so that monitoring starts at once.
    ///
    /// # Errors
    /// [`BaselineError`] names what does not fit.
    pub fn from_stored(stored: &Stored, share: ExplainedShare) -> Result<Self, BaselineError> {
        for (position, (mean, sigma)) in stored.mean.into_iter().zip(stored.sigma).enumerate() {
            let channel = Channel::at(position);
            if !mean.is_finite() {
                return Err(BaselineError::Mean(channel));
            }
            if !(sigma > 0.0 && sigma.is_finite()) {
                return Err(BaselineError::Sigma(channel));
            }
        }
        let loadings = SMatrix::<f32, 3, 3>::from(stored.loadings);
        let gram_error = loadings.transpose() * loadings - SMatrix::identity();
        if !gram_error.iter().all(|e| e.abs() <= STORED_TOLERANCE) {
            return Err(BaselineError::Loadings);
        }
        let [first, second, third] = stored.eigenvalues;
        let total = first + second + third;
        if !(first >= second && second >= third && third >= 0.0 && (total - 3.0).abs() <= STORED_TOLERANCE) {
            return Err(BaselineError::Eigenvalues);
        }
        if stored.samples < Moments::<3>::MIN_SAMPLES {
            return Err(BaselineError::Samples);
        }
        let eigenvalues = SVector::from(stored.eigenvalues);
        // The pairs need the correlations, which loadings and eigenvalues give back: R = P D P'.
        let correlation = loadings * SMatrix::from_diagonal(&eigenvalues) * loadings.transpose();
        let full = Pca::from_parts(loadings, eigenvalues, share);
        Ok(Self::new(stored.mean.into(), stored.sigma.into(), stored.samples, full, &correlation, share)?)
    }

    fn new(
        mean: SVector<f32, 3>,
        sigma: SVector<f32, 3>,
        samples: u32,
        full: Pca<3>,
        correlation: &SMatrix<f32, 3, 3>,
        share: ExplainedShare,
    ) -> Result<Self, PcaError> {
        let sigma_of: [f32; 3] = sigma.into();
        let pair = |pair: Pair| {
            let [a, b] = pair.channels().map(Channel::position);
            // Absent is impossible for positions below three; NaN would be refused by the PCA.
            let rho = correlation.get((a, b)).map_or(f32::NAN, |rho| rho.clamp(-1.0, 1.0));
            let pca = Pca::of_correlation(&Matrix2::new(1.0, rho, rho, 1.0), share)?;
            Ok::<_, PcaError>(Model::new(pca, pair.of(sigma_of).into(), samples))
        };
        Ok(Baseline {
            mean: mean.into(),
            sigma: sigma_of,
            samples,
            full: Model::new(full, sigma, samples),
            pairs: PerPair {
                speed_current: pair(Pair::SpeedCurrent)?,
                current_voltage: pair(Pair::CurrentVoltage)?,
                speed_voltage: pair(Pair::SpeedVoltage)?,
            },
        })
    }

    /// The numbers to store, so that [`Baseline::from_stored`] gives this baseline back.
    #[must_use]
    pub fn stored(&self) -> Stored {
        let pca = self.full.pca();
        Stored {
            mean: self.mean,
            sigma: self.sigma,
            loadings: pca.loadings().data.0,
            eigenvalues: pca.eigenvalues().map(|v| v.max(0.0)).into(),
            samples: self.samples,
        }
    }

    /// Mean of each channel, in its unit.
    #[must_use]
    pub const fn mean(&self) -> [f32; 3] {
        self.mean
    }

    /// Standard deviation of each channel, in its unit.
    #[must_use]
    pub const fn sigma(&self) -> [f32; 3] {
        self.sigma
    }

    /// Samples of the window it was learned from.
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.samples
    }

    /// The PCA over all three channels.
    #[must_use]
    pub const fn full(&self) -> &Model<3> {
        &self.full
    }

    /// The partial PCA over each pair.
    #[must_use]
    pub const fn pairs(&self) -> &PerPair<Model<2>> {
        &self.pairs
    }

    /// How many components each model retains.
    #[must_use]
    pub fn retained(&self) -> Bank<usize> {
        Bank::from_fn(|model| match model {
            ModelId::Full => self.full.pca().retained(),
            ModelId::Pair(pair) => self.pairs.get(pair).pca().retained(),
        })
    }

    /// The deviation of a sample from the mean: the first half of (1.7). The other half, the division by sigma, is
    /// folded into the triangles of the models; the mean is not, because an offset of mean/sigma would cost that many
    /// eps.
    #[inline(always)]
    #[must_use]
    pub fn deviation(&self, sample: [f32; 3]) -> [f32; 3] {
        let ([x1, x2, x3], [m1, m2, m3]) = (sample, self.mean);
        [x1 - m1, x2 - m2, x3 - m3] // (1.7)
    }

    /// T2 (1.6) of a deviation, by the full model and by each pair.
    #[inline(always)]
    #[must_use]
    pub fn t2(&self, deviation: [f32; 3]) -> Bank<f32> {
        Bank {
            full: self.full.t2(deviation),
            pairs: PerPair {
                speed_current: self.pairs.speed_current.t2(Pair::SpeedCurrent.of(deviation)),
                current_voltage: self.pairs.current_voltage.t2(Pair::CurrentVoltage.of(deviation)),
                speed_voltage: self.pairs.speed_voltage.t2(Pair::SpeedVoltage.of(deviation)),
            },
        }
    }

    /// What each channel contributes to the T2 of a sample by the full model. See [`Model::contributions`].
    #[must_use]
    pub fn contributions(&self, sample: [f32; 3]) -> [f32; 3] {
        let ([d1, d2, d3], [s1, s2, s3]) = (self.deviation(sample), self.sigma);
        self.full.contributions([d1 / s1, d2 / s2, d3 / s3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored() -> Stored {
        let h = core::f32::consts::FRAC_1_SQRT_2;
        Stored {
            mean: [300.0, 2.0, 10.0],
            sigma: [0.1, 0.02, 0.02],
            loadings: [[0.0, h, h], [1.0, 0.0, 0.0], [0.0, h, -h]],
            eigenvalues: [1.8, 1.0, 0.2],
            samples: 15_000,
        }
    }

    #[test]
    fn a_stored_baseline_gives_the_correlations_back_to_the_pairs() {
        let baseline = Baseline::from_stored(&stored(), ExplainedShare::PAPER).unwrap();
        let tied = baseline.pairs().current_voltage.pca().eigenvalues();
        assert!((tied[0] - 1.8).abs() < 1e-6 && (tied[1] - 0.2).abs() < 1e-6);
        let loose = baseline.pairs().speed_current.pca().eigenvalues();
        assert!((loose[0] - 1.0).abs() < 1e-6 && (loose[1] - 1.0).abs() < 1e-6);
        assert_eq!(
            baseline.retained(),
            Bank { full: 2, pairs: PerPair { speed_current: 2, current_voltage: 1, speed_voltage: 2 } }
        );
    }

    #[test]
    fn a_baseline_that_is_stored_and_taken_back_judges_alike() {
        let first = Baseline::from_stored(&stored(), ExplainedShare::PAPER).unwrap();
        let again = Baseline::from_stored(&first.stored(), ExplainedShare::PAPER).unwrap();
        assert_eq!(first, again);
    }

    #[test]
    fn stored_numbers_that_do_not_fit_are_refused_by_name() {
        let refused = |change: fn(&mut Stored)| {
            let mut stored = stored();
            change(&mut stored);
            Baseline::from_stored(&stored, ExplainedShare::PAPER).unwrap_err()
        };
        assert_eq!(refused(|s| s.mean[1] = f32::NAN), BaselineError::Mean(Channel::ArmatureCurrent));
        assert_eq!(refused(|s| s.sigma[2] = 0.0), BaselineError::Sigma(Channel::ArmatureVoltage));
        assert_eq!(refused(|s| s.sigma[0] = f32::NAN), BaselineError::Sigma(Channel::Speed));
        assert_eq!(refused(|s| s.loadings[0][0] = 0.1), BaselineError::Loadings);
        assert_eq!(refused(|s| s.loadings[2][2] = f32::NAN), BaselineError::Loadings);
        assert_eq!(refused(|s| s.eigenvalues = [1.0, 1.8, 0.2]), BaselineError::Eigenvalues);
        assert_eq!(refused(|s| s.eigenvalues = [2.8, 1.0, 0.2]), BaselineError::Eigenvalues);
        assert_eq!(refused(|s| s.eigenvalues[2] = f32::NAN), BaselineError::Eigenvalues);
        assert_eq!(refused(|s| s.samples = 3), BaselineError::Samples);
    }
}
