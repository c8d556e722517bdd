//! The limit of a T2 that is formed behind exponential smoothers.

use super::LimitError;
use crate::ewma::Ewma;
use crate::quantile::{upper_chi_square, upper_f};

/// How far beyond a level a process that is looked at in steps is when it is first seen beyond it, in standard deviations of
/// a step: -zeta(1/2)/sqrt(2 pi) (Siegmund 1985, ch. X).
const OVERSHOOT: f32 = 0.582_6;

/// Largest tail probability whose quantile is known, and smallest.
const TAIL: core::ops::RangeInclusive<f32> = 1e-12..=0.05;

/// The limit that |U y|^2 exceeds once per `interval_samples` on average while the process is in control, where y are
/// `channels` smoothed channels (one to three) and U'U is the inverse of their covariance, learned with `degrees_of_freedom`.
///
/// - Whitened, y is a vector of independent Ornstein-Uhlenbeck processes with a relaxation time of T = -1/ln(1 - a)
///   samples, seen in steps, and its length r wanders about the mode of a chi distribution of p channels with density f.
///   It leaves through a far level R at the rate of Kramers' flux, (1/T) f(R) (R - (p-1)/R).
/// - Seen in steps of sqrt(2a) standard deviations, it crosses a level only when it is 0.58 steps beyond it (Siegmund).
/// - It cannot cross more often than it is beyond: for quick smoothers the tail probability is the smaller rate, and with
///   a = 1 the exact one.
/// - A covariance from few samples makes of the chi-square p nu/(nu-p+1) F(p, nu-p+1): the limit is this at the tail
///   probability found so (Hotelling 1931).
///
/// # Errors
/// [`LimitError::Retained`] unless there are one to three channels, [`LimitError::Samples`] below 12 degrees of freedom,
/// [`LimitError::FalseAlarmInterval`] when the interval is out of the range that quantiles are known for: from a few hundred
/// samples to some 1e11.
pub fn smoothed_t2_limit(
    smoother: &Ewma,
    channels: u8,
    degrees_of_freedom: f32,
    interval_samples: f32,
) -> Result<f32, LimitError> {
    if !(1..=3).contains(&channels) {
        return Err(LimitError::Retained);
    }
    let p = f32::from(channels);
    let rest = degrees_of_freedom - p + 1.0;
    if !(rest >= 10.0) {
        return Err(LimitError::Samples);
    }
    let tail = tail_probability(smoother, p, interval_samples).ok_or(LimitError::FalseAlarmInterval)?;
    Ok(p * degrees_of_freedom / rest * upper_f(tail, p, rest.min(1e6))?)
}

/// The probability of a level that is crossed once per interval.
fn tail_probability(smoother: &Ewma, channels: f32, interval_samples: f32) -> Option<f32> {
    let goal = -libm::logf(interval_samples);
    let mut log_tail = goal;
    // The rate is nearly proportional to the tail probability.
    for _ in 0..6 {
        let tail = libm::expf(log_tail);
        let level = libm::sqrtf(upper_chi_square(tail, channels).ok()?);
        log_tail += goal - log_crossing_rate(smoother, channels, level).min(log_tail);
    }
    Some(libm::expf(log_tail)).filter(|tail| TAIL.contains(tail))
}

/// ln of how often per sample the length of the whitened, smoothed channels leaves through a level.
fn log_crossing_rate(smoother: &Ewma, channels: f32, level: f32) -> f32 {
    let a = smoother.weight();
    if a >= 1.0 {
        return 0.0;
    }
    let level = level + OVERSHOOT * libm::sqrtf(2.0 * a);
    let log_density = log_norm(channels) + (channels - 1.0) * libm::logf(level) - 0.5 * level * level;
    log_density + libm::logf(level - (channels - 1.0) / level) + libm::logf(-libm::log1pf(-a))
}

/// ln of 2^(1-p/2)/Gamma(p/2), the norm of a chi density of one to three degrees of freedom.
fn log_norm(channels: f32) -> f32 {
    const LN_SQRT_2_OVER_PI: f32 = -0.225_791_35;
    // That of two degrees of freedom is one.
    if channels > 1.5 && channels < 2.5 { 0.0 } else { LN_SQRT_2_OVER_PI }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smoother(samples: f32) -> Ewma {
        Ewma::with_time_constant(samples, 1.0).unwrap()
    }

    #[test]
    fn without_smoothing_the_limit_is_the_quantile_of_one_sample() {
        let limit = smoothed_t2_limit(&smoother(0.0), 3, 1e6, 1e6).unwrap();
        let exact = upper_chi_square(1e-6, 3.0).unwrap();
        assert!((limit / exact - 1.0).abs() < 1e-3, "{limit} for {exact}");
    }

    /// How often per sample the length of smoothed channels leaves through `level`: the density, the flux and the step of the
    /// documentation above as products in `f64`, from the time constant in samples.
    fn crossings(channels: u8, samples: f64, level: f64) -> f64 {
        let step = (-2.0 * (-1.0 / samples).exp_m1()).sqrt();
        let r = level + 0.582_6 * step;
        let root = core::f64::consts::FRAC_2_PI.sqrt();
        let (norm, inwards) = match channels {
            1 => (root, 0.0),
            2 => (r, 1.0 / r),
            _ => (root * r * r, 2.0 / r),
        };
        norm * (-0.5 * r * r).exp() * (r - inwards) / samples
    }

    #[test]
    fn a_limit_known_exactly_is_left_once_per_interval_by_the_flux_itself() {
        for channels in 1..=3 {
            for samples in [4.0_f32, 64.0, 3000.0] {
                for interval in [1e5, 1e7, 1e10] {
                    let limit = smoothed_t2_limit(&smoother(samples), channels, 1e9, interval).unwrap();
                    let found = crossings(channels, samples.into(), f64::from(limit).sqrt()) * f64::from(interval);
                    assert!((found - 1.0).abs() < 2e-3, "{channels}, {samples}, {interval:e}: {found} per interval");
                }
            }
        }
    }

    #[test]
    fn a_covariance_from_few_samples_widens_the_limit_as_the_closed_form_for_two_channels_does() {
        // Tails: exp(-x/2) of the chi-square, (1 + 2 F/m)^(-m/2) of F(2, m).
        let limit = |nu| f64::from(smoothed_t2_limit(&smoother(64.0), 2, nu, 1e6).unwrap());
        let known = limit(1e9);
        for nu in [11.0_f32, 12.0, 30.0, 1000.0] {
            let exact = f64::from(nu) * (known / (f64::from(nu) - 1.0)).exp_m1();
            assert!((limit(nu) / exact - 1.0).abs() < 1e-4, "{} for {exact} at {nu}", limit(nu));
        }
    }

    #[test]
    fn a_slow_smoother_or_a_short_interval_or_more_samples_lower_the_limit() {
        let limit = |samples, nu, interval| smoothed_t2_limit(&smoother(samples), 3, nu, interval).unwrap();
        assert!(limit(1000.0, 1e3, 1e9) < limit(64.0, 1e3, 1e9));
        assert!(limit(64.0, 1e3, 1e7) < limit(64.0, 1e3, 1e9));
        assert!(limit(64.0, 1e3, 1e9) < limit(64.0, 50.0, 1e9));
    }

    #[test]
    fn the_crossing_rate_in_control_is_the_one_asked_for() {
        // Independent normal samples; a crossing is one where the statistic was below a moment before and has been for long.
        for (samples, interval) in [(0.0, 2e3), (4.0, 2e4), (64.0, 1e5)] {
            let smoother = smoother(samples);
            let limit = smoothed_t2_limit(&smoother, 3, 1e6, interval).unwrap() * smoother.variance_ratio();
            let (mut seed, mut y, mut quiet, mut crossings) = (7_u64, [0.0_f32; 3], 1_000_000_u32, 0);
            let mut uniform = || {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 40) as f32 / (1 << 24) as f32
            };
            let n = 6_000_000;
            for _ in 0..n {
                // Twelve uniforms: normal to some four sigmas, which is where these limits are.
                let x = [0; 3].map(|_| (0..12).map(|_| uniform()).sum::<f32>() - 6.0);
                smoother.step(false, &mut y, x);
                let over = crate::triangle::square(y) > limit;
                crossings += u32::from(over && quiet as f32 > 3.0 * samples);
                quiet = if over { 0 } else { quiet + 1 };
            }
            let ratio = f64::from(crossings) * f64::from(interval) / f64::from(n);
            // 60 to 3,000 crossings. The sum of uniforms has short tails, and clusters count once.
            assert!((0.3..1.6).contains(&ratio), "{samples} samples: {ratio} of the rate asked for, {crossings}");
        }
    }

    #[test]
    fn what_cannot_be_calculated_is_refused_by_name() {
        let ewma = smoother(64.0);
        for channels in [0, 4] {
            assert_eq!(smoothed_t2_limit(&ewma, channels, 100.0, 1e6), Err(LimitError::Retained));
        }
        for nu in [0.0, 11.0, f32::NAN] {
            assert_eq!(smoothed_t2_limit(&ewma, 3, nu, 1e6), Err(LimitError::Samples));
        }
        for interval in [0.0, 5.0, -1.0, f32::NAN, f32::INFINITY, 1e20] {
            assert_eq!(smoothed_t2_limit(&ewma, 3, 100.0, interval), Err(LimitError::FalseAlarmInterval));
        }
    }
}
