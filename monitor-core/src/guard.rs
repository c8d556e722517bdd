//! `guard` mode: small faults, found fast, named right, and silence for months.
//!
//! ```text
//! sample ─ fit? ─ gate ─ deviation (1.7) ─┬─ fast   ─ T² ─┐
//!            │                            ├─ middle ─ T² ─┼─ limits ─ raise, withdraw ─ verdict
//!          losses                         │  └─ trend ─ T² ┤                  │
//!                                         └─ slow   ─ T² ─┘                  │
//!                                              └─ estimate ─ directions ─ finding, size   (on request)
//! ```
#![doc = include_str!("../GUARD.md")]

use crate::moments::{Clip, LearnError, Moments, Statistics};
use crate::sample::Absence;
use crate::sample::{Channel, Sample};
use crate::set_point::{Gate, GateState};
use crate::units::RadPerSec;

mod alarm;
mod bank;
mod design;
mod direction;
mod flag;
mod judge;
mod known;
mod level;
mod model;
mod pair;
mod sensor;
mod stored;
mod verdict;
mod window;

use alarm::{Alarm, Rules};
use bank::Bank;
pub use design::{Config, ConfigError, Design};
pub use direction::{
    Cause, Direction, DirectionError, Directions, Explanation, Finding, MotorConstants, Noise, TOLERANCE_OF_CONSTANTS,
};
use flag::Flag;
use judge::Judge;
use known::Known;
pub use model::{Model, Quality};
use sensor::{Activity, ROUND, Senses};
pub use stored::{RestoreError, Stored};
pub use verdict::{Loss, Phase, Verdict};
pub use window::Window;

/// Time scales side by side: a sample or a few, the loop, drifts, trends.
pub const SCALES: usize = 4;

/// Place of the slowest, which is judged once in a period.
const TREND: usize = SCALES - 1;

/// Slots in a row without a sample that are a gap: as long as a sensor may say nothing.
const GAP: u32 = 16;

/// Sigmas of the first seeding window at which the second is clipped.
const SEED_CLIP_SIGMAS: f32 = 4.0;

/// How far the mean may move from the first seeding window to the second: further, and the loop has not settled.
const SETTLED_TO_SIGMAS: f32 = 2.0;

/// How far it may have moved for neighbours to lend their noise, so that the motor is judged at once, in units of how far the mean
/// may follow afterwards: the loop stands, and what the window's mean is off by can be made good.
const LENT_TO: f32 = 0.5;

/// A window, and the activity of each channel while it was gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned {
    window: Window,
    activity: Activity,
}

/// Where the monitor stands; each phase owns what it moves.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// With the running mean of what was read while the loop settled.
    Settling(Option<[f32; 3]>),
    /// The clip is that of the window before.
    Seeding(Moments<3>, Option<Clip<3>>),
    Learning(Learned),
    ModelDue(Learned),
    Judging(Judge),
    Withheld,
}

/// The fault monitor of one motor, in `guard` mode.
#[derive(Clone, Debug)]
pub struct Monitor {
    verdict: Verdict,
    gate: GateState,
    design: Design,
    rules: Rules,
    senses: Senses,
    stage: Stage,
    /// Samples taken: they say whose turn it is, and nothing else writes them.
    count: u32,
    /// Slots in a row that had no sample.
    gap: u32,
    bank: Bank,
    quality: Quality,
    refused: Option<LearnError>,
    /// Whether the motor was said to be healthy at this set point, whatever its neighbours make expect.
    trusted: bool,
}

impl Monitor {
    /// A monitor that settles, seeds, learns and then judges.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let design = Design::new(config)?;
        Ok(Monitor {
            verdict: Verdict { sample: u64::MAX, ..Verdict::default() }, // the first sample has index zero
            gate: design.gate.unknown(),
            rules: Rules::new(config, &design)?,
            design,
            senses: Senses::NONE,
            stage: Stage::Settling(None),
            count: 0,
            gap: 0,
            bank: Bank::EMPTY,
            quality: Quality::default(),
            refused: None,
            trusted: false,
        })
    }

    /// Takes one sample of the motor and says whether something is wrong. The verdict is the monitor's own: copy what
    /// outlives the next step.
    #[inline]
    pub fn step(&mut self, set_point: RadPerSec, sample: Sample) -> &Verdict {
        self.step_channels(set_point.0, sample.into())
    }

    /// The same for any three channels.
    ///
    /// Never fails, never allocates. Readings that are no numbers are reported, and leave model and filters as they were.
    #[inline]
    pub fn step_channels(&mut self, set_point: f32, x: [f32; 3]) -> &Verdict {
        let [a, b, c] = x;
        self.slot(set_point, a, b, c)
    }

    #[inline(never)]
    fn slot(&mut self, set_point: f32, a: f32, b: f32, c: f32) -> &Verdict {
        self.gap = 0;
        self.verdict.sample = self.verdict.sample.wrapping_add(1);
        self.verdict.readings = [a, b, c];
        if let Stage::Judging(judge) = &mut self.stage
            && self.design.gate.holds(&self.gate, set_point)
        {
            judge.step(&self.design, &self.rules, &mut self.senses, self.count, &mut self.verdict);
        } else {
            self.before_judging(set_point);
        }
        self.count = self.count.wrapping_add(1);
        &self.verdict
    }

    /// Lets a slot of the sampling clock go by that has no sample of its own, and says so.
    pub fn skip(&mut self, why: Absence) -> &Verdict {
        let gap = self.gap.saturating_add(1);
        if let Stage::Judging(_) = self.stage {
            // It says nothing of the sensors either.
            self.verdict.sample = self.verdict.sample.wrapping_add(1);
            self.verdict.readings = [f32::NAN; 3];
            self.verdict.standing = self.verdict.standing.unsampled();
        } else {
            self.step_channels(self.gate.reference(), [f32::NAN; 3]);
        }
        self.gap = gap;
        self.verdict.standing = self.verdict.standing.absent(why, gap >= GAP);
        &self.verdict
    }

    /// A sample that no model judges.
    #[cold]
    #[inline(never)]
    fn before_judging(&mut self, set_point: f32) {
        let x = self.verdict.readings;
        let held = x.iter().fold(Flag::new(false), |held, x| held | Flag::unfit(*x));
        if !set_point.is_finite() {
            self.verdict.standing = self.verdict.standing.without_set_point();
            return;
        }
        let turn = (self.count % ROUND) as usize;
        if let Some(x) = x.get(turn) {
            self.senses.begin(turn, *x);
            self.senses.step(turn, *x);
        }
        self.verdict.standing = self.verdict.standing.unjudged(held.is_set());
        let from = self.gate.reference();
        match self.design.gate.step(&mut self.gate, set_point) {
            Gate::Changed => self.set_point_changed(from, set_point),
            Gate::Settling => {}
            Gate::Open => self.open(held.is_set(), x),
        }
        self.gather(held, x);
        self.verdict.phase = self.phase();
        if let Stage::Judging(_) = self.stage {
            self.verdict.standing = self.verdict.standing.settling();
        }
    }

    /// The set point has moved: what was known of it is recalled, or else it will be learned, unless a fault is suspected. What
    /// has become known of the one before is kept.
    #[inline(never)]
    fn set_point_changed(&mut self, from: f32, set_point: f32) {
        let suspected = self.verdict.standing.alarm();
        self.trusted = false;
        if let Stage::Judging(judge) = &self.stage {
            self.bank.keep(&self.design, from, &judge.known);
        }
        self.stage = if let Some(known) = self.bank.recall(&self.design.gate, set_point) {
            self.gate = self.design.gate.open_at(set_point);
            self.entered(*known)
        } else if suspected {
            Stage::Withheld
        } else {
            Stage::Settling(None)
        };
    }

    /// Judging at a set point of which something is known before the loop has been seen to stand there.
    fn entered(&self, known: Known) -> Stage {
        Stage::Judging(Judge::new(known, Alarm::settling(&self.rules), &self.design))
    }

    /// The set point has been constant for long enough: seeding begins around what was read meanwhile.
    fn open(&mut self, held: bool, x: [f32; 3]) {
        if let Stage::Settling(mean) = self.stage
            && let Some(shift) = mean.or((!held).then_some(x))
        {
            self.stage = Stage::Seeding(Moments::around(shift), None);
        }
    }

    /// Lets a phase before judging take its sample, and go over into the next.
    fn gather(&mut self, held: Flag, x: [f32; 3]) {
        let design = &self.design;
        match &mut self.stage {
            Stage::Settling(mean) if !held.is_set() => {
                let before = mean.unwrap_or(x);
                let [d0, d1, d2] = difference(x, before).map(|d| d * 0.0625); // over the last sixteen or so
                let [m0, m1, m2] = before;
                *mean = Some([m0 + d0, m1 + d1, m2 + d2]);
            }
            Stage::Seeding(moments, clip) => {
                moments.push_unless(held.is_set(), clip.map_or(x, |clip| clip.apply(x).0));
                if moments.slots() >= design.seed_slots {
                    self.seeded();
                }
            }
            Stage::Learning(learned) => {
                learned.window.push(design, held, x);
                learned.activity.push(&self.senses, self.count);
                if learned.window.slots >= design.learn_slots {
                    self.stage = Stage::ModelDue(*learned);
                }
            }
            _ => {}
        }
    }

    /// Goes over into what follows a seeding window: the second one, clipped by the first; or, if the loop has settled, what comes
    /// after both. Begins again if it has not. If the mean is one that the set point's neighbours do not make expect, that is an
    /// alarm, and nothing is learned.
    #[inline(never)]
    fn seeded(&mut self) {
        let Stage::Seeding(moments, clip) = &self.stage else { return };
        let (second, around) = (clip.is_some(), moments.shift());
        let seed = moments.statistics().map(|seed| self.design.floored(&seed, 1.0, 0.0));
        let next = seed.and_then(|seed| match second {
            false => Ok(Stage::Seeding(Moments::around(seed.mean.into()), Some(Clip::at(&seed, SEED_CLIP_SIGMAS)))),
            true => settled(&seed, around).and_then(|moved| self.after_seeding(&seed, moved)),
        });
        match next {
            Ok(stage) => self.stage = stage,
            Err(error) => {
                self.refused = Some(error);
                if let LearnError::Unexpected(_) = error {
                    self.verdict.standing = self.verdict.standing.raised();
                    self.verdict.alarm_since = self.verdict.sample;
                    self.stage = Stage::Withheld;
                } else {
                    self.stage = Stage::Seeding(Moments::around(around), None);
                }
            }
        }
    }

    /// What begins with the statistics of the second seeding window, whose mean has moved by so many sigmas: judging, by what the
    /// set point's neighbours lend, or else the learning window.
    fn after_seeding(&self, seed: &Statistics<3>, moved: f32) -> Result<Stage, LearnError> {
        let set_point = self.gate.reference();
        if let Some(neighbours) = self.bank.neighbours(set_point).filter(|_| !self.trusted) {
            bank::expected(neighbours, set_point, seed.mean.into())?;
            if moved <= LENT_TO * self.design.drift_sigmas
                && let Some(known) = Known::lent(seed, neighbours.map(|(_, known)| known), &self.design)
            {
                return Ok(self.entered(known));
            }
        }
        Ok(Stage::Learning(Learned { window: Window::after(seed), activity: Activity::NONE }))
    }

    /// The learning window, once it is complete and until a model is installed. A board copies it out of the sampling
    /// interrupt, calls [`Model::learn`] at leisure, and hands the result in with [`Monitor::install`].
    #[must_use]
    pub const fn learned(&self) -> Option<&Window> {
        match &self.stage {
            Stage::ModelDue(learned) => Some(&learned.window),
            _ => None,
        }
    }

    /// Hands in what was made of the learning window. Returns whether the monitor was waiting for it.
    pub fn install(&mut self, model: Result<(Model, Quality), LearnError>) -> bool {
        let Stage::ModelDue(learned) = self.stage else { return false };
        match model {
            Ok((model, quality)) => {
                let known = Known::new(model, learned.activity.stuck_below(), self.design.learn_slots);
                self.bank.keep(&self.design, self.gate.reference(), &known);
                self.stage = Stage::Judging(Judge::new(known, Alarm::default(), &self.design));
                (self.quality, self.refused) = (quality, None);
            }
            Err(error) => {
                // The clip may have been the wrong one: from the beginning.
                self.stage = Stage::Seeding(Moments::around(learned.window.centre), None);
                self.refused = Some(error);
            }
        }
        self.verdict.phase = self.phase();
        true
    }

    /// Makes a model of the learning window if it is complete, on the spot. Returns whether a model was installed.
    ///
    /// # Errors
    /// [`LearnError`] when the window was refused; learning has begun again.
    pub fn finish_learning(&mut self) -> Result<bool, LearnError> {
        let Some(window) = self.learned() else { return Ok(false) };
        let model = Model::learn(window, &self.design);
        self.install(model);
        model.map(|_| true)
    }

    /// The settings as worked out; what [`Model::learn`] asks for.
    #[must_use]
    pub const fn design(&self) -> &Design {
        &self.design
    }

    /// The model that samples are judged by, while the monitor judges.
    #[must_use]
    pub const fn model(&self) -> Option<&Model> {
        match &self.stage {
            Stage::Judging(judge) => Some(&judge.known.model),
            _ => None,
        }
    }

    /// What is known of each set point, to be kept where it outlives a loss of power. Outside the sampling interrupt, from a copy of
    /// the monitor.
    pub fn stored(&self) -> impl Iterator<Item = Stored> + '_ {
        let here = match &self.stage {
            Stage::Judging(judge) => self.bank.recall(&self.design.gate, self.gate.reference()).zip(Some(&judge.known)),
            _ => None,
        };
        self.bank.iter().map(move |(set_point, known)| {
            // What is judged by has become sharper since it was recalled.
            let newest = here.filter(|(here, _)| core::ptr::eq(*here, known)).map_or(known, |(_, newest)| newest);
            Stored::of(&self.design, *set_point, newest)
        })
    }

    /// Takes in what was known of a set point: when that is reached next, it is judged by it. Before the first sample, a monitor
    /// is ready as soon as the loop has settled.
    ///
    /// # Errors
    /// [`RestoreError`] when it was learned under other settings; then nothing has changed.
    pub fn restore(&mut self, stored: &Stored) -> Result<(), RestoreError> {
        let (set_point, known) = stored.restored(&self.design)?;
        self.bank.keep(&self.design, set_point, &known);
        Ok(())
    }

    /// Limit of the distance at each time scale, as sharp as it is by now.
    #[must_use]
    pub fn limits(&self) -> Option<[f32; SCALES]> {
        match &self.stage {
            Stage::Judging(judge) => Some(judge.limits()),
            _ => None,
        }
    }

    /// What there is to say of the last learning window that was accepted.
    #[must_use]
    pub const fn quality(&self) -> &Quality {
        &self.quality
    }

    /// Why the last learning window was refused, until one is accepted.
    #[must_use]
    pub const fn refused(&self) -> Option<LearnError> {
        self.refused
    }

    /// The verdict on the last slot.
    #[must_use]
    pub const fn verdict(&self) -> &Verdict {
        &self.verdict
    }

    /// Withdraws an alarm that is latched, or by which nothing is learned at an unknown set point: then the motor is taken for
    /// healthy and learned. If the fault still stands at a known one, it is raised again.
    pub fn acknowledge(&mut self) {
        self.verdict.standing = self.verdict.standing.without_alarm();
        self.trusted = true;
        if let Stage::Withheld = self.stage {
            self.stage = Stage::Settling(None);
            self.verdict.phase = self.phase();
        }
    }

    /// Estimate of the deviation from healthy, each channel in its unit; none while nothing is judged.
    #[must_use]
    pub fn deviation(&self) -> Option<[f32; 3]> {
        match &self.stage {
            Stage::Judging(judge) => Some(judge.located(&self.design, &self.verdict.severity).0),
            _ => None,
        }
    }

    /// The noise by which a fault is named that has stood for a while: what [`Directions::rehearse`] asks for. None while nothing
    /// is judged.
    #[must_use]
    pub fn noise(&self) -> Option<Noise> {
        match &self.stage {
            Stage::Judging(judge) => Some(judge.noise_of_slow()),
            _ => None,
        }
    }

    /// What is wrong, by the directions of faults: which, how large, and what else it might be. On request and outside the
    /// sampling interrupt, from a copy of the monitor.
    #[must_use]
    pub fn finding(&self, directions: &Directions) -> Finding {
        if !self.verdict.deviates() {
            return Finding::Healthy;
        }
        let Stage::Judging(judge) = &self.stage else { return Finding::Locating };
        if !self.verdict.settled() {
            return Finding::Locating;
        }
        let (deviation, noise) = judge.located(&self.design, &self.verdict.severity);
        match directions.explain(deviation, &noise) {
            Finding::Unknown if judge.is_young(&self.design) => Finding::Locating,
            finding => finding,
        }
    }

    const fn phase(&self) -> Phase {
        match &self.stage {
            Stage::Settling(_) => Phase::Settling,
            Stage::Seeding(..) => Phase::Seeding,
            Stage::Learning(_) => Phase::Learning,
            Stage::ModelDue(_) => Phase::ModelDue,
            Stage::Judging(_) => Phase::Monitoring,
            Stage::Withheld => Phase::Withheld,
        }
    }
}

/// How far the mean has moved from the first seeding window to the second, in sigmas of the channel that has moved most, if that
/// says that the loop has settled.
fn settled(seed: &Statistics<3>, before: [f32; 3]) -> Result<f32, LearnError> {
    let (mean, sigma): ([f32; 3], [f32; 3]) = (seed.mean.into(), seed.sigma().into());
    let mut largest = 0.0;
    for (position, (moved, sigma)) in difference(mean, before).into_iter().zip(sigma).enumerate() {
        if moved.abs() > SETTLED_TO_SIGMAS * sigma {
            return Err(LearnError::Drifting(Channel::at(position)));
        }
        largest = f32::max(largest, moved.abs() / sigma);
    }
    Ok(largest)
}

/// a - b.
#[inline(always)]
fn difference([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [a - x, b - y, c - z]
}

/// An exponential smoother's next value.
#[inline(always)]
fn smoothed([a, b, c]: [f32; 3], weight: f32, [x, y, z]: [f32; 3]) -> [f32; 3] {
    [a + weight * (x - a), b + weight * (y - b), c + weight * (z - c)]
}

#[cfg(test)]
mod tests;
