//! Sensor loss: a channel whose readings are no readings any more, stand still, or have lost their noise.
//!
//! A healthy sensor's reading changes from sample to sample by its own noise. The mean square of those changes is watched: a
//! stuck sensor's falls to zero, a dying one's collapses, and readings that repeat because the converter is coarse are in
//! what was learned. No count of repeats has to be chosen.

use super::flag::{Flag, lesser};
use crate::moments::Moments;

/// Slots of a round: each channel is looked at once in it, so that no slot looks at all of them.
pub(super) const ROUND: u32 = 4;

/// Weight of the newest change: the mean square then is that of some fifteen.
const WEIGHT: f32 = 1.0 / 8.0;

/// A stuck channel's mean square falls exponentially, so how long it has stood still is in the logarithm: it is stuck below
/// mean (least/mean)^6 / 8, of the mean squares seen while learning. Readings of a coarse converter repeat in runs whose
/// lengths are exponential, and the longest run in years is some five or six times the longest in seconds.
const RUNS: i32 = 5;
const STUCK_SHARE: f32 = 0.125;

/// It moves again above so many times that.
const AGAIN: f32 = 4.0;

/// Readings in a row, as they are looked at, that are none before a sensor counts as lost, and that are fit before it counts as
/// back: 16 slots.
const RUN: u32 = 4;

/// Rounds until the mean square has forgotten where it started: four of its time constants.
const WARM_UP: u32 = 32;

/// Two seeding windows and a learning window, as short as they may be, are longer: something is always seen.
const _: () = assert!(WARM_UP * ROUND < 6 * Moments::<3>::MIN_SAMPLES);

/// One channel: the reading before, and the mean square of the changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sense {
    /// No number before the first.
    previous: f32,
    activity: f32,
}

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Senses {
    channels: [Sense; 3],
}

impl Senses {
    /// Of sensors that have said nothing yet.
    pub(super) const NONE: Self = Senses { channels: [Sense { previous: f32::NAN, activity: 0.0 }; 3] };

    /// Lets a first reading be no change.
    pub(super) fn begin(&mut self, turn: usize, x: f32) {
        if let Some(sense) = self.channels.get_mut(turn).filter(|sense| sense.previous.is_nan() && x.is_finite()) {
            sense.previous = x;
        }
    }

    /// Takes the reading of the channel whose turn it is, if it is fit. Returns the channel's activity.
    #[inline(always)]
    pub(super) fn step(&mut self, turn: usize, x: f32) -> f32 {
        let Some(sense) = self.channels.get_mut(turn) else { return 0.0 };
        let fit = !Flag::unfit(x);
        let x = fit.choose(x, sense.previous);
        let change = x - sense.previous;
        // What a wild reading leaves behind must be able to fade.
        let square = lesser(change * change, 1e30);
        sense.activity += fit.or_zero(WEIGHT) * (square - sense.activity);
        sense.previous = x;
        sense.activity
    }
}

/// What was seen of the activity of each channel while learning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Activity {
    least: [f32; 3],
    mean: [f32; 3],
    slots: f32,
}

impl Activity {
    pub(super) const NONE: Self = Activity { least: [f32::MAX; 3], mean: [0.0; 3], slots: 0.0 };

    /// Takes what the senses say after so many slots.
    pub(super) fn push(&mut self, senses: &Senses, slots: u32) {
        if slots < WARM_UP * ROUND {
            return;
        }
        self.slots += 1.0;
        for ((least, mean), sense) in self.least.iter_mut().zip(&mut self.mean).zip(senses.channels) {
            *least = least.min(sense.activity);
            *mean += (sense.activity - *mean) / self.slots;
        }
    }

    /// Below these a channel is stuck.
    pub(super) fn stuck_below(&self) -> [f32; 3] {
        let mut below = self.least;
        for (below, mean) in below.iter_mut().zip(self.mean) {
            let share = *below / mean.max(f32::MIN_POSITIVE);
            *below *= STUCK_SHARE * (0..RUNS).fold(1.0, |power, _| power * share);
        }
        below
    }
}

/// Which channels are lost, a bit each: the first's is the lowest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Losses {
    stuck: u32,
    silent: u32,
    /// Readings in a row that were none, up to `RUN`; counted down by those that are fit.
    unfit: [u32; 3],
}

impl Losses {
    /// Judges the channel that the slot has looked at, by its reading and its activity.
    #[inline(always)]
    pub(super) fn step(&mut self, turn: usize, x: f32, activity: f32, stuck_below: f32) {
        let Some(run) = self.unfit.get_mut(turn) else { return };
        let place = turn as u32;
        let unfit = Flag::unfit(x);
        let level = Flag::of(self.stuck, place).choose(AGAIN, 1.0) * stuck_below;
        self.stuck = self.stuck & !(1 << place) | Flag::below(activity, level).bit() << place;
        let (longer, shorter) = (unfit & !Flag::reached(*run, RUN), !unfit & Flag::any(*run));
        *run = *run + longer.bit() - shorter.bit();
        let silent = Flag::reached(*run, RUN) | (Flag::of(self.silent, place) & Flag::any(*run));
        self.silent = self.silent & !(1 << place) | silent.bit() << place;
    }

    pub(super) const fn stuck(&self) -> u32 {
        self.stuck
    }

    pub(super) const fn silent(&self) -> u32 {
        self.silent
    }

    /// Channels that say nothing.
    #[inline(always)]
    pub(super) const fn lost(&self) -> u32 {
        self.stuck | self.silent
    }
}
