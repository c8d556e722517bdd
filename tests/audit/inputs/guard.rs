//! What a monitor in `guard` mode is asked: set points that change and come back, seeding and learning with spikes, faults
//! that come and go in steps and ramps, and sensors that are lost in every way.

use firmware_stub::kernels::{self, Kernel, Request, SET_POINT, guard as given};
use monitor_core::guard::{Monitor, Phase, Verdict};

use super::{Odd, Question};

/// Labels of `Monitor::step_channels`.
pub const GUARD_SETTLING: &str = "guard_settling";
/// A seeding window, but for its end.
pub const GUARD_SEEDING: &str = "guard_seeding";
/// The learning window, but for its end.
pub const GUARD_LEARNING: &str = "guard_learning";
/// A judged slot in which nothing is learned.
pub const GUARD_MONITORING: &str = "guard_monitoring";
/// The few judged slots of a period in which metrics and mean are brought up to date, by the count.
pub const GUARD_TURN: &str = "guard_turn";
/// A slot with which a phase begins or ends, and slots that wait for a model or for another set point.
pub const GUARD_TRANSITION: &str = "guard_transition";
/// `Monitor::finish_learning`.
pub const GUARD_WINDOW_END: &str = "guard_window_end";
/// `Monitor::finding`.
pub const GUARD_FINDING: &str = "guard_finding";

/// A copy of the monitor.
const GUARD_COPY: &str = "guard_copy";
/// `Monitor::install`.
const GUARD_INSTALL: &str = "guard_install";

/// Slots of a period, and how many of them have a turn: each of four scales two, the mean, and the trend.
const PERIOD: u64 = 64;
const TURNS: u64 = 10;

/// Slots without a fault before the set point changes.
const QUIET: usize = 400;

/// Flies `episodes` set points, `judged` slots each in which faults come and go.
#[must_use]
pub fn guard(episodes: usize, judged: usize) -> Vec<Question> {
    let Ok(guard) = Monitor::new(&given::config()) else { return Vec::new() };
    let mut flight = Flight { guard, last: Verdict::default(), seeding: 0, beside: 0, questions: Vec::new() };
    let mut samples = kernels::healthy(23);
    let mut next = || samples.next().unwrap_or_default();
    let mut odd = Odd::default();
    for episode in 0..episodes {
        // The third is between two that are known.
        let mut set_point = SET_POINT + [0.0, 8.0, 4.0][episode % 3];
        for slot in 0..20 {
            // It moves before the loop has settled; once it is no number.
            set_point += if slot % 7 == 0 { 0.25 } else { 0.0 };
            flight.step(if slot == 10 { f32::NAN } else { set_point }, odd.in_one_of(5, next()));
        }
        while !matches!(flight.last.phase(), Phase::Monitoring | Phase::Withheld) {
            // Few outliers, or the window is refused.
            let [a, b, c] = next();
            let spiked = (flight.questions.len() - flight.beside) % 41 == 40;
            flight.step(set_point, if spiked { [odd.unfit(), b, c] } else { [a, b, c] });
            if flight.last.phase() == Phase::ModelDue {
                flight.step(set_point, next());
                flight.install();
                flight.finish_learning();
            }
        }
        for slot in 0..judged + QUIET {
            let x = next();
            // Nothing is learned at a set point that is reached with a fault.
            let x = if slot < judged { odd.in_one_of(23, lost(slot, faulty(slot, x))) } else { x };
            flight.step(set_point, x);
            if slot % 9 == 0 {
                flight.finding();
            }
            if slot % 300 == 0 {
                flight.copy();
            }
        }
    }
    flight.questions
}

/// 60 slots of a fault, 140 without; a small step, a large one and a ramp in turn, in each channel.
fn faulty(slot: usize, mut x: [f32; 3]) -> [f32; 3] {
    let (turn, place) = (slot / 200, slot % 200);
    if place < 60
        && let Some(channel) = x.get_mut(turn % 3)
    {
        *channel += [0.1, -4.0, 0.02 * place as f32][turn / 3 % 3];
    }
    x
}

/// In the second half of each 700 slots one channel says nothing, is no number, or stands still.
fn lost(slot: usize, mut x: [f32; 3]) -> [f32; 3] {
    let (turn, place) = (slot / 700, slot % 700);
    if (350..550).contains(&place)
        && let Some(channel) = x.get_mut(turn % 3)
    {
        *channel = [f32::NAN, 12.0, f32::INFINITY, 1e-40, 0.0][turn % 5];
    }
    x
}

/// A monitor on the host beside that of the firmware.
struct Flight {
    guard: Monitor,
    last: Verdict,
    /// Slots that were spent seeding.
    seeding: usize,
    /// Questions that change nothing: inputs do not depend on how many there are.
    beside: usize,
    questions: Vec<Question>,
}

impl Flight {
    fn step(&mut self, set_point: f32, x: [f32; 3]) {
        let verdict = *self.guard.step_channels(set_point, x);
        self.seeding = if verdict.phase() == Phase::Seeding { self.seeding + 1 } else { 0 };
        let config = given::config();
        let window_ends = self.seeding.is_multiple_of((config.seed_s * config.sample_rate_hz) as usize);
        let label = match (self.last.phase(), verdict.phase()) {
            (Phase::Settling, Phase::Settling) => GUARD_SETTLING,
            (Phase::Seeding, Phase::Seeding) if !window_ends => GUARD_SEEDING,
            (Phase::Learning, Phase::Learning) => GUARD_LEARNING,
            (Phase::Monitoring, Phase::Monitoring) if verdict.sample() % PERIOD < TURNS => GUARD_TURN,
            (Phase::Monitoring, Phase::Monitoring) => GUARD_MONITORING,
            _ => GUARD_TRANSITION,
        };
        let [a, b, c] = x;
        let request = Request::new(Kernel::GuardStep, &[set_point, a, b, c]);
        self.ask(request, label, given::digest_of_verdict(&verdict));
        self.last = verdict;
    }

    fn finish_learning(&mut self) {
        let accepted = self.guard.finish_learning().is_ok();
        self.ask(Request::new(Kernel::GuardFinishLearning, &[]), GUARD_WINDOW_END, u32::from(accepted));
        self.last = *self.guard.verdict();
    }

    fn finding(&mut self) {
        let answer = given::digest_of_finding(&self.guard.finding(&given::directions()));
        self.ask(Request::new(Kernel::GuardFinding, &[]), GUARD_FINDING, answer);
    }

    fn copy(&mut self) {
        self.beside += 1;
        self.ask(Request::new(Kernel::GuardCopy, &[]), GUARD_COPY, given::digest_of_verdict(&self.last));
    }

    /// The monitor waits for a model, whatever it is.
    fn install(&mut self) {
        self.beside += 1;
        self.ask(Request::new(Kernel::GuardInstall, &[]), GUARD_INSTALL, 1);
    }

    fn ask(&mut self, request: Request, label: &'static str, expected: u32) {
        self.questions.push(Question { request, label, expected: Some(expected) });
    }
}
