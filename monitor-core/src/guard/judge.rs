//! Phase II of `guard` mode: the distances of one sample at three time scales, and what follows from them.

use core::hint::select_unpredictable;

use super::alarm::{Alarm, Evidence, Outcome, Rules};
use super::design::Design;
use super::direction::Noise;
use super::level::PERIOD;
use super::model::Model;
use super::sensor::{Losses, Senses};
use super::verdict::{Standing, Verdict};
use super::{SCALES, at_least, at_most, difference};
use crate::root::reciprocal_sqrt;
use crate::triangle::{inner, square};

/// Places of the time scales.
const FAST: usize = 0;
const MIDDLE: usize = 1;
const SLOW: usize = 2;

/// Limits while a model proves itself: what it rests on is not what it judges.
const UNPROVEN: f32 = 1.5;

/// Most that the tail of a statistic may raise its limit. Beyond, the window was not healthy.
const RAISED_TO: f32 = 4.0;

/// Share of a deviation that an estimate may be off by when it has just begun, and when it has averaged for long: what the
/// loop still moves by averages out.
const SETTLED_TO_AT_FIRST: f32 = 0.05;
const SETTLED_TO: f32 = 0.01;

/// Deviations count up to so many sigmas, far beyond any fault, so that no number leaves the range of `f32`.
const REACH_SIGMAS: f32 = 1e6;

/// Share of its limit from which on a distance is a suspicion, under which nothing is learned.
const SUSPECTED_FROM: f32 = 0.5;

/// Share of the estimate's length by which a fault may move and still be the one that is being averaged.
const MOVED_SHARE: f32 = 0.05;

/// Share of the fast scale's limit beyond which the loop is moving. Noise is beyond it once in a hundred samples, and is
/// within it for the rest, which is all that is asked: a run.
const MOVING_SHARE: f32 = 0.25;

/// What a model brings with it when it is installed or recalled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    pub(super) model: Model,
    /// Activity of each channel below which its sensor is stuck.
    stuck_below: [f32; 3],
    /// The reciprocal of the limit of each time scale, as sharp as it is by now.
    pub(super) per_limit: [f32; SCALES],
    /// Slots that mean and limits rest on.
    slots: f32,
    /// Slots until the limits are proven.
    pub(super) unproven: u32,
    /// Largest distance of each time scale while they were not, in units of the limit.
    peak: [f32; SCALES],
    /// Slow movement of the mean that is taken to be benign.
    pub(super) drift: [f32; 3],
}

/// The moving part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge {
    pub(super) known: Known,
    pub(super) alarm: Alarm,
    pub(super) senses: Senses,
    pub(super) losses: Losses,
    fast: [f32; 3],
    middle: [f32; 3],
    /// The slow scale. While an alarm stands it is the estimate of the fault: it begins again at the middle scale's value
    /// when the fault has moved, and averages all samples since.
    pub(super) estimate: [f32; 3],
    /// Weight of the newest sample in the estimate.
    pub(super) gain: f32,
    /// Slots since the middle scale was last far from the estimate.
    still: u32,
    /// Slots since the fast scale last ran ahead of the middle one.
    steady: u32,
    slots: u32,
    /// The channel that the metrics do without, and for each scale the direction of w = U y that it accounts for.
    blind: u32,
    blinds: [[f32; 3]; SCALES],
}

impl Known {
    pub(super) fn new(model: Model, stuck_below: [f32; 3], learned_slots: u32) -> Self {
        let slots = learned_slots as f32;
        let per_limit = model.scales.map(|scale| 1.0 / scale.level.limit(slots));
        Known { model, stuck_below, per_limit, slots, unproven: learned_slots, peak: [0.0; SCALES], drift: [0.0; 3] }
    }

    /// Widens limits by the tail that was seen (the largest distance of so many slots), once.
    #[cold]
    #[inline(never)]
    fn prove(&mut self, design: &Design) {
        for ((scale, peak), expected) in self.model.scales.iter_mut().zip(self.peak).zip(design.expected_peaks) {
            scale.level.widen((peak / expected).clamp(1.0, RAISED_TO));
        }
    }

    /// Sharpens what is known by a slot that is healthy beyond suspicion: in turn one of the scales, or the mean. The work is
    /// the same for a slot that is not; then nothing changes.
    #[inline(always)]
    fn sharpen(&mut self, design: &Design, suspected: bool, turn: u32, smoothed: [[f32; 3]; SCALES]) {
        let smoothed = smoothed.map(|y| y.map(|y| select_unpredictable(suspected, 0.0, y)));
        let period = select_unpredictable(suspected, 0.0, PERIOD as f32);
        let [_, middle, _] = smoothed;
        let place = turn as usize;
        let entries = self.model.scales.get_mut(place).zip(self.per_limit.get_mut(place)).zip(smoothed.get(place));
        if let Some(((scale, per_limit), y)) = entries {
            scale.sharpen(*y, period / self.slots);
            *per_limit = 1.0 / scale.level.limit(self.slots);
        } else {
            self.slots += period;
            let share = period / at_most(self.slots, design.memory_slots);
            for ((drift, moved), sigma) in self.drift.iter_mut().zip(middle).zip(self.model.sigma) {
                let reach = design.drift_sigmas * sigma;
                *drift = at_most(at_least(*drift + share * moved, -reach), reach);
            }
        }
    }
}

/// What the metrics make of the smoothed channels: each is white noise of variance one per place while the motor is healthy.
struct Images {
    fast: [f32; 3],
    middle: [f32; 3],
    estimate: [f32; 3],
    /// The estimate in the metric of the middle scale, to see whether the fault is gone or has moved.
    estimate_by_middle: [f32; 3],
}

impl Judge {
    pub(super) fn new(known: Known, alarm: Alarm, senses: Senses, design: &Design) -> Self {
        let [_, _, slow] = design.scales;
        Judge {
            known,
            alarm,
            senses,
            losses: Losses::default(),
            fast: [0.0; 3],
            middle: [0.0; 3],
            estimate: [0.0; 3],
            gain: slow.weight(),
            still: 0,
            steady: 0,
            slots: 0,
            blind: 0,
            blinds: [[0.0; 3]; SCALES],
        }
    }

    /// Judges one sample, and brings the verdict on the sample before up to date. Reads as the flow of the module's front page.
    #[inline(always)]
    pub(super) fn step(&mut self, design: &Design, rules: &Rules, x: [f32; 3], verdict: &mut Verdict) {
        let [of_fast, of_middle, _] = &design.scales;
        let up = verdict.standing.alarm();
        let fit = x.map(super::measurable);
        self.senses.step(fit, x); //                                                            is it a sensor still?
        self.losses.step(fit, &self.senses, &self.known.stuck_below);
        let (deviation, held) = self.deviation(fit, x); //                                      from the mean (1.7)
        of_fast.step(held, &mut self.fast, deviation); //                                       smooth
        of_middle.step(held, &mut self.middle, deviation);
        let images = self.images();
        let severity = self.severity(&images); //                                               (1.6), over the limits
        let gone = select_unpredictable(held, 0.0, self.gone(design, &images));
        let Outcome { up: now, new, recovering } = self.alarm.step(rules, up, &Evidence { severity, gone });
        let now = now | (design.latch & up);
        self.follow(design, rules, held, now, recovering, deviation, &images);
        self.learn(design, now | recovering | held, severity);
        verdict.severity = severity;
        verdict.alarm_since = select_unpredictable(new, verdict.sample, verdict.alarm_since);
        let named = self.still >= rules.named_after;
        verdict.standing = Standing::new(now, recovering, named, held, self.losses.stuck(), self.losses.silent());
    }

    /// Deviations from the mean; and whether the sample says nothing, because a channel that is not lost has no reading, or
    /// two channels are lost, or the metrics do not know yet which one is.
    #[inline(always)]
    fn deviation(&self, fit: [bool; 3], x: [f32; 3]) -> ([f32; 3], bool) {
        let lost = self.losses.lost();
        let [a, b, c] = fit;
        let unfit = u32::from(!a) | u32::from(!b) << 1 | u32::from(!c) << 2;
        let several = lost & lost.wrapping_sub(1) != 0;
        let held = (unfit & !lost != 0) | several | (lost != self.blind);
        let mut d = difference(difference(x, self.known.model.mean), self.known.drift);
        for (position, (d, sigma)) in d.iter_mut().zip(self.known.model.sigma).enumerate() {
            let (reach, there) = (REACH_SIGMAS * sigma, (unfit | lost) >> position & 1 == 0);
            *d = select_unpredictable(there & !held, at_most(at_least(*d, -reach), reach), 0.0);
        }
        (d, held)
    }

    #[inline(always)]
    fn images(&self) -> Images {
        Images {
            fast: self.image(FAST, self.fast),
            middle: self.image(MIDDLE, self.middle),
            estimate: self.image(SLOW, self.estimate),
            estimate_by_middle: self.image(MIDDLE, self.estimate),
        }
    }

    /// A smoothed deviation in the metric of a time scale, without what a lost channel could explain.
    #[inline(always)]
    fn image(&self, place: usize, y: [f32; 3]) -> [f32; 3] {
        let Some((scale, blind)) = self.known.model.scales.get(place).zip(self.blinds.get(place)) else {
            return [0.0; 3];
        };
        let image = scale.metric.times(y);
        let along = inner(*blind, image);
        difference(image, blind.map(|b| b * along))
    }

    /// The distance (1.6) of each time scale, all components retained, in units of its limit.
    #[inline(always)]
    fn severity(&self, images: &Images) -> [f32; SCALES] {
        let widened = select_unpredictable(self.known.unproven > 0, 1.0 / UNPROVEN, 1.0);
        let mut severity = [images.fast, images.middle, images.estimate].map(square);
        for (severity, per_limit) in severity.iter_mut().zip(self.known.per_limit) {
            *severity *= per_limit * widened;
        }
        severity
    }

    /// ln of the likelihood of the sample where the fault is gone over that where it stands as estimated.
    ///
    /// Of a deviation y and an estimate f it is |f|^2/2 - y'f. Of the middle scale and by its metric, so that noise counts by
    /// its memory; one sample is the share of it that a sample has in what that scale averages.
    #[inline(always)]
    fn gone(&self, design: &Design, images: &Images) -> f32 {
        let [_, of_middle, _] = &design.scales;
        let estimate = images.estimate_by_middle;
        (0.5 * square(estimate) - inner(images.middle, estimate)) * of_middle.variance_ratio()
    }

    /// Moves the slow scale.
    ///
    /// While an alarm stands it begins again where the fault has come to stand elsewhere: not while the loop is moving, for
    /// then the estimate is the memory of the fault by which its end is seen.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what a slot brings, in scalars that stay in registers")]
    fn follow(
        &mut self,
        design: &Design,
        rules: &Rules,
        held: bool,
        up: bool,
        recovering: bool,
        deviation: [f32; 3],
        images: &Images,
    ) {
        let [_, of_middle, of_slow] = &design.scales;
        let again = up & self.has_moved(rules, images);
        self.gain = at_least(self.gain / (1.0 + self.gain), of_slow.weight());
        self.gain = select_unpredictable(again, of_middle.weight(), self.gain);
        let weight = select_unpredictable(held, 0.0, self.gain);
        for ((e, middle), d) in self.estimate.iter_mut().zip(self.middle).zip(deviation) {
            let from = select_unpredictable(again, middle, *e);
            *e = select_unpredictable(recovering, 0.0, from + weight * (d - from));
        }
    }

    /// Whether the fault has come to stand elsewhere than it is estimated. One slot asks whether the loop is moving (the fast
    /// scale runs ahead of the middle one), the next whether the middle scale is far from the estimate.
    #[inline(always)]
    fn has_moved(&mut self, rules: &Rules, images: &Images) -> bool {
        let [per_fast, per_middle, _] = self.known.per_limit;
        if self.slots.is_multiple_of(2) {
            let moving = differ(per_fast / MOVING_SHARE, images.fast, self.image(FAST, self.middle));
            self.steady = select_unpredictable(moving, 0, self.steady.saturating_add(2));
            return false;
        }
        let before = images.estimate_by_middle;
        let far = differ(per_middle, images.middle, before);
        self.still = select_unpredictable(far, 0, self.still.saturating_add(2));
        // Nearer to health than to the estimate, it is on its way out.
        let on_its_way_out = inner(images.middle, before) < 0.5 * square(before);
        far & !on_its_way_out & (self.steady >= rules.steady)
    }

    /// What is learned while judging: the tail of each distance, mean and metrics, which channel the metrics do without.
    #[inline(always)]
    fn learn(&mut self, design: &Design, suspected: bool, severity: [f32; SCALES]) {
        self.prove(design, suspected, severity);
        let suspected = suspected | (self.losses.lost() != 0) | !quiet(severity);
        let turn = self.slots % PERIOD;
        if turn <= SCALES as u32 + 1 {
            self.take_turn(design, suspected, turn);
        }
        self.slots = self.slots.wrapping_add(1);
    }

    /// What one slot in a period does beside judging. Whose turn it is, the count of slots says.
    #[inline(never)]
    fn take_turn(&mut self, design: &Design, suspected: bool, turn: u32) {
        if turn <= SCALES as u32 {
            self.known.sharpen(design, suspected, turn, [self.fast, self.middle, self.estimate]);
        } else {
            self.do_without_the_lost();
        }
    }

    /// Works out what the metrics must leave out so that a lost channel counts for nothing.
    ///
    /// The least distance over all values of a channel is what is left when w = U y loses its part along the channel's column
    /// of U: the distance of the pair that does not use it.
    #[inline(always)]
    fn do_without_the_lost(&mut self) {
        self.blind = self.losses.lost();
        for (blind, scale) in self.blinds.iter_mut().zip(&self.known.model.scales) {
            let lost = [0, 1, 2].map(|position| (self.blind >> position & 1) as f32);
            let column = scale.metric.rows().map(|row| inner(row, lost));
            let per_length = reciprocal_sqrt(at_least(square(column), 1e-30));
            *blind = column.map(|cell| cell * per_length);
        }
    }

    /// Gathers the tail that limits are refined by; at its end refines them.
    #[inline(always)]
    fn prove(&mut self, design: &Design, suspected: bool, severity: [f32; SCALES]) {
        for (peak, severity) in self.known.peak.iter_mut().zip(severity) {
            // Of the limit as it is, not as it was widened; and what raises an alarm is no tail.
            *peak = select_unpredictable(suspected, *peak, at_least(*peak, severity * UNPROVEN));
        }
        if self.known.unproven == 1 {
            self.known.prove(design);
        }
        self.known.unproven = self.known.unproven.saturating_sub(1);
    }
}

/// Whether two images differ by more than noise (given as its reciprocal), and by more than a share of the second.
#[inline(always)]
fn differ(per_noise: f32, a: [f32; 3], b: [f32; 3]) -> bool {
    (square(difference(a, b)) - MOVED_SHARE * MOVED_SHARE * square(b)) * per_noise > 1.0
}

/// Whether every distance is so far below its limit that nothing is suspected.
#[inline(always)]
fn quiet(severity: [f32; SCALES]) -> bool {
    severity.iter().fold(true, |all, severity| all & (*severity < SUSPECTED_FROM))
}

impl Judge {
    pub(super) fn limits(&self) -> [f32; SCALES] {
        self.known.per_limit.map(|per_limit| 1.0 / per_limit)
    }

    /// Whether the estimate has not yet averaged for as long as the slow scale does.
    pub(super) fn is_young(&self, design: &Design) -> bool {
        let [_, _, of_slow] = &design.scales;
        self.gain > of_slow.weight()
    }

    /// The noise in the estimate: that of the slow scale, by how much more or less the estimate averages than the slow scale
    /// does.
    pub(super) fn noise(&self, design: &Design) -> Noise {
        let ([_, _, slow], [_, _, of_slow]) = (&self.known.model.scales, &design.scales);
        let more = self.gain / (2.0 - self.gain) / of_slow.variance_ratio();
        let mut covariance = slow.metric.covariance().map(|column| column.map(|c| c * more));
        // Of a lost channel nothing is known.
        for (i, column) in covariance.iter_mut().enumerate() {
            for (j, (cell, sigma)) in column.iter_mut().zip(self.known.model.sigma).enumerate() {
                let blind = |k: usize| self.blind >> k & 1 != 0;
                if blind(i) || blind(j) {
                    *cell = if i == j { 1e6 * sigma * sigma } else { 0.0 };
                }
            }
        }
        let [_, of_middle, _] = &design.scales;
        let young = self.gain / of_middle.weight();
        let settled_to = SETTLED_TO + (SETTLED_TO_AT_FIRST - SETTLED_TO) * at_most(young, 1.0);
        Noise { covariance, sigma: self.known.model.sigma, settled_to }
    }
}
