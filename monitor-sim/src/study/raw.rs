//! The loop itself, without any monitor's filter: how far one sample lies from the learned baseline, in double precision.

use nalgebra::{Matrix3, Vector3};

use super::poisson::chi_square_limit;

/// What a sample in control exceeds with this probability is taken for a loop that has not recovered.
const ONE_SAMPLE_PROBABILITY: f64 = 1e-6;

/// Mean and covariance of a learning window.
#[derive(Clone, Debug, Default)]
pub struct Moments {
    n: f64,
    shift: Vector3<f64>,
    sum: Vector3<f64>,
    products: Matrix3<f64>,
}

impl Moments {
    /// Takes one sample of the window.
    pub fn push(&mut self, x: [f64; 3]) {
        if self.n == 0.0 {
            self.shift = x.into();
        }
        let d = Vector3::from(x) - self.shift;
        self.n += 1.0;
        self.sum += d;
        self.products += d * d.transpose();
    }

    /// Mean of what was taken; not a number before the first sample.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        (self.shift + self.sum / self.n).into()
    }

    /// The baseline of the window; none if a channel stood still.
    #[must_use]
    pub fn baseline(&self) -> Option<RawBaseline> {
        let mean = self.sum / self.n;
        let covariance = (self.products - self.n * mean * mean.transpose()) / (self.n - 1.0);
        let inverse = covariance.cholesky()?.inverse();
        let limit = chi_square_limit(3, ONE_SAMPLE_PROBABILITY);
        Some(RawBaseline { mean: self.shift + mean, inverse, limit })
    }
}

/// Learned mean and inverse covariance.
#[derive(Clone, Debug)]
pub struct RawBaseline {
    mean: Vector3<f64>,
    inverse: Matrix3<f64>,
    limit: f64,
}

impl RawBaseline {
    /// Length of a shift of the three channels in sigmas of one sample (Mahalanobis).
    #[must_use]
    pub fn length(&self, shift: [f64; 3]) -> f64 {
        let d = Vector3::from(shift);
        (d.transpose() * self.inverse * d)[0].max(0.0).sqrt()
    }

    /// Sine of the angle between two shifts in that metric: 0 if they cannot be told apart by direction, 1 if nothing of
    /// one looks like the other. 0 where one of them is no shift.
    #[must_use]
    pub fn sine_between(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let lengths = self.length(a) * self.length(b);
        if lengths == 0.0 {
            return 0.0;
        }
        let cosine = (Vector3::from(a).transpose() * self.inverse * Vector3::from(b))[0] / lengths;
        (1.0 - cosine * cosine).max(0.0).sqrt()
    }

    /// Whether one sample lies beyond what a million in control exceed once.
    #[must_use]
    pub fn is_beyond(&self, x: [f64; 3]) -> bool {
        self.length((Vector3::from(x) - self.mean).into()).powi(2) > self.limit
    }

    /// The learned mean.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        self.mean.into()
    }
}
