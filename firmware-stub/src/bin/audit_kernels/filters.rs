//! The low-passes of `monitor-core`, one sample each.

#![allow(unsafe_code)] // Unmangled names, which the host looks for; nothing else has them.

use firmware_stub::kernels::{self, Average, Kernel};
use monitor_core::ewma::Ewma;
use monitor_core::low_pass::{Compensated, FirstOrder, LowPass};
use monitor_core::smoother::Smoother;

/// A filter with its state.
struct Filter<S: Smoother> {
    design: S,
    state: S::State,
}

impl<S: Smoother> Filter<S> {
    fn new(design: S) -> Self {
        Filter { state: design.at_rest(1.0), design }
    }

    #[inline(always)]
    fn step(&mut self, input: f32) -> f32 {
        self.design.step(&mut self.state, input)
    }
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_filter(filter: &mut Filter<LowPass>, input: &f32) -> f32 {
    filter.step(*input)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_first_order(filter: &mut Filter<FirstOrder>, input: &f32) -> f32 {
    filter.step(*input)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_compensated(filter: &mut Filter<Compensated<LowPass>>, input: &f32) -> f32 {
    filter.step(*input)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_compensated_first_order(filter: &mut Filter<Compensated<FirstOrder>>, input: &f32) -> f32 {
    filter.step(*input)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_moving_average(filter: &mut Filter<Average>, input: &f32) -> f32 {
    filter.step(*input)
}

/// An exponential smoother with its state.
struct Smoothed {
    design: Ewma,
    state: [f32; 3],
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_ewma(smoothed: &mut Smoothed, input: &[f32; 3]) {
    smoothed.design.step(false, &mut smoothed.state, *input);
}

/// One of each form.
pub(crate) struct Filters {
    second: Filter<LowPass>,
    first: Filter<FirstOrder>,
    compensated: Filter<Compensated<LowPass>>,
    compensated_first: Filter<Compensated<FirstOrder>>,
    average: Filter<Average>,
    smoothed: Smoothed,
}

impl Filters {
    pub(crate) fn new(cutoff_hz: f32, sample_rate_hz: f32) -> Option<Self> {
        let second = LowPass::butterworth(cutoff_hz, sample_rate_hz).ok()?;
        let first = FirstOrder::butterworth(cutoff_hz, sample_rate_hz).ok()?;
        Some(Filters {
            second: Filter::new(second),
            first: Filter::new(first),
            compensated: Filter::new(Compensated(second)),
            compensated_first: Filter::new(Compensated(first)),
            average: Filter::new(Average::new(16).ok()?),
            smoothed: Smoothed { design: Ewma::with_time_constant(kernels::EWMA_SAMPLES, 1.0).ok()?, state: [0.0; 3] },
        })
    }

    /// Takes a step of the kernel's filter; returns the digest of its output.
    pub(crate) fn call(&mut self, kernel: Kernel, channels: [f32; 3]) -> u32 {
        let [input, ..] = channels;
        let output = match kernel {
            Kernel::Ewma => {
                audit_ewma(&mut self.smoothed, &channels);
                return kernels::digest_of_numbers(self.smoothed.state);
            }
            Kernel::MovingAverage => audit_moving_average(&mut self.average, &input),
            Kernel::Filter => audit_filter(&mut self.second, &input),
            Kernel::FirstOrder => audit_first_order(&mut self.first, &input),
            Kernel::CompensatedFilter => audit_compensated(&mut self.compensated, &input),
            Kernel::CompensatedFirstOrder => audit_compensated_first_order(&mut self.compensated_first, &input),
            _ => return 0,
        };
        kernels::digest_of_numbers([output])
    }
}
