//! How accurate each form of the low-pass is, against another structure in `f64`. `NUMERICS.md` quotes what
//! `the_accuracy_table` and `a_hundred_million_samples` print; they are long and run on demand:
//!
//! `cargo test --release -p monitor-core -- --ignored --nocapture low_pass`

use super::*;
use crate::smoother::Smoother;
use core::f64::consts::{PI, SQRT_2, TAU};

extern crate std;
use std::vec::Vec;
use std::{eprintln, format, string::String};

/// Trapezoidal integrators in `f64` (Zavalishin, The Art of VA Filter Design, 2018, 3.10 and 4.4): the same transfer
/// functions by another structure, which stays accurate at any cutoff.
struct Reference {
    order: u8,
    g: f64,
    s1: f64,
    s2: f64,
}

impl Reference {
    fn at_rest(order: u8, cutoff: f32, value: f64) -> Self {
        let g = libm::tan(PI * f64::from(cutoff));
        if order == 1 { Reference { order, g, s1: value, s2: 0.0 } } else { Reference { order, g, s1: 0.0, s2: value } }
    }

    fn step(&mut self, x: f64) -> f64 {
        if self.order == 1 {
            let v = (x - self.s1) * self.g / (1.0 + self.g);
            let y = v + self.s1;
            self.s1 = y + v;
            return y;
        }
        let a1 = 1.0 / (1.0 + self.g * (self.g + SQRT_2));
        let v1 = a1 * self.s1 + a1 * self.g * (x - self.s2);
        let v2 = self.s2 + self.g * v1;
        (self.s1, self.s2) = (2.0 * v1 - self.s1, 2.0 * v2 - self.s2);
        v2
    }
}

/// Samples after which a step has come to rest: twenty time constants, e^-20 = 2e-9.
fn settling(cutoff: f32) -> usize {
    (20.0 / (TAU * f64::from(cutoff) * core::f64::consts::FRAC_1_SQRT_2)) as usize + 100
}

/// Steps up and down, below, across and above a power of two, where a unit in the last place is largest.
const STEPS: [(f32, f32); 5] = [(0.0, 1.0), (1.0, 1.3), (0.0, 1.01), (2.5, 1.0), (7.9, 4.05)];

/// The largest error of the step responses, and of their ends alone (the DC gain), relative to the larger level.
fn step_errors<S: Smoother>(filter: &S, order: u8, cutoff: f32) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for (from, to) in STEPS {
        let mut state = filter.at_rest(from);
        let mut reference = Reference::at_rest(order, cutoff, from.into());
        let scale = f64::from(from.max(to));
        for _ in 0..settling(cutoff) {
            let error = f64::from(filter.step(&mut state, to)) - reference.step(to.into());
            worst[0] = worst[0].max(error.abs() / scale);
        }
        let last = f64::from(filter.step(&mut state, to)) / f64::from(to) - 1.0;
        worst[1] = worst[1].max(last.abs());
    }
    worst
}

/// |H of the filter - H of the reference| at a frequency: the component at that frequency of the difference between
/// their outputs, for a sine about one, over whole periods once the start has died out.
fn response_error<S: Smoother>(filter: &S, order: u8, cutoff: f32, frequency_over_cutoff: f64) -> f64 {
    let period = libm::round(1.0 / (f64::from(cutoff) * frequency_over_cutoff)).max(2.0);
    let skipped = libm::ceil(settling(cutoff) as f64 / period) as usize * period as usize;
    let periods = usize::max(1, 2000 / period as usize);
    let (mut state, mut reference) = (filter.at_rest(1.0), Reference::at_rest(order, cutoff, 1.0));
    let (mut real, mut imaginary, mut count) = (0.0, 0.0, 0.0);
    for k in 0..skipped + periods * period as usize {
        let phase = TAU * (k % period as usize) as f64 / period + 0.5;
        let input = 1.0 + libm::sin(phase) as f32;
        let error = f64::from(filter.step(&mut state, input)) - reference.step(input.into());
        if k >= skipped {
            real += error * libm::cos(phase);
            imaginary += error * libm::sin(phase);
            count += 1.0;
        }
    }
    // Half the period of two: the sine there has no quadrature, and twice the power.
    let norm = if period > 2.0 { 2.0 } else { 1.0 };
    norm * libm::hypot(real, imaginary) / count
}

fn worst_response_error<S: Smoother>(filter: &S, order: u8, cutoff: f32) -> f64 {
    let below_half = |ratio: &f64| ratio * f64::from(cutoff) <= 0.5;
    [0.1, 0.5, 1.0, 2.0, 10.0]
        .into_iter()
        .filter(below_half)
        .map(|ratio| response_error(filter, order, cutoff, ratio))
        .fold(0.0, f64::max)
}

/// Mean and largest magnitude of the error over noise: squares of uniform numbers, one on average, as T2 is.
fn noise_errors<S: Smoother>(filter: &S, order: u8, cutoff: f32, samples: u64) -> [f64; 2] {
    let (mut state, mut reference) = (filter.at_rest(1.0), Reference::at_rest(order, cutoff, 1.0));
    let (mut draw, mut sum, mut worst) = (1_u64, 0.0_f64, 0.0_f64);
    for _ in 0..samples {
        draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407); // Knuth's MMIX
        let uniform = (draw >> 40) as f32 * (1.0 / 16_777_216.0);
        let input = 3.0 * uniform * uniform;
        let error = f64::from(filter.step(&mut state, input)) - reference.step(input.into());
        sum += error;
        worst = worst.max(error.abs());
    }
    [sum / samples as f64, worst]
}

fn designs(cutoff: f32) -> (LowPass, FirstOrder) {
    (LowPass::butterworth(cutoff, 1.0).unwrap(), FirstOrder::butterworth(cutoff, 1.0).unwrap())
}

/// The plain forms meet 1e-4 down to these cutoffs; below, the compensated forms are needed.
const PLAIN_SECOND_FROM: f32 = 1.4e-4;
const PLAIN_FIRST_FROM: f32 = 1e-4;

#[test]
fn step_and_frequency_responses_are_within_1e_4_of_f64_from_5e_5_to_0_45() {
    for cutoff in [0.45, 0.2, 0.02, 1e-3, 2e-4, 1.4e-4, 1e-4, 5e-5] {
        let (second, first) = designs(cutoff);
        let check = |form: &str, bound: f64, [step, dc]: [f64; 2], response: f64| {
            let worst = step.max(dc).max(response);
            assert!(worst <= bound, "{form} at fc/fs {cutoff}: step {step:e}, DC {dc:e}, response {response:e}");
        };
        let slow = Compensated(second);
        check("second", 2e-6, step_errors(&slow, 2, cutoff), worst_response_error(&slow, 2, cutoff));
        let slow = Compensated(first);
        check("first", 2e-6, step_errors(&slow, 1, cutoff), worst_response_error(&slow, 1, cutoff));
        if cutoff >= PLAIN_SECOND_FROM {
            check("plain second", 1e-4, step_errors(&second, 2, cutoff), worst_response_error(&second, 2, cutoff));
        }
        if cutoff >= PLAIN_FIRST_FROM {
            check("plain first", 1e-4, step_errors(&first, 1, cutoff), worst_response_error(&first, 1, cutoff));
        }
    }
}

#[test]
fn the_compensated_dc_gain_is_one_to_1e_6_down_to_a_millionth_of_the_sampling_rate() {
    for cutoff in [1e-5, 1e-6] {
        let (second, first) = designs(cutoff);
        for (order, [_, dc]) in
            [(2, step_errors(&Compensated(second), 2, cutoff)), (1, step_errors(&Compensated(first), 1, cutoff))]
        {
            assert!(dc <= 1e-6, "order {order} at fc/fs {cutoff}: {dc:e}");
        }
        // What the compensation is for: the plain form is wrong by far more.
        assert!(step_errors(&second, 2, cutoff)[1] > 1e-4 && step_errors(&first, 1, cutoff)[1] > 1e-4);
    }
}

#[test]
fn a_million_samples_of_noise_do_not_make_the_output_drift() {
    let (second, first) = designs(1e-3);
    for [mean, worst] in [noise_errors(&second, 2, 1e-3, 1_000_000), noise_errors(&first, 1, 1e-3, 1_000_000)] {
        assert!(mean.abs() <= 2e-6 && worst <= 2e-5, "mean {mean:e}, worst {worst:e}");
    }
    let (second, first) = designs(5e-5);
    let (second, first) = (Compensated(second), Compensated(first));
    for [mean, worst] in [noise_errors(&second, 2, 5e-5, 1_000_000), noise_errors(&first, 1, 5e-5, 1_000_000)] {
        assert!(mean.abs() <= 2e-7 && worst <= 1e-6, "mean {mean:e}, worst {worst:e}");
    }
}

fn row<S: Smoother>(filter: &S, order: u8, cutoff: f32) -> String {
    let [step, dc] = step_errors(filter, order, cutoff);
    let response = worst_response_error(filter, order, cutoff);
    format!("{cutoff:>8e} | {step:.1e} | {response:.1e} | {dc:.1e}")
}

#[test]
#[ignore = "prints the table of NUMERICS.md: a minute"]
fn the_accuracy_table_of_the_low_pass() {
    for cutoff in [0.45, 0.2, 0.02, 1e-3, 2e-4, 1.4e-4, 1e-4, 5e-5, 1e-5, 1e-6] {
        let (second, first) = designs(cutoff);
        eprintln!("first          | {}", row(&first, 1, cutoff));
        eprintln!("first, comp.   | {}", row(&Compensated(first), 1, cutoff));
        eprintln!("second         | {}", row(&second, 2, cutoff));
        eprintln!("second, comp.  | {}", row(&Compensated(second), 2, cutoff));
    }
}

#[test]
#[ignore = "takes minutes: 1e8 samples through each form"]
fn a_hundred_million_samples_of_noise_do_not_make_the_low_pass_drift() {
    let mut failures = Vec::new();
    let mut check = |form: &str, cutoff: f32, bound: f64, errors: &dyn Fn(u64) -> [f64; 2]| {
        let [[short_mean, short], [mean, worst]] = [1_000_000, 100_000_000].map(errors);
        eprintln!("{form} at {cutoff:e}: mean {short_mean:.1e} then {mean:.1e}, worst {short:.1e} then {worst:.1e}");
        if worst > bound {
            failures.push(format!("{form} at {cutoff:e}: {worst:e} is above {bound:e}"));
        }
    };
    for (cutoff, bound) in [(1e-3, 2e-5), (2e-4, 1e-4)] {
        let (second, first) = designs(cutoff);
        check("second", cutoff, bound, &|n| noise_errors(&second, 2, cutoff, n));
        check("first", cutoff, bound, &|n| noise_errors(&first, 1, cutoff, n));
    }
    for cutoff in [1e-3, 5e-5, 1e-6] {
        let (second, first) = designs(cutoff);
        check("compensated second", cutoff, 1e-6, &|n| noise_errors(&Compensated(second), 2, cutoff, n));
        check("compensated first", cutoff, 1e-6, &|n| noise_errors(&Compensated(first), 1, cutoff, n));
    }
    assert!(failures.is_empty(), "{failures:?}");
}
