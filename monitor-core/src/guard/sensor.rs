//! Sensor loss: a channel whose readings are no readings any more, stand still, or have lost their noise.
//!
//! A healthy sensor's reading changes from sample to sample by its own noise. The mean square of those changes is watched: a
//! stuck sensor's falls to zero, a dying one's collapses, and readings that repeat because the converter is coarse are in
//! what was learned. No count of repeats has to be chosen.

use core::hint::select_unpredictable;

/// Weight of the newest change: the mean square then is that of some sixty samples, and normal noise never makes it
/// fall to a sixteenth of its mean (below 1e-30 for a chi-square of 60 degrees of freedom).
const WEIGHT: f32 = 1.0 / 32.0;

/// A stuck channel's mean square falls exponentially, so how long it has stood still is in the logarithm: it is stuck below
/// mean (least/mean)^6 / 8, of the mean squares seen while learning. Readings of a coarse converter repeat in runs whose
/// lengths are exponential, and the longest run in years is some five or six times the longest in seconds.
const RUNS: i32 = 5;
const STUCK_SHARE: f32 = 0.125;

/// It moves again above so many times that.
const AGAIN: f32 = 4.0;

/// Readings in a row that are none before their sensor counts as lost, and that are fit before it counts as back.
const RUN: u32 = 16;

/// Slots until the mean square has forgotten where it started.
const WARM_UP: u32 = 256;

/// What moves: the readings before, and the mean square of the changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Senses {
    previous: [f32; 3],
    activity: [f32; 3],
    slots: u32,
}

impl Senses {
    /// Takes the readings of a slot that are fit, channel by channel.
    #[inline(always)]
    pub(super) fn step(&mut self, fit: [bool; 3], x: [f32; 3]) {
        let states = self.previous.iter_mut().zip(&mut self.activity);
        for ((previous, activity), (x, fit)) in states.zip(x.into_iter().zip(fit)) {
            let x = select_unpredictable(fit, x, *previous);
            let change = x - *previous;
            // What a wild reading leaves behind must be able to fade.
            let square = (change * change).min(1e30);
            let weight = select_unpredictable(fit, WEIGHT, 0.0);
            *activity += weight * (square - *activity);
            *previous = x;
        }
        self.slots = self.slots.saturating_add(1);
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

    pub(super) fn push(&mut self, senses: &Senses) {
        if senses.slots < WARM_UP {
            return;
        }
        self.slots += 1.0;
        for ((least, mean), activity) in self.least.iter_mut().zip(&mut self.mean).zip(senses.activity) {
            *least = least.min(activity);
            *mean += (activity - *mean) / self.slots;
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

/// Which channels are lost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Losses {
    stuck: [bool; 3],
    /// Slots in a row whose reading was none, up to `RUN`; counted down by readings that are fit.
    unfit: [u32; 3],
    unfit_lost: [bool; 3],
}

impl Losses {
    /// Judges a slot by the levels below which channels are stuck.
    #[inline(always)]
    pub(super) fn step(&mut self, fit: [bool; 3], senses: &Senses, stuck_below: &[f32; 3]) {
        for (stuck, (activity, level)) in self.stuck.iter_mut().zip(senses.activity.iter().zip(stuck_below)) {
            *stuck = *activity < select_unpredictable(*stuck, AGAIN * level, *level);
        }
        for ((run, lost), fit) in self.unfit.iter_mut().zip(&mut self.unfit_lost).zip(fit) {
            *run = select_unpredictable(fit, run.saturating_sub(1), (*run + 1).min(RUN));
            *lost = (*run >= RUN) | (*lost & (*run > 0));
        }
    }

    pub(super) const fn stuck(&self) -> [bool; 3] {
        self.stuck
    }

    pub(super) const fn silent(&self) -> [bool; 3] {
        self.unfit_lost
    }

    /// Channels that say nothing.
    #[inline(always)]
    pub(super) fn lost(&self) -> [bool; 3] {
        let ([a, b, c], [x, y, z]) = (self.stuck, self.unfit_lost);
        [a | x, b | y, c | z]
    }
}
