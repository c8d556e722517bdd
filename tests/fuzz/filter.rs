//! The low-passes: what goes in bounded comes out bounded, and a held state stays.

use bolero::{TypeGenerator, check};
use monitor_core::low_pass::{Compensated, FirstOrder, LowPass};
use monitor_core::sample::{Bank, ModelId};
use monitor_core::smoother::Smoother;

use super::TEST_TIME;
use super::number::Number;

/// Sum of the magnitudes of the impulse response, the most by which a filter can magnify a bounded input, over
/// fc/fs from 1e-6 to 0.45; each plus one in a hundred for rounding. First order: 2g/(1 + g) where g = tan(pi fc/fs) is
/// above one. Second order: the sum over the filter in `f64`, largest at 0.45.
const FIRST_ORDER_GAIN: f32 = 1.727 * 1.01;
const SECOND_ORDER_GAIN: f32 = 2.0385 * 1.01;

/// A low-pass, and what it is fed.
#[derive(Clone, Debug, TypeGenerator)]
struct Input {
    /// Design by any numbers: it may be refused, and must not panic.
    cutoff_hz: Number,
    sample_rate_hz: Number,
    /// fc/fs = 0.45 * 10^(-5.6 slowness/2^16): 0.45 down to 1.1e-6.
    slowness: u16,
    /// Bound of the inputs, as a power of ten.
    #[generator(-30..35_i32)]
    size: i32,
    rest: i16,
    slots: Vec<Slot>,
}

/// Inputs of the four states, as shares of the bound; each is repeated.
#[derive(Clone, Debug, TypeGenerator)]
struct Slot {
    held: bool,
    shares: [i16; 4],
    #[generator(1..40_u8)]
    times: u8,
}

impl Input {
    fn ratio(&self) -> f32 {
        0.45 * 10.0_f32.powf(-5.6 * f32::from(self.slowness) / 65_536.0)
    }

    fn bound(&self) -> f32 {
        10.0_f32.powi(self.size)
    }
}

#[test]
fn bounded_inputs_give_bounded_outputs_and_held_states_stay() {
    check!().with_test_time(TEST_TIME).with_type::<Input>().for_each(|input| {
        design_by_any_numbers(input.cutoff_hz.value(), input.sample_rate_hz.value());
        let (first, second) = (FirstOrder::butterworth(input.ratio(), 1.0), LowPass::butterworth(input.ratio(), 1.0));
        let (first, second) = (first.unwrap(), second.unwrap());
        run(&first, FIRST_ORDER_GAIN, input);
        run(&Compensated(first), FIRST_ORDER_GAIN, input);
        run(&second, SECOND_ORDER_GAIN, input);
        run(&Compensated(second), SECOND_ORDER_GAIN, input);
    });
}

/// A design that is accepted passes a constant on.
fn design_by_any_numbers(cutoff_hz: f32, sample_rate_hz: f32) {
    let rests = |y: f32| assert!((y - 1.0).abs() < 1e-6, "{cutoff_hz:e} Hz of {sample_rate_hz:e} Hz: 1 becomes {y}");
    let valid = cutoff_hz / sample_rate_hz > 0.0 && cutoff_hz / sample_rate_hz < 0.5 && sample_rate_hz > 0.0;
    let first = FirstOrder::butterworth(cutoff_hz, sample_rate_hz);
    assert_eq!(first.is_ok(), valid);
    if let Ok(first) = first {
        rests(first.step(&mut first.at_rest(1.0), 1.0));
    }
    if let Ok(second) = LowPass::butterworth(cutoff_hz, sample_rate_hz) {
        assert!(valid);
        rests(second.step(&mut second.at_rest(1.0), 1.0));
    }
}

fn run<S: Smoother>(filter: &S, gain: f32, input: &Input) {
    let bound = input.bound();
    let share = |count: i16| bound * (f32::from(count) / 32_768.0);
    let mut states = Bank::from_fn(|_| filter.at_rest(share(input.rest)));
    for slot in &input.slots {
        let [full, a, b, c] = slot.shares.map(share);
        let inputs = bank([full, a, b, c]);
        for _ in 0..slot.times {
            let before = states;
            let outputs = filter.step_bank(slot.held, &mut states, inputs);
            if slot.held {
                assert_eq!(states, before, "a held state has moved");
                continue;
            }
            for model in ModelId::ALL {
                let (y, mut alone) = (*outputs.get(model), *before.get(model));
                assert!(y.abs() <= gain * bound, "{y:e} of inputs up to {bound:e}");
                assert_eq!(filter.step(&mut alone, *inputs.get(model)), y, "one by one it differs");
                assert_eq!(alone, *states.get(model), "one by one its state differs");
            }
        }
    }
}

fn bank(values: [f32; 4]) -> Bank<f32> {
    let mut values = values.into_iter();
    Bank::from_fn(|_| values.next().unwrap_or_default())
}
