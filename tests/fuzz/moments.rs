//! The moments: whatever is pushed, merged, forgotten or clipped, a window's statistics are numbers or refused.

use bolero::{TypeGenerator, check};
use monitor_core::moments::{Clip, LearnError, Moments, Statistics};

use super::TEST_TIME;
use super::number::Number;

/// What is done to one of two windows.
#[derive(Clone, Debug, TypeGenerator)]
enum Op {
    Push([Number; 3]),
    /// As many samples as a window needs to be learned from, around a centre.
    Gather {
        centre: [Number; 3],
        spread: Number,
        seed: u32,
        #[generator(1..150_u8)]
        samples: u8,
    },
    /// The other window joins.
    Merge,
    /// A copy of itself joins.
    Double,
    Forget(Number),
    /// By the same share as boards do.
    Fade(u8),
    /// From here on samples are clipped at so many sigmas.
    Clip(Number),
    Restart([Number; 3]),
}

/// A window, and the weight of its samples as reckoned beside it.
#[derive(Clone, Copy)]
struct Window {
    moments: Moments<3>,
    weight: f64,
    clip: Option<Clip<3>>,
}

/// A window that holds more stays at the end of its counts: it is no longer what its samples say.
const MOST_SAMPLES: f64 = (1_u64 << 31) as f64;

#[test]
fn statistics_of_any_samples_are_numbers_or_refused() {
    check!().with_test_time(TEST_TIME).with_type::<Vec<(bool, Op)>>().for_each(|ops| {
        let mut windows = [Window::around([0.0; 3]); 2];
        for (second, op) in ops {
            let [first, other] = &mut windows;
            let (window, other) = if *second { (other, &*first) } else { (first, &*other) };
            window.apply(op, other);
            window.judge();
        }
    });
}

impl Window {
    fn around(shift: [f32; 3]) -> Self {
        Window { moments: Moments::around(shift), weight: 0.0, clip: None }
    }

    fn apply(&mut self, op: &Op, other: &Window) {
        match op {
            Op::Push(x) => self.push(x.map(Number::value)),
            Op::Gather { centre, spread, seed, samples } => {
                let mut noise = Noise(*seed);
                for _ in 0..*samples {
                    self.push(centre.map(|c| c.value() + spread.value() * noise.draw()));
                }
            }
            Op::Merge => self.merge(*other),
            Op::Double => self.merge(*self),
            Op::Forget(keep) => self.forget(keep.value()),
            Op::Fade(share) => self.forget(f32::from(*share) / 255.0),
            Op::Clip(sigmas) => {
                let seed = self.moments.statistics().ok();
                self.clip = seed.map(|seed| Clip::at(&seed, sigmas.value()));
            }
            Op::Restart(shift) => *self = Window::around(shift.map(Number::value)),
        }
    }

    fn push(&mut self, x: [f32; 3]) {
        let x = self.clip.map_or(x, |clip| clip.apply(x).0);
        self.moments.push(x);
        self.weight += 1.0;
    }

    fn merge(&mut self, other: Window) {
        if self.weight + other.weight < MOST_SAMPLES {
            self.moments.merge(&other.moments);
            self.weight += other.weight;
        }
    }

    fn forget(&mut self, keep: f32) {
        self.moments.forget(keep);
        self.weight = if keep > 0.0 { self.weight * f64::from(keep.min(1.0)) } else { 0.0 };
    }

    fn judge(&self) {
        let (found, weight) = (self.moments.samples(), self.weight);
        // Half a sample is not counted; weights are `f32`.
        assert!((f64::from(found) - weight).abs() <= 1.0 + 1e-5 * weight, "{found} samples of {weight}");
        match self.moments.statistics() {
            Ok(statistics) => judge_statistics(&statistics),
            Err(LearnError::TooShort { samples }) => assert!(samples < Moments::<3>::MIN_SAMPLES && samples == found),
            Err(error) => assert!(found >= Moments::<3>::MIN_SAMPLES, "{error:?} with {found} samples"),
        }
    }
}

fn judge_statistics(statistics: &Statistics<3>) {
    let Statistics { samples, mean, covariance } = statistics;
    assert!(*samples >= Moments::<3>::MIN_SAMPLES);
    assert!(mean.iter().chain(covariance).all(|x| x.is_finite()), "{statistics:?}");
    assert!(*covariance == covariance.transpose(), "{covariance} is not symmetric");
    for (sigma, variance) in statistics.sigma().iter().zip(covariance.diagonal().iter()) {
        let error = f64::from(*sigma).powi(2) / f64::from(*variance) - 1.0;
        assert!(*sigma > 0.0 && error.abs() < 1e-6, "sigma is {sigma:e}, variance {variance:e}");
    }
    let correlation = statistics.correlation();
    assert!(correlation.diagonal().iter().all(|x| *x == 1.0), "{correlation}");
    assert!(correlation.iter().all(|rho| rho.abs() <= 1.0), "{correlation}");
}

/// Reproducible noise between -1/2 and 1/2.
pub(super) struct Noise(pub(super) u32);

impl Noise {
    pub(super) fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223); // Numerical Recipes
        (self.0 >> 8) as f32 / (1 << 24) as f32 - 0.5
    }
}

/// Samples about a mean, of a size that sensors give.
#[derive(Clone, Debug, TypeGenerator)]
struct Halves {
    #[generator(-1000..1000_i16)]
    mean: i16,
    #[generator(-6..7_i8)]
    size: i8,
    first: Vec<[i16; 3]>,
    second: Vec<[i16; 3]>,
}

#[test]
fn two_halves_merge_into_the_whole() {
    check!().with_test_time(TEST_TIME).with_type::<Halves>().for_each(|halves| {
        let sample = |counts: &[i16; 3]| {
            counts.map(|count| f32::from(halves.mean) + f32::from(count) / 32_768.0 * f32::from(halves.size).exp2())
        };
        let (first, second): (Vec<_>, Vec<_>) =
            (halves.first.iter().map(sample).collect(), halves.second.iter().map(sample).collect());
        let all = [first.clone(), second.clone()].concat();
        let mut merged = window(&first);
        merged.merge(&window(&second));
        let whole = window(&all);
        assert_eq!((merged.samples(), whole.samples()), (all.len() as u32, all.len() as u32));
        // A channel that hardly moves may be constant to one and not to the other.
        if all.len() >= Moments::<3>::MIN_SAMPLES as usize && (0..3).all(|i| moves(&all, i)) {
            judge_against(&all, &whole.statistics().unwrap());
            judge_against(&all, &merged.statistics().unwrap());
        }
    });
}

fn window(samples: &[[f32; 3]]) -> Moments<3> {
    samples.iter().copied().collect()
}

/// Mean of a channel, and covariance of two, in two passes.
fn mean(data: &[[f32; 3]], i: usize) -> f64 {
    data.iter().map(|x| f64::from(x[i])).sum::<f64>() / data.len() as f64
}

fn covariance(data: &[[f32; 3]], i: usize, j: usize) -> f64 {
    let (m_i, m_j) = (mean(data, i), mean(data, j));
    data.iter().map(|x| (f64::from(x[i]) - m_i) * (f64::from(x[j]) - m_j)).sum::<f64>() / (data.len() - 1) as f64
}

fn moves(data: &[[f32; 3]], i: usize) -> bool {
    let rounding = f64::from(f32::EPSILON) * mean(data, i);
    covariance(data, i, i) > 16.0 * rounding * rounding && covariance(data, i, i) > 0.0
}

fn judge_against(data: &[[f32; 3]], found: &Statistics<3>) {
    let sigma = [0, 1, 2].map(|i| covariance(data, i, i).sqrt());
    for i in 0..3 {
        let error = f64::from(found.mean[i]) - mean(data, i);
        assert!(error.abs() <= 2e-7 * mean(data, i).abs() + 1e-4 * sigma[i], "mean {i} is off by {error:e}");
        for j in 0..3 {
            let error = (f64::from(found.covariance[(i, j)]) - covariance(data, i, j)) / (sigma[i] * sigma[j]);
            assert!(error.abs() <= 1e-4, "covariance {i} {j} is off by {error:e} of the sigmas");
        }
    }
}
