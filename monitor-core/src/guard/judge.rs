//! Phase II of `guard` mode: the distances of one sample at three time scales, and what follows from them.
//!
//! Every slot takes one path, whatever the readings are: by its count it looks at one sensor, asks one of two questions about
//! the fault, and in a few slots of a period sharpens what is known.

use super::alarm::{Alarm, Evidence, Outcome, Rules};
use super::design::Design;
use super::direction::Noise;
use super::flag::{Flag, greater, within};
use super::known::Known;
use super::level::PERIOD;
use super::sensor::{Losses, ROUND, Senses};
use super::verdict::{Standing, Verdict};
use super::{SCALES, TREND, difference, smoothed};
use crate::triangle::{Packed, inner, square};

/// Deviations count up to 2^20 sigmas, far beyond any fault, so that no number leaves the range of `f32`.
const REACH_OCTAVES: u32 = 20;

/// Sigmas of a channel beyond which one reading by itself says nothing: a disturbance of the converter or its line. Less than
/// would raise an alarm alone, with what noise adds (drawn 400,000 times at the default time constant and a limit of 45.5: of
/// readings off by 8 sigma one in 270 would, by 10 one in 24, by 12 one in 5).
const WILD_FROM: f32 = 8.0;

/// Slots without a wild reading after which the next one may be the only one.
const WILD_ONCE_IN: u32 = 16;

/// Share of its limit from which on a distance is a suspicion, under which nothing is learned.
const SUSPECTED_FROM: f32 = 0.5;

/// Share of the estimate's length by which a fault may move and still be the one that is being averaged.
const MOVED_SHARE: f32 = 0.05;

/// Share of the fast scale's limit beyond which the loop is moving. Noise is beyond it once in a hundred samples, and is
/// within it for the rest, which is all that is asked: a run.
const MOVING_SHARE: f32 = 0.25;

/// Share of a deviation that an estimate may be off by when it has just begun, and when it has averaged for long: what the
/// loop still moves by averages out.
const SETTLED_TO_AT_FIRST: f32 = 0.05;
const SETTLED_TO: f32 = 0.01;

/// Slots of a period that have a turn: for each scale two, the mean, and the trend.
const TURNS: u32 = 2 * SCALES as u32 + 2;

/// The moving part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge {
    pub(super) known: Known,
    pub(super) alarm: Alarm,
    pub(super) losses: Losses,
    /// Where deviations are taken from, by what is known.
    centre: [f32; 3],
    /// The metrics as they judge: as known, but for the channel that they do without.
    metrics: [Packed; SCALES],
    blind: u8,
    /// The channel that they are being made to do without.
    blind_next: u8,
    /// Slots since a reading was last wild, up to what is asked for.
    tame: u8,
    /// The reciprocals of the limits as they judge.
    per_limit: [f32; SCALES],
    fast: [f32; 3],
    middle: [f32; 3],
    /// Of the middle scale, once in a period, and the severity found then.
    trend: [f32; 3],
    trending: f32,
    /// Whether the loop has recovered since the trend was last asked, or the fault has moved: it begins again.
    disturbed: Flag,
    /// The slow scale. While an alarm stands it is the estimate of the fault: it begins again at the middle scale's value
    /// when the fault has moved, and averages all samples since.
    pub(super) estimate: [f32; 3],
    /// Weight of the newest sample in the estimate.
    pub(super) gain: f32,
    /// Looks since the middle scale was last far from the estimate, up to what is asked for.
    still: u32,
    /// Looks since the fast scale last ran ahead of the middle one.
    steady: u32,
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
    pub(super) fn new(known: Known, alarm: Alarm, design: &Design) -> Self {
        let [_, _, slow, _] = design.scales;
        Judge {
            alarm,
            losses: Losses::default(),
            centre: known.centre(),
            metrics: known.model.scales.map(|scale| scale.metric),
            blind: 0,
            blind_next: 0,
            tame: 0,
            per_limit: known.per_limit.map(|per_limit| known.judged_by(per_limit)),
            fast: [0.0; 3],
            middle: [0.0; 3],
            trend: [0.0; 3],
            trending: 0.0,
            disturbed: Flag::default(),
            estimate: [0.0; 3],
            gain: slow.weight(),
            still: 0,
            steady: 0,
            known,
        }
    }

    /// Judges one sample, and brings the verdict on the sample before up to date. Reads as the flow of the module's front page.
    /// The count of slots says whose turn it is.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        design: &Design,
        rules: &Rules,
        senses: &mut Senses,
        count: u32,
        verdict: &mut Verdict,
    ) {
        let [of_fast, of_middle, ..] = &design.scales;
        let up = Flag::new(verdict.standing.alarm());
        self.sense(senses, count, &verdict.readings); //                                         is it a sensor still?
        let (deviation, held) = self.deviation(verdict.readings); //                             from the mean (1.7)
        let keep = !held;
        self.fast = smoothed(self.fast, keep.or_zero(of_fast.weight()), deviation);
        self.middle = smoothed(self.middle, keep.or_zero(of_middle.weight()), deviation);
        let images = self.images();
        let severity = self.severity(&images); //                                               (1.6), over the limits
        let over = over(&images); //                                                            is the fault still there?
        let steady = Flag::reached(self.steady, rules.steady);
        let evidence = Evidence { severity, gone: keep.or_zero(over * rules.per_sample), steady };
        let Outcome { up: now, new, disturbed, recovering, settling } = self.alarm.step(rules, up, &evidence);
        let now = now | (Flag::new(design.latch) & up);
        self.follow(design, keep, recovering, deviation);
        self.look_at_fault(design, rules, count, now & !recovering & Flag::negative(over), &images);
        verdict.severity = severity;
        self.learn(design, count, now | disturbed, held, square(images.fast), &verdict.severity);
        let since = verdict.sample.wrapping_sub(rules.held_before_raised());
        verdict.alarm_since = new.choose_long(since, verdict.alarm_since);
        self.still = (up | !now).choose_word(self.still, 0); // what stood still before the alarm was not the fault
        let named = Flag::reached(self.still, rules.named_after);
        verdict.standing =
            Standing::new([now, recovering, named, held, settling], self.losses.stuck(), self.losses.silent());
    }

    /// Looks at the sensor whose turn it is.
    #[inline(always)]
    fn sense(&mut self, senses: &mut Senses, count: u32, readings: &[f32; 3]) {
        let turn = (count % ROUND) as usize;
        if let (Some(x), Some(stuck_below)) = (readings.get(turn), self.known.stuck_below.get(turn)) {
            let activity = senses.step(turn, *x);
            self.losses.step(turn, *x, activity, *stuck_below);
        }
    }

    /// Deviations from the mean; and whether the sample says nothing, because a channel that is not lost has no reading, or
    /// two channels are lost, or the metrics do not know yet which one is, or because it is wild and none was before it: if
    /// that is a fault, the next one says so too.
    #[inline(always)]
    fn deviation(&mut self, x: [f32; 3]) -> ([f32; 3], Flag) {
        let lost = self.losses.lost();
        let [a, b, c] = x.map(|x| Flag::unfit(x).bit());
        let unfit = a | b << 1 | c << 2;
        let several = lost & lost.wrapping_sub(1);
        let held = Flag::any((unfit & !lost) | several | (lost ^ u32::from(self.blind)));
        // No bit, if the sample says nothing.
        let there = !(unfit | lost) & held.bit().wrapping_sub(1);
        let mut d = difference(x, self.centre);
        let mut wild = Flag::default();
        for (place, (d, sigma)) in d.iter_mut().zip(self.known.model.sigma).enumerate() {
            let reach = f32::from_bits(sigma.to_bits() + (REACH_OCTAVES << 23)); // the exponent, grown
            *d = Flag::or_zero_by(there, place as u32, within(*d, reach));
            wild = wild | Flag::above(d.abs(), WILD_FROM * sigma);
        }
        let held = held | (wild & Flag::reached(self.tame.into(), WILD_ONCE_IN));
        self.tame = (!wild).count(self.tame.into(), WILD_ONCE_IN) as u8;
        (d, held)
    }

    #[inline(always)]
    fn images(&self) -> Images {
        let [by_fast, by_middle, by_slow, _] = self.metrics.map(|metric| metric.unpacked());
        Images {
            fast: by_fast.times(self.fast),
            middle: by_middle.times(self.middle),
            estimate: by_slow.times(self.estimate),
            estimate_by_middle: by_middle.times(self.estimate),
        }
    }

    /// The distance (1.6) of each time scale, all components retained, in units of its limit; of the trend as last found.
    #[inline(always)]
    fn severity(&self, images: &Images) -> [f32; SCALES] {
        let [fast, middle, slow] = [images.fast, images.middle, images.estimate].map(square);
        let [per_fast, per_middle, per_slow, _] = self.per_limit;
        [fast * per_fast, middle * per_middle, slow * per_slow, self.trending]
    }

    /// Moves the slow scale. While the loop recovers it waits at health, and so does the trend. A fault that seems to be gone is
    /// remembered as it was until that is decided.
    #[inline(always)]
    fn follow(&mut self, design: &Design, keep: Flag, recovering: Flag, deviation: [f32; 3]) {
        let [_, _, of_slow, _] = &design.scales;
        self.gain = greater(self.gain / (1.0 + self.gain), of_slow.weight());
        let keep = keep & !self.alarm.doubted();
        let stays = (!recovering).or_zero(1.0);
        self.estimate = smoothed(self.estimate, keep.or_zero(self.gain), deviation).map(|e| stays * e);
        self.trending *= stays;
        self.disturbed = self.disturbed | recovering;
    }

    /// Asks one of two questions about the fault, in slots that look at no sensor: whether the loop is moving (the fast scale runs
    /// ahead of the middle one), and whether the middle scale is far from the estimate.
    ///
    /// If it is, and an alarm `stands` by a fault that is not on its way out, the estimate begins again where the fault has come
    /// to stand: not while the loop is moving, for then it is the memory of the fault by which its end is seen.
    #[inline(always)]
    fn look_at_fault(&mut self, design: &Design, rules: &Rules, count: u32, stands: Flag, images: &Images) {
        let ([by_fast, ..], [per_fast, per_middle, ..]) = (&self.metrics, self.known.per_limit);
        let by_fast = by_fast.unpacked();
        if count % ROUND != ROUND - 1 {
            return;
        }
        if count & ROUND == 0 {
            let moving = differ(per_fast / MOVING_SHARE, images.fast, by_fast.times(self.middle));
            self.steady = (!moving).count(self.steady, rules.steady);
            return;
        }
        let far = differ(per_middle, images.middle, images.estimate_by_middle);
        self.still = (!far).count(self.still, rules.named_after);
        let again = stands & far & Flag::reached(self.steady, rules.steady);
        let [_, of_middle, ..] = &design.scales;
        self.gain = again.choose(of_middle.weight(), self.gain);
        self.estimate = smoothed(self.estimate, again.or_zero(1.0), self.middle);
        self.disturbed = self.disturbed | again; // the trend remembers a fault that has moved
    }

    /// What is learned while judging: the tail of a distance, one a slot; mean and metrics; which channel the metrics do without.
    #[inline(always)]
    fn learn(&mut self, design: &Design, count: u32, disturbed: Flag, held: Flag, fast: f32, severity: &[f32; SCALES]) {
        let [_, middle, slow, _] = severity;
        let [peak_of_middle, peak_of_slow] = &mut self.known.peak;
        // What raises an alarm is no tail, nor is what came before it.
        match count % ROUND {
            0 => self.known.exceed(disturbed | held, fast),
            1 => *peak_of_middle = (!disturbed).or_zero(greater(*peak_of_middle, *middle)),
            2 => *peak_of_slow = (!disturbed).or_zero(greater(*peak_of_slow, *slow)),
            _ => {}
        }
        let turn = count % PERIOD;
        if turn < TURNS {
            let [fast, middle, slow, trend] = severity.map(|severity| Flag::below(severity, SUSPECTED_FROM));
            let suspected = disturbed | held | Flag::any(self.losses.lost()) | !(fast & middle & slow & trend);
            self.take_turn(design, disturbed, suspected, turn as usize);
        }
    }

    /// What a few slots in a period do beside judging, each its own: they sharpen a scale, let the mean follow, or work out how a
    /// scale judges. What is lost is the same for all three; until the last is done, nothing is judged if that is another channel
    /// than before.
    #[inline(never)]
    fn take_turn(&mut self, design: &Design, disturbed: Flag, suspected: Flag, turn: usize) {
        if let Some((y, per_limit)) =
            [self.fast, self.middle, self.estimate, self.trend].get(turn).zip(self.per_limit.get_mut(turn))
        {
            *per_limit = self.known.sharpen(design, suspected, turn, *y).unwrap_or(*per_limit);
            return;
        }
        let Some(place) = turn.checked_sub(SCALES + 1) else {
            self.known.follow(design, suspected, self.middle);
            self.known.prove(design, disturbed);
            self.centre = self.known.centre();
            self.blind_next = self.losses.lost() as u8;
            return;
        };
        if let Some((metric, scale)) = self.metrics.get_mut(place).zip(self.known.model.scales.get(place)) {
            *metric = Packed::of(&scale.metric.unpacked().without(u32::from(self.blind_next)));
        }
        if place == TREND {
            self.blind = self.blind_next;
        }
        if place == SCALES {
            self.move_trend(design);
        }
    }

    /// Moves the trend by what the middle scale is now.
    #[inline(always)]
    fn move_trend(&mut self, design: &Design) {
        let ([.., of_trend], [.., by_trend], [.., per_trend]) = (&design.scales, &self.metrics, &self.per_limit);
        let from = self.trend.map(|trend| (!self.disturbed).or_zero(trend));
        self.trend = smoothed(from, of_trend.weight(), self.middle);
        self.trending = by_trend.unpacked().square_of(self.trend) * per_trend;
        self.disturbed = Flag::default();
    }
}

/// ln of the likelihood of the middle scale where the fault is gone over that where it stands as estimated.
///
/// Of a deviation y and an estimate f it is |f|^2/2 - y'f. By that scale's metric, so that noise counts by its memory; one
/// sample is the share of it that a sample has in what the scale averages. Where it is positive the motor is nearer to health
/// than to the fault: if that has moved, it is on its way out.
#[inline(always)]
fn over(images: &Images) -> f32 {
    let estimate = images.estimate_by_middle;
    0.5 * square(estimate) - inner(images.middle, estimate)
}

/// Whether two images differ by more than noise (given as its reciprocal), and by more than a share of the second.
#[inline(always)]
fn differ(per_noise: f32, a: [f32; 3], b: [f32; 3]) -> Flag {
    let beyond = (square(difference(a, b)) - MOVED_SHARE * MOVED_SHARE * square(b)) * per_noise - 1.0;
    !Flag::negative(beyond)
}

impl Judge {
    pub(super) fn limits(&self) -> [f32; SCALES] {
        self.known.per_limit.map(|per_limit| 1.0 / per_limit)
    }

    /// Whether the estimate has not yet averaged for as long as the slow scale does.
    pub(super) fn is_young(&self, design: &Design) -> bool {
        let [_, _, of_slow, _] = &design.scales;
        self.gain > of_slow.weight()
    }

    /// What is known of the fault: where the readings have moved to, and the noise in that. It is the estimate, or the trend where
    /// only that is beyond its limit.
    pub(super) fn located(&self, design: &Design, severity: &[f32; SCALES]) -> ([f32; 3], Noise) {
        let [.., slow, trend] = severity;
        let [.., of_slow, _] = &design.scales;
        let [.., metric_of_slow, metric_of_trend] = &self.known.model.scales;
        if *slow < 1.0 && slow < trend {
            return (self.trend, self.noise(&metric_of_trend.metric, 1.0, SETTLED_TO));
        }
        // By how much more or less the estimate averages than the slow scale does.
        let more = self.gain / (2.0 - self.gain) / of_slow.variance_ratio();
        let [_, of_middle, ..] = &design.scales;
        let young = self.gain / of_middle.weight();
        let settled_to = SETTLED_TO + (SETTLED_TO_AT_FIRST - SETTLED_TO) * young.min(1.0);
        (self.estimate, self.noise(&metric_of_slow.metric, more, settled_to))
    }

    /// The noise of the slow scale, which a fault is located by once it has stood for long.
    pub(super) fn noise_of_slow(&self) -> Noise {
        let [_, _, slow, _] = &self.known.model.scales;
        self.noise(&slow.metric, 1.0, SETTLED_TO)
    }

    /// So many times the variance that a metric is of.
    fn noise(&self, metric: &Packed, times: f32, settled_to: f32) -> Noise {
        let mut covariance = metric.unpacked().covariance().map(|column| column.map(|c| c * times));
        // Of a lost channel nothing is known.
        for (i, column) in covariance.iter_mut().enumerate() {
            for (j, (cell, sigma)) in column.iter_mut().zip(self.known.model.sigma).enumerate() {
                let blind = |k: usize| self.blind >> k & 1 != 0;
                if blind(i) || blind(j) {
                    *cell = if i == j { 1e6 * sigma * sigma } else { 0.0 };
                }
            }
        }
        Noise { covariance, sigma: self.known.model.sigma, settled_to }
    }
}
