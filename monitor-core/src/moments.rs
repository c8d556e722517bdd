//! Phase I: mean, standard deviation and covariance of the learning window, in one pass and constant memory.
//!
//! Sums of deviations from a shift near the mean, gathered in blocks. A plain sum of squares in `f32` loses every
//! digit of the variance once mean/sigma passes a few thousand (a speed of 300 rad/s with 0.1 rad/s of noise is there
//! already), and Welford's update on raw samples drifts over long windows. Here
//! - the shift is the first sample, then the mean of the first block, so deviations stay of the size of sigma;
//! - a block of 64 samples is summed on its own before it joins the total, so the rounding error of a long window grows
//!   with the number of blocks and not with the number of samples (Chan, Golub, LeVeque 1983, shifted and pairwise);
//! - no division per sample.

use nalgebra::{SMatrix, SVector};

use crate::pca::PcaError;
use crate::sample::Channel;

/// Samples in a block: long enough that merging is rare, short enough that 64 squares keep 18 of 24 bits each.
const BLOCK: u32 = 64;

/// Fewest samples per channel that a covariance may rest on: below about ten, the sampling error of a correlation
/// (1/sqrt(n)) is of the size of the correlations themselves.
const MIN_SAMPLES_PER_CHANNEL: u32 = 10;

/// Why a learning window was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LearnError {
    /// The window holds fewer samples than a covariance needs.
    TooShort {
        /// Samples in the window; [`Moments::MIN_SAMPLES`] are needed.
        samples: u32,
    },
    /// A channel varies by no more than the rounding of an `f32` of its size: nothing can be standardized by it.
    ConstantChannel(Channel),
    /// A channel brought a sample that is not finite, or so large that its square is not.
    NonFinite(Channel),
    /// The window has no PCA.
    Pca(PcaError),
}

impl From<PcaError> for LearnError {
    fn from(error: PcaError) -> Self {
        LearnError::Pca(error)
    }
}

/// Sums of deviations from the shift and of their products; of the products, the lower triangle is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums<const N: usize> {
    first: [f32; N],
    second: [[f32; N]; N],
}

impl<const N: usize> Sums<N> {
    const ZERO: Self = Sums { first: [0.0; N], second: [[0.0; N]; N] };

    fn add(&mut self, other: &Self) {
        for (a, b) in self.first.iter_mut().zip(other.first) {
            *a += b;
        }
        for (a, b) in self.second.iter_mut().flatten().zip(other.second.as_flattened()) {
            *a += b;
        }
    }
}

/// Online moments of `N` channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments<const N: usize> {
    shift: [f32; N],
    block: Sums<N>,
    total: Sums<N>,
    /// Slots of the window so far, those without a sample included; blocks are counted in slots.
    slots: u32,
    /// Samples taken.
    taken: u32,
}

/// What a learning window says: `mean` (N), `covariance` (N x N, symmetric, 1/(n-1)) of `samples` samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics<const N: usize> {
    /// Samples in the window.
    pub samples: u32,
    /// Mean of each channel, in its unit.
    pub mean: SVector<f32, N>,
    /// Covariance, in the product of the channels' units.
    pub covariance: SMatrix<f32, N, N>,
}

impl<const N: usize> Default for Moments<N> {
    fn default() -> Self {
        Moments { shift: [0.0; N], block: Sums::ZERO, total: Sums::ZERO, slots: 0, taken: 0 }
    }
}

impl<const N: usize> Moments<N> {
    /// Fewest samples of a window that can be learned from.
    pub const MIN_SAMPLES: u32 = MIN_SAMPLES_PER_CHANNEL * N as u32;

    /// Takes one sample. Constant work, but for every 64th slot, which merges a block.
    ///
    /// A value that is not finite poisons its channel's sums on purpose: [`Moments::statistics`] then refuses the
    /// window and names the channel.
    #[inline(always)]
    pub fn push(&mut self, x: [f32; N]) {
        self.push_unless(false, x);
    }

    /// As [`Moments::push`] unless `held`: then the slot goes by without a sample, with the same work. The first slot of
    /// a window must not be.
    #[inline(always)]
    pub(crate) fn push_unless(&mut self, held: bool, x: [f32; N]) {
        if self.slots == 0 {
            self.shift = x;
        }
        let deviation = difference(x, self.shift).map(|d| if held { 0.0 } else { d });
        for (i, (sum, d_i)) in self.block.first.iter_mut().zip(deviation).enumerate() {
            *sum += d_i;
            if let Some(row) = self.block.second.get_mut(i) {
                for (product, d_j) in row.iter_mut().zip(deviation).take(i + 1) {
                    *product += d_i * d_j;
                }
            }
        }
        self.taken += u32::from(!held);
        self.slots += 1;
        if self.slots.is_multiple_of(BLOCK) {
            self.merge_block();
        }
    }

    /// Samples taken so far.
    #[inline]
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.taken
    }

    /// Slots that have gone by, with and without a sample.
    #[inline(always)]
    pub(crate) const fn slots(&self) -> u32 {
        self.slots
    }

    #[cold]
    #[inline(never)]
    fn merge_block(&mut self) {
        if self.slots == BLOCK {
            self.recentre_block();
        }
        self.total.add(&self.block);
        self.block = Sums::ZERO;
    }

    /// Moves the shift from the first sample, which may be an outlier, to the mean of the first block.
    fn recentre_block(&mut self) {
        let n = self.taken as f32;
        let before = self.shift;
        for (shift, sum) in self.shift.iter_mut().zip(self.block.first) {
            *shift += sum / n;
        }
        // What the shift moved by after rounding, so that the sums stay exact relative to it.
        let moved = difference(self.shift, before);
        let first = self.block.first;
        for ((row, m_i), s_i) in self.block.second.iter_mut().zip(moved).zip(first) {
            for ((product, m_j), s_j) in row.iter_mut().zip(moved).zip(first) {
                *product += n * m_i * m_j - m_i * s_j - s_i * m_j;
            }
        }
        for (sum, m) in self.block.first.iter_mut().zip(moved) {
            *sum -= n * m;
        }
    }

    /// Mean and covariance of the window so far.
    ///
    /// # Errors
    /// [`LearnError`] when the window is too short, a channel is constant, or a sample was not finite.
    pub fn statistics(&self) -> Result<Statistics<N>, LearnError> {
        let samples = self.samples();
        if samples < Self::MIN_SAMPLES {
            return Err(LearnError::TooShort { samples });
        }
        let mut sums = self.total;
        sums.add(&self.block);
        let n = samples as f32;
        let mean: [f32; N] = {
            let mut mean = self.shift;
            for (m, sum) in mean.iter_mut().zip(sums.first) {
                *m += sum / n;
            }
            mean
        };
        let mut covariance = SMatrix::<f32, N, N>::zeros();
        for (i, (row, s_i)) in sums.second.iter().zip(sums.first).enumerate() {
            for (j, (product, s_j)) in row.iter().zip(sums.first).take(i + 1).enumerate() {
                // The paper prints cov(X) as X'X; the covariance of a sample divides by n - 1.
                let value = (product - s_i * s_j / n) / (n - 1.0);
                for place in [(i, j), (j, i)] {
                    if let Some(cell) = covariance.get_mut(place) {
                        *cell = value;
                    }
                }
            }
        }
        let diagonal = covariance.diagonal();
        let of_channels = || diagonal.iter().zip(mean).enumerate().map(|(i, (v, m))| (Channel::at(i), v, m));
        for (channel, variance, m) in of_channels() {
            if !(variance.is_finite() && m.is_finite()) {
                return Err(LearnError::NonFinite(channel));
            }
        }
        for (channel, variance, m) in of_channels() {
            let rounding = f32::EPSILON * m;
            if !(*variance > rounding * rounding) {
                return Err(LearnError::ConstantChannel(channel));
            }
        }
        Ok(Statistics { samples, mean: SVector::from(mean), covariance })
    }
}

impl<const N: usize> Statistics<N> {
    /// Standard deviation of each channel.
    #[must_use]
    pub fn sigma(&self) -> SVector<f32, N> {
        self.covariance.diagonal().map(libm::sqrtf)
    }

    /// The correlation matrix: the covariance of the standardized channels (1.7). Its diagonal is exactly one.
    #[must_use]
    pub fn correlation(&self) -> SMatrix<f32, N, N> {
        let sigma = self.sigma();
        let mut correlation = self.covariance;
        for ((i, mut column), s_j) in correlation.column_iter_mut().enumerate().zip(sigma.iter()) {
            for ((j, cell), s_i) in column.iter_mut().enumerate().zip(sigma.iter()) {
                // Dividing one after the other cannot underflow where the product of two small sigmas would.
                *cell = if i == j { 1.0 } else { (*cell / s_i / s_j).clamp(-1.0, 1.0) };
            }
        }
        correlation
    }
}

#[inline(always)]
fn difference<const N: usize>(mut a: [f32; N], b: [f32; N]) -> [f32; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= b;
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Textbook two-pass moments in `f64`.
    fn two_pass<const N: usize>(data: &[[f32; N]]) -> ([f64; N], [[f64; N]; N]) {
        let n = data.len() as f64;
        let mean: [f64; N] = core::array::from_fn(|i| data.iter().map(|x| f64::from(x[i])).sum::<f64>() / n);
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                data.iter().map(|x| (f64::from(x[i]) - mean[i]) * (f64::from(x[j]) - mean[j])).sum::<f64>() / (n - 1.0)
            })
        });
        (mean, covariance)
    }

    fn learned<const N: usize>(data: &[[f32; N]]) -> Result<Statistics<N>, LearnError> {
        let mut moments = Moments::<N>::default();
        data.iter().for_each(|x| moments.push(*x));
        moments.statistics()
    }

    /// A reproducible, correlated window around (300, 2, 10), the default motor's operating point.
    fn window(n: usize) -> Vec<[f32; 3]> {
        let mut seed = 1_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        (0..n)
            .map(|_| {
                let (a, b, c) = (uniform(), uniform(), uniform());
                [300.0 + 0.2 * a, 2.0 + 0.02 * (a + b), 10.0 + 0.02 * (c - b)]
            })
            .collect()
    }

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn moments_agree_with_a_two_pass_f64_reference_at_every_window_length() {
        for n in [30, 63, 64, 65, 128, 1000, 100_000] {
            let data = window(n);
            let (mean, covariance) = two_pass(&data);
            let found = learned(&data).unwrap();
            let sigma = [0, 1, 2].map(|i| covariance[i][i].sqrt());
            for i in 0..3 {
                assert!((f64::from(found.mean[i]) - mean[i]).abs() < 2e-7 * mean[i].abs() + 1e-4 * sigma[i]);
            }
            for (i, j) in [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
                let error = f64::from(found.covariance[(i, j)]) - covariance[i][j];
                assert!(error.abs() < 1e-4 * sigma[i] * sigma[j], "n {n}, entry {i} {j}: {error:e}");
            }
        }
    }

    #[test]
    fn an_outlier_as_first_sample_does_not_cost_digits_of_a_long_window() {
        let mut data = window(6400);
        data[0] = [310.0, 2.0, 10.0];
        let (_, covariance) = two_pass(&data);
        let found = learned(&data).unwrap();
        assert!((f64::from(found.covariance[(0, 0)]) / covariance[0][0] - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_window_that_cannot_be_learned_is_refused_and_the_channel_is_named() {
        assert_eq!(learned(&window(29)), Err(LearnError::TooShort { samples: 29 }));
        let mut constant = window(100);
        constant.iter_mut().for_each(|x| x[1] = 2.0);
        assert_eq!(learned(&constant), Err(LearnError::ConstantChannel(Channel::ArmatureCurrent)));
        for bad in [f32::NAN, f32::INFINITY, 1e38] {
            let mut data = window(100);
            data[70][2] = bad;
            assert_eq!(learned(&data), Err(LearnError::NonFinite(Channel::ArmatureVoltage)));
        }
    }

    #[test]
    fn a_channel_that_stands_at_zero_or_moves_by_rounding_alone_is_constant() {
        let mut zero = window(100);
        zero.iter_mut().for_each(|x| x[2] = 0.0);
        assert_eq!(learned(&zero), Err(LearnError::ConstantChannel(Channel::ArmatureVoltage)));
        // One sample in a hundred is off by one unit in the last place of 300.
        let mut rounded = window(100);
        rounded.iter_mut().enumerate().for_each(|(k, x)| x[0] = if k == 50 { 300.0_f32.next_up() } else { 300.0 });
        assert_eq!(learned(&rounded), Err(LearnError::ConstantChannel(Channel::Speed)));
    }

    #[test]
    fn correlations_are_covariances_in_units_of_both_sigmas() {
        let data = window(1000);
        let (_, covariance) = two_pass(&data);
        let found = learned(&data).unwrap().correlation();
        for (i, j) in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let exact = covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt();
            assert!((f64::from(found[(i, j)]) - exact).abs() < 1e-4, "{i} {j}: {} for {exact}", found[(i, j)]);
        }
        assert!(found[(1, 2)] < -0.4, "the window is correlated, or this would show nothing");
    }

    #[test]
    fn two_channels_learn_as_three_do() {
        let data: Vec<[f32; 2]> = window(500).iter().map(|x| [x[0], x[2]]).collect();
        let (_, covariance) = two_pass(&data);
        let found = learned(&data).unwrap();
        assert!((f64::from(found.covariance[(0, 1)]) - covariance[0][1]).abs() < 1e-7);
        assert_eq!(found.correlation()[(0, 0)], 1.0);
    }

    proptest! {
        #[test]
        fn shifting_and_scaling_the_data_shifts_and_scales_the_moments(
            shift in -1e3_f32..1e3, scale in 0.01_f32..100.0, n in 30_usize..300,
        ) {
            let data = window(n);
            let moved: Vec<[f32; 3]> = data.iter().map(|x| x.map(|v| (v - 2.0) * scale + shift)).collect();
            let (mean, covariance) = two_pass(&moved);
            let found = learned(&moved).unwrap();
            for i in 0..3 {
                let sigma = covariance[i][i].sqrt();
                prop_assert!((f64::from(found.mean[i]) - mean[i]).abs() <= 2e-7 * mean[i].abs() + 1e-4 * sigma);
                prop_assert!((f64::from(found.covariance[(i, i)]) / covariance[i][i] - 1.0).abs() < 1e-3);
            }
        }

        #[test]
        fn no_window_of_any_bits_makes_a_panic_or_a_statistic_that_is_not_finite(
            bits in prop::collection::vec(prop::array::uniform3(any::<u32>()), 0..200),
        ) {
            let data: Vec<[f32; 3]> = bits.iter().map(|b| b.map(f32::from_bits)).collect();
            if let Ok(found) = learned(&data) {
                prop_assert!(found.mean.iter().all(|m| m.is_finite()));
                prop_assert!(found.correlation().iter().all(|r| r.abs() <= 1.0));
            }
        }
    }
}
