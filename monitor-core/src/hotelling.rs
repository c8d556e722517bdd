//! Hotelling's T2 of one sample, and what each channel contributes to it.

use nalgebra::SVector;

use crate::pca::Pca;

/// Smallest eigenvalue a retained component is divided by, of a total of `N`: below it the variance is rounding of
/// the correlation matrix (N eps), and dividing by it would judge samples by that rounding.
const EIGENVALUE_FLOOR: f32 = 16.0 * f32::EPSILON;

/// Largest T2 that is passed on. It only keeps a sample near the largest `f32` from turning a filter's state into
/// infinity, where it would stay; any limit is 9 orders of magnitude below.
const T2_CEILING: f32 = 1e12;

/// A model of `N` channels: a PCA, and the rows that turn a deviation from the mean into T2.
///
/// Row k is loading k divided by sigma and by the component's standard deviation, times the square root of the scale
/// in (1.6), so T2 is a plain sum of squares: no inverse, no division and no standardization are left per sample. The
/// rows of components that are not retained are zero, so that the work does not depend on how many are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<const N: usize> {
    pca: Pca<N>,
    rows: [[f32; N]; N],
}

impl<const N: usize> Model<N> {
    /// The model of a PCA learned from `samples` samples of channels with standard deviations `sigma`.
    #[must_use]
    pub fn new(pca: Pca<N>, sigma: SVector<f32, N>, samples: u32) -> Self {
        let scale = phase_two_scale(samples, pca.retained());
        let mut rows = [[0.0; N]; N];
        let components = pca.loadings().column_iter().zip(pca.eigenvalues().iter()).take(pca.retained());
        for (row, (loading, variance)) in rows.iter_mut().zip(components) {
            // (1.6): D^-1 as a division by the component's standard deviation; (1.7): the division by sigma.
            let weight = libm::sqrtf(scale / variance.max(EIGENVALUE_FLOOR));
            for ((cell, p), s) in row.iter_mut().zip(loading.iter()).zip(sigma.iter()) {
                *cell = weight * p / s;
            }
        }
        Model { pca, rows }
    }

    /// The PCA behind the model.
    #[must_use]
    pub const fn pca(&self) -> &Pca<N> {
        &self.pca
    }

    /// T2 of one deviation from the mean (each channel in its unit), with the scale of (1.6): about one on average
    /// while the process is in control.
    #[inline]
    #[must_use]
    pub fn t2(&self, deviation: [f32; N]) -> f32 {
        let t2 = self.scores(deviation).iter().map(|y| y * y).sum::<f32>(); // (1.6)
        // Written so that NaN (infinity minus infinity of a sample near the largest f32) is above the ceiling too.
        if t2 < T2_CEILING { t2 } else { T2_CEILING }
    }

    /// Scores of the retained components, each over its standard deviation and scaled as in (1.6); zero for the rest.
    #[inline]
    fn scores(&self, deviation: [f32; N]) -> [f32; N] {
        self.rows.map(|row| row.iter().zip(deviation).map(|(w, d)| w * d).sum())
    }

    /// What each channel contributes to the T2 of a deviation. The contributions are not negative and sum to T2.
    ///
    /// Complete decomposition contributions (Alcala and Qin 2009): the square of each channel's entry in
    /// M^(1/2) z, where T2 = z' M z. Of the forms in use it is the one that cannot blame a channel by a negative
    /// number.
    #[must_use]
    pub fn contributions(&self, deviation: [f32; N]) -> [f32; N] {
        let scores = self.scores(deviation);
        let mut contributions = [0.0; N];
        for (channel, share) in contributions.iter_mut().enumerate() {
            let loading = self.pca.loadings().row(channel);
            let entry: f32 = loading.iter().zip(scores).map(|(p, y)| p * y).sum();
            *share = entry * entry;
        }
        contributions
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
    fn a_sample_that_overflows_gives_the_ceiling_and_never_a_number_that_is_not_one() {
        let model = model([0.5, 0.2, -0.3], [0.1, 0.02, 0.02], 15_000, 1.0);
        for deviation in [[f32::MAX, f32::MAX, -f32::MAX], [1e30, 0.0, 0.0], [f32::INFINITY, f32::NEG_INFINITY, 0.0]] {
            assert_eq!(model.t2(deviation), T2_CEILING);
        }
    }

    #[test]
    fn a_channel_that_moves_alone_contributes_most_when_channels_are_independent() {
        let model = model([0.0, 0.0, 0.0], [0.1, 0.02, 0.02], 15_000, 1.0);
        let contributions = model.contributions([0.0, 0.2, 0.0]);
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
