//! What the monitor says of one sample.
//!
//! A verdict is written in the sampling interrupt and read outside it, so it carries what the interrupt has at hand, in
//! few words, and its methods work out the rest: the name of the fault, the reason why a sample was turned away.

use core::fmt;

use super::localize::{Diagnosis, localize};
use crate::sample::{Absence, Bank, Channel, PerPair};

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
    /// The window is complete; [`Monitor::finish_learning`](crate::paper::Monitor::finish_learning) has not been called yet.
    ModelDue,
    /// Phase II: every sample is judged.
    Monitoring,
}

impl Default for Phase {
    fn default() -> Self {
        Phase::Settling(Settling::Start)
    }
}

/// Why a sample was turned away before it touched any state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Rejected {
    /// This channel (the first such) is not a number.
    NonFinite(Channel),
    /// This channel (the first such) reads what its sensor cannot: an infinity, as [`Range`](crate::Range) makes of a
    /// converter at its rail, or a number so large that nothing measures it.
    OutOfRange(Channel),
    /// The set point is not a finite number.
    NonFiniteSetPoint,
    /// The slot has no sample of its own.
    Absent(Absence),
}

/// What became of a slot of the sampling clock, as it stands in [`Standing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// Its sample was taken.
    Taken = 0x000,
    /// Its sample was turned away for one of its readings.
    Unfit = 0x100,
    /// Its sample was turned away for the set point.
    SetPointNonFinite = 0x200,
    /// Its sample came too late.
    Late = 0x300,
    /// It has no sample.
    Missing = 0x400,
}

/// What stands, in one word, so that a sample costs one load and one store.
///
/// Bits 0 to 3 say which relays are up, in the order of [`ModelId::ALL`](crate::sample::ModelId::ALL): the full model's,
/// then r1 to r3 of (1.8). Bits 8 to 10 say what became of the slot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Standing(u32);

impl Standing {
    const RELAYS: u32 = 0xf;

    /// Relays from the lowest bit on.
    #[inline(always)]
    pub(crate) const fn new(relays: u32, slot: Slot) -> Self {
        Standing(relays & Self::RELAYS | slot as u32)
    }

    /// The same relays after another slot.
    #[inline(always)]
    pub(crate) const fn with(self, slot: Slot) -> Self {
        Standing::new(self.0, slot)
    }

    /// The same slot with all relays down.
    pub(crate) const fn without_relays(self) -> Self {
        Standing(self.0 & !Self::RELAYS)
    }

    #[inline(always)]
    pub(crate) const fn relay(self, bit: u32) -> bool {
        self.0 >> bit & 1 != 0
    }

    #[inline(always)]
    pub(crate) const fn alarm(self) -> bool {
        self.0 & Self::RELAYS != 0
    }

    pub(crate) const fn relays(self) -> Bank<bool> {
        let pairs =
            PerPair { speed_current: self.relay(1), current_voltage: self.relay(2), speed_voltage: self.relay(3) };
        Bank { full: self.relay(0), pairs }
    }

    pub(crate) const fn diagnosis(self) -> Diagnosis {
        localize(self.relays().pairs)
    }

    const fn taken(self) -> bool {
        self.0 & !Self::RELAYS == Slot::Taken as u32
    }

    fn rejected(self, readings: [f32; 3]) -> Option<Rejected> {
        const UNFIT: u32 = Slot::Unfit as u32;
        const SET_POINT: u32 = Slot::SetPointNonFinite as u32;
        const LATE: u32 = Slot::Late as u32;
        const MISSING: u32 = Slot::Missing as u32;
        match self.0 & !Self::RELAYS {
            UNFIT => Some(unfit(readings)),
            SET_POINT => Some(Rejected::NonFiniteSetPoint),
            LATE => Some(Rejected::Absent(Absence::Late)),
            MISSING => Some(Rejected::Absent(Absence::Missing)),
            _ => None,
        }
    }
}

/// Which reading made a sample unfit, and why.
fn unfit(readings: [f32; 3]) -> Rejected {
    if let Some(position) = readings.iter().position(|x| x.is_nan()) {
        return Rejected::NonFinite(Channel::at(position));
    }
    // None is NaN, so there is a largest, and it is the one beyond its range.
    let largest = readings.iter().fold(0.0, |largest: f32, x| largest.max(x.abs()));
    let position = readings.iter().position(|x| x.abs() >= largest).unwrap_or_default();
    Rejected::OutOfRange(Channel::at(position))
}

/// What the monitor says of one sample.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Verdict {
    pub(crate) sample: u64,
    /// Meaningless while no relay is up.
    pub(crate) alarm_since: u64,
    /// Meaningless unless the sample was judged.
    pub(crate) residuals: Bank<f32>,
    pub(crate) readings: [f32; 3],
    pub(crate) standing: Standing,
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
        self.standing.rejected(self.readings)
    }

    /// The readings that the verdict is about, in the order of [`Channel::ALL`].
    #[must_use]
    pub const fn readings(&self) -> [f32; 3] {
        self.readings
    }

    /// The smoothed T2 of the four models; none when the sample was not judged.
    #[must_use]
    pub fn residuals(&self) -> Option<Bank<f32>> {
        (self.phase == Phase::Monitoring && self.standing.taken()).then_some(self.residuals)
    }

    /// Which relays are up.
    #[must_use]
    pub const fn relays(&self) -> Bank<bool> {
        self.standing.relays()
    }

    /// Whether any relay is up: what drives a fault output.
    #[must_use]
    pub const fn alarm(&self) -> bool {
        self.standing.alarm()
    }

    /// What the table (1.8) says of the pair relays.
    #[must_use]
    pub const fn diagnosis(&self) -> Diagnosis {
        self.standing.diagnosis()
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
