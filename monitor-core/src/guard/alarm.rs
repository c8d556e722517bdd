//! When an alarm is raised, when it is withdrawn, and what may vote in between.

use super::SCALES;
use super::design::{Config, ConfigError, Design, whole_slots};
use super::flag::{Flag, greater, lesser, positive_part};
use super::sensor::ROUND;

/// ln of the likelihood ratio at which the fault is taken to be gone: exp(18) to one.
const GONE: f32 = 18.0;

/// The one from which on that is likely enough for the fault not to be averaged any further: while it stands, a sum that
/// begins comes so far at most once in exp(4.5) = 90 times (Wald 1947).
const DOUBTED: f32 = 4.5;

/// Share of its limit that a distance must come below before its scale counts as quiet.
const QUIET: f32 = 0.5;

/// How long the slower scales may stay without a vote, in time constants of the middle one, and how often they are asked
/// whether they still come down.
const RECOVERY: f32 = 32.0;
const RECOVERY_CHECK: f32 = 2.0;

/// What the fast scale must have come below for an alarm to be withdrawn, in limits, and its limit while slower scales have no
/// vote: the loop still comes to rest, and noise on top of that must not raise again what has just been withdrawn.
const CALM: f32 = 1.4;
const RECOVERING_LIMIT: f32 = 2.5;

/// A recovery goes on while the distance falls below this share of what it was at the check before: a loop that settles with
/// a time constant of 8 checks or quicker.
const STILL_FALLING: f32 = 0.8;

/// The same after a change of the set point: a speed loop may be as slow as it likes, so it is asked less often, and given more
/// time for as long as it comes down. That is a time of motors, in seconds; where samples are few, the middle scale must forget in
/// between what was before.
const SETTLING_CHECK: f32 = 16.0;
const SETTLING_CHECK_S: f32 = 1.25;
const FORGOTTEN: f32 = 4.0;

/// Time for which a deviation must have stood still before it is named, in time constants of the middle scale.
const NAMED_AFTER: f32 = 1.0;

/// Slots from one look at whether a fault has moved to the next: in two rounds of the sensors there are two slots that look
/// at none, and two questions.
const LOOK: u32 = 2 * ROUND;

/// The frozen part, in samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rules {
    raise_hold: u32,
    clear_hold: u32,
    recovery: u32,
    /// Longest that a loop is given to settle at a known set point.
    settling: u32,
    check: u32,
    settling_check: u32,
    /// Slots until the first check, so that the last falls on the end.
    first_check: u32,
    /// Looks for which a deviation must have stood still before it is named.
    pub(super) named_after: u32,
    /// Looks without movement after which a loop counts as standing.
    pub(super) steady: u32,
    /// The share of one sample in what the middle scale averages.
    pub(super) per_sample: f32,
}

/// What moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Alarm {
    /// ln of the likelihood of "the fault is gone" over "it stands", since it last could not be told.
    gone: f32,
    /// Slots for which some scale has been beyond its limit, up to the hold.
    beyond: u32,
    /// Slots since the fast scale was last not calm, and since any scale was last not quiet; up to the hold.
    calm: u32,
    quiet: u32,
    /// Slots for which the slower scales are still without a vote; zero if they have one.
    recovery: u32,
    /// Slots until it is asked again whether they still come down.
    until_check: u32,
    /// Slots for which the middle scale has been quiet while they had none.
    recovered: u32,
    /// The middle scale's distance at the last check, or at the last by which it had come down.
    falling_from: f32,
    /// Whether it is the set point that has changed: then no scale has a vote, and none says that a fault is gone.
    settling: Flag,
}

/// What a sample says, each distance in units of its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence {
    pub(super) severity: [f32; SCALES],
    /// ln of the likelihood of the sample where the fault is gone over that where it stands.
    pub(super) gone: f32,
    /// Whether the loop has stood for a while, wherever.
    pub(super) steady: Flag,
}

/// What the alarm does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Outcome {
    pub(super) up: Flag,
    /// It went up with this sample, and is not the same fault's that has just been withdrawn.
    pub(super) new: Flag,
    /// It is up, or would be if not for the hold, or the loop recovers: what is read is not health.
    pub(super) disturbed: Flag,
    /// The loop recovers from a fault, or from a change of the set point: slower scales have no vote.
    pub(super) recovering: Flag,
    /// It is from a change of the set point.
    pub(super) settling: Flag,
}

impl Rules {
    /// # Errors
    /// [`ConfigError`] names the hold that is out of range.
    pub(super) fn new(config: &Config, design: &Design) -> Result<Self, ConfigError> {
        let hold = |seconds: f32| whole_slots(seconds * config.sample_rate_hz).map(|slots| slots.max(1));
        let [_, middle, ..] = &design.scales;
        let samples = 1.0 / middle.weight();
        let settling_check = (SETTLING_CHECK_S * config.sample_rate_hz / samples).clamp(FORGOTTEN, SETTLING_CHECK);
        let [recovery, check, settling_check] =
            [RECOVERY, RECOVERY_CHECK, settling_check].map(|constants| (constants * samples) as u32 + 1);
        Ok(Rules {
            raise_hold: hold(config.raise_hold_s).ok_or(ConfigError::RaiseHold)?,
            clear_hold: hold(config.clear_hold_s).ok_or(ConfigError::ClearHold)?,
            recovery,
            settling: design.gate.settle_samples().max(recovery),
            check,
            settling_check,
            first_check: recovery % check.max(1),
            named_after: ((NAMED_AFTER * samples) as u32).div_ceil(LOOK),
            steady: (samples as u32).div_ceil(LOOK),
            per_sample: middle.variance_ratio(),
        })
    }

    /// Slots that an alarm has been held back when it is raised.
    #[inline(always)]
    pub(super) fn held_before_raised(&self) -> u64 {
        u64::from(self.raise_hold - 1)
    }
}

impl Alarm {
    /// As after a change to a known set point: nothing has a vote until the loop has settled.
    pub(super) fn settling(rules: &Rules) -> Self {
        let (recovery, until_check) = (rules.settling, 2 * rules.check);
        Alarm { recovery, until_check, falling_from: f32::MAX, settling: Flag::new(true), ..Alarm::default() }
    }

    /// Takes one sample's evidence. `up` is whether the alarm was up before it.
    #[inline(always)]
    pub(super) fn step(&mut self, rules: &Rules, up: Flag, evidence: &Evidence) -> Outcome {
        let [fast, middle, slow, trend] = evidence.severity;
        let fast_beyond = Flag::above(fast, 1.0);
        let any_beyond = fast_beyond | Flag::above(greater(greater(middle, slow), trend), 1.0);
        let all_quiet = !fast_beyond & Flag::below(greater(greater(middle, slow), trend), QUIET);
        self.calm = (!Flag::above(fast, CALM)).count(self.calm, rules.clear_hold);
        self.quiet = all_quiet.count(self.quiet, rules.clear_hold);
        // Page's test (1954) of the fault that stands against none; its sum is bounded, so that it can turn at once.
        self.gone = (up & !self.settling).or_zero(lesser(positive_part(self.gone + evidence.gone), 2.0 * GONE));

        let is_gone = !Flag::below(self.gone, GONE);
        let is_quiet = Flag::reached(self.quiet, rules.clear_hold);
        let calm = Flag::reached(self.calm, rules.clear_hold);
        let withdrawn = up & calm & (is_gone | is_quiet) & !self.settling;
        let was_recovering = Flag::any(self.recovery) & !self.settling;
        self.recover(rules, middle, evidence.steady, withdrawn, is_gone);
        let recovering = Flag::any(self.recovery);
        self.settling = self.settling & recovering;
        let beyond = (recovering & !self.settling & Flag::above(fast, RECOVERING_LIMIT)) | (!recovering & any_beyond);
        self.beyond = beyond.count(self.beyond, rules.raise_hold);
        let raised = !up & Flag::reached(self.beyond, rules.raise_hold);
        let (up, new, settling) = ((up & !withdrawn) | raised, raised & !was_recovering, self.settling);
        Outcome { up, new, disturbed: up | recovering | beyond, recovering, settling }
    }

    /// Whether the fault seems to be gone, though that is not decided.
    #[inline(always)]
    pub(super) const fn doubted(&self) -> Flag {
        Flag::above(self.gone, DOUBTED)
    }

    /// Lets one slot of a recovery go by, or begins one. It ends when the middle scale has been quiet for long enough, when it
    /// no longer comes down, or when its time is over. What a new set point moves may rise before it falls: there the loop
    /// must have come to stand as well.
    #[inline(always)]
    fn recover(&mut self, rules: &Rules, middle: f32, steady: Flag, withdrawn: Flag, is_gone: Flag) {
        let (quiet, check) = (Flag::below(middle, QUIET), !Flag::any(self.until_check));
        self.recovered = quiet.count(self.recovered, rules.check);
        let falls = !Flag::above(middle, STILL_FALLING * self.falling_from);
        let stands = check & !quiet & !falls & (steady | !self.settling);
        let over = stands | Flag::reached(self.recovered, rules.check);
        let more = check & falls & self.settling;
        let left = more.choose_word(rules.settling, self.recovery - Flag::any(self.recovery).bit());
        let left = (!over).choose_word(left, 0);
        let every = self.settling.choose_word(rules.settling_check, rules.check);
        let begins = withdrawn & is_gone;
        self.recovery = begins.choose_word(rules.recovery, left);
        self.until_check = begins.choose_word(rules.first_check, check.choose_word(every, self.until_check) - 1);
        // A loop that swings comes down again and again, but not to ever less.
        let next = check & (falls | !self.settling);
        self.falling_from = withdrawn.choose(f32::MAX, next.choose(middle, self.falling_from));
    }
}
