//! What the audited functions are asked: ordinary samples, and everything that a broken sensor, a converter at its rail or
//! a degenerate matrix can bring.
//!
//! The host computes the same beside it: that gives each call its label (which phase, whether an alarm switched), and the
//! result that the firmware must answer.

mod filters;
mod guard;
mod start_up;

use firmware_stub::kernels::{self, Kernel, Request, SET_POINT};
use monitor_core::eigen::{ClosedFormEigen, Decomposition};
use monitor_core::hotelling::Model;
use monitor_core::moments::Moments;
use monitor_core::paper::{Monitor, Phase, Verdict};
use monitor_core::pca::{ExplainedShare, Pca};
use monitor_core::sample::Absence;
use nalgebra::{Matrix2, Matrix3};

pub use filters::{
    COMPENSATED, COMPENSATED_FIRST_ORDER, EWMA, FILTER, FIRST_ORDER, MOVING_AVERAGE, filtered, residuals,
};
pub use guard::{
    GUARD_FINDING, GUARD_LEARNING, GUARD_MONITORING, GUARD_SEEDING, GUARD_SETTLING, GUARD_TRANSITION, GUARD_TURN,
    GUARD_WINDOW_END, guard,
};
pub use start_up::{AT_START_UP, start_up};

/// A request, what it is counted as, and the answer it must get.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    /// What is asked.
    pub request: Request,
    /// Name of the row it is counted in; empty if it calls nothing or is only preparation.
    pub label: &'static str,
    /// The digest of the host's result, where the host computes the same.
    pub expected: Option<u32>,
}

impl Question {
    fn preparation(kernel: Kernel) -> Self {
        Question { request: Request::new(kernel, &[]), label: "", expected: None }
    }

    fn of_peer(kernel: Kernel, numbers: &[f32], label: &'static str) -> Self {
        Question { request: Request::new(kernel, numbers), label, expected: None }
    }
}

/// Numbers that no sensor should give, and zeros.
pub const NASTY: [f32; 14] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    1e-40,
    -1e-45,
    f32::MIN_POSITIVE,
    1e38,
    -1e38,
    f32::MAX,
    0.0,
    -0.0,
    1e9,
    -1e9,
    1e-20,
];

/// Labels of `Monitor::step_channels`.
pub const SETTLING: &str = "step_settling";
/// A routine slot of the learning window.
pub const LEARNING: &str = "step_learning";
/// Twelve slots in 64 of it: a sum joins the total.
pub const LEARNING_JOIN: &str = "step_learning_join";
/// Sums of a window: each joins its total in a slot of its own.
const SUMS: usize = 12;

/// A judged slot in which no relay switched.
pub const MONITORING: &str = "step_monitoring";
/// A judged slot in which one did.
pub const SWITCHING: &str = "step_alarm_switching";
/// A slot with which a phase begins or ends, and slots that wait for a model.
pub const TRANSITION: &str = "step_transition";
/// `Moments::push`.
pub const PUSH: &str = "learning_push";
/// The same in the twelve slots in 64 in which a sum joins the total.
pub const PUSH_JOIN: &str = "learning_push_join";
/// `Baseline::learn`.
pub const WINDOW_END: &str = "window_end";
/// The solvers, and T2.
pub const EIGEN_2: &str = "eigen_2x2";
/// See [`EIGEN_2`].
pub const EIGEN_3: &str = "eigen_3x3";
/// The solvers that learning uses: of correlation matrices.
pub const CORRELATION_2: &str = "eigen_2x2_correlation";
/// See [`CORRELATION_2`].
pub const CORRELATION_3: &str = "eigen_3x3_correlation";
/// See [`EIGEN_2`].
pub const T2: &str = "t2_of_three";

/// Flies `episodes` set points: settling, learning, and `judged` slots in which faults come and go.
#[must_use]
pub fn steps(episodes: usize, judged: usize) -> Vec<Question> {
    let Ok(monitor) = Monitor::new(&kernels::config()) else { return Vec::new() };
    let mut flight = Flight { monitor, slots: 0, last: Verdict::default(), questions: Vec::new() };
    let mut samples = kernels::healthy(7);
    let mut odd = Odd::default();
    for episode in 0..episodes {
        let mut set_point = SET_POINT + 4.0 * episode as f32;
        for slot in 0..90 {
            // It moves before the loop has settled; once it is no number.
            set_point += if slot % 7 == 0 { 0.25 } else { 0.0 };
            let x = odd.in_one_of(5, samples.next().unwrap_or_default());
            flight.step(if slot == 50 { f32::NAN } else { set_point }, x);
        }
        while flight.last.phase() != Phase::Learning {
            flight.step(set_point, samples.next().unwrap_or_default());
        }
        while flight.last.phase() != Phase::ModelDue {
            // Few outliers, or the model would take any fault for noise.
            let x = samples.next().unwrap_or_default();
            let x = if flight.slots % 9 == 8 { [odd.unfit(), x[1], x[2]] } else { x };
            flight.step(set_point, x);
        }
        flight.step(set_point, samples.next().unwrap_or_default());
        flight.finish_learning();
        for slot in 0..judged {
            let x = faulty(slot, samples.next().unwrap_or_default());
            flight.step(set_point, odd.in_one_of(9, x));
        }
    }
    flight.questions
}

/// Two slots of a fault, ten without; each fault in turn.
fn faulty(slot: usize, mut x: [f32; 3]) -> [f32; 3] {
    if slot % 12 < 2
        && let Some(channel) = x.get_mut(slot / 12 % 3)
    {
        *channel += if (slot / 36).is_multiple_of(2) { 0.8 } else { -4.0 };
    }
    x
}

/// Puts nasty numbers among others.
#[derive(Default)]
struct Odd(usize);

impl Odd {
    /// Replaces one channel of one sample in `period`.
    fn in_one_of(&mut self, period: usize, mut x: [f32; 3]) -> [f32; 3] {
        self.0 += 1;
        let turn = self.0 / period;
        if self.0.is_multiple_of(period)
            && let (Some(channel), Some(nasty)) = (x.get_mut(turn % 3), NASTY.get(turn % NASTY.len()))
        {
            *channel = *nasty;
        }
        x
    }

    /// A number that the monitor turns away.
    fn unfit(&mut self) -> f32 {
        self.0 += 1;
        [f32::NAN, f32::INFINITY, 1e38, -f32::MAX, 1e9][self.0 % 5]
    }
}

/// A monitor on the host beside that of the firmware.
struct Flight {
    monitor: Monitor,
    slots: usize,
    last: Verdict,
    questions: Vec<Question>,
}

impl Flight {
    fn step(&mut self, set_point: f32, x: [f32; 3]) {
        let verdict = *self.monitor.step_channels(set_point, x);
        let [a, b, c] = x;
        let label = match (self.last.phase(), verdict.phase()) {
            (Phase::Settling(_), Phase::Settling(_)) => SETTLING,
            (Phase::Learning, Phase::Learning) => {
                self.slots += 1;
                if (self.slots - 1) % 64 < SUMS { LEARNING_JOIN } else { LEARNING }
            }
            (Phase::Monitoring, Phase::Monitoring) if verdict.relays() == self.last.relays() => MONITORING,
            (Phase::Monitoring, Phase::Monitoring) => SWITCHING,
            _ => {
                self.slots = usize::from(verdict.phase() == Phase::Learning);
                TRANSITION
            }
        };
        self.questions.push(Question {
            request: Request::new(Kernel::Step, &[set_point, a, b, c]),
            label,
            expected: Some(kernels::digest_of_verdict(&verdict)),
        });
        self.last = verdict;
    }

    fn finish_learning(&mut self) {
        let accepted = self.monitor.finish_learning().is_ok();
        let request = Request::new(Kernel::FinishLearning, &[]);
        self.questions.push(Question { request, label: "", expected: Some(u32::from(accepted)) });
        if accepted {
            // The step after it begins in the new phase, without a transition of its own.
            self.last = *self.monitor.clone().skip(Absence::Missing);
        }
    }
}

/// Windows of 30 samples and more, with an end after each further sample; in some there is a number that no window survives.
#[must_use]
pub fn windows(count: usize, growth: usize) -> Vec<Question> {
    let mut samples = kernels::healthy(11);
    let mut questions = Vec::new();
    for window in 0..count {
        questions.push(Question::preparation(Kernel::ClearWindow));
        for slot in 0..30 + growth {
            let [a, mut b, c] = samples.next().unwrap_or_default();
            if window % 4 == 3 && slot == 20 {
                b = NASTY[window / 4 % NASTY.len()];
            }
            let label = if slot % 64 < SUMS { PUSH_JOIN } else { PUSH };
            questions.push(Question { request: Request::new(Kernel::Push, &[a, b, c]), label, expected: Some(0) });
            if slot >= 30 {
                questions.push(Question::of_peer(Kernel::WindowEnd, &[], WINDOW_END));
            }
        }
    }
    questions
}

/// Lower triangles by rows: small integers, correlations from independent to tied. All are finite.
#[must_use]
pub fn matrices() -> Vec<[f32; 6]> {
    let digit = |k: u32, place: u32| (k / 3_u32.pow(place) % 3) as f32 - 1.0;
    let mut matrices: Vec<[f32; 6]> = (0..729).map(|k| [0, 1, 2, 3, 4, 5].map(|place| digit(k, place))).collect();
    let rho = [-1.0, -0.999_999_9, -0.5, 0.0, 1e-7, 0.3, 0.999_9, 1.0_f32];
    for a in rho {
        for b in rho {
            matrices.extend(rho.map(|c| [1.0, a, 1.0, b, c, 1.0]));
        }
    }
    matrices
}

/// Matrices with a nasty number in every place, and of bits at random.
fn nasty_matrices() -> Vec<[f32; 6]> {
    let mut matrices = Vec::new();
    for nasty in NASTY {
        for place in 0..6 {
            let mut entries = [1.0, 0.5, 2.0, -0.25, 0.125, 1.5];
            entries[place] = nasty;
            matrices.push(entries);
        }
    }
    let mut state = 1_u32;
    matrices.extend((0..300).map(|_| {
        [0; 6].map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from_bits(state ^ state >> 15)
        })
    }));
    matrices
}

fn digest<const N: usize>(found: Decomposition<N>) -> u32 {
    found
        .checked()
        .map_or(0, |found| kernels::digest_of_numbers(found.values.iter().chain(found.vectors.iter()).copied()))
}

/// The solvers, the filters and T2 of `monitor-core`, `few` of each if that is given.
#[must_use]
pub fn functions(few: Option<usize>) -> Vec<Question> {
    let few = few.unwrap_or(usize::MAX);
    let mut questions = Vec::new();
    let matrices: Vec<_> = matrices().into_iter().rev().chain(nasty_matrices()).collect();
    let every = (matrices.len() / few.min(matrices.len())).max(1);
    for matrix in matrices.iter().step_by(every) {
        let [a, b, c, d, e, f] = *matrix;
        let (two, three) = (Matrix2::new(a, b, b, c), Matrix3::new(a, b, d, b, c, e, d, e, f));
        let ask = |kernel, label, expected| Question {
            request: Request::new(kernel, matrix),
            label,
            expected: Some(expected),
        };
        questions.extend([
            ask(Kernel::Eigen2, EIGEN_2, digest(two.decompose())),
            ask(Kernel::Correlation2, CORRELATION_2, digest(two.decompose_correlation())),
            ask(Kernel::Eigen3, EIGEN_3, digest(three.decompose())),
            ask(Kernel::Correlation3, CORRELATION_3, digest(three.decompose_correlation())),
        ]);
    }
    questions.extend(filtered(few.min(1200)));
    questions.extend(distances(few.min(1200)));
    questions
}

fn distances(count: usize) -> Vec<Question> {
    let window: Moments<3> = kernels::healthy(1).take(200).collect();
    let Ok(learned) = window.statistics() else { return Vec::new() };
    let Ok(pca) = Pca::of_correlation(&learned.correlation(), ExplainedShare::PAPER) else { return Vec::new() };
    let (model, mean) = (Model::new(pca, learned.sigma(), learned.samples), learned.mean);
    let mut odd = Odd::default();
    let asked = kernels::healthy(17).take(count).map(|x| {
        let x = odd.in_one_of(4, x);
        let t2 = model.t2([x[0] - mean[0], x[1] - mean[1], x[2] - mean[2]]);
        let expected = Some(kernels::digest_of_numbers([t2]));
        Question { request: Request::new(Kernel::T2, &x), label: T2, expected }
    });
    asked.collect()
}

/// The peers, on the same inputs; those in C if the firmware holds them.
#[must_use]
pub fn peers(with_c: bool) -> Vec<Question> {
    let mut questions = Vec::new();
    // Only what is finite: nalgebra's solver iterates until it converges, and a NaN never does.
    for matrix in matrices() {
        let [a, b, c, ..] = matrix;
        questions.push(Question::of_peer(Kernel::NalgebraEigen2, &[a, b, c], "nalgebra SymmetricEigen 2x2"));
        questions.push(Question::of_peer(Kernel::NalgebraEigen3, &matrix, "nalgebra SymmetricEigen 3x3"));
    }
    let mut odd = Odd::default();
    for (x, residual) in kernels::healthy(17).zip(residuals(1200)) {
        let x = odd.in_one_of(4, x);
        questions.push(Question::of_peer(Kernel::NalgebraT2, &x, "nalgebra T2 of three, matrix form"));
        questions.push(Question::of_peer(Kernel::Biquad, &[residual], "crate biquad, one sample"));
        questions.push(Question::of_peer(Kernel::Textbook, &x, "whole chain, nalgebra and biquad"));
        if with_c {
            questions.push(Question::of_peer(Kernel::CMatrixT2, &x, "C: T2 of three, matrix form"));
            questions.push(Question::of_peer(Kernel::CTriangleT2, &x, "C: T2 of three, triangular"));
            questions.push(Question::of_peer(Kernel::CBiquad, &[residual], "C: biquad, one sample"));
        }
    }
    questions
}
