//! Phase I: mean, standard deviation and covariance of the learning window, in one pass and constant memory.
//!
//! Sums of deviations from a shift near the mean, gathered in blocks. A plain sum of squares in `f32` loses every
//! digit of the variance once mean/sigma passes a few thousand (a speed of 300 rad/s with 0.1 rad/s of noise is there
//! already), and Welford's update on raw samples drifts over long windows. Here
//! - the shift is given (the first sample, or a guess of the mean), so deviations stay of the size of sigma;
//! - 64 samples are summed by themselves before they join the total, so the rounding error of a long window grows with
//!   the number of blocks and not with the number of samples (Chan, Golub, LeVeque 1983, shifted and pairwise). Each sum
//!   joins in a slot of its own: no slot is slow;
//! - no division per sample.
//!
//! Windows can be merged, and can forget: every way to weight samples shares these sums. To keep spikes out, clip a sample
//! before it is pushed ([`Clip`]).

use nalgebra::{SMatrix, SVector};

use crate::pca::PcaError;
use crate::root::square_root;
use crate::sample::Channel;

/// Slots in a block: more than there are sums, and few enough that 64 squares keep 18 of 24 bits each.
const BLOCK: u32 = 64;

/// Fewest samples per channel that a covariance may rest on: below about ten, the sampling error of a correlation
/// (1/sqrt(n)) is of the size of the correlations themselves.
const MIN_SAMPLES_PER_CHANNEL: u32 = 10;

/// Below it a variance has no root of full precision.
const SMALLEST_VARIANCE: f32 = 4.0 * f32::MIN_POSITIVE;

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
    /// Too many samples had to be clipped: what was clipped is not the exception.
    Clipped,
    /// This channel's mean moved from the first half of the window to the second: the motor had not settled, or something
    /// is going on.
    Drifting(Channel),
    /// This channel's mean is not what those of the set point's neighbours make expect: something may be wrong.
    Unexpected(Channel),
    /// The window has no PCA.
    Pca(PcaError),
}

impl From<PcaError> for LearnError {
    fn from(error: PcaError) -> Self {
        LearnError::Pca(error)
    }
}

/// A sum of a window: of the block that is being gathered, and of the blocks before it. Side by side, so that one index
/// finds both.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sum {
    block: f32,
    total: f32,
}

impl Sum {
    const ZERO: Self = Sum { block: 0.0, total: 0.0 };

    #[inline(always)]
    fn join(&mut self) {
        self.total += self.block;
        self.block = 0.0;
    }

    const fn value(self) -> f32 {
        self.total + self.block
    }
}

/// Sums of deviations from a shift and of their products; of the products, the lower triangle is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums<const N: usize> {
    first: [Sum; N],
    second: [[Sum; N]; N],
}

impl<const N: usize> Sums<N> {
    const ZERO: Self = Sums { first: [Sum::ZERO; N], second: [[Sum::ZERO; N]; N] };

    fn for_each(&mut self, change: impl FnMut(&mut Sum)) {
        self.first.iter_mut().chain(self.second.as_flattened_mut()).for_each(change);
    }

    fn add(&mut self, other: &Self) {
        let others = other.first.iter().chain(other.second.as_flattened());
        for (sum, other) in self.first.iter_mut().chain(self.second.as_flattened_mut()).zip(others) {
            sum.total += other.value();
        }
    }

    /// The same sums, of `n` samples, for a shift that has `moved`. Blocks must have joined.
    fn recentre(&mut self, n: f32, moved: [f32; N]) {
        let first = self.first;
        for (i, ((row, m_i), s_i)) in self.second.iter_mut().zip(moved).zip(first).enumerate() {
            for ((product, m_j), s_j) in row.iter_mut().zip(moved).zip(first).take(i + 1) {
                product.total += n * m_i * m_j - m_i * s_j.total - s_i.total * m_j;
            }
        }
        for (sum, m) in self.first.iter_mut().zip(moved) {
            sum.total -= n * m;
        }
    }
}

/// Online moments of `N` channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments<const N: usize> {
    shift: [f32; N],
    sums: Sums<N>,
    /// Slots since the window began or last forgot, those without a sample included; sums join the total by slots.
    slots: u32,
    /// How many of them had no sample.
    held: u32,
    /// What is left of the weight of samples before that.
    remembered: f32,
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

impl<const N: usize> Moments<N> {
    /// Fewest samples of a window that can be learned from.
    pub const MIN_SAMPLES: u32 = MIN_SAMPLES_PER_CHANNEL * N as u32;

    /// A window whose mean is expected at `shift`: its first sample will do. Being a hundred sigmas off costs four of seven
    /// digits, no more.
    #[must_use]
    pub const fn around(shift: [f32; N]) -> Self {
        Moments { shift, sums: Sums::ZERO, slots: 0, held: 0, remembered: 0.0 }
    }

    /// Where deviations are taken from.
    pub(crate) const fn shift(&self) -> [f32; N] {
        self.shift
    }

    /// Takes one sample.
    ///
    /// A value that is not finite poisons its channel's sums on purpose: [`Moments::statistics`] then refuses the
    /// window and names the channel.
    #[inline(always)]
    pub fn push(&mut self, x: [f32; N]) {
        self.push_unless(false, x);
    }

    /// As [`Moments::push`] unless `held`: then the slot goes by without a sample, with the same work.
    #[inline(always)]
    pub(crate) fn push_unless(&mut self, held: bool, x: [f32; N]) {
        let deviation = difference(x, self.shift).map(|d| if held { 0.0 } else { d });
        for (i, (sum, d_i)) in self.sums.first.iter_mut().zip(deviation).enumerate() {
            sum.block += d_i;
            if let Some(row) = self.sums.second.get_mut(i) {
                for (product, d_j) in row.iter_mut().zip(deviation).take(i + 1) {
                    product.block += d_i * d_j;
                }
            }
        }
        self.held += u32::from(held);
        let slots = self.slots;
        self.join((slots % BLOCK) as usize);
        self.slots = slots.wrapping_add(1);
    }

    /// Lets the sum join the total whose turn it is: products by rows, then first powers, then none.
    #[inline(always)]
    fn join(&mut self, turn: usize) {
        if let Some(product) = self.sums.second.as_flattened_mut().get_mut(turn) {
            product.join();
        } else if let Some(sum) = self.sums.first.get_mut(turn.wrapping_sub(N * N)) {
            sum.join();
        }
    }

    /// Samples taken so far; those of a window that forgets count by what is left of their weight.
    #[inline]
    #[must_use]
    pub const fn samples(&self) -> u32 {
        (self.remembered as u32).saturating_add(self.taken())
    }

    /// Slots that have gone by since the window began or last forgot, with and without a sample.
    #[inline(always)]
    pub(crate) const fn slots(&self) -> u32 {
        self.slots
    }

    const fn taken(&self) -> u32 {
        self.slots.wrapping_sub(self.held)
    }

    fn weight(&self) -> f32 {
        self.remembered + self.taken() as f32
    }

    /// Adds another window, as if its samples had been pushed here (Chan, Golub, LeVeque 1983, eq. 2.1).
    pub fn merge(&mut self, other: &Self) {
        if !(self.weight() > 0.0) {
            *self = *other;
            return;
        }
        let mut other = *other;
        other.sums.for_each(Sum::join);
        // From its shift to ours.
        other.sums.recentre(other.weight(), difference(self.shift, other.shift));
        self.sums.add(&other.sums);
        self.remembered += other.remembered;
        if let Some(slots) = self.slots.checked_add(other.slots) {
            (self.slots, self.held) = (slots, self.held.saturating_add(other.held));
        } else {
            // More than can be counted one by one.
            self.remembered += self.taken() as f32 + other.taken() as f32;
            (self.slots, self.held) = (0, 0);
        }
    }

    /// Lets everything so far weigh `keep` times what it did. Called once every k samples, this is exponential forgetting
    /// with a time constant of k/(1 - keep) samples; the mean may then drift, and the shift follows it.
    ///
    /// `keep` is at most 1; with 0, less, or NaN the window begins again around the same shift. Under forgetting the
    /// covariance divides by the sum of weights less one, which is unbiased to within one part in that sum.
    pub fn forget(&mut self, keep: f32) {
        let weight = self.weight();
        if !(keep > 0.0 && weight > 0.0) {
            *self = Self::around(self.shift);
            return;
        }
        self.sums.for_each(Sum::join);
        let before = self.shift;
        for (shift, sum) in self.shift.iter_mut().zip(self.sums.first) {
            *shift += sum.total / weight;
        }
        // By what the shift has moved after rounding, so that the sums stay exact relative to it.
        self.sums.recentre(weight, difference(self.shift, before));
        let keep = keep.min(1.0);
        self.sums.for_each(|sum| sum.total *= keep);
        self.remembered = weight * keep;
        (self.slots, self.held) = (0, 0);
    }

    /// Mean of the window so far; of an empty one, where it is expected.
    pub(crate) fn mean(&self) -> [f32; N] {
        let mut mean = self.shift;
        for (m, sum) in mean.iter_mut().zip(self.sums.first) {
            *m += sum.value() / self.weight().max(1.0);
        }
        mean
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
        let first = self.sums.first.map(Sum::value);
        let n = self.weight();
        let mean = self.mean();
        let (per_n, per_n_less_one) = (1.0 / n, 1.0 / (n - 1.0));
        let mut lower = self.sums.second.map(|row| row.map(Sum::value));
        for (row, s_i) in lower.iter_mut().zip(first) {
            for (product, s_j) in row.iter_mut().zip(first) {
                // The paper prints cov(X) as X'X; the covariance of a sample divides by n - 1.
                *product = (*product - s_i * s_j * per_n) * per_n_less_one;
            }
        }
        // Its rows are columns to the matrix, so the lower triangle comes to lie above the diagonal.
        let mut covariance = SMatrix::<f32, N, N>::from(lower);
        covariance.fill_lower_triangle_with_upper_triangle();
        let diagonal = covariance.diagonal();
        let of_channels = || diagonal.iter().zip(mean).enumerate().map(|(i, (v, m))| (Channel::at(i), v, m));
        for (channel, variance, m) in of_channels() {
            if !(variance.is_finite() && m.is_finite()) {
                return Err(LearnError::NonFinite(channel));
            }
        }
        for (channel, variance, m) in of_channels() {
            let rounding = f32::EPSILON * m;
            if !(*variance > rounding * rounding && *variance > SMALLEST_VARIANCE) {
                return Err(LearnError::ConstantChannel(channel));
            }
        }
        Ok(Statistics { samples, mean: SVector::from(mean), covariance })
    }
}

/// The window of these samples, around the first of them.
impl<const N: usize> FromIterator<[f32; N]> for Moments<N> {
    fn from_iter<I: IntoIterator<Item = [f32; N]>>(samples: I) -> Self {
        let mut samples = samples.into_iter().peekable();
        let mut moments = Moments::around(samples.peek().copied().unwrap_or([0.0; N]));
        samples.for_each(|x| moments.push(x));
        moments
    }
}

impl<const N: usize> Statistics<N> {
    /// Standard deviation of each channel.
    #[must_use]
    pub fn sigma(&self) -> SVector<f32, N> {
        self.covariance.diagonal().map(square_root)
    }

    /// The correlation matrix: the covariance of the standardized channels (1.7). Its diagonal is exactly one.
    #[must_use]
    pub fn correlation(&self) -> SMatrix<f32, N, N> {
        // Arrays: nalgebra's iterators over a matrix of three take ten times the code.
        let (mut columns, sigma): (_, [f32; N]) = (self.covariance.data.0, self.sigma().into());
        for (j, (column, s_j)) in columns.iter_mut().zip(sigma).enumerate() {
            for (i, (cell, s_i)) in column.iter_mut().zip(sigma).enumerate() {
                // Dividing one after the other cannot underflow where the product of two small sigmas would; always in
                // the same order, so that the matrix is symmetric.
                let (first, second) = if i > j { (s_i, s_j) } else { (s_j, s_i) };
                *cell = if i == j { 1.0 } else { (*cell / first / second).clamp(-1.0, 1.0) };
            }
        }
        SMatrix::from(columns)
    }
}

#[inline(always)]
fn difference<const N: usize>(mut a: [f32; N], b: [f32; N]) -> [f32; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= b;
    }
    a
}

/// Keeps spikes from what is learned: moves a reading that lies further from a centre than its reach back to the reach
/// (Huber's psi function).
///
/// At a reach of 3 sigma the variance of normal noise comes out 0.5 % too small; at 2 sigma, 8 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip<const N: usize> {
    centre: [f32; N],
    reach: [f32; N],
}

impl<const N: usize> Clip<N> {
    /// Clips at `sigmas` standard deviations from the mean of a seeding window.
    #[must_use]
    pub fn at(seed: &Statistics<N>, sigmas: f32) -> Self {
        Clip { centre: seed.mean.into(), reach: (seed.sigma() * sigmas).into() }
    }

    /// The sample with each reading within its reach, and whether one had to be moved. NaN stays NaN.
    #[inline]
    #[must_use]
    pub fn apply(&self, mut x: [f32; N]) -> ([f32; N], bool) {
        let mut clipped = false;
        for ((x, centre), reach) in x.iter_mut().zip(self.centre).zip(self.reach) {
            let (low, high) = (centre - reach, centre + reach);
            clipped |= *x < low || *x > high;
            *x = if *x < low { low } else { *x };
            *x = if *x > high { high } else { *x };
        }
        (x, clipped)
    }
}

#[cfg(test)]
mod tests;
