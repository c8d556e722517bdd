//! The second-order low-pass.

use super::{LowPassError, prewarped};
use crate::sample::Bank;
use crate::smoother::Smoother;

/// Coefficients of the filter H(z), bilinear transform of the Butterworth prototype, in delta-operator form.
///
/// The two states are in the unit of the input: `lag` follows the input, and the output follows `lag`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    /// Share of the input in the output of the same sample.
    pub(super) direct: f32,
    /// How far `lag` moves towards the input in one sample, as a share of what separates output and input.
    pub(super) to_lag: f32,
    /// How far `base` moves in one sample, as a share of what separates output and `lag`.
    pub(super) to_base: f32,
}

/// State of a [`LowPass`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LowPassState {
    /// The output without the input's direct share.
    pub(super) base: f32,
    pub(super) lag: f32,
}

impl LowPass {
    /// A low-pass whose gain is 1/sqrt(2) at `cutoff_hz`, and falls by 40 dB per decade above.
    ///
    /// # Errors
    /// [`LowPassError::Cutoff`] unless 0 < `cutoff_hz`/`sample_rate_hz` < 0.5.
    pub const fn butterworth(cutoff_hz: f32, sample_rate_hz: f32) -> Result<Self, LowPassError> {
        // With g = tan(pi fc/fs) and D = 1/(1 + sqrt(2) g + g^2): b0 = g^2 D, a1 = 2 D (g^2 - 1),
        // a2 = D (1 - sqrt(2) g + g^2). In delta form alpha2 = 1 + a1 + a2 = 4 b0 and alpha1 = 2 + a1 = 4 b0 + beta with
        // beta = 2 sqrt(2) g D. The second state is scaled by beta, so that at rest it equals the input; then
        // alpha2/beta = sqrt(2) g, and no coefficient is a difference that would cost its digits.
        const SQRT_2: f32 = core::f32::consts::SQRT_2;
        let g = match prewarped(cutoff_hz, sample_rate_hz) {
            Ok(g) => g,
            Err(error) => return Err(error),
        };
        let d = 1.0 / (1.0 + g * (SQRT_2 + g));
        let direct = g * g * d;
        if !(direct > 0.0) {
            return Err(LowPassError::Cutoff); // so slow that the gain underflows
        }
        Ok(LowPass { direct, to_lag: SQRT_2 * g, to_base: 2.0 * SQRT_2 * g * d })
    }
}

impl Smoother for LowPass {
    type State = LowPassState;

    fn at_rest(&self, value: f32) -> LowPassState {
        // The fixed point of `step` for a constant input.
        LowPassState { base: value - self.direct * value, lag: value }
    }

    #[inline(always)]
    fn step(&self, state: &mut LowPassState, input: f32) -> f32 {
        let output = state.base + self.direct * input;
        state.lag += self.to_lag * (input - output);
        state.base += self.to_base * (state.lag - output);
        output
    }

    #[inline(always)]
    fn step_bank(&self, held: bool, states: &mut Bank<LowPassState>, inputs: Bank<f32>) -> Bank<f32> {
        // Every increment has a factor, so zeros hold the states without a branch.
        let to_lag = if held { 0.0 } else { self.to_lag };
        let to_base = if held { 0.0 } else { self.to_base };
        let (base, lag) = (states.map(|state| state.base), states.map(|state| state.lag));
        let outputs = base + inputs * self.direct;
        let lag = lag + (inputs - outputs) * to_lag;
        states.update(lag, |state, lag| state.lag = lag);
        let base = base + (lag - outputs) * to_base;
        states.update(base, |state, base| state.base = base);
        outputs
    }
}
