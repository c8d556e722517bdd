//! Moving average over an interval of samples: the alternative to the low-pass that the paper names (III.B).

use crate::sample::{Bank, PerPair};
use crate::smoother::Smoother;

/// Why a moving average was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MovingAverageError {
    /// The interval must hold between one sample and the capacity.
    Interval,
}

/// The mean of the last `interval` inputs, at most `CAPACITY`: a state holds `CAPACITY` samples, so this is the
/// smoother for memory that is there and windows that are short.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingAverage<const CAPACITY: usize> {
    interval: usize,
    reciprocal: f32,
}

/// State of a [`MovingAverage`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingAverageState<const CAPACITY: usize> {
    inputs: [f32; CAPACITY],
    next: usize,
    sum: f32,
    /// The sum of the inputs since `next` was zero. It replaces `sum` when `next` wraps, so the rounding of one
    /// interval does not pile up over the next.
    since_wrap: f32,
}

impl<const CAPACITY: usize> MovingAverage<CAPACITY> {
    /// The mean over `interval` samples.
    ///
    /// # Errors
    /// [`MovingAverageError::Interval`] unless 1 <= `interval` <= `CAPACITY`.
    pub fn new(interval: usize) -> Result<Self, MovingAverageError> {
        if interval == 0 || interval > CAPACITY {
            return Err(MovingAverageError::Interval);
        }
        Ok(MovingAverage { interval, reciprocal: 1.0 / interval as f32 })
    }
}

impl<const CAPACITY: usize> Smoother for MovingAverage<CAPACITY> {
    type State = MovingAverageState<CAPACITY>;

    fn at_rest(&self, value: f32) -> Self::State {
        MovingAverageState { inputs: [value; CAPACITY], next: 0, sum: value * self.interval as f32, since_wrap: 0.0 }
    }

    #[inline]
    fn step(&self, state: &mut Self::State, input: f32) -> f32 {
        if let Some(oldest) = state.inputs.get_mut(state.next) {
            state.sum += input - *oldest;
            *oldest = input;
        }
        state.since_wrap += input;
        state.next += 1;
        if state.next >= self.interval {
            state.next = 0;
            state.sum = state.since_wrap;
            state.since_wrap = 0.0;
        }
        state.sum * self.reciprocal
    }

    #[inline]
    fn step_bank(&self, held: bool, states: &mut Bank<Self::State>, inputs: Bank<f32>) -> Bank<f32> {
        let step = |state: &mut Self::State, input| if held { 0.0 } else { self.step(state, input) };
        Bank {
            full: step(&mut states.full, inputs.full),
            pairs: PerPair {
                speed_current: step(&mut states.pairs.speed_current, inputs.pairs.speed_current),
                current_voltage: step(&mut states.pairs.current_voltage, inputs.pairs.current_voltage),
                speed_voltage: step(&mut states.pairs.speed_voltage, inputs.pairs.speed_voltage),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn intervals_that_do_not_fit_are_refused() {
        assert_eq!(MovingAverage::<8>::new(0), Err(MovingAverageError::Interval));
        assert_eq!(MovingAverage::<8>::new(9), Err(MovingAverageError::Interval));
        assert!(MovingAverage::<8>::new(8).is_ok());
    }

    #[test]
    fn a_huge_input_leaves_no_trace_once_two_intervals_have_passed() {
        let average = MovingAverage::<16>::new(10).unwrap();
        let mut state = average.at_rest(1.0);
        average.step(&mut state, 1e12);
        let last = (0..20).map(|_| average.step(&mut state, 1.0)).last();
        assert_eq!(last, Some(1.0));
    }

    proptest! {
        #[test]
        fn the_output_is_the_mean_of_the_last_interval(
            inputs in prop::collection::vec(0.0_f32..100.0, 1..200), interval in 1_usize..=32,
        ) {
            let average = MovingAverage::<32>::new(interval).unwrap();
            let mut state = average.at_rest(1.0);
            for k in 0..inputs.len() {
                let y = average.step(&mut state, inputs[k]);
                let exact = (0..interval)
                    .map(|back| if back <= k { f64::from(inputs[k - back]) } else { 1.0 })
                    .sum::<f64>() / interval as f64;
                prop_assert!((f64::from(y) - exact).abs() < 1e-3, "{y} for {exact}");
            }
        }
    }
}
