//! The paper's chain as a programmer would first write it, with libraries: the peer of the benchmark.
//!
//! `nalgebra`'s iterative `SymmetricEigen` and matrix products, and the `biquad` crate's Butterworth low-pass. It does
//! the same work as the monitor in its monitoring phase: four models, four filters, four relays, the truth table. It needs
//! no `std`, so the firmware that is audited holds it too.

use biquad::{Biquad, Coefficients, DirectForm2Transposed, Q_BUTTERWORTH_F32, ToHertz, Type};
use nalgebra::{ComplexField, SMatrix, SVector, SymmetricEigen};

/// A model of `N` channels: standardization, and the inverse of P D P' over the retained components.
#[derive(Clone, Debug)]
pub struct TextbookModel<const N: usize> {
    mean: SVector<f32, N>,
    sigma: SVector<f32, N>,
    inverse: SMatrix<f32, N, N>,
    scale: f32,
}

impl<const N: usize> TextbookModel<N> {
    /// The model of a window, in two passes, with components retained up to 80 % of the variance.
    #[must_use]
    pub fn learn(window: impl Iterator<Item = SVector<f32, N>> + Clone) -> Self
    where
        SMatrix<f32, N, N>: IterativeEigen<N>,
    {
        let n = window.clone().count() as f32;
        let sum = window.clone().fold(SVector::<f32, N>::zeros(), |sum, x| sum + x);
        let mean = sum / n;
        let outer = |x: SVector<f32, N>| (x - mean) * (x - mean).transpose();
        let products = window.fold(SMatrix::<f32, N, N>::zeros(), |sum, x| sum + outer(x));
        let covariance = products / (n - 1.0);
        let sigma: SVector<f32, N> = covariance.diagonal().map(ComplexField::sqrt);
        let correlation = covariance.component_div(&(sigma * sigma.transpose()));
        let (inverse, retained) = retained_inverse(correlation);
        let r = retained as f32;
        TextbookModel { mean, sigma, inverse, scale: n * (n - r) / (r * (n * n - 1.0)) }
    }

    /// T2 of a sample.
    #[inline]
    #[must_use]
    pub fn t2(&self, x: &SVector<f32, N>) -> f32 {
        let z = (x - self.mean).component_div(&self.sigma);
        (z.transpose() * self.inverse * z)[0] * self.scale
    }
}

/// `nalgebra`'s iterative solver, which is not generic over the size.
pub trait IterativeEigen<const N: usize> {
    /// Eigenvalues in no order, and the eigenvectors as columns.
    fn iterative_eigen(self) -> (SVector<f32, N>, SMatrix<f32, N, N>);
}

impl IterativeEigen<2> for SMatrix<f32, 2, 2> {
    fn iterative_eigen(self) -> (SVector<f32, 2>, Self) {
        let eigen = SymmetricEigen::new(self);
        (eigen.eigenvalues, eigen.eigenvectors)
    }
}

impl IterativeEigen<3> for SMatrix<f32, 3, 3> {
    fn iterative_eigen(self) -> (SVector<f32, 3>, Self) {
        let eigen = SymmetricEigen::new(self);
        (eigen.eigenvalues, eigen.eigenvectors)
    }
}

/// The inverse of P D P' over the components that explain 80 %, and how many those are.
#[must_use]
pub fn retained_inverse<const N: usize>(correlation: SMatrix<f32, N, N>) -> (SMatrix<f32, N, N>, usize)
where
    SMatrix<f32, N, N>: IterativeEigen<N>,
{
    let (eigenvalues, eigenvectors) = correlation.iterative_eigen();
    let mut order: [usize; N] = core::array::from_fn(|k| k);
    order.sort_unstable_by(|a, b| eigenvalues[*b].total_cmp(&eigenvalues[*a]));
    let total: f32 = eigenvalues.iter().sum();
    let (mut share, mut retained, mut inverse) = (0.0, 0, SMatrix::<f32, N, N>::zeros());
    for k in order {
        let p = eigenvectors.column(k);
        inverse += p * p.transpose() / eigenvalues[k];
        share += eigenvalues[k] / total;
        retained += 1;
        if share >= 0.80 {
            break;
        }
    }
    (inverse, retained)
}

/// The whole chain: full model and pairs, filters, relays and truth table.
#[derive(Debug)]
pub struct TextbookMonitor {
    full: TextbookModel<3>,
    pairs: [([usize; 2], TextbookModel<2>); 3],
    filters: [DirectForm2Transposed<f32>; 4],
    up: [bool; 4],
    threshold: f32,
    hysteresis: f32,
}

/// A filter that the `biquad` crate refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadCutoff;

impl TextbookMonitor {
    /// Learns a window of samples.
    ///
    /// # Errors
    /// [`BadCutoff`] when the cutoff does not lie below half the rate.
    pub fn learn(
        window: impl Iterator<Item = [f32; 3]> + Clone,
        cutoff_hz: f32,
        rate_hz: f32,
        threshold: f32,
    ) -> Result<Self, BadCutoff> {
        let pair = |[i, j]: [usize; 2]| ([i, j], TextbookModel::learn(window.clone().map(|x| [x[i], x[j]].into())));
        let low_pass = Coefficients::from_params(Type::LowPass, rate_hz.hz(), cutoff_hz.hz(), Q_BUTTERWORTH_F32);
        let filter = DirectForm2Transposed::new(low_pass.map_err(|_| BadCutoff)?);
        Ok(TextbookMonitor {
            full: TextbookModel::learn(window.clone().map(SVector::from)),
            pairs: [pair([0, 1]), pair([1, 2]), pair([0, 2])],
            filters: [filter; 4],
            up: [false; 4],
            threshold,
            hysteresis: 0.1,
        })
    }

    /// Judges one sample: the four residuals, and the fault by (1.8): 0 none, 1 to 3 the paper's, 4 unknown.
    #[inline]
    pub fn step(&mut self, x: [f32; 3]) -> ([f32; 4], u8) {
        let pair = |k: usize| {
            let ([i, j], model) = &self.pairs[k];
            model.t2(&[x[*i], x[*j]].into())
        };
        let t2 = [self.full.t2(&x.into()), pair(0), pair(1), pair(2)];
        let mut residuals = [0.0; 4];
        for k in 0..4 {
            residuals[k] = self.filters[k].run(t2[k]);
            let level = if self.up[k] { self.threshold * (1.0 - self.hysteresis) } else { self.threshold };
            self.up[k] = residuals[k] > level;
        }
        let fault = match self.up {
            [_, false, false, false] => 0,
            [_, true, true, true] => 1,
            [_, false, true, true] => 2,
            [_, true, true, false] => 3,
            _ => 4,
        };
        (residuals, fault)
    }
}
