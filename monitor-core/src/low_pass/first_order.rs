//! The first-order low-pass: one state and three quarters of the arithmetic where 20 dB per decade are enough.

use super::{LowPassError, prewarped};
use crate::sample::Bank;
use crate::smoother::Smoother;

/// Coefficients of the first-order filter, bilinear transform of 1/(1 + s), in delta-operator form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrder {
    /// Share of the input in the output of the same sample.
    pub(super) direct: f32,
    /// How far the state moves in one sample, as a share of what separates output and input.
    pub(super) to_base: f32,
}

/// State of a [`FirstOrder`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FirstOrderState {
    /// The output without the input's direct share.
    pub(super) base: f32,
}

impl FirstOrder {
    /// A low-pass whose gain is 1/sqrt(2) at `cutoff_hz`, and falls by 20 dB per decade above.
    ///
    /// # Errors
    /// [`LowPassError::Cutoff`] unless 0 < `cutoff_hz`/`sample_rate_hz` < 0.5.
    pub const fn butterworth(cutoff_hz: f32, sample_rate_hz: f32) -> Result<Self, LowPassError> {
        // With g = tan(pi fc/fs): y[n] = b0 (x[n] + x[n-1]) + (1 - 2 b0) y[n-1], b0 = g/(1 + g). With the state
        // s[n] = b0 x[n-1] + (1 - 2 b0) y[n-1] that is y = s + b0 x and s += 2 b0 (x - y): no 1 - 2 b0 is left to round.
        let g = match prewarped(cutoff_hz, sample_rate_hz) {
            Ok(g) => g,
            Err(error) => return Err(error),
        };
        let direct = g / (1.0 + g);
        Ok(FirstOrder { direct, to_base: 2.0 * direct })
    }
}

impl Smoother for FirstOrder {
    type State = FirstOrderState;

    fn at_rest(&self, value: f32) -> FirstOrderState {
        FirstOrderState { base: value - self.direct * value }
    }

    #[inline(always)]
    fn step(&self, state: &mut FirstOrderState, input: f32) -> f32 {
        let output = state.base + self.direct * input;
        state.base += self.to_base * (input - output);
        output
    }

    #[inline(always)]
    fn step_bank(&self, held: bool, states: &mut Bank<FirstOrderState>, inputs: Bank<f32>) -> Bank<f32> {
        // The increment has a factor, so a zero holds the states without a branch.
        let to_base = if held { 0.0 } else { self.to_base };
        let base = states.map(|state| state.base);
        let outputs = base + inputs * self.direct;
        let base = base + (inputs - outputs) * to_base;
        states.update(base, |state, base| state.base = base);
        outputs
    }
}
