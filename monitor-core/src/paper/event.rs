//! What happened, and at which sample: events read off the stream of verdicts, in a log of fixed capacity.
//!
//! The log stands beside the monitor, not in it: the sampling interrupt's work then does not depend on whether
//! something happened, and a board chooses how many events it can afford to keep.

use heapless::Deque;

use super::localize::Diagnosis;
use super::verdict::{Phase, Standing, Verdict};
use crate::moments::LearnError;
use crate::sample::ModelId;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EventKind {
    /// The monitor entered a phase.
    Phase(Phase),
    /// The learning window was refused; a new one has begun.
    LearningRefused(LearnError),
    /// The relay of a residual went up.
    RelayUp(ModelId),
    /// The relay of a residual came down.
    RelayDown(ModelId),
    /// This diagnosis (a fault, or unknown) stands from here on.
    Located(Diagnosis),
    /// This diagnosis no longer stands.
    Cleared(Diagnosis),
}

/// Something that happened at a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Event {
    /// Index of the sample, counted from zero by the monitor.
    pub sample: u64,
    /// What happened.
    pub kind: EventKind,
}

/// Most events that one verdict can bring: a phase, four relays, a diagnosis that goes and one that comes.
pub const EVENTS_PER_VERDICT: usize = 7;

/// Reads events off the stream of verdicts: what differs from one to the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    phase: Option<Phase>,
    standing: Standing,
}

impl Watch {
    /// Compares a verdict with the one before it and hands over what changed. Give it every verdict in turn.
    #[inline]
    pub fn observe(&mut self, verdict: &Verdict, event: impl FnMut(Event)) {
        if self.phase != Some(verdict.phase()) || self.standing.relays() != verdict.relays() {
            self.changed(verdict, event);
        }
    }

    fn changed(&mut self, verdict: &Verdict, mut event: impl FnMut(Event)) {
        // Gathered first and handed over in one place: whatever takes events is then in flash once.
        for kind in self.changes(verdict).into_iter().flatten() {
            event(Event { sample: verdict.sample(), kind });
        }
        *self = Watch { phase: Some(verdict.phase()), standing: verdict.standing };
    }

    #[inline(never)]
    fn changes(&self, verdict: &Verdict) -> [Option<EventKind>; EVENTS_PER_VERDICT] {
        let phase = (self.phase != Some(verdict.phase())).then_some(EventKind::Phase(verdict.phase()));
        let (relays_before, relays) = (self.standing.relays(), verdict.relays());
        let [full, r1, r2, r3] = ModelId::ALL.map(|model| match (relays_before.get(model), relays.get(model)) {
            (false, true) => Some(EventKind::RelayUp(model)),
            (true, false) => Some(EventKind::RelayDown(model)),
            _ => None,
        });
        let (before, now) = (self.standing.diagnosis(), verdict.diagnosis());
        let cleared = (before != now && before != Diagnosis::Healthy).then_some(EventKind::Cleared(before));
        let located = (before != now && now != Diagnosis::Healthy).then_some(EventKind::Located(now));
        [phase, full, r1, r2, r3, cleared, located]
    }
}

/// A first-in, first-out log of at most `CAPACITY` events.
///
/// When it is full it keeps what it has and counts what comes: the beginning of a fault tells more than its tail.
#[derive(Clone, Debug, Default)]
pub struct EventLog<const CAPACITY: usize> {
    events: Deque<Event, CAPACITY>,
    dropped: u32,
    watch: Watch,
}

impl<const CAPACITY: usize> EventLog<CAPACITY> {
    /// Appends what changed between the verdict before and this one. Give it every verdict in turn.
    pub fn observe(&mut self, verdict: &Verdict) {
        let EventLog { events, dropped, watch } = self;
        watch.observe(verdict, |event| {
            if events.push_back(event).is_err() {
                *dropped = dropped.saturating_add(1);
            }
        });
    }

    /// Appends that the learning window which ended before `sample` was refused.
    pub fn refused(&mut self, sample: u64, error: LearnError) {
        if self.events.push_back(Event { sample, kind: EventKind::LearningRefused(error) }).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Takes the oldest event out.
    pub fn pop(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// The events that wait, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Event> {
        self.events.iter()
    }

    /// How many events found the log full, since it was made.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    use crate::paper::localize::Fault;
    use crate::paper::verdict::Slot;
    use crate::sample::ModelId::{Full, Pair};
    use crate::sample::Pair::{CurrentVoltage, SpeedVoltage};

    fn verdict(sample: u64, phase: Phase) -> Verdict {
        Verdict { sample, phase, ..Verdict::default() }
    }

    /// Relays as in [`Standing`]: full model, r1, r2, r3 from the lowest bit.
    fn alarm(sample: u64, up: u32) -> Verdict {
        Verdict { standing: Standing::new(up, Slot::Taken), ..verdict(sample, Phase::Monitoring) }
    }

    #[test]
    fn what_changes_between_two_verdicts_is_logged_once_and_in_order() {
        let mut log = EventLog::<16>::default();
        let fault = Diagnosis::Fault(Fault::SpeedSensor);
        for v in [
            verdict(0, Phase::Learning),
            verdict(1, Phase::Monitoring),
            alarm(2, 0b0101),
            alarm(3, 0b1101),
            alarm(4, 0b1101),
            alarm(5, 0),
        ] {
            log.observe(&v);
        }
        let seen: Vec<(u64, EventKind)> = core::iter::from_fn(|| log.pop().map(|e| (e.sample, e.kind))).collect();
        assert_eq!(
            seen,
            [
                (0, EventKind::Phase(Phase::Learning)),
                (1, EventKind::Phase(Phase::Monitoring)),
                (2, EventKind::RelayUp(Full)),
                (2, EventKind::RelayUp(Pair(CurrentVoltage))),
                (2, EventKind::Located(Diagnosis::Unknown)),
                (3, EventKind::RelayUp(Pair(SpeedVoltage))),
                (3, EventKind::Cleared(Diagnosis::Unknown)),
                (3, EventKind::Located(fault)),
                (5, EventKind::RelayDown(Full)),
                (5, EventKind::RelayDown(Pair(CurrentVoltage))),
                (5, EventKind::RelayDown(Pair(SpeedVoltage))),
                (5, EventKind::Cleared(fault)),
            ]
        );
    }

    #[test]
    fn one_verdict_brings_at_most_the_events_that_are_promised() {
        let mut watch = Watch::default();
        let mut most = 0;
        for (before, after) in (0..16).flat_map(|a| (0..16).map(move |b| (a, b))) {
            watch.observe(&alarm(0, before), |_| {});
            let mut count = 0;
            watch.observe(&Verdict { phase: Phase::Learning, ..alarm(1, after) }, |_| count += 1);
            most = usize::max(most, count);
        }
        assert_eq!(most, EVENTS_PER_VERDICT);
    }

    #[test]
    fn a_refused_window_is_logged_with_its_reason() {
        let mut log = EventLog::<8>::default();
        log.observe(&verdict(0, Phase::ModelDue));
        log.refused(1, LearnError::TooShort { samples: 3 });
        let last = log.iter().last().map(|e| (e.sample, e.kind));
        assert_eq!(last, Some((1, EventKind::LearningRefused(LearnError::TooShort { samples: 3 }))));
    }

    #[test]
    fn a_full_log_keeps_the_oldest_events_in_order_and_counts_the_rest() {
        let mut log = EventLog::<2>::default();
        for sample in 0..5 {
            log.observe(&verdict(sample, if sample % 2 == 0 { Phase::Learning } else { Phase::Monitoring }));
        }
        assert_eq!((log.dropped(), log.iter().count()), (3, 2));
        assert_eq!(log.pop().map(|e| e.sample), Some(0));
        log.observe(&verdict(9, Phase::Monitoring));
        assert_eq!(log.pop().map(|e| e.sample), Some(1));
        assert_eq!(log.pop().map(|e| e.sample), Some(9));
        assert_eq!(log.pop(), None);
        assert_eq!(log.dropped(), 3);
    }
}
