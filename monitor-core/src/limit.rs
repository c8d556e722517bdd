//! Control limits by calculation: what a statistic in control exceeds as seldom as asked.
//!
//! [`t2_limit`] is for a T2 that is compared sample by sample, [`filtered_limit`] for one that is smoothed first, as the
//! paper does (fig. 3). Both are in the units of the scaled T2 (1.6), whose mean in control is about one, and both are
//! for design and start-up, not for `step`.
//!
//! The paper finds its thresholds by borderline runs instead (III.B). The calculation needs samples that are normal and
//! independent; where they are not, [`Statistic::measured`] takes the moments that the statistic has in truth.

use crate::quantile::{QuantileError, upper_f};

mod smoothed;

pub use smoothed::smoothed_t2_limit;

/// Why a limit was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LimitError {
    /// The probability of a false alarm must lie in [1e-12, 0.1].
    FalseAlarmProbability,
    /// The number of retained components must lie in 1 to 50.
    Retained,
    /// The learning window must hold at least ten samples more than there are retained components.
    Samples,
    /// The mean of the statistic must be finite and above zero.
    Mean,
    /// The variance of the statistic must be finite and above zero.
    Variance,
    /// The autocorrelation factor must be finite and above zero.
    AutocorrelationFactor,
    /// The cutoff must lie above zero and at or below a twentieth of the sampling rate.
    Cutoff,
    /// The interval between false alarms must be finite, and many times what the filter takes to forget.
    FalseAlarmInterval,
    /// The filter must average over at least four degrees of freedom: a lower cutoff, or a statistic that scatters less.
    DegreesOfFreedom,
}

impl From<QuantileError> for LimitError {
    fn from(error: QuantileError) -> Self {
        match error {
            QuantileError::TailProbability => LimitError::FalseAlarmProbability,
            QuantileError::DegreesOfFreedom => LimitError::Retained,
            QuantileError::DenominatorDegreesOfFreedom => LimitError::Samples,
        }
    }
}

/// The phase-II limit of T2: what the T2 (1.6) of one future sample exceeds with `false_alarm_probability` while the
/// process is in control, for `retained` components learned from `samples` samples.
///
/// With the scale of (1.6) T2 is distributed as F(R, I - R) (NIST/SEMATECH e-Handbook 6.5.4.3), so the limit is that
/// distribution's upper quantile. The probability is that over learning windows as well as over samples: one window's
/// own rate scatters about it, the more the shorter the window.
///
/// # Errors
/// [`LimitError::FalseAlarmProbability`], [`LimitError::Retained`], [`LimitError::Samples`].
pub fn t2_limit(false_alarm_probability: f32, retained: usize, samples: u32) -> Result<f32, LimitError> {
    let [r, rest] = degrees_of_freedom(retained, samples)?;
    Ok(upper_f(false_alarm_probability, r, rest)?)
}

/// R and I - R.
fn degrees_of_freedom(retained: usize, samples: u32) -> Result<[f32; 2], LimitError> {
    let r = u32::try_from(retained).ok().filter(|r| (1..=50).contains(r)).ok_or(LimitError::Retained)?;
    let rest = samples.checked_sub(r).filter(|rest| *rest >= 10).ok_or(LimitError::Samples)?;
    Ok([r as f32, rest as f32])
}

/// The first moments of a statistic in control, before it is filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    mean: f32,
    variance: f32,
    autocorrelation_factor: f32,
}

impl Statistic {
    /// T2 (1.6) of independent normal samples, for `retained` components learned from `samples` samples: the mean and
    /// the variance of F(R, I - R), near 1 and 2/R.
    ///
    /// # Errors
    /// [`LimitError::Retained`], [`LimitError::Samples`].
    pub fn phase_two(retained: usize, samples: u32) -> Result<Self, LimitError> {
        let [r, rest] = degrees_of_freedom(retained, samples)?;
        let mean = rest / (rest - 2.0);
        let variance = 2.0 * mean * mean * ((r + rest - 2.0) / (rest - 4.0)) / r;
        Ok(Statistic { mean, variance, autocorrelation_factor: 1.0 })
    }

    /// A statistic whose moments were estimated in control, on samples after the learning window.
    ///
    /// `mean` and `variance` are in the statistic's unit and its square. `autocorrelation_factor` is the sum of its
    /// autocorrelations over all lags, of both signs: one for independent samples, (1 + a)/(1 - a) for a^|k|. Where the
    /// statistic is heavy-tailed, clamp it before the filter, at 6 to 12 times its mean, and take the moments behind
    /// the clamp; the clamp also bounds how long the filter takes to come down after a fault.
    ///
    /// # Errors
    /// [`LimitError::Mean`], [`LimitError::Variance`], [`LimitError::AutocorrelationFactor`] unless each is finite and
    /// above zero.
    pub fn measured(mean: f32, variance: f32, autocorrelation_factor: f32) -> Result<Self, LimitError> {
        let usable = |x: f32, error| if x > 0.0 && x.is_finite() { Ok(()) } else { Err(error) };
        usable(mean, LimitError::Mean)?;
        usable(variance, LimitError::Variance)?;
        usable(autocorrelation_factor, LimitError::AutocorrelationFactor)?;
        Ok(Statistic { mean, variance, autocorrelation_factor })
    }
}

/// Highest cutoff, as a share of the sampling rate, at which the rate of false alarms was measured.
const CUTOFF_TO: f32 = 0.05;

/// Least number of mean periods of the filter between two false alarms: below, crossings are not rare and Rice's rate
/// does not count alarms.
const PERIODS_FROM: f32 = 10.0;

/// Least degrees of freedom at which Wilson and Hilferty's cube root is within 9 % of the chi-square's quantile, and above it,
/// for tails as thin as 1e-8; from 9 on it is within 5 %.
const DEGREES_OF_FREEDOM_FROM: f32 = 4.0;

/// The limit that a statistic, smoothed by the second-order [`LowPass`](crate::low_pass::LowPass), exceeds once per
/// `false_alarm_interval_s` seconds on average while the process is in control. In the unit of the statistic.
///
/// - The filter averages: it leaves sum h^2 = (pi/sqrt 2) fc/fs of the variance v, so m times a chi-square over its degrees
///   of freedom nu = 2 m^2 fs / ((pi/sqrt 2) fc v tau) has the smoothed statistic's mean and variance (Box 1954).
/// - A process that this filter has smoothed crosses its mean upwards fc times per second, and a level z standard
///   deviations above fc exp(-z^2/2) times (Rice 1944), as the slope's mean square, over all frequencies f of
///   f^2/(1 + (f/fc)^4), is fc^2 times the process' own. So z = sqrt(2 ln(fc T0)).
/// - The chi-square's quantile at z is nu (1 - 2/(9 nu) + z sqrt(2/(9 nu)))^3 (Wilson and Hilferty 1931).
///
/// On independent normal samples the rate came out 0.82 to 1.09 times what was asked (`NUMERICS.md`,
/// [`crate::numerics`]). A learned mean and covariance are off by chance, which moves the filtered statistic as a whole;
/// with a short window that matters more than anything above.
///
/// # Errors
/// [`LimitError::Cutoff`] unless 0 < `cutoff_hz`/`sample_rate_hz` <= 0.05; [`LimitError::FalseAlarmInterval`] unless
/// `cutoff_hz` times the interval is finite and at least 10; [`LimitError::DegreesOfFreedom`] when nu is below 4.
pub fn filtered_limit(
    statistic: Statistic,
    cutoff_hz: f32,
    sample_rate_hz: f32,
    false_alarm_interval_s: f32,
) -> Result<f32, LimitError> {
    const SUM_OF_SQUARES: f32 = core::f32::consts::PI * core::f32::consts::FRAC_1_SQRT_2;
    let cutoff = cutoff_hz / sample_rate_hz;
    if !(cutoff > 0.0 && cutoff <= CUTOFF_TO && sample_rate_hz > 0.0) {
        return Err(LimitError::Cutoff);
    }
    let periods = cutoff_hz * false_alarm_interval_s;
    if !(periods >= PERIODS_FROM && periods.is_finite()) {
        return Err(LimitError::FalseAlarmInterval);
    }
    let Statistic { mean, variance, autocorrelation_factor } = statistic;
    let nu = 2.0 * (mean / variance * mean) / (SUM_OF_SQUARES * cutoff * autocorrelation_factor);
    if !(nu >= DEGREES_OF_FREEDOM_FROM) {
        return Err(LimitError::DegreesOfFreedom);
    }
    let z = libm::sqrtf(2.0 * libm::logf(periods));
    Ok(mean * wilson_hilferty(nu, z))
}

/// A chi-square over its degrees of freedom, at the probability at which a normal variable is z.
fn wilson_hilferty(nu: f32, z: f32) -> f32 {
    let variance = 2.0 / (9.0 * nu);
    let root = 1.0 - variance + z * libm::sqrtf(variance);
    root * root * root
}

#[cfg(test)]
mod tests;
