//! What a monitor in `guard` mode says of one sample.

use super::SCALES;
use super::flag::Flag;
use crate::sample::Absence;
use crate::sample::Channel;

/// What the monitor is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// Waiting for the loop to settle after a change of the set point: for a fixed time before learning, and until it is seen
    /// to have settled where the set point is known.
    #[default]
    Settling,
    /// Gathering the seeding windows, by which spikes will be known.
    Seeding,
    /// Gathering the learning window.
    Learning,
    /// The window is complete; [`finish_learning`](super::Monitor::finish_learning) has not been called yet.
    ModelDue,
    /// Every sample is judged.
    Monitoring,
    /// Nothing is known of this set point, and a fault is suspected: what would be learned now might be the fault.
    Withheld,
}

/// Why a channel says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Loss {
    /// Its readings stand still, or have lost their noise.
    Stuck,
    /// Its readings are no numbers, or are out of range.
    Silent,
}

/// The standing of a slot in one word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Standing(u32);

const ALARM: u32 = 1;
const RECOVERING: u32 = 1 << 1;
const NAMED: u32 = 1 << 2;
const HELD: u32 = 1 << 3;
const STUCK_SHIFT: u32 = 4;
const SILENT_SHIFT: u32 = 7;
const LATE: u32 = 1 << 10;
const MISSING: u32 = 1 << 11;
const SET_POINT: u32 = 1 << 12;
const GAP: u32 = 1 << 13;
const SETTLING_SHIFT: u32 = 14;
const SETTLING: u32 = 1 << SETTLING_SHIFT;

impl Standing {
    #[inline(always)]
    pub(super) const fn new([alarm, recovering, named, held, settling]: [Flag; 5], stuck: u32, silent: u32) -> Self {
        let flags = alarm.bit() | recovering.bit() << 1 | named.bit() << 2 | held.bit() << 3;
        Standing(flags | settling.bit() << SETTLING_SHIFT | stuck << STUCK_SHIFT | silent << SILENT_SHIFT)
    }

    pub(super) const fn alarm(self) -> bool {
        self.0 & ALARM != 0
    }

    /// The same alarm, nothing else, and why the slot has no sample that was judged.
    pub(super) const fn unjudged(self, held: bool) -> Self {
        Standing(self.0 & ALARM | if held { HELD } else { 0 })
    }

    pub(super) const fn raised(self) -> Self {
        Standing(self.0 | ALARM)
    }

    pub(super) const fn without_alarm(self) -> Self {
        Standing(self.0 & !ALARM)
    }

    /// The same of a slot without a sample.
    pub(super) const fn unsampled(self) -> Self {
        Standing(self.0 & !(LATE | MISSING | GAP | SET_POINT) | HELD)
    }

    pub(super) const fn absent(self, why: Absence, gap: bool) -> Self {
        let why = match why {
            Absence::Late => LATE,
            Absence::Missing => MISSING,
        };
        Standing(self.0 | why | if gap { GAP } else { 0 })
    }

    /// The same of the first slot at a known set point.
    pub(super) const fn settling(self) -> Self {
        Standing(self.0 | SETTLING)
    }

    pub(super) const fn without_set_point(self) -> Self {
        Standing(self.0 & ALARM | HELD | SET_POINT)
    }

    const fn any(self, bits: u32) -> bool {
        self.0 & bits != 0
    }
}

/// What the monitor says of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdict {
    pub(super) sample: u64,
    pub(super) alarm_since: u64,
    pub(super) severity: [f32; SCALES],
    pub(super) readings: [f32; 3],
    pub(super) standing: Standing,
    pub(super) phase: Phase,
}

impl Verdict {
    /// Index of the sample, counted from zero; slots without a sample count, because time passes with them too.
    #[must_use]
    pub const fn sample(&self) -> u64 {
        self.sample
    }

    /// What the monitor is doing.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        if self.standing.any(SETTLING) { Phase::Settling } else { self.phase }
    }

    /// The readings that the verdict is about, in the order of [`Channel::ALL`].
    #[must_use]
    pub const fn readings(&self) -> [f32; 3] {
        self.readings
    }

    /// Whether something is wrong: what drives a fault output. A lost sensor is wrong too, and a gap in the samples.
    #[must_use]
    pub const fn alarm(&self) -> bool {
        const LOSSES: u32 = 0b11_1111 << STUCK_SHIFT;
        self.standing.any(ALARM | GAP | LOSSES)
    }

    /// Whether samples have been missing for so many slots in a row that the motor is not watched.
    #[must_use]
    pub const fn gap(&self) -> bool {
        self.standing.any(GAP)
    }

    /// Whether the motor behaves otherwise than it was learned to.
    #[must_use]
    pub const fn deviates(&self) -> bool {
        self.standing.alarm()
    }

    /// The sample with which the deviation was detected, while it stands. A fault that is withdrawn and found again while the
    /// loop recovers is the same.
    #[must_use]
    pub fn since(&self) -> Option<u64> {
        self.standing.alarm().then_some(self.alarm_since)
    }

    /// The distance of each time scale in units of its limit; none when the sample was not judged.
    #[must_use]
    pub fn severity(&self) -> Option<[f32; SCALES]> {
        (self.phase == Phase::Monitoring && !self.standing.any(HELD | SETTLING)).then_some(self.severity)
    }

    /// Whether the loop recovers from a fault: meanwhile only the fast scale can raise an alarm.
    #[must_use]
    pub const fn recovering(&self) -> bool {
        self.standing.any(RECOVERING) && !self.standing.any(SETTLING)
    }

    /// Whether the deviation has stood still for long enough that a name can be given.
    #[must_use]
    pub const fn settled(&self) -> bool {
        self.standing.any(NAMED)
    }

    /// Whether the sample was turned away: no reading of a channel that is not lost, two lost channels, or no set point.
    #[must_use]
    pub const fn rejected(&self) -> bool {
        self.standing.any(HELD)
    }

    /// Why the slot has no sample of its own.
    #[must_use]
    pub const fn absent(&self) -> Option<Absence> {
        if self.standing.any(LATE) {
            Some(Absence::Late)
        } else if self.standing.any(MISSING) {
            Some(Absence::Missing)
        } else {
            None
        }
    }

    /// Channels that say nothing any more. The others are still judged if one is lost.
    pub fn losses(&self) -> impl Iterator<Item = (Channel, Loss)> + use<> {
        let bits = self.standing.0;
        Channel::ALL.into_iter().enumerate().filter_map(move |(position, channel)| {
            let (stuck, silent) = (bits >> STUCK_SHIFT >> position & 1, bits >> SILENT_SHIFT >> position & 1);
            if silent != 0 { Some((channel, Loss::Silent)) } else { (stuck != 0).then_some((channel, Loss::Stuck)) }
        })
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Verdict {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "sample {=u64}: {}, severity {}, deviates since {}, recovering {=bool}, absent {}, gap {=bool}, lost",
            self.sample(),
            self.phase(),
            self.severity(),
            self.since(),
            self.recovering(),
            self.absent(),
            self.gap()
        );
        for (channel, loss) in self.losses() {
            defmt::write!(f, " {} {}", channel, loss);
        }
    }
}
