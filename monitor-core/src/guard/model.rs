//! What healthy means in `guard` mode: a mean, and for each time scale the metric of the smoothed channels with its limit.

use super::design::Design;
use super::direction::Covariance;
use super::flag::{greater, lesser, positive_part};
use super::level::Level;
use super::window::{MIDDLE, Window};
use super::{SCALES, TREND, difference};
use crate::moments::{LearnError, Statistics};
use crate::pca::{ExplainedShare, Pca};
use crate::root::{reciprocal_sqrt, square_root};
use crate::sample::Channel;
use crate::triangle::{Packed, Triangle};

/// Smallest variance of a component of the standardized channels, of a total of three: a hundredth of a sigma. What moves
/// less is rounding of the converters and of the correlation, and a fault must not be called by it.
const EIGENVALUE_FLOOR: f32 = 1e-4;

/// Largest share of clipped samples: more, and what was clipped is not the exception.
const CLIPPED_TO: f32 = 0.1;

/// How far the mean may move from the first to the second half of a window: in sigmas of a channel, and in standard errors.
const DRIFT_SIGMAS: f32 = 0.25;
const DRIFT_STANDARD_ERRORS: f32 = 6.0;

/// From how many independent samples on a window shows the directions of the middle scale's noise; of fewer, its size only.
const SHAPED_FROM: f32 = 30.0;

/// Degrees of freedom of a variance along known directions, per independent sample: one for each channel.
const DEGREES_OF_SIZE: f32 = 3.0;

/// How many times the standard deviation of smoothed noise may be that of smoothed white noise.
const NOISE_MEMORY: f32 = 3.0;

/// One time scale of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// |U y|^2 is the distance (1.6) of smoothed deviations y, all components retained.
    pub(super) metric: Packed,
    /// The diagonal as learned: how far the metric may be sharpened is bounded by it.
    learned: [f32; 3],
    pub(super) level: Level,
}

/// How much wider or narrower noise may become than it was learned, as a factor of its standard deviation: what grows slowly
/// must not be taken for noise without end, and what is rare was not seen yet.
const WIDER_TO: f32 = 2.0;
const NARROWER_TO: f32 = 0.7;

impl Scale {
    const BLANK: Self =
        Scale { metric: Packed::of(&Triangle::from_upper([[0.0; 3]; 3])), learned: [0.0; 3], level: Level::BLANK };

    fn each_number(&mut self, f: &mut impl FnMut(&mut f32)) {
        self.metric.cells().iter_mut().chain(&mut self.learned).for_each(&mut *f);
        self.level.each_number(f);
    }

    /// Brings the metric a step nearer to where smoothed deviations are white ([`Triangle::whiten`]).
    #[inline(always)]
    pub(super) fn sharpen(&mut self, y: [f32; 3], gain: f32) {
        let mut metric = self.metric.unpacked();
        // However few samples the gain is of: no step is longer than the way (Cardoso and Laheld 1996, their normalized form).
        metric.whiten(y, gain / (1.0 + gain * metric.square_of(y)));
        let mut back = [1.0; 3];
        for (back, (now, learned)) in back.iter_mut().zip(metric.diagonal().into_iter().zip(self.learned)) {
            // Rows may point either way.
            let share = now / learned;
            *back = lesser(greater(positive_part(share), 1.0 / WIDER_TO), 1.0 / NARROWER_TO) / share;
        }
        metric.scale_rows(back);
        self.metric = Packed::of(&metric);
    }
}

/// A model of the healthy motor at one set point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    pub(super) mean: [f32; 3],
    pub(super) sigma: [f32; 3],
    pub(super) scales: [Scale; SCALES],
}

/// What there is to say of a learning window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Quality {
    /// Samples in the window.
    pub samples: u32,
    /// Share of the samples of which a reading was clipped.
    pub clipped_share: f32,
    /// Largest over smallest eigenvalue of the correlation matrix.
    pub condition: f32,
    /// Largest movement of a channel's mean from the first half to the second, in sigmas of the channel.
    pub drift_sigmas: f32,
    /// How much larger the slow scale's variance is than the middle scale's makes expect: one for noise without memory.
    pub slow_variance_ratio: f32,
}

impl Model {
    pub(super) const BLANK: Self = Model { mean: [0.0; 3], sigma: [0.0; 3], scales: [Scale::BLANK; SCALES] };

    pub(super) fn each_number(&mut self, f: &mut impl FnMut(&mut f32)) {
        self.mean.iter_mut().chain(&mut self.sigma).for_each(&mut *f);
        self.scales.iter_mut().for_each(|scale| scale.each_number(f));
    }

    /// Whether samples can be judged by it, its numbers being finite.
    pub(super) fn is_usable(&self) -> bool {
        let scales = self.scales.iter().flat_map(|scale| scale.learned);
        self.sigma.iter().all(|sigma| *sigma > 0.0) && scales.into_iter().all(|cell| cell.abs() > 0.0)
    }

    /// Learns from a window. The eigen-solver runs here: outside the sampling interrupt.
    ///
    /// # Errors
    /// [`LearnError`] when the window cannot be learned from.
    #[inline(never)]
    pub fn learn(window: &Window, design: &Design) -> Result<(Self, Quality), LearnError> {
        let [raw, fast, middle, slow] = window.moments;
        let (raw, fast, middle, slow) =
            (raw.statistics()?, fast.statistics()?, middle.statistics()?, slow.statistics()?);
        let clipped_share = window.clipped_share();
        if !(clipped_share <= CLIPPED_TO) {
            return Err(LearnError::Clipped);
        }
        let drift_sigmas = drift(window, design, &raw, &middle)?;
        let ratios @ [of_fast, of_middle, of_slow, of_trend] = design.variance_ratios();
        let n = window.slots as f32;
        let [fast_scale, middle_scale, ..] = &design.scales;
        let fast_floored = design.floored(&fast, of_fast, fast_scale.weight());
        let middle_floored = design.floored(&middle, of_middle, middle_scale.weight());
        let [fast_held, middle_held] = [(&fast_floored, &fast), (&middle_floored, &middle)].map(|(a, b)| a != b);
        let (fast, _) = metric(&fast_floored)?;
        let independent = n * of_middle;
        let is_few = independent < SHAPED_FROM;
        // So few independent samples of the middle scale do not show their directions: the fast scale has them, and many more.
        let (base, of_base, degrees) = if is_few {
            (fast, of_fast, f32::min(DEGREES_OF_SIZE * independent, n * of_fast))
        } else {
            (metric(&middle_floored)?.0, of_middle, independent)
        };
        // Of the slower scales there are fewer still: each has the metric of the scale before it.
        let unseen = [[0.0; 3]; 3];
        let size = if is_few { &middle_floored.covariance.data.0 } else { &unseen };
        let (middle, _) = averaged(base, of_base / of_middle, size);
        let (slow, excess) = averaged(middle, of_middle / of_slow, &slow.covariance.data.0);
        let (trend, _) = averaged(slow, of_slow / of_trend, &unseen);
        let slow_variance_ratio = excess.iter().sum::<f32>() / 3.0;
        let raw = design.floored(&raw, 1.0, 0.0);
        let (_, condition) = metric(&raw)?;
        let scale = |place: usize, metric: Triangle<3>, is_held: bool| {
            let per_slot = ratios.get(place).copied().unwrap_or(of_trend);
            // What the slower ones rest on is the middle scale's.
            let level = Level::new(design, place, n, degrees.max(n * per_slot), per_slot)?;
            // A converter's floor is not to be sharpened away.
            let sharpest = if is_held { NARROWER_TO } else { 1.0 };
            let learned = metric.diagonal().map(|cell| sharpest * cell);
            Ok::<_, LearnError>(Scale { metric: Packed::of(&metric), learned, level })
        };
        let mut mean = window.centre;
        for (m, d) in mean.iter_mut().zip(window.moments.get(MIDDLE).map(|m| m.mean()).unwrap_or_default()) {
            *m += d;
        }
        let scales = [
            scale(0, fast, fast_held)?,
            scale(1, middle, middle_held)?,
            scale(2, slow, middle_held)?,
            scale(TREND, trend, middle_held)?,
        ];
        let model = Model { mean, sigma: raw.sigma().into(), scales };
        let samples = window.slots;
        Ok((model, Quality { samples, clipped_share, condition, drift_sigmas, slow_variance_ratio }))
    }

    /// Whether the slow scale has the larger covariance, by its volume.
    pub(super) fn is_noisier_than(&self, other: &Self) -> bool {
        let [sharpness, others] = [self, other].map(|model| {
            let [_, _, slow, _] = &model.scales;
            slow.metric.unpacked().diagonal().into_iter().product::<f32>().abs()
        });
        sharpness < others
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
}

/// The metric of channels with these statistics, and the condition number of their correlation.
fn metric(statistics: &Statistics<3>) -> Result<(Triangle<3>, f32), LearnError> {
    let all = ExplainedShare::new(1.0)?;
    let pca = Pca::of_correlation(&statistics.correlation(), all)?;
    let sigma: [f32; 3] = statistics.sigma().into();
    let (mut rows, variances) = (pca.loadings().data.0, pca.eigenvalues());
    for (row, variance) in rows.iter_mut().zip(variances.iter()) {
        let weight = reciprocal_sqrt(variance.max(EIGENVALUE_FLOOR));
        for (cell, s) in row.iter_mut().zip(sigma) {
            *cell *= weight / s;
        }
    }
    let condition = variances.max() / variances.min().max(f32::EPSILON);
    Ok((Triangle::of_rows(rows), condition))
}

/// The metric of the same channels after more averaging, by which white noise has a variance so many times `less`; and the
/// mean squares of what was `seen` of them so averaged. Where they exceed one, noise has a memory, and it counts.
#[inline(never)] // once in flash
fn averaged(mut metric: Triangle<3>, less: f32, seen: &Covariance) -> (Triangle<3>, [f32; 3]) {
    metric.scale_rows([square_root(less); 3]);
    let squares = metric.mean_squares_of(seen);
    metric.scale_rows(squares.map(|square| reciprocal_sqrt(square.max(1.0))));
    (metric, squares)
}

/// How far the mean moved from the first half of the window to the second, in sigmas of the channel that moved most.
fn drift(window: &Window, design: &Design, raw: &Statistics<3>, middle: &Statistics<3>) -> Result<f32, LearnError> {
    let whole: [f32; 3] = middle.mean.into();
    let [_, of_middle, ..] = design.variance_ratios();
    let (sigma, smoothed): ([f32; 3], [f32; 3]) = (raw.sigma().into(), middle.sigma().into());
    // Of the difference of two halves, each with half the window's independent samples.
    let per_sigma = 2.0 * reciprocal_sqrt((window.slots as f32 * of_middle).max(1.0));
    let mut largest = 0.0;
    let white = square_root(of_middle);
    for (position, ((moved, s), smoothed)) in
        difference(whole, window.first_half).into_iter().zip(sigma).zip(smoothed).enumerate()
    {
        let moved = 2.0 * moved.abs(); // the second half lies as far on the other side
        // A step inflates what is smoothed more than any noise does.
        let smoothed = smoothed.min(NOISE_MEMORY * white * s);
        if moved > DRIFT_SIGMAS * s && moved > DRIFT_STANDARD_ERRORS * per_sigma * smoothed {
            return Err(LearnError::Drifting(Channel::at(position)));
        }
        largest = f32::max(largest, moved / s);
    }
    Ok(largest)
}

impl Triangle<3> {
    /// The mean of (U y)^2, place by place, for y with this covariance.
    pub(super) fn mean_squares_of(&self, covariance: &Covariance) -> [f32; 3] {
        self.rows().map(|row| crate::triangle::inner(row, covariance.map(|column| crate::triangle::inner(row, column))))
    }

    /// The covariance (U'U)^-1 = U^-1 (U^-1)' that this is the metric of.
    pub(super) fn covariance(&self) -> Covariance {
        let [[a, b, c], [_, d, e], [_, _, f]] = self.rows();
        // Rows of U^-1, which is an upper triangle as well.
        let (x, y, z) = (1.0 / a, 1.0 / d, 1.0 / f);
        let inverse = [[x, -b * x * y, (b * e * y - c) * x * z], [0.0, y, -e * y * z], [0.0, 0.0, z]];
        inverse.map(|row| inverse.map(|other| crate::triangle::inner(row, other)))
    }
}
