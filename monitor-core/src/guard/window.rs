//! Phase I of `guard` mode: what a window of healthy samples leaves behind, in constant work and memory.

use super::design::Design;
use super::flag::Flag;
use super::smoothed;
use crate::ewma::Ewma;
use crate::moments::{Clip, Moments, Statistics};

/// Reach of the clip, in standard deviations of the seeding window: normal noise passes (one in 2 million), and a spike
/// counts for no more than five sigmas.
const CLIP_SIGMAS: f32 = 5.0;

/// Place of the middle time scale among what is gathered: the channels as they are, then smoothed at each time scale.
pub(super) const MIDDLE: usize = 2;

/// A learning window: moments of the clipped channels and of what the three time scales make of them.
///
/// Every slot smooths; one of the four moments takes the result in turn. Smoothed channels change little in four slots, so
/// little is lost, and a slot costs one push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    clip: Clip<3>,
    /// The mean of the seeding window, from which deviations are taken.
    pub(super) centre: [f32; 3],
    smoothed: [[f32; 3]; 3],
    pub(super) moments: [Moments<3>; 4],
    /// Mean deviation over the first half, at the middle time scale.
    pub(super) first_half: [f32; 3],
    pub(super) clipped: u32,
    pub(super) slots: u32,
}

impl Window {
    pub(super) fn after(seed: &Statistics<3>) -> Self {
        Window {
            clip: Clip::at(seed, CLIP_SIGMAS),
            centre: seed.mean.into(),
            smoothed: [[0.0; 3]; 3],
            moments: [Moments::around([0.0; 3]); 4],
            first_half: [0.0; 3],
            clipped: 0,
            slots: 0,
        }
    }

    /// Lets one slot go by; `held` if it has no sample that is fit.
    pub(super) fn push(&mut self, design: &Design, held: Flag, x: [f32; 3]) {
        let (x, clipped) = self.clip.apply(if held.is_set() { self.centre } else { x });
        self.clipped += u32::from(clipped);
        let deviation = super::difference(x, self.centre);
        // No loop: its condition would be asked once, by a branch, and not masked in each round.
        let weight = |scale: &Ewma| (!held).or_zero(scale.weight());
        let ([of_fast, of_middle, of_slow, _], [fast, middle, slow]) = (&design.scales, self.smoothed);
        let fast = smoothed(fast, weight(of_fast), deviation);
        let middle = smoothed(middle, weight(of_middle), deviation);
        let slow = smoothed(slow, weight(of_slow), deviation);
        self.smoothed = [fast, middle, slow];
        let turn = (self.slots % 4) as usize;
        if let (Some(moments), Some(y)) = (self.moments.get_mut(turn), [deviation, fast, middle, slow].get(turn)) {
            moments.push_unless(held.is_set(), *y);
        }
        self.slots += 1;
        if self.slots == design.learn_slots / 2
            && let Some(middle) = self.moments.get(MIDDLE)
        {
            self.first_half = middle.mean();
        }
    }

    /// Share of the samples of which a reading was clipped.
    pub(super) fn clipped_share(&self) -> f32 {
        self.clipped as f32 / self.slots.max(1) as f32
    }
}
