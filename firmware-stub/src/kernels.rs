//! What a host asks of the firmware `audit-kernels`: which audited function to call, with which input.
//!
//! Host to board: one word, how many requests follow; then the requests, [`REQUEST_WORDS`] words each. Board to host: one
//! word for each request, a digest of the result, so that the host knows that what was traced is what it computes itself.

use monitor_core::moving_average::MovingAverage;
use monitor_core::paper::{Config, Verdict};
use monitor_core::sample::{Bank, PerPair};

use crate::record;

pub mod guard;

/// Words of a request: the kernel, then its input.
pub const REQUEST_WORDS: usize = 8;

/// Declares the kernels with the symbol of the function that each request calls.
macro_rules! kernels {
    ($($(#[doc = $doc:literal])* $kernel:ident = $symbol:literal,)*) => {
        /// An audited function, or a thing that the firmware does between two of them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Kernel { $($(#[doc = $doc])* $kernel,)* }

        impl Kernel {
            /// All of them; a request names a kernel by its place here.
            pub const ALL: &[Kernel] = &[$(Kernel::$kernel,)*];

            /// The symbol of the function that is called; empty if none is.
            #[must_use]
            pub const fn symbol(self) -> &'static str {
                match self { $(Kernel::$kernel => $symbol,)* }
            }
        }
    };
}

kernels! {
    /// A new monitor, filter and window: no call.
    Restart = "",
    /// `Monitor::step_channels`, which every image calls in flash as this function; input: set point, three channels.
    Step = "<monitor_core::paper::monitor::Monitor>::slot",
    /// `Monitor::finish_learning`.
    FinishLearning = "audit_finish_learning",
    /// `guard::Monitor::step_channels`, which every image calls in flash as this function; input: set point, three channels.
    GuardStep = "<monitor_core::guard::Monitor>::slot",
    /// `guard::Monitor::finish_learning`: `Model::learn` of the window, and the model put in its place.
    GuardFinishLearning = "audit_guard_finish_learning",
    /// `guard::Monitor::finding`.
    GuardFinding = "audit_guard_finding",
    /// A copy of `guard::Monitor`, for which a board holds its sampling interrupt off.
    GuardCopy = "audit_guard_copy",
    /// `guard::Monitor::install` of a copy, for which it does so as well.
    GuardInstall = "audit_guard_install",
    /// `Moments::push`; input: three channels.
    Push = "audit_push",
    /// A new window for `Push`: no call.
    ClearWindow = "",
    /// `Baseline::learn` of what was pushed.
    WindowEnd = "audit_window_end",
    /// `decompose` 2x2; input: the lower triangle by rows.
    Eigen2 = "audit_eigen2",
    /// `decompose` 3x3; input: the lower triangle by rows.
    Eigen3 = "audit_eigen3",
    /// `decompose_correlation` 2x2; input as of `Eigen2`.
    Correlation2 = "audit_correlation2",
    /// `decompose_correlation` 3x3; input as of `Eigen3`.
    Correlation3 = "audit_correlation3",
    /// `LowPass::step`; input: one number.
    Filter = "audit_filter",
    /// `FirstOrder::step`; input: one number.
    FirstOrder = "audit_first_order",
    /// `Compensated<LowPass>::step`; input: one number.
    CompensatedFilter = "audit_compensated",
    /// `Compensated<FirstOrder>::step`; input: one number.
    CompensatedFirstOrder = "audit_compensated_first_order",
    /// `MovingAverage::step`; input: one number.
    MovingAverage = "audit_moving_average",
    /// `Ewma::step` of three channels; input: three channels.
    Ewma = "audit_ewma",
    /// `Model::t2` of a sample, the mean taken off; input: three channels.
    T2 = "audit_t2",
    /// `quantile::upper_normal`; input: the tail probability.
    UpperNormal = "audit_upper_normal",
    /// `quantile::upper_chi_square`; input: the tail probability, the degrees of freedom.
    UpperChiSquare = "audit_upper_chi_square",
    /// `quantile::upper_f`; input: the tail probability, the degrees of freedom of numerator and denominator.
    UpperF = "audit_upper_f",
    /// `limit::t2_limit`; input: the probability of a false alarm, the components and the samples, rounded down.
    T2Limit = "audit_t2_limit",
    /// `limit::filtered_limit`; input: mean, variance and autocorrelation factor, cutoff and sampling rate, interval.
    FilteredLimit = "audit_filtered_limit",
    /// `limit::smoothed_t2_limit`; input: the time constant in samples, channels, degrees of freedom, interval in samples.
    SmoothedLimit = "audit_smoothed_limit",
    /// Peer: nalgebra's `SymmetricEigen` 2x2; input as of `Eigen2`.
    NalgebraEigen2 = "audit_nalgebra_eigen2",
    /// Peer: nalgebra's `SymmetricEigen` 3x3; input as of `Eigen3`.
    NalgebraEigen3 = "audit_nalgebra_eigen3",
    /// Peer: T2 as nalgebra's matrix product with the inverse covariance; input: three channels.
    NalgebraT2 = "audit_nalgebra_t2",
    /// Peer: the `biquad` crate, direct form II transposed; input: one number.
    Biquad = "audit_biquad",
    /// Peer: the whole chain with nalgebra and `biquad`; input: three channels.
    Textbook = "audit_textbook",
    /// Peer in C: T2 with the inverse covariance, as emlearn computes it; input: three channels.
    CMatrixT2 = "audit_c_t2_matrix",
    /// Peer in C: T2 in triangular form; input: three channels.
    CTriangleT2 = "audit_c_t2_triangle",
    /// Peer in C: a biquad, as CMSIS-DSP's direct form II transposed; input: one number.
    CBiquad = "audit_c_biquad",
    /// Specimen of an audit's test: a loop whose length depends on its input; input: one number.
    Branching = "audit_branching",
    /// Specimen: a limit by a select; input: one number.
    Selecting = "audit_selecting",
    /// Specimen: a table that is indexed by the input; input: one number.
    Indexing = "audit_indexing",
    /// Specimen: a loop whose length depends on the input of the call before; input: one number.
    Remembering = "audit_remembering",
}

/// One request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// What to call.
    pub kernel: Kernel,
    /// Its input, as the bits of numbers; the rest is zero.
    pub input: [u32; REQUEST_WORDS - 1],
}

impl Request {
    /// A request with numbers as input; those that do not fit are left out.
    #[must_use]
    pub fn new(kernel: Kernel, numbers: &[f32]) -> Self {
        let mut input = [0; REQUEST_WORDS - 1];
        for (word, number) in input.iter_mut().zip(numbers) {
            *word = number.to_bits();
        }
        Request { kernel, input }
    }

    /// The request as words.
    #[must_use]
    pub fn to_words(&self) -> [u32; REQUEST_WORDS] {
        let [a, b, c, d, e, f, g] = self.input;
        [self.kernel as u32, a, b, c, d, e, f, g]
    }

    /// Reads a request; none when the words are not one.
    #[must_use]
    pub fn from_words(words: [u32; REQUEST_WORDS]) -> Option<Self> {
        let [kernel, input @ ..] = words;
        let kernel = *Kernel::ALL.get(kernel as usize)?;
        Some(Request { kernel, input })
    }

    /// The input as numbers.
    #[must_use]
    pub fn numbers(&self) -> [f32; REQUEST_WORDS - 1] {
        self.input.map(f32::from_bits)
    }

    /// The first three numbers.
    #[must_use]
    pub fn channels(&self) -> [f32; 3] {
        let [a, b, c, ..] = self.numbers();
        [a, b, c]
    }
}

/// Settings of the monitor: the paper's, with times so short and a filter so fast that phases and alarms change often.
#[must_use]
pub fn config() -> Config {
    let pairs = PerPair { speed_current: 1.8, current_voltage: 1.8, speed_voltage: 1.8 };
    // 8 slots to settle; 200 slots of learning, in which three blocks of 64 are merged.
    Config { settle_s: 0.008, learn_s: 0.2, cutoff_hz: 100.0, ..Config::paper(1000.0, Bank { full: 1.8, pairs }) }
}

/// The moving average that is audited, and the samples that it goes over.
pub type Average = MovingAverage<16>;

/// Time constant of the exponential smoother that is audited, seconds at a sample each.
pub const EWMA_SAMPLES: f32 = 64.0;

/// Where the default motor works: rad/s, A, V.
pub const SET_POINT: f32 = 300.0;

/// Mean of the healthy samples: speed, armature current, armature voltage.
pub const HEALTHY_MEAN: [f32; 3] = [SET_POINT, 2.0, 10.0];

/// Reproducible, correlated samples around the default motor's operating point, without end.
pub fn healthy(seed: u32) -> impl Iterator<Item = [f32; 3]> + Clone {
    let mut state = seed;
    let mut uniform = move || {
        // Numerical Recipes' generator; its upper bits are good enough for noise.
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let [speed, current, voltage] = HEALTHY_MEAN;
    core::iter::repeat_with(move || {
        let (a, b, c) = (uniform(), uniform(), uniform());
        [speed + 0.2 * a, current + 0.02 * (a + b), voltage + 0.02 * (c - b)]
    })
}

/// A digest of a result (FNV-1a by words).
#[must_use]
pub fn digest(words: impl IntoIterator<Item = u32>) -> u32 {
    words.into_iter().fold(0x811c_9dc5, |digest, word| (digest ^ word).wrapping_mul(0x0100_0193))
}

/// The digest of numbers. All NaNs count as one: which of two a sum hands on differs between processors.
#[must_use]
pub fn digest_of_numbers(numbers: impl IntoIterator<Item = f32>) -> u32 {
    digest(numbers.into_iter().map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }))
}

/// The digest of a verdict.
#[must_use]
pub fn digest_of_verdict(verdict: &Verdict) -> u32 {
    digest(record::verdict_to_words(verdict))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read_as_it_was_written_and_anything_else_is_refused() {
        for (place, kernel) in Kernel::ALL.iter().enumerate() {
            assert_eq!(*kernel as usize, place);
            let request = Request::new(*kernel, &[1.0, -2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
            assert_eq!(Request::from_words(request.to_words()), Some(request));
        }
        assert_eq!(Request::from_words([Kernel::ALL.len() as u32, 0, 0, 0, 0, 0, 0, 0]), None);
    }
}
