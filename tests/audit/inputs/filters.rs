//! What the low-passes are asked: one sample at a time, each form the same samples.

use firmware_stub::kernels::{self, Average, EWMA_SAMPLES, Kernel, Request};
use monitor_core::ewma::Ewma;
use monitor_core::low_pass::{Compensated, FirstOrder, LowPass};
use monitor_core::smoother::Smoother;

use super::{NASTY, Question};

/// `LowPass::step`, one filter of four in a step of the monitor.
pub const FILTER: &str = "low_pass";
/// `FirstOrder::step`.
pub const FIRST_ORDER: &str = "first_order";
/// `Compensated<LowPass>::step`.
pub const COMPENSATED: &str = "low_pass_compensated";
/// `Compensated<FirstOrder>::step`.
pub const COMPENSATED_FIRST_ORDER: &str = "first_order_compensated";
/// `MovingAverage::step`; one path but where its interval ends.
pub const MOVING_AVERAGE: &str = "moving_average";
/// `Ewma::step` of three channels.
pub const EWMA: &str = "ewma_of_three";

/// Inputs of a filter: T2 in control, alarms, and at the end what its state never forgets.
pub fn residuals(count: usize) -> impl Iterator<Item = f32> {
    let mut samples = kernels::healthy(13);
    (0..count).map(move |k| match k {
        _ if k + 200 > count && k % 5 == 0 => NASTY[k / 5 % NASTY.len()],
        _ if k % 50 < 10 => 100.0,
        _ if k % 50 == 11 => [0.0, 1e-40, 1e-20, 1e9, -1e38, 1e38][k / 50 % 6],
        _ => 1.0 + samples.next().map_or(0.0, |x| x[1] - 2.0),
    })
}

/// `count` samples through each form.
#[must_use]
pub fn filtered(count: usize) -> Vec<Question> {
    let config = kernels::config();
    let (Ok(second), Ok(first)) = (
        LowPass::butterworth(config.cutoff_hz, config.sample_rate_hz),
        FirstOrder::butterworth(config.cutoff_hz, config.sample_rate_hz),
    ) else {
        return Vec::new();
    };
    let Ok(average) = Average::new(16) else { return Vec::new() };
    [
        through(Kernel::Filter, FILTER, &second, count),
        through(Kernel::FirstOrder, FIRST_ORDER, &first, count),
        through(Kernel::CompensatedFilter, COMPENSATED, &Compensated(second), count),
        through(Kernel::CompensatedFirstOrder, COMPENSATED_FIRST_ORDER, &Compensated(first), count),
        through(Kernel::MovingAverage, MOVING_AVERAGE, &average, count),
        smoothed(count),
    ]
    .concat()
}

fn through<S: Smoother>(kernel: Kernel, label: &'static str, design: &S, count: usize) -> Vec<Question> {
    let mut state = design.at_rest(1.0);
    let asked = residuals(count).map(|x| Question {
        request: Request::new(kernel, &[x]),
        label,
        expected: Some(kernels::digest_of_numbers([design.step(&mut state, x)])),
    });
    asked.collect()
}

/// Three channels, each the residuals from another place on.
fn smoothed(count: usize) -> Vec<Question> {
    let Ok(design) = Ewma::with_time_constant(EWMA_SAMPLES, 1.0) else { return Vec::new() };
    let channels = residuals(count).zip(residuals(count + 7).skip(7)).zip(residuals(count + 19).skip(19));
    let mut state = [0.0; 3];
    let asked = channels.map(|((a, b), c)| {
        design.step(false, &mut state, [a, b, c]);
        let expected = Some(kernels::digest_of_numbers(state));
        Question { request: Request::new(Kernel::Ewma, &[a, b, c]), label: EWMA, expected }
    });
    asked.collect()
}
