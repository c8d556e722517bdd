//! What the quantiles and the control limits are asked, which a board computes once: a grid over the range in which they
//! answer, its ends, and beside each argument everything that they must refuse.

use firmware_stub::kernels::{self, Kernel, Request};
use monitor_core::ewma::Ewma;
use monitor_core::limit::{self, Statistic};
use monitor_core::quantile;

use super::{NASTY, Question};

/// Inputs of each function.
const INPUTS: usize = 1000;

/// The range of one argument: from, to.
type Range = [f32; 2];

/// A tail, by its decimal logarithm.
const TAIL: Range = [-12.0, -1.0];
/// Degrees of freedom of a numerator.
const DEGREES: Range = [1.0, 50.0];

/// A function, and where it answers.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// What is asked.
    pub kernel: Kernel,
    /// Name of its row.
    pub label: &'static str,
    /// One range for each argument; the first is that of a tail, if `of_tail`.
    ranges: &'static [Range],
    of_tail: bool,
    /// Inputs that are within all ranges: the costly ones.
    answered: usize,
    host: fn(&[f32; 6]) -> Option<f32>,
}

/// All of them.
pub const AT_START_UP: [Function; 6] = [
    Function {
        kernel: Kernel::UpperNormal,
        label: "upper_normal",
        ranges: &[TAIL],
        of_tail: true,
        answered: 240,
        host: |a| quantile::upper_normal(a[0]).ok(),
    },
    Function {
        kernel: Kernel::UpperChiSquare,
        label: "upper_chi_square",
        ranges: &[TAIL, DEGREES],
        of_tail: true,
        answered: 240,
        host: |a| quantile::upper_chi_square(a[0], a[1]).ok(),
    },
    Function {
        kernel: Kernel::UpperF,
        label: "upper_f",
        ranges: &[TAIL, DEGREES, [10.0, 1e6]],
        of_tail: true,
        answered: 240,
        host: |a| quantile::upper_f(a[0], a[1], a[2]).ok(),
    },
    Function {
        kernel: Kernel::T2Limit,
        label: "t2_limit",
        ranges: &[TAIL, DEGREES, [60.0, 1e6]],
        of_tail: true,
        answered: 240,
        host: |a| limit::t2_limit(a[0], a[1] as usize, a[2] as u32).ok(),
    },
    Function {
        kernel: Kernel::FilteredLimit,
        label: "filtered_limit",
        ranges: &[[0.5, 2.0], [0.2, 2.0], [0.5, 4.0], [0.5, 40.0], [1000.0, 2000.0], [100.0, 36_000.0]],
        of_tail: false,
        answered: 240,
        host: filtered_limit,
    },
    Function {
        kernel: Kernel::SmoothedLimit,
        label: "smoothed_t2_limit",
        ranges: &[[0.0, 1e5], [1.0, 3.0], [12.0, 1e5], [1e3, 1e11]],
        of_tail: false,
        answered: 48, // seven quantiles each
        host: |a| {
            let smoother = Ewma::with_time_constant(a[0], 1.0).ok()?;
            limit::smoothed_t2_limit(&smoother, a[1] as u8, a[2], a[3]).ok()
        },
    },
];

/// A thousand inputs of each function.
#[must_use]
pub fn start_up() -> Vec<Question> {
    AT_START_UP.iter().flat_map(Function::questions).collect()
}

fn filtered_limit(&[mean, variance, factor, cutoff_hz, sample_rate_hz, interval_s]: &[f32; 6]) -> Option<f32> {
    let statistic = Statistic::measured(mean, variance, factor).ok()?;
    limit::filtered_limit(statistic, cutoff_hz, sample_rate_hz, interval_s).ok()
}

impl Function {
    fn questions(&self) -> Vec<Question> {
        (0..INPUTS).map(|k| self.question(if k < self.answered { self.within(k) } else { self.beside(k) })).collect()
    }

    /// Both ends of each range and, by golden ratios, what lies between.
    fn within(&self, k: usize) -> [f32; 6] {
        let corners = 1 << self.ranges.len();
        let mut arguments = [0.0; 6];
        for (place, (argument, [from, to])) in arguments.iter_mut().zip(self.ranges).enumerate() {
            let share = match k {
                _ if k < corners => (k >> place & 1) as f32,
                _ => (k as f32 * (0.618_034 + 0.131 * place as f32)).fract(),
            };
            *argument = self.argument(place, from + share * (to - from));
        }
        arguments
    }

    fn argument(&self, place: usize, value: f32) -> f32 {
        // The largest power of ten would be rounded beyond the range.
        if self.of_tail && place == 0 { 10.0_f32.powf(value).clamp(1e-12, 0.1) } else { value }
    }

    /// The same with nasty bits in one argument; in one of three, any bits at all.
    fn beside(&self, k: usize) -> [f32; 6] {
        let mut arguments = self.within(k);
        let any = f32::from_bits((k as u32).wrapping_mul(0x9e37_79b9));
        let nasty = if k.is_multiple_of(3) { any } else { NASTY[k % NASTY.len()] };
        if let Some(argument) = arguments.get_mut(k % self.ranges.len()) {
            *argument = nasty;
        }
        arguments
    }

    fn question(&self, arguments: [f32; 6]) -> Question {
        let answer = (self.host)(&arguments).unwrap_or(f32::NAN);
        Question {
            request: Request::new(self.kernel, &arguments),
            label: self.label,
            expected: Some(kernels::digest_of_numbers([answer])),
        }
    }
}
