//! Hotelling's T2 of one sample, and what each channel contributes to it.

use nalgebra::SVector;

use crate::pca::Pca;
use crate::root::square_root;
use crate::triangle::Triangle;

/// Smallest eigenvalue a retained component is divided by, of a total of `N`: below it the variance is rounding of
/// the correlation matrix (N eps), and dividing by it would judge samples by that rounding.
const EIGENVALUE_FLOOR: f32 = 16.0 * f32::EPSILON;

/// A model of `N` channels: a PCA, and the triangle that turns a deviation from the mean into T2.
///
/// With P the retained loadings, D their variances and S the sigmas, (1.6) is T2 = |W d|^2 with W = c D^(-1/2) P' S^(-1) and
/// c^2 the scale, so no inverse, no division and no standardization are left per sample. A triangle U has the same lengths
/// at half the products: T2 = |U d|^2. W has a row of zeros for every component that is not retained, so the work does not
/// depend on how many are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<const N: usize> {
    pca: Pca<N>,
    /// c^2.
    scale: f32,
    triangle: Triangle<N>,
}

impl<const N: usize> Model<N> {
    /// The model of a PCA learned from `samples` samples of channels with standard deviations `sigma`.
    #[must_use]
    pub fn new(pca: Pca<N>, sigma: SVector<f32, N>, samples: u32) -> Self {
        let scale = phase_two_scale(samples, pca.retained());
        // Loadings column by column are W row by row. Arrays: nalgebra's iterators over small matrices take much code.
        let (mut rows, sigma): (_, [f32; N]) = (pca.loadings().data.0, sigma.into());
        for (row, weight) in rows.iter_mut().zip(weights(&pca, scale)) {
            for (cell, s) in row.iter_mut().zip(sigma) {
                *cell = weight * *cell / s; // (1.7): the division by sigma
            }
        }
        Model { pca, scale, triangle: Triangle::of_rows(rows) }
    }

    /// The PCA behind the model.
    #[must_use]
    pub const fn pca(&self) -> &Pca<N> {
        &self.pca
    }

    /// T2 of one deviation from the mean (each channel in its unit), with the scale of (1.6): about one on average
    /// while the process is in control.
    #[inline(always)]
    #[must_use]
    pub fn t2(&self, deviation: [f32; N]) -> f32 {
        self.triangle.square_of(deviation) // (1.6)
    }

    /// What each channel contributes to the T2 of a standardized deviation z (1.7). The contributions are not negative
    /// and sum to T2.
    ///
    /// Complete decomposition contributions (Alcala and Qin 2009): the square of each channel's entry in
    /// M^(1/2) z, where T2 = z' M z. Of the forms in use it is the one that cannot blame a channel by a negative
    /// number.
    #[must_use]
    pub fn contributions(&self, z: [f32; N]) -> [f32; N] {
        let mut entries = [0.0; N];
        for (loading, weight) in self.pca.loadings().data.0.into_iter().zip(weights(&self.pca, self.scale)) {
            let score = weight * loading.iter().zip(z).map(|(p, z)| p * z).sum::<f32>();
            for (entry, p) in entries.iter_mut().zip(loading) {
                *entry += p * score;
            }
        }
        entries.map(|entry| entry * entry)
    }
}

/// c D^(-1/2) of (1.6): what the score of each component is multiplied by; zero for those that are not retained.
fn weights<const N: usize>(pca: &Pca<N>, scale: f32) -> [f32; N] {
    let mut weights = [0.0; N];
    fill_weights(&mut weights, pca.eigenvalues().as_slice(), pca.retained(), scale);
    weights
}

// Slices, and never inlined: once in flash for models of two and of three channels, where time is not dear.
#[inline(never)]
fn fill_weights(weights: &mut [f32], variances: &[f32], retained: usize, scale: f32) {
    for (weight, variance) in weights.iter_mut().zip(variances).take(retained) {
        *weight = square_root(scale / variance.max(EIGENVALUE_FLOOR));
    }
}

/// The factor I (I - R) / (R (I^2 - 1)) of (1.6), for I samples and R retained components.
///
/// The paper prints I^2 - I in the denominator; the limit of a future sample's T2 (phase II) has I^2 - 1, and that is
/// what stands here (NIST/SEMATECH e-Handbook, 6.5.4.3). With it T2 is distributed as F(R, I - R).
fn phase_two_scale(samples: u32, retained: usize) -> f32 {
    let (i, r) = (samples as f32, retained as f32);
    // As a product of ratios near one, so that I^2 does not leave f32's precision.
    i / (i + 1.0) * ((i - r) / (i - 1.0)) / r
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pca::ExplainedShare;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    fn correlation(a: f32, b: f32, c: f32) -> Matrix3<f32> {
        Matrix3::new(1.0, a, b, a, 1.0, c, b, c, 1.0)
    }

    fn model(rho: [f32; 3], sigma: [f32; 3], samples: u32, share: f32) -> Model<3> {
        let [a, b, c] = rho;
        let pca = Pca::of_correlation(&correlation(a, b, c), ExplainedShare::new(share).unwrap()).unwrap();
        Model::new(pca, sigma.into(), samples)
    }

    #[test]
    fn the_scale_is_the_papers_with_the_standard_denominator() {
        let (i, r) = (15_000.0_f64, 2.0_f64);
        let exact = i * (i - r) / (r * (i * i - 1.0));
        assert!((f64::from(phase_two_scale(15_000, 2)) - exact).abs() < 1e-6 * exact);
        let (i, r) = (30.0_f64, 3.0_f64);
        let exact = i * (i - r) / (r * (i * i - 1.0));
        assert!((f64::from(phase_two_scale(30, 3)) - exact).abs() < 1e-6 * exact);
    }

    #[test]
    fn models_of_any_rank_measure_the_same_length_by_their_triangle_as_by_their_components() {
        for share in [0.3, 0.8, 1.0] {
            let model = model([0.6, 0.5, 0.4], [2.0, 0.5, 1.0], 15_000, share);
            for z in [[1.0, 0.0, 0.0], [0.3, -2.0, 0.7], [5.0, 5.0, -5.0_f32]] {
                let components = model.pca().loadings().column_iter().zip(weights(model.pca(), model.scale));
                let exact: f32 = components
                    .map(|(loading, weight)| weight * loading.iter().zip(z).map(|(p, z)| p * z).sum::<f32>())
                    .map(|score| score * score)
                    .sum();
                let found = model.t2([2.0 * z[0], 0.5 * z[1], z[2]]);
                assert!((found - exact).abs() <= 1e-5 * exact + 1e-6, "{found} for {exact}");
            }
        }
    }

    #[test]
    fn a_channel_that_moves_alone_contributes_most_when_channels_are_independent() {
        let model = model([0.0, 0.0, 0.0], [0.1, 0.02, 0.02], 15_000, 1.0);
        let contributions = model.contributions([0.0, 10.0, 0.0]);
        assert!(contributions[1] > 0.999 * contributions.iter().sum::<f32>());
    }

    proptest! {
        #[test]
        fn t2_of_all_components_is_the_mahalanobis_distance_by_matrix_inverse(
            rho in prop::array::uniform3(-0.49_f32..0.49), z in prop::array::uniform3(-10.0_f32..10.0),
        ) {
            let sigma = [0.1_f32, 0.02, 5.0];
            let [a, b, c] = rho;
            let inverse = correlation(a, b, c).cast::<f64>().try_inverse().unwrap();
            let zv = Vector3::from(z).cast::<f64>();
            let exact = (zv.transpose() * inverse * zv)[0] * f64::from(phase_two_scale(15_000, 3));
            let deviation = core::array::from_fn(|i| z[i] * sigma[i]);
            let found = f64::from(model(rho, sigma, 15_000, 1.0).t2(deviation));
            prop_assert!((found - exact).abs() <= 2e-5 * exact + 1e-6, "{found} for {exact}");
        }

        #[test]
        fn contributions_are_not_negative_and_sum_to_t2(
            rho in prop::array::uniform3(-0.49_f32..0.49), z in prop::array::uniform3(-10.0_f32..10.0),
            share in 0.3_f32..1.0,
        ) {
            let model = model(rho, [1.0; 3], 500, share);
            let contributions = model.contributions(z);
            prop_assert!(contributions.iter().all(|c| *c >= 0.0));
            let (sum, t2) = (contributions.iter().sum::<f32>(), model.t2(z));
            prop_assert!((sum - t2).abs() <= 1e-4 * t2 + 1e-6);
        }
    }
}
