//! When an alarm is raised, when it is withdrawn, and what may vote in between.

use core::hint::select_unpredictable;

use super::{at_least, at_most};
use crate::ewma::Ewma;

/// ln of the likelihood ratio at which the fault is taken to be gone: exp(18) to one.
const GONE: f32 = 18.0;

/// Share of its limit that a distance must come below before its scale counts as quiet.
const QUIET: f32 = 0.5;

/// How long the slower scales may stay without a vote, in time constants of the middle one, and how often they are asked
/// whether they still come down.
const RECOVERY: f32 = 32.0;
const RECOVERY_CHECK: f32 = 2.0;

/// Limit of the fast scale while slower ones have no vote, in limits: the loop still comes to rest, and noise on top of that
/// must not raise again what has just been withdrawn.
const RECOVERING_LIMIT: f32 = 2.0;

/// A recovery goes on while the distance falls below this share of what it was at the check before: a loop that settles with
/// a time constant of 8 checks or quicker.
const STILL_FALLING: f32 = 0.8;

/// Time for which a deviation must have stood still before it is named, in time constants of the middle scale.
const NAMED_AFTER: f32 = 1.0;

/// The frozen part, in samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rules {
    clear_hold: u32,
    recovery: u32,
    check: u32,
    /// Slots for which a deviation must have stood still before it is named.
    pub(super) named_after: u32,
    /// Slots without movement after which a loop counts as standing.
    pub(super) steady: u32,
}

/// What moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Alarm {
    /// ln of the likelihood of "the fault is gone" over "it stands", since it last could not be told.
    gone: f32,
    /// Slots since the fast scale was last beyond its limit, and since any scale was last not quiet.
    calm: u32,
    quiet: u32,
    /// Slots for which the slower scales are still without a vote; zero if they have one.
    recovery: u32,
    /// Slots for which the middle scale has been quiet while they had none.
    recovered: u32,
    /// The middle scale's distance at the last check.
    falling_from: f32,
}

/// What a sample says, each distance in units of its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence {
    pub(super) severity: [f32; 3],
    /// ln of the likelihood of the sample where the fault is gone over that where it stands.
    pub(super) gone: f32,
}

/// What the alarm does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Outcome {
    pub(super) up: bool,
    /// It went up with this sample, and is not the same fault's that has just been withdrawn.
    pub(super) new: bool,
    /// The loop recovers from a fault, or from a change of the set point: slower scales have no vote.
    pub(super) recovering: bool,
}

impl Rules {
    pub(super) fn new(clear_hold: u32, middle: &Ewma) -> Self {
        let samples = 1.0 / middle.weight();
        Rules {
            clear_hold: clear_hold.max(1),
            recovery: (RECOVERY * samples) as u32 + 1,
            check: (RECOVERY_CHECK * samples) as u32 + 1,
            named_after: (NAMED_AFTER * samples) as u32,
            steady: samples as u32,
        }
    }
}

impl Alarm {
    /// As after a change of the set point: slower scales have no vote until the loop has settled.
    pub(super) fn recovering(rules: &Rules) -> Self {
        Alarm { recovery: rules.recovery, falling_from: f32::MAX, ..Alarm::default() }
    }

    /// Takes one sample's evidence. `up` is whether the alarm was up before it.
    #[inline(always)]
    pub(super) fn step(&mut self, rules: &Rules, up: bool, evidence: &Evidence) -> Outcome {
        let [fast, middle, slow] = evidence.severity;
        let any_beyond = (fast > 1.0) | (middle > 1.0) | (slow > 1.0);
        let all_quiet = (fast <= 1.0) & (middle < QUIET) & (slow < QUIET);
        self.calm = select_unpredictable(fast > 1.0, 0, self.calm.saturating_add(1));
        self.quiet = select_unpredictable(all_quiet, self.quiet.saturating_add(1), 0);
        // Page's test (1954) of the fault that stands against none; its sum is bounded, so that it can turn at once.
        let gone = at_most(at_least(self.gone + evidence.gone, 0.0), 2.0 * GONE);
        self.gone = select_unpredictable(up, gone, 0.0);

        let is_gone = self.gone >= GONE;
        let healthy = (self.calm >= rules.clear_hold) & (is_gone | (self.quiet >= rules.clear_hold));
        let withdrawn = up & healthy;
        let was_recovering = self.recovery > 0;
        self.recover(rules, middle);
        self.recovery = select_unpredictable(withdrawn & is_gone, rules.recovery, self.recovery);
        self.falling_from = select_unpredictable(withdrawn, f32::MAX, self.falling_from);
        let recovering = self.recovery > 0;
        let beyond = select_unpredictable(recovering, fast > RECOVERING_LIMIT, any_beyond);
        let raised = !up & beyond;
        Outcome { up: (up & !withdrawn) | raised, new: raised & !was_recovering, recovering }
    }

    /// Lets one slot of a recovery go by. It ends when the middle scale has been quiet for long enough, when it no longer
    /// comes down, or when its time is over.
    #[inline(always)]
    fn recover(&mut self, rules: &Rules, middle: f32) {
        self.recovered = select_unpredictable(middle < QUIET, self.recovered.saturating_add(1), 0);
        let check = self.recovery.is_multiple_of(rules.check);
        let stands = check & (middle >= QUIET) & (middle > STILL_FALLING * self.falling_from);
        self.falling_from = select_unpredictable(check, middle, self.falling_from);
        let over = stands | (self.recovered >= rules.check);
        self.recovery = select_unpredictable(over, 0, self.recovery.saturating_sub(1));
    }
}
