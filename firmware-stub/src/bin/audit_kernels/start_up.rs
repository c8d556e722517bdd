//! What `monitor-core` computes once, at start-up: quantiles and control limits. A refusal is answered by a NaN.

#![allow(unsafe_code)] // Unmangled names, which the host looks for; nothing else has them.

use firmware_stub::kernels::{self, Kernel, Request};
use monitor_core::ewma::Ewma;
use monitor_core::limit::{self, Statistic};
use monitor_core::quantile;

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_upper_normal(tail_probability: f32) -> f32 {
    quantile::upper_normal(tail_probability).unwrap_or(f32::NAN)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_upper_chi_square(tail_probability: f32, degrees_of_freedom: f32) -> f32 {
    quantile::upper_chi_square(tail_probability, degrees_of_freedom).unwrap_or(f32::NAN)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_upper_f(tail_probability: f32, numerator: f32, denominator: f32) -> f32 {
    quantile::upper_f(tail_probability, numerator, denominator).unwrap_or(f32::NAN)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_t2_limit(false_alarm_probability: f32, retained: usize, samples: u32) -> f32 {
    limit::t2_limit(false_alarm_probability, retained, samples).unwrap_or(f32::NAN)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_filtered_limit(moments: &[f32; 3], cutoff_hz: f32, sample_rate_hz: f32, interval_s: f32) -> f32 {
    let [mean, variance, autocorrelation_factor] = *moments;
    let statistic = Statistic::measured(mean, variance, autocorrelation_factor);
    let found = statistic.and_then(|known| limit::filtered_limit(known, cutoff_hz, sample_rate_hz, interval_s));
    found.unwrap_or(f32::NAN)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_smoothed_limit(samples: f32, channels: u8, degrees_of_freedom: f32, interval: f32) -> f32 {
    let Ok(smoother) = Ewma::with_time_constant(samples, 1.0) else { return f32::NAN };
    limit::smoothed_t2_limit(&smoother, channels, degrees_of_freedom, interval).unwrap_or(f32::NAN)
}

/// Calls a kernel; returns the digest of its result.
pub(crate) fn call(request: &Request) -> u32 {
    let [a, b, c, d, e, f, _] = request.numbers();
    let result = match request.kernel {
        Kernel::UpperNormal => audit_upper_normal(a),
        Kernel::UpperChiSquare => audit_upper_chi_square(a, b),
        Kernel::UpperF => audit_upper_f(a, b, c),
        Kernel::T2Limit => audit_t2_limit(a, b as usize, c as u32),
        Kernel::FilteredLimit => audit_filtered_limit(&[a, b, c], d, e, f),
        Kernel::SmoothedLimit => audit_smoothed_limit(a, b as u8, c, d),
        _ => return 0,
    };
    kernels::digest_of_numbers([result])
}
