//! Second-order Butterworth low-pass: the smoothing filter at the end of the residual generator (the paper, fig. 3).
//!
//! The biquad is in delta-operator form. In the usual direct forms the feedback is 2 y[n-1] - y[n-2] plus something of
//! the size of (fc/fs)^2; in `f32` that something drowns in the rounding of the two large terms, and at a cutoff of
//! 5e-5 of the sampling rate the DC gain is wrong by more than half. The delta form keeps the small coefficients
//! themselves and adds differences to its states (Kauraniemi, Laakso, Hartimo, Ovaska, IEEE TCAS-II 45(1), 1998).

use crate::sample::Bank;
use crate::smoother::Smoother;

/// Why a filter was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LowPassError {
    /// The cutoff must lie above zero and below half the sampling rate.
    Cutoff,
}

/// Coefficients of the filter H(z), bilinear transform of the Butterworth prototype, in delta-operator form.
///
/// The two states are in the unit of the input: `lag` follows the input, and the output follows `lag`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    /// Share of the input in the output of the same sample.
    direct: f32,
    /// How far `lag` moves towards the input in one sample, as a share of what separates output and input.
    to_lag: f32,
    /// How far `base` moves in one sample, as a share of what separates output and `lag`.
    to_base: f32,
}

/// State of a [`LowPass`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LowPassState {
    /// The output without the input's direct share.
    base: f32,
    lag: f32,
}

impl LowPass {
    /// A low-pass whose gain is 1/sqrt(2) at `cutoff_hz`.
    ///
    /// # Errors
    /// [`LowPassError::Cutoff`] unless 0 < `cutoff_hz`/`sample_rate_hz` < 0.5.
    pub fn butterworth(cutoff_hz: f32, sample_rate_hz: f32) -> Result<Self, LowPassError> {
        let cutoff = cutoff_hz / sample_rate_hz;
        if !(cutoff > 0.0 && cutoff < 0.5 && sample_rate_hz > 0.0) {
            return Err(LowPassError::Cutoff);
        }
        // With g = tan(pi fc/fs) and D = 1/(1 + sqrt(2) g + g^2): b0 = g^2 D, a1 = 2 D (g^2 - 1),
        // a2 = D (1 - sqrt(2) g + g^2). In delta form alpha2 = 1 + a1 + a2 = 4 b0 and alpha1 = 2 + a1 = 4 b0 + beta with
        // beta = 2 sqrt(2) g D. The second state is scaled by beta, so that at rest it equals the input; then
        // alpha2/beta = sqrt(2) g, and no coefficient is a difference that would cost its digits.
        const SQRT_2: f32 = core::f32::consts::SQRT_2;
        let g = tangent_of_pi_times(cutoff);
        let d = 1.0 / (1.0 + g * (SQRT_2 + g));
        let direct = g * g * d;
        if !(direct > 0.0) {
            return Err(LowPassError::Cutoff); // so slow that the gain underflows
        }
        Ok(LowPass { direct, to_lag: SQRT_2 * g, to_base: 2.0 * SQRT_2 * g * d })
    }
}

/// tan(pi x) for x in (0, 1/2), to within two units in the last place, by `tests/references/fit_tangent.py`.
///
/// `libm::tanf` computes in double precision, which is software on a target without it: kilobytes of flash for one number.
fn tangent_of_pi_times(x: f32) -> f32 {
    let to_quarter = |x: f32| {
        let w = x * x;
        let high = 161.149_1 + w * (732.735_8 + w * (860.452_2 + w * 27_534.316));
        x * (core::f32::consts::PI + w * (10.335_347 + w * (40.822_414 + w * high)))
    };
    // The difference is exact.
    if x <= 0.25 { to_quarter(x) } else { 1.0 / to_quarter(0.5 - x) }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::ModelId;
    use proptest::prelude::*;

    extern crate std;
    use std::vec::Vec;

    /// The same filter in `f64`, direct form, from the textbook coefficients.
    fn reference(cutoff: f64, input: impl Iterator<Item = f64>) -> Vec<f64> {
        let g = libm::tan(core::f64::consts::PI * cutoff);
        let d = 1.0 / (1.0 + core::f64::consts::SQRT_2 * g + g * g);
        let (b0, a1, a2) = (g * g * d, 2.0 * d * (g * g - 1.0), d * (1.0 - core::f64::consts::SQRT_2 * g + g * g));
        let (mut x1, mut x2, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0);
        input
            .map(|x| {
                let y = b0 * (x + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
                (x2, x1, y2, y1) = (x1, x, y1, y);
                y
            })
            .collect()
    }

    fn gain_error_at_dc(cutoff: f32) -> f32 {
        let filter = LowPass::butterworth(cutoff, 1.0).unwrap();
        let mut state = filter.at_rest(0.0);
        // 12 time constants of the slower pole pair.
        let steps = (12.0 / (core::f32::consts::TAU * cutoff * core::f32::consts::FRAC_1_SQRT_2)) as usize;
        let mut y = 0.0;
        for _ in 0..steps {
            y = filter.step(&mut state, 1.0);
        }
        (y - 1.0).abs()
    }

    #[test]
    fn the_dc_gain_is_one_even_at_cutoffs_where_direct_forms_fail() {
        for cutoff in [0.2, 1e-2, 1e-3, 2e-4, 5e-5] {
            assert!(gain_error_at_dc(cutoff) <= 1e-4, "at fc/fs = {cutoff}: {:e}", gain_error_at_dc(cutoff));
        }
        assert!(gain_error_at_dc(1e-5) <= 1e-3, "at fc/fs = 1e-5: {:e}", gain_error_at_dc(1e-5));
    }

    #[test]
    fn the_step_response_agrees_with_the_textbook_filter_in_f64() {
        for cutoff in [5e-5, 1e-3, 0.02, 0.2, 0.45] {
            let filter = LowPass::butterworth(cutoff, 1.0).unwrap();
            let mut state = filter.at_rest(0.0);
            let steps = usize::min(40_000, (4.0 / cutoff) as usize + 100);
            for (exact, _) in reference(f64::from(cutoff), core::iter::repeat_n(1.0, steps)).into_iter().zip(0..) {
                let y = f64::from(filter.step(&mut state, 1.0));
                assert!((y - exact).abs() < 1e-4, "fc/fs {cutoff}: {y} for {exact}");
            }
        }
    }

    #[test]
    fn the_gain_at_the_cutoff_is_the_square_root_of_one_half() {
        let (cutoff, filter) = (0.01_f32, LowPass::butterworth(10.0, 1000.0).unwrap());
        let mut state = filter.at_rest(0.0);
        let outputs: Vec<f32> = (0..5000)
            .map(|k| filter.step(&mut state, libm::sinf(core::f32::consts::TAU * cutoff * k as f32)))
            .collect();
        let peak = outputs[3000..].iter().fold(0.0, |m: f32, y| m.max(y.abs()));
        assert!((peak - core::f32::consts::FRAC_1_SQRT_2).abs() < 2e-3, "{peak}");
    }

    #[test]
    fn a_filter_at_rest_stays_at_rest() {
        for cutoff in [1e-5, 1e-3, 0.1, 0.4] {
            let filter = LowPass::butterworth(cutoff, 1.0).unwrap();
            let mut state = filter.at_rest(3.75);
            for _ in 0..1000 {
                assert!((filter.step(&mut state, 3.75) - 3.75).abs() < 4e-3, "at fc/fs = {cutoff}");
            }
        }
    }

    #[test]
    fn the_tangent_of_the_design_is_right_to_two_units_in_the_last_place() {
        for k in 1..50_000 {
            for x in [k as f32 * 1e-5, k as f32 * 1e-9] {
                let exact = libm::tan(core::f64::consts::PI * f64::from(x));
                let error = f64::from(tangent_of_pi_times(x)) / exact - 1.0;
                assert!(error.abs() < 2.4e-7, "at {x}: {error:e}");
            }
        }
    }

    #[test]
    fn cutoffs_outside_zero_to_one_half_are_refused() {
        for (cutoff, rate) in [
            (0.0, 1.0),
            (-1.0, 1.0),
            (0.5, 1.0),
            (500.0, 1000.0),
            (f32::NAN, 1.0),
            (1.0, f32::NAN),
            (-1.0, -10.0),
            (1e-30, 1.0),
        ] {
            assert_eq!(LowPass::butterworth(cutoff, rate), Err(LowPassError::Cutoff), "{cutoff} of {rate}");
        }
    }

    #[test]
    fn four_states_side_by_side_move_as_each_does_alone_and_stand_still_while_held() {
        let filter = LowPass::butterworth(20.0, 1000.0).unwrap();
        let mut bank = Bank::from_fn(|_| filter.at_rest(1.0));
        let mut alone = bank;
        for k in 0..500 {
            let inputs = Bank::from_fn(|model| 1.0 + libm::sinf(k as f32 * (1.0 + *starts().get(model))));
            let before = bank;
            filter.step_bank(true, &mut bank, inputs);
            assert_eq!(bank, before);
            let outputs = filter.step_bank(false, &mut bank, inputs);
            let expected = [
                filter.step(&mut alone.full, inputs.full),
                filter.step(&mut alone.pairs.speed_current, inputs.pairs.speed_current),
                filter.step(&mut alone.pairs.current_voltage, inputs.pairs.current_voltage),
                filter.step(&mut alone.pairs.speed_voltage, inputs.pairs.speed_voltage),
            ];
            assert_eq!(ModelId::ALL.map(|model| *outputs.get(model)), expected);
        }
    }

    fn starts() -> Bank<f32> {
        let mut next = 0.0;
        Bank::from_fn(|_| {
            next += 0.1;
            next
        })
    }

    proptest! {
        #[test]
        fn a_bounded_input_gives_a_bounded_output(cutoff in 1e-4_f32..0.49, input in prop::collection::vec(0.0_f32..1e12, 1..200)) {
            let filter = LowPass::butterworth(cutoff, 1.0).unwrap();
            let mut state = filter.at_rest(1.0);
            let largest = input.iter().fold(1.0_f32, |m, x| m.max(*x));
            for x in &input {
                // A second-order Butterworth step overshoots by 4.3 %; alternating inputs can add a little to it.
                prop_assert!(filter.step(&mut state, *x).abs() <= 1.5 * largest);
            }
        }
    }
}
