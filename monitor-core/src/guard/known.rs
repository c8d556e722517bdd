//! What is known of the healthy motor while it is judged, and how that sharpens.

use super::SCALES;
use super::design::Design;
use super::flag::{Flag, greater, lesser, positive_part, within};
use super::level::PERIOD;
use super::model::Model;
use crate::moments::Statistics;

/// Limits while a model proves itself: what it rests on is not what it judges.
const UNPROVEN: f32 = 1.5;

/// Most that the tail of a statistic may raise its limit. Beyond, the window was not healthy.
const RAISED_TO: f32 = 4.0;

/// The tail of the fast scale's distance begins here: one normal sample in a thousand is beyond.
const TAIL_FROM: f32 = 16.27;

/// How far those are beyond on average.
const NORMAL_EXCESS: f32 = 2.105;

/// The same before any is known, in units of that, and the share of the newest.
const EXCESS_AT_FIRST: f32 = 1.3;
const EXCESS_GAIN: f32 = 1.0 / 256.0;

/// Excess that is taken for chance, in units of the normal one, and how much further than what is more the tail is taken to
/// reach: the mean excess of such tails goes on growing.
const EXCESS_BY_CHANCE: f32 = 1.1;
const EXCESS_GROWS: f32 = 1.5;

/// How far the noise of a set point may be from that of its neighbours for them to lend theirs, as a factor of the standard deviation.
const ALIKE_WITHIN: f32 = 1.25;

/// What a model brings with it when it is installed or recalled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    pub(super) model: Model,
    /// Activity of each channel below which its sensor is stuck.
    pub(super) stuck_below: [f32; 3],
    /// The reciprocal of the limit of each time scale, as sharp as it is by now.
    pub(super) per_limit: [f32; SCALES],
    /// Slots that metrics and limits rest on.
    slots: f32,
    /// Slots that the mean rests on: fewer, where a neighbour has lent the rest.
    mean_slots: f32,
    /// Slots until the limits are proven, in whole periods.
    unproven: u32,
    /// Mean excess of the fast scale's distance over where its tail begins.
    excess: f32,
    /// Largest distance of the middle and the slow scale while limits were not proven and no alarm stood, of the slots that
    /// looked at it, in units of the limit that was judged by.
    pub(super) peak: [f32; 2],
    /// Slow movement of the mean that is taken to be benign.
    drift: [f32; 3],
}

impl Known {
    pub(super) fn new(model: Model, stuck_below: [f32; 3], learned_slots: u32) -> Self {
        let slots = learned_slots as f32;
        let mut known = Known { model, stuck_below, slots, mean_slots: slots, unproven: learned_slots, ..Known::BLANK };
        known.excess = EXCESS_AT_FIRST * NORMAL_EXCESS;
        known.set_limits();
        known
    }

    fn set_limits(&mut self) {
        for (place, (per_limit, scale)) in self.per_limit.iter_mut().zip(&self.model.scales).enumerate() {
            *per_limit = 1.0 / reaching(place, scale.level.limit(self.slots, self.mean_slots), self.excess);
        }
    }

    /// What is known of a set point between two known ones, of which a seeding window has been seen: its mean is that of the
    /// window, and everything else what the noisier of the two lends. None if the noise of the window is not like theirs.
    pub(super) fn lent(seed: &Statistics<3>, neighbours: [&Known; 2], design: &Design) -> Option<Self> {
        let [a, b] = neighbours;
        let (of_seed, mean): ([f32; 3], [f32; 3]) = (seed.sigma().into(), seed.mean.into());
        let is_alike = |sigma: f32, lender: f32| (1.0 / ALIKE_WITHIN..ALIKE_WITHIN).contains(&(sigma / lender));
        let alike = |lender: &Known| of_seed.into_iter().zip(lender.model.sigma).all(|(s, l)| is_alike(s, l));
        if !(alike(a) && alike(b)) {
            return None;
        }
        let lender = if a.model.is_noisier_than(&b.model) { a } else { b };
        let mut known = *lender;
        known.model.mean = mean;
        known.mean_slots = seed.samples as f32;
        for ((below, a), b) in known.stuck_below.iter_mut().zip(a.stuck_below).zip(b.stuck_below) {
            *below = a.min(b);
        }
        known.excess = a.excess.max(b.excess);
        (known.drift, known.peak, known.unproven) = ([0.0; 3], [0.0; 2], design.learn_slots);
        known.set_limits();
        Some(known)
    }

    /// Whether nothing is known.
    pub(super) const fn is_blank(&self) -> bool {
        self.slots == 0.0
    }

    /// Whether a whole learning window of healthy samples has been seen, and not lent by neighbours.
    pub(super) fn is_own(&self, design: &Design) -> bool {
        self.mean_slots >= design.learn_slots as f32
    }

    pub(super) const BLANK: Self = Known {
        model: Model::BLANK,
        stuck_below: [0.0; 3],
        per_limit: [0.0; SCALES],
        slots: 0.0,
        mean_slots: 0.0,
        unproven: 0,
        excess: 0.0,
        peak: [0.0; 2],
        drift: [0.0; 3],
    };

    /// Hands out every number of it in turn, to be read or written.
    pub(super) fn each_number(&mut self, f: &mut impl FnMut(&mut f32)) {
        self.model.each_number(f);
        let arrays =
            self.stuck_below.iter_mut().chain(&mut self.per_limit).chain(&mut self.peak).chain(&mut self.drift);
        arrays.chain([&mut self.slots, &mut self.mean_slots, &mut self.excess]).for_each(&mut *f);
        // Whole periods, of which an f32 counts 2^24.
        let mut periods = (self.unproven / PERIOD) as f32;
        f(&mut periods);
        self.unproven = periods as u32 * PERIOD;
    }

    /// Whether samples can be judged by it.
    pub(super) fn is_usable(&self) -> bool {
        let (mut finite, mut known) = (true, *self);
        known.each_number(&mut |number| finite &= number.is_finite());
        let sharp = self.per_limit.iter().all(|per_limit| *per_limit > 0.0);
        finite && sharp && self.slots >= 1.0 && self.mean_slots >= 1.0 && self.model.is_usable()
    }

    /// Where deviations are taken from: the mean, with what it has drifted.
    #[inline(always)]
    pub(super) fn centre(&self) -> [f32; 3] {
        let ([a, b, c], [x, y, z]) = (self.model.mean, self.drift);
        [a + x, b + y, c + z]
    }

    #[cfg(test)]
    pub(super) const fn is_unproven(&self) -> bool {
        self.unproven > 0
    }

    /// The reciprocal of the limit that a scale is judged by. Until it is proven it is a wider one.
    #[inline(always)]
    pub(super) fn judged_by(&self, per_limit: f32) -> f32 {
        per_limit * Flag::any(self.unproven).choose(1.0 / UNPROVEN, 1.0)
    }

    /// Sharpens a scale by a smoothed deviation that is healthy beyond suspicion. The work is the same for one that is not; then
    /// nothing changes. Returns the reciprocal of the limit that it is judged by.
    #[inline(always)]
    pub(super) fn sharpen(&mut self, design: &Design, suspected: Flag, place: usize, y: [f32; 3]) -> Option<f32> {
        let healthy = !suspected;
        let gain = healthy.or_zero(PERIOD as f32) / self.slots;
        // In the last period of the proof the limit is widened by the tail that was seen, once.
        let due = Flag::any(self.unproven) & !Flag::reached(self.unproven, PERIOD + 1);
        let tail = place
            .checked_sub(1)
            .and_then(|place| self.peak.get(place).zip(design.expected_peaks.get(place)))
            .map_or(1.0, |(peak, expected)| UNPROVEN * peak / expected);
        let tail = lesser(greater(tail, 1.0), RAISED_TO);
        let scale = self.model.scales.get_mut(place)?;
        scale.sharpen(y.map(|y| healthy.or_zero(y)), gain);
        scale.level.widen(due.choose(tail, 1.0));
        let per_limit = 1.0 / reaching(place, scale.level.limit(self.slots, self.mean_slots), self.excess);
        *self.per_limit.get_mut(place)? = per_limit;
        Some(self.judged_by(per_limit))
    }

    /// Looks at the tail of the fast scale by one of its distances.
    #[inline(always)]
    pub(super) fn exceed(&mut self, disturbed: Flag, distance: f32) {
        let in_tail = !disturbed & Flag::above(distance, TAIL_FROM);
        let excess = lesser(positive_part(distance - TAIL_FROM), RAISED_TO * NORMAL_EXCESS);
        self.excess += in_tail.or_zero(EXCESS_GAIN) * (excess - self.excess);
    }

    /// Lets the mean follow a deviation of the middle scale that is healthy beyond suspicion.
    #[inline(always)]
    pub(super) fn follow(&mut self, design: &Design, suspected: Flag, middle: [f32; 3]) {
        let period = (!suspected).or_zero(PERIOD as f32);
        self.slots += period;
        // A mean that may not follow gets no better either.
        self.mean_slots += Flag::new(design.follows).or_zero(period);
        let share = period / lesser(self.mean_slots, design.memory_slots);
        for ((drift, moved), sigma) in self.drift.iter_mut().zip(middle).zip(self.model.sigma) {
            *drift = within(*drift + share * moved, design.drift_sigmas * sigma);
        }
    }

    /// A period has gone by. Behind a disturbance the proof begins again, for its peaks do too.
    #[inline(always)]
    pub(super) fn prove(&mut self, design: &Design, disturbed: Flag) {
        let again = disturbed & Flag::any(self.unproven);
        self.unproven = again.choose_word(design.learn_slots, self.unproven.saturating_sub(PERIOD));
    }
}

/// A limit that reaches as far as the tail of its scale does, of which the fast one's is known by its mean excess. A few samples
/// are not yet normal, whatever the readings are; slower scales average so many that they are.
#[inline(always)]
fn reaching(place: usize, limit: f32, excess: f32) -> f32 {
    if place > 0 {
        return limit;
    }
    let more = positive_part(excess / NORMAL_EXCESS - EXCESS_BY_CHANCE);
    TAIL_FROM + (limit - TAIL_FROM) * (1.0 + EXCESS_GROWS * more)
}
