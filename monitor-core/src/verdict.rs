//! What the monitor says of one sample.
//!
//! A verdict is written in the sampling interrupt and read outside it, so it carries what the interrupt has at hand, in
//! few words, and its methods work out the rest: the name of the fault, the reason why a sample was turned away.

use core::fmt;

use crate::localize::{Diagnosis, localize};
use crate::range::{Look, Unfit};
use crate::sample::{Bank, Channel, PerPair};

/// Why the monitor is settling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Settling {
    /// It has just been started.
    #[default]
    Start,
    /// The set point has changed: the baseline of the old one says nothing about the new one.
    SetPointChanged,
}

/// What the monitor is doing; anything but `Monitoring` is the reason why a sample was not judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// Waiting for the loop to settle.
    Settling(Settling),
    /// Phase I: gathering the learning window.
    Learning,
    /// The window is complete; [`Monitor::finish_learning`](crate::Monitor::finish_learning) has not been called yet.
    ModelDue,
    /// Phase II: every sample is judged.
    Monitoring,
}

impl Default for Phase {
    fn default() -> Self {
        Phase::Settling(Settling::Start)
    }
}

/// Why a slot of the sampling clock has no sample that can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Absence {
    /// The sample was taken after its slot: filters of a fixed rate have no place for it.
    Late,
    /// There is none.
    Missing,
}

/// Why a sample was turned away before it touched any state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Rejected {
    /// This channel (the first such) is not a finite number.
    NonFinite(Channel),
    /// This channel (the first such) reads what its sensor cannot: a converter at its rail.
    OutOfRange(Channel),
    /// The set point is not a finite number.
    NonFiniteSetPoint,
    /// The slot has no sample of its own.
    Absent(Absence),
}

/// Why a slot was turned away for a reason other than a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Slot {
    #[default]
    Sampled,
    SetPointNonFinite,
    Absent(Absence),
}

/// Which of the four relays are up, in the order of [`ModelId::ALL`](crate::sample::ModelId::ALL): bit 0 is the full
/// model's, bits 1 to 3 are r1 to r3 of (1.8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Up(pub(crate) u32);

impl Up {
    pub(crate) const fn any(self) -> bool {
        self.0 != 0
    }

    pub(crate) const fn bank(self) -> Bank<bool> {
        let Up(bits) = self;
        let pairs =
            PerPair { speed_current: bits & 2 != 0, current_voltage: bits & 4 != 0, speed_voltage: bits & 8 != 0 };
        Bank { full: bits & 1 != 0, pairs }
    }

    pub(crate) const fn diagnosis(self) -> Diagnosis {
        localize(self.bank().pairs)
    }
}

/// What the monitor says of one sample.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Verdict {
    pub(crate) sample: u64,
    /// Meaningless while no relay is up.
    pub(crate) alarm_since: u64,
    /// Meaningless unless the sample was judged.
    pub(crate) residuals: Bank<f32>,
    pub(crate) up: Up,
    pub(crate) look: Look,
    pub(crate) slot: Slot,
    pub(crate) phase: Phase,
}

impl Verdict {
    /// Index of the sample, counted from zero; rejected samples count, because time passes with them too.
    #[must_use]
    pub const fn sample(&self) -> u64 {
        self.sample
    }

    /// What the monitor is doing.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Why the sample was turned away, if it was. The rest of the verdict then is as the sample before left it.
    #[must_use]
    pub fn rejected(&self) -> Option<Rejected> {
        match (self.slot, self.look.unfit()) {
            (Slot::Absent(why), _) => Some(Rejected::Absent(why)),
            (Slot::SetPointNonFinite, _) => Some(Rejected::NonFiniteSetPoint),
            (Slot::Sampled, Some(Unfit::NonFinite(channel))) => Some(Rejected::NonFinite(channel)),
            (Slot::Sampled, Some(Unfit::OutOfRange(channel))) => Some(Rejected::OutOfRange(channel)),
            (Slot::Sampled, None) => None,
        }
    }

    /// The smoothed T2 of the four models; none when the sample was not judged.
    #[must_use]
    pub fn residuals(&self) -> Option<Bank<f32>> {
        (self.phase == Phase::Monitoring && self.rejected().is_none()).then_some(self.residuals)
    }

    /// Which relays are up.
    #[must_use]
    pub const fn relays(&self) -> Bank<bool> {
        self.up.bank()
    }

    /// Whether any relay is up: what drives a fault output.
    #[must_use]
    pub const fn alarm(&self) -> bool {
        self.up.any()
    }

    /// What the table (1.8) says of the pair relays.
    #[must_use]
    pub const fn diagnosis(&self) -> Diagnosis {
        self.up.diagnosis()
    }

    /// The sample from which on some relay has been up without a break.
    #[must_use]
    pub fn alarm_since(&self) -> Option<u64> {
        self.alarm().then_some(self.alarm_since)
    }
}

impl fmt::Debug for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Verdict")
            .field("sample", &self.sample())
            .field("phase", &self.phase())
            .field("rejected", &self.rejected())
            .field("residuals", &self.residuals())
            .field("relays", &self.relays())
            .field("diagnosis", &self.diagnosis())
            .field("alarm_since", &self.alarm_since())
            .finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Verdict {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "sample {=u64}: {}, rejected {}, residuals {}, relays {}, {}, alarm since {}",
            self.sample(),
            self.phase(),
            self.rejected(),
            self.residuals(),
            self.relays(),
            self.diagnosis(),
            self.alarm_since()
        );
    }
}
