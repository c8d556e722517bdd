//! Principal components of the standardized channels: loadings, explained variance, how many to keep.

use nalgebra::{SMatrix, SVector};

use crate::eigen::{ClosedFormEigen, Eigen, EigenError};

/// Why a PCA was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PcaError {
    /// The correlation matrix holds an entry that is not finite.
    NonFinite,
    /// The share of variance to explain must lie in (0, 1].
    ExplainedShare,
}

impl From<EigenError> for PcaError {
    fn from(_: EigenError) -> Self {
        PcaError::NonFinite
    }
}

/// The share of variance the retained components must explain, in (0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplainedShare(f32);

impl ExplainedShare {
    /// The paper's criterion (II.A): at least 80 % of the total variance.
    pub const PAPER: ExplainedShare = ExplainedShare(0.80);

    /// A share in (0, 1].
    ///
    /// # Errors
    /// [`PcaError::ExplainedShare`] when it is not.
    pub fn new(share: f32) -> Result<Self, PcaError> {
        if share > 0.0 && share <= 1.0 { Ok(ExplainedShare(share)) } else { Err(PcaError::ExplainedShare) }
    }

    /// The share as a number.
    #[must_use]
    pub const fn get(self) -> f32 {
        self.0
    }
}

/// The PCA of `N` standardized channels.
///
/// Column k of the loadings is the direction of component k; eigenvalues descend; signs are fixed as in
/// [`Eigen`]. All `N` components are kept, and `retained` says how many of them the model uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pca<const N: usize> {
    loadings: SMatrix<f32, N, N>,
    eigenvalues: SVector<f32, N>,
    retained: u8,
}

impl<const N: usize> Pca<N>
where
    SMatrix<f32, N, N>: ClosedFormEigen<N>,
{
    /// The PCA of a correlation matrix (N x N, symmetric).
    ///
    /// # Errors
    /// [`PcaError::NonFinite`] when an entry is not finite.
    pub fn of_correlation(correlation: &SMatrix<f32, N, N>, share: ExplainedShare) -> Result<Self, PcaError> {
        // The columns of P are the eigenvectors of the covariance (1.2); channels are standardized by (1.7) first, so
        // that covariance is the correlation matrix.
        let Eigen { values, vectors } = correlation.decompose_correlation().checked()?;
        Ok(Self::from_parts(vectors, values, share))
    }
}

impl<const N: usize> Pca<N> {
    /// The PCA with given loadings and descending eigenvalues.
    pub(crate) fn from_parts(
        loadings: SMatrix<f32, N, N>,
        eigenvalues: SVector<f32, N>,
        share: ExplainedShare,
    ) -> Self {
        let mut pca = Pca { loadings, eigenvalues, retained: N as u8 };
        // The smallest l whose cumulative share reaches the criterion; all of them when rounding keeps 100 % away.
        if let Some(last) = pca.cumulative().iter().position(|s| *s >= share.get()) {
            pca.retained = last as u8 + 1;
        }
        pca
    }

    /// Directions of the components, one a column (N x N, orthonormal).
    #[must_use]
    pub const fn loadings(&self) -> &SMatrix<f32, N, N> {
        &self.loadings
    }

    /// Variance of each component, descending, in units of the standardized channels' variance.
    #[must_use]
    pub const fn eigenvalues(&self) -> &SVector<f32, N> {
        &self.eigenvalues
    }

    /// How many components the model retains: l of (1.4).
    #[must_use]
    pub const fn retained(&self) -> usize {
        self.retained as usize
    }

    /// The share of the total variance that each component explains (figures 5 and 8), summing to one.
    #[must_use]
    pub fn explained(&self) -> [f32; N] {
        // An eigenvalue of zero may come out a rounding below zero.
        let variance: [f32; N] = self.eigenvalues.map(|v| v.max(0.0)).into();
        let total: f32 = variance.iter().sum();
        variance.map(|v| v / total)
    }

    /// The cumulative share s_i,cum (1.3), as a fraction.
    #[must_use]
    pub fn cumulative(&self) -> [f32; N] {
        let mut sum = 0.0;
        self.explained().map(|share| {
            sum += share; // (1.3)
            sum
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3};
    use proptest::prelude::*;

    #[test]
    fn the_smallest_number_of_components_that_reaches_the_criterionis_retained() {
        for (share, retained) in [(0.5, 1), (0.66, 1), (0.67, 2), (0.80, 2), (0.95, 3), (1.0, 3)] {
            let criterion = ExplainedShare::new(share).unwrap();
            let pca = Pca::from_parts(Matrix3::identity(), [2.0, 0.7, 0.3].into(), criterion);
            assert_eq!(pca.retained(), retained, "at a share of {share}");
        }
    }

    #[test]
    fn a_strongly_tied_pair_needs_one_component_and_a_loose_one_needs_two() {
        let pair = |rho| Pca::of_correlation(&Matrix2::new(1.0, rho, rho, 1.0), ExplainedShare::PAPER).unwrap();
        assert_eq!(pair(0.9).retained(), 1); // (1 + 0.9)/2 = 95 %
        assert_eq!(pair(-0.9).retained(), 1);
        assert_eq!(pair(0.5).retained(), 2); // 75 %
        assert_eq!(pair(1.0).retained(), 1);
    }

    #[test]
    fn shares_outside_zero_to_one_and_matrices_that_are_not_finite_are_refused() {
        for share in [0.0, -0.1, 1.1, f32::NAN] {
            assert_eq!(ExplainedShare::new(share), Err(PcaError::ExplainedShare));
        }
        let broken = Matrix2::new(1.0, f32::NAN, f32::NAN, 1.0);
        assert_eq!(Pca::of_correlation(&broken, ExplainedShare::PAPER), Err(PcaError::NonFinite));
    }

    proptest! {
        #[test]
        fn shares_sum_to_one_and_do_not_grow(rho in prop::array::uniform3(-0.49_f32..0.49)) {
            let [a, b, c] = rho;
            let pca = Pca::of_correlation(&Matrix3::new(1.0, a, b, a, 1.0, c, b, c, 1.0), ExplainedShare::PAPER).unwrap();
            let explained = pca.explained();
            prop_assert!((explained.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            prop_assert!(explained[0] >= explained[1] && explained[1] >= explained[2]);
            prop_assert!(pca.cumulative()[pca.retained() - 1] >= 0.80);
        }
    }
}
