//! Exponential smoothing of a vector of channels: the time scales of `guard` mode, from one sample to minutes, all of one
//! design type.
//!
//! y += a (x - y), the filter of the multivariate EWMA chart (Lowry, Woodall, Champ, Rigdon 1992). The channels are
//! smoothed before the distance is formed: noise then averages out while it still has both signs, and a distance of
//! smoothed channels sees shifts that a smoothed distance cannot.

/// Why a time scale was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EwmaError {
    /// The time constant must be finite and not negative, and below 2^20 samples: slower, an `f32` no longer follows.
    TimeConstant,
    /// The sampling rate must be finite and above zero.
    SampleRate,
}

/// An exponential smoother.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ewma {
    weight: f32,
}

impl Ewma {
    /// A smoother that forgets to 1/e in `time_constant_s`; with 0 its output is the last sample.
    ///
    /// # Errors
    /// [`EwmaError`] names the parameter that is out of range.
    pub fn with_time_constant(time_constant_s: f32, sample_rate_hz: f32) -> Result<Self, EwmaError> {
        if !(sample_rate_hz > 0.0 && sample_rate_hz.is_finite()) {
            return Err(EwmaError::SampleRate);
        }
        let samples = time_constant_s * sample_rate_hz;
        if !(0.0..1_048_576.0).contains(&samples) {
            return Err(EwmaError::TimeConstant);
        }
        let weight = if samples > 0.0 { -libm::expm1f(-1.0 / samples) } else { 1.0 };
        Ok(Ewma { weight })
    }

    /// Weight of the newest sample, in (0, 1].
    #[must_use]
    pub const fn weight(&self) -> f32 {
        self.weight
    }

    /// Variance of the output over that of the input, for independent samples: a/(2 - a). Its reciprocal is how many
    /// samples the output averages.
    #[must_use]
    pub const fn variance_ratio(&self) -> f32 {
        self.weight / (2.0 - self.weight)
    }

    /// Takes one sample. When `held` the state stays as it is, for the same work; the sample must be finite then, too.
    #[inline(always)]
    pub fn step<const N: usize>(&self, held: bool, state: &mut [f32; N], x: [f32; N]) {
        let weight = if held { 0.0 } else { self.weight };
        for (y, x) in state.iter_mut().zip(x) {
            *y += weight * (x - *y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_followed_to_all_but_1_over_e_in_one_time_constant() {
        let smoother = Ewma::with_time_constant(0.064, 1000.0).unwrap();
        let mut y = [0.0_f32];
        (0..64).for_each(|_| smoother.step(false, &mut y, [1.0]));
        assert!((f64::from(y[0]) - (1.0 - (-1.0_f64).exp())).abs() < 1e-5);
    }

    #[test]
    fn without_a_time_constant_the_output_is_the_last_sample() {
        let smoother = Ewma::with_time_constant(0.0, 1000.0).unwrap();
        let mut y = [5.0, 0.0, 1.0];
        smoother.step(false, &mut y, [1.0, -2.0, 3.5]);
        assert_eq!((y, smoother.variance_ratio()), ([1.0, -2.0, 3.5], 1.0));
        smoother.step(true, &mut y, [9.0, 9.0, 9.0]);
        assert_eq!(y, [1.0, -2.0, 3.5], "a held sample changes nothing");
    }

    #[test]
    fn the_variance_ratio_is_the_sum_of_the_squared_impulse_response() {
        let smoother = Ewma::with_time_constant(0.01, 1000.0).unwrap();
        let (mut y, mut sum) = ([0.0_f32], 0.0_f64);
        for k in 0..500 {
            smoother.step(false, &mut y, [if k == 0 { 1.0 } else { 0.0 }]);
            sum += f64::from(y[0]).powi(2);
        }
        assert!((f64::from(smoother.variance_ratio()) / sum - 1.0).abs() < 1e-5);
    }

    #[test]
    fn time_scales_that_make_no_sense_are_refused_by_name() {
        for tau in [-1.0, f32::NAN, f32::INFINITY, 2e3] {
            assert_eq!(Ewma::with_time_constant(tau, 1000.0), Err(EwmaError::TimeConstant));
        }
        for rate in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Ewma::with_time_constant(1.0, rate), Err(EwmaError::SampleRate));
        }
    }
}
