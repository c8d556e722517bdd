//! What each form of the low-pass promises; how accurate each is, is in `accuracy.rs`.

use super::*;
use crate::sample::{Bank, ModelId};
use crate::smoother::Smoother;
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
    let outputs: Vec<f32> =
        (0..5000).map(|k| filter.step(&mut state, libm::sinf(core::f32::consts::TAU * cutoff * k as f32))).collect();
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
        if cutoff != 1e-30 {
            assert_eq!(FirstOrder::butterworth(cutoff, rate), Err(LowPassError::Cutoff), "{cutoff} of {rate}");
        }
    }
}

/// Four states fed side by side, held at every third sample, against the same four alone.
fn assert_bank_moves_as_each_alone<S: Smoother>(filter: &S) {
    let mut bank = Bank::from_fn(|_| filter.at_rest(0.0));
    let mut alone = bank;
    for k in 0..500 {
        let inputs = Bank::from_fn(|model| 1.0 + libm::sinf(k as f32 * (1.0 + *starts().get(model))));
        let before = bank;
        filter.step_bank(true, &mut bank, inputs);
        assert_eq!(bank, before, "held at sample {k}");
        let outputs = filter.step_bank(false, &mut bank, inputs);
        let expected = [
            filter.step(&mut alone.full, inputs.full),
            filter.step(&mut alone.pairs.speed_current, inputs.pairs.speed_current),
            filter.step(&mut alone.pairs.current_voltage, inputs.pairs.current_voltage),
            filter.step(&mut alone.pairs.speed_voltage, inputs.pairs.speed_voltage),
        ];
        assert_eq!(ModelId::ALL.map(|model| *outputs.get(model)), expected);
        assert_eq!(bank, alone);
    }
}

#[test]
fn four_states_side_by_side_move_as_each_does_alone_and_stand_still_while_held() {
    for cutoff in [0.02, 1e-6] {
        let (second, first) = designs(cutoff);
        assert_bank_moves_as_each_alone(&second);
        assert_bank_moves_as_each_alone(&first);
        assert_bank_moves_as_each_alone(&Compensated(second));
        assert_bank_moves_as_each_alone(&Compensated(first));
    }
}

fn starts() -> Bank<f32> {
    let mut next = 0.0;
    Bank::from_fn(|_| {
        next += 0.1;
        next
    })
}

fn designs(cutoff: f32) -> (LowPass, FirstOrder) {
    (LowPass::butterworth(cutoff, 1.0).unwrap(), FirstOrder::butterworth(cutoff, 1.0).unwrap())
}

#[test]
fn a_design_made_while_compiling_has_the_bits_of_one_made_at_start_up() {
    const SECOND: Result<LowPass, LowPassError> = LowPass::butterworth(1.0, 1000.0);
    const FIRST: Result<FirstOrder, LowPassError> = FirstOrder::butterworth(333.0, 1000.0);
    let [cutoffs, rates] = core::hint::black_box([[1.0, 333.0], [1000.0, 1000.0]]);
    assert_eq!(LowPass::butterworth(cutoffs[0], rates[0]), SECOND);
    assert_eq!(FirstOrder::butterworth(cutoffs[1], rates[1]), FIRST);
    assert!(SECOND.is_ok() && FIRST.is_ok());
}

/// Feeds alternations of the largest and smallest of a range, its steps, and noise; returns the largest output.
fn largest_output<S: Smoother>(filter: &S, amplitude: f32) -> f32 {
    let mut state = filter.at_rest(-amplitude);
    let mut noise = 1_u32;
    let mut largest = 0.0_f32;
    for k in 0..20_000_u32 {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let input = match k / 5000 {
            0 => amplitude,
            1 => amplitude * (1.0 - 2.0 * (k % 2) as f32),
            2 => amplitude * (1.0 - 2.0 * ((k / 50) % 2) as f32),
            _ => amplitude * (noise as f32 / 2_147_483_648.0 - 1.0),
        };
        let output = filter.step(&mut state, input);
        assert!(output.is_finite(), "output {output} at sample {k}");
        largest = largest.max(output.abs());
    }
    assert!(filter.step(&mut state, 0.0).is_finite());
    largest
}

#[test]
fn a_bounded_input_gives_a_bounded_output_from_the_smallest_subnormal_to_1e30() {
    for amplitude in [1e-45, 1e-39, 1e-20, 1.0, 1e30_f32] {
        for cutoff in [1e-6, 5e-5, 0.01, 0.25, 0.45, 0.49] {
            let (second, first) = designs(cutoff);
            // The sum of |h[k]|: up to fc/fs = 1/4 the first order does not overshoot; above it rings at half the rate.
            let [of_second, of_first] = if cutoff <= 0.25 { [1.3, 1.000_01] } else { [2.5, 2.0] };
            // Increments of subnormals are whole subnormals, of which a fast filter takes up to nine times one.
            let unit = 16.0 * f32::from_bits(1);
            let outputs = [largest_output(&second, amplitude), largest_output(&Compensated(second), amplitude)];
            assert!(outputs.iter().all(|y| *y <= of_second * amplitude + unit), "{outputs:?}, {amplitude:e}, {cutoff}");
            let outputs = [largest_output(&first, amplitude), largest_output(&Compensated(first), amplitude)];
            assert!(outputs.iter().all(|y| *y <= of_first * amplitude + unit), "{outputs:?}, {amplitude:e}, {cutoff}");
        }
    }
}

/// The outputs of a filter for an input and for the input scaled by a power of two.
fn assert_scale_does_not_matter<S: Smoother>(filter: &S, scale: f32) {
    let (mut state, mut scaled) = (filter.at_rest(1.0), filter.at_rest(scale));
    for k in 0..2000 {
        let input = 1.0 + 0.5 * libm::sinf(k as f32);
        assert_eq!(filter.step(&mut state, input) * scale, filter.step(&mut scaled, input * scale), "at {k}");
    }
}

/// Nothing in a step looks at the magnitude of what it works on: the outputs scale bit for bit. (That the instructions
/// are the same too, for subnormals as well, is for the target's trace to show.)
#[test]
fn inputs_scaled_by_a_power_of_two_give_outputs_scaled_by_it_bit_for_bit() {
    for scale in [libm::ldexpf(1.0, -60), libm::ldexpf(1.0, 60)] {
        let (second, first) = designs(0.01);
        assert_scale_does_not_matter(&second, scale);
        assert_scale_does_not_matter(&first, scale);
        assert_scale_does_not_matter(&Compensated(second), scale);
        assert_scale_does_not_matter(&Compensated(first), scale);
    }
}

#[test]
fn subnormal_inputs_are_followed_to_the_last_subnormal() {
    let input = 1e-40_f32;
    let unit = f32::from_bits(1);
    let (second, first) = designs(0.2);
    let (mut second_state, mut first_state) = (second.at_rest(0.0), first.at_rest(0.0));
    let outputs = (0..200).map(|_| (second.step(&mut second_state, input), first.step(&mut first_state, input))).last();
    let (of_second, of_first) = outputs.unwrap();
    // An increment below half the smallest subnormal is lost, as it is at any other scale below half a unit.
    assert!(
        (of_second - input).abs() <= 4.0 * unit && (of_first - input).abs() <= 4.0 * unit,
        "{of_second} {of_first}"
    );
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
