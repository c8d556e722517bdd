//! Low-passes whose states carry their rounding: for cutoffs so slow that a plain state loses its increments.

use super::{FirstOrder, FirstOrderState, LowPass, LowPassState};
use crate::sample::{Bank, PerPair};
use crate::smoother::Smoother;

/// A low-pass of the same design, with compensated states.
///
/// Each state is the unevaluated sum of two numbers, about 48 bits together: what an addition rounds away is kept and
/// added with the next increment (Kahan 1965), found by Knuth's six operations, which are exact whichever addend is
/// larger (The Art of Computer Programming 2, 4.2.2, theorem B). Kahan's own three are not while the state is smaller
/// than its increment, and would let a held state move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensated<Design>(pub Design);

/// State of a [`Compensated`] filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedState<State> {
    /// What the plain filter would have.
    rounded: State,
    /// What is missing from `rounded`: at most half a unit in its last place.
    carry: State,
}

/// Adds an increment and what was carried to a state; returns the state, and what is carried on.
#[inline(always)]
fn add(state: f32, carry: f32, increment: f32) -> (f32, f32) {
    let increment = increment + carry;
    let sum = state + increment;
    let of_increment = sum - state;
    (sum, (state - (sum - of_increment)) + (increment - of_increment))
}

impl Compensated<LowPass> {
    /// One step by the factors given: those of the design, or zeros, by which a state stays as it is.
    #[inline(always)]
    fn advance(&self, [to_lag, to_base]: [f32; 2], state: &mut CompensatedState<LowPassState>, input: f32) -> f32 {
        let CompensatedState { rounded, carry } = state;
        let output = rounded.base + self.0.direct * input;
        (rounded.lag, carry.lag) = add(rounded.lag, carry.lag, to_lag * (input - output));
        (rounded.base, carry.base) = add(rounded.base, carry.base, to_base * (rounded.lag - output));
        output
    }
}

impl Smoother for Compensated<LowPass> {
    type State = CompensatedState<LowPassState>;

    fn at_rest(&self, value: f32) -> Self::State {
        let (base, carry) = add(value, 0.0, -(self.0.direct * value));
        CompensatedState { rounded: LowPassState { base, lag: value }, carry: LowPassState { base: carry, lag: 0.0 } }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, input: f32) -> f32 {
        self.advance([self.0.to_lag, self.0.to_base], state, input)
    }

    #[inline(always)]
    fn step_bank(&self, held: bool, states: &mut Bank<Self::State>, inputs: Bank<f32>) -> Bank<f32> {
        let factors = if held { [0.0; 2] } else { [self.0.to_lag, self.0.to_base] };
        each(states, inputs, |state, input| self.advance(factors, state, input))
    }
}

impl Compensated<FirstOrder> {
    /// One step by the factor given: that of the design, or zero, by which a state stays as it is.
    #[inline(always)]
    fn advance(&self, to_base: f32, state: &mut CompensatedState<FirstOrderState>, input: f32) -> f32 {
        let CompensatedState { rounded, carry } = state;
        let output = rounded.base + self.0.direct * input;
        (rounded.base, carry.base) = add(rounded.base, carry.base, to_base * (input - output));
        output
    }
}

impl Smoother for Compensated<FirstOrder> {
    type State = CompensatedState<FirstOrderState>;

    fn at_rest(&self, value: f32) -> Self::State {
        let (base, carry) = add(value, 0.0, -(self.0.direct * value));
        CompensatedState { rounded: FirstOrderState { base }, carry: FirstOrderState { base: carry } }
    }

    #[inline(always)]
    fn step(&self, state: &mut Self::State, input: f32) -> f32 {
        self.advance(self.0.to_base, state, input)
    }

    #[inline(always)]
    fn step_bank(&self, held: bool, states: &mut Bank<Self::State>, inputs: Bank<f32>) -> Bank<f32> {
        let to_base = if held { 0.0 } else { self.0.to_base };
        each(states, inputs, |state, input| self.advance(to_base, state, input))
    }
}

/// Takes the step of each model.
#[inline(always)]
fn each<State>(states: &mut Bank<State>, inputs: Bank<f32>, mut step: impl FnMut(&mut State, f32) -> f32) -> Bank<f32> {
    Bank {
        full: step(&mut states.full, inputs.full),
        pairs: PerPair {
            speed_current: step(&mut states.pairs.speed_current, inputs.pairs.speed_current),
            current_voltage: step(&mut states.pairs.current_voltage, inputs.pairs.current_voltage),
            speed_voltage: step(&mut states.pairs.speed_voltage, inputs.pairs.speed_voltage),
        },
    }
}
