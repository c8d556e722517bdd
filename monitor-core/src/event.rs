//! What happened, and at which sample: events read off the stream of verdicts, in a log of fixed capacity.
//!
//! The log stands beside the monitor, not in it: the sampling interrupt's work then does not depend on whether
//! something happened, and a board chooses how many events it can afford to keep.

use heapless::Deque;

use crate::localize::Diagnosis;
use crate::moments::LearnError;
use crate::monitor::{Phase, Verdict};
use crate::sample::{Bank, ModelId};

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

/// A first-in, first-out log of at most `CAPACITY` events.
///
/// When it is full it keeps what it has and counts what comes: the beginning of a fault tells more than its tail.
#[derive(Clone, Debug, Default)]
pub struct EventLog<const CAPACITY: usize> {
    events: Deque<Event, CAPACITY>,
    dropped: u32,
    phase: Option<Phase>,
    up: Bank<bool>,
    diagnosis: Diagnosis,
}

impl<const CAPACITY: usize> EventLog<CAPACITY> {
    /// Compares a verdict with the one before it and appends what changed. Give it every verdict in turn.
    pub fn observe(&mut self, verdict: &Verdict) {
        if self.phase == Some(verdict.phase) && self.up == verdict.relays && self.diagnosis == verdict.diagnosis {
            return;
        }
        let sample = verdict.sample;
        if self.phase != Some(verdict.phase) {
            // A window that ends in a new window was refused.
            if let (Some(Phase::ModelDue), Phase::Learning, Some(error)) = (self.phase, verdict.phase, verdict.refused)
            {
                self.push(sample, EventKind::LearningRefused(error));
            }
            self.push(sample, EventKind::Phase(verdict.phase));
        }
        for model in ModelId::ALL {
            match (self.up.get(model), verdict.relays.get(model)) {
                (false, true) => self.push(sample, EventKind::RelayUp(model)),
                (true, false) => self.push(sample, EventKind::RelayDown(model)),
                _ => {}
            }
        }
        if self.diagnosis != verdict.diagnosis {
            if self.diagnosis != Diagnosis::Healthy {
                self.push(sample, EventKind::Cleared(self.diagnosis));
            }
            if verdict.diagnosis != Diagnosis::Healthy {
                self.push(sample, EventKind::Located(verdict.diagnosis));
            }
        }
        (self.phase, self.up, self.diagnosis) = (Some(verdict.phase), verdict.relays, verdict.diagnosis);
    }

    fn push(&mut self, sample: u64, kind: EventKind) {
        if self.events.push_back(Event { sample, kind }).is_err() {
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
    use crate::localize::Fault;
    use crate::sample::ModelId::Full;

    fn verdict(sample: u64, phase: Phase) -> Verdict {
        Verdict { sample, phase, ..Verdict::default() }
    }

    fn alarm(sample: u64, diagnosis: Diagnosis) -> Verdict {
        let relays = Bank { full: diagnosis != Diagnosis::Healthy, ..Bank::default() };
        Verdict { diagnosis, relays, ..verdict(sample, Phase::Monitoring) }
    }

    #[test]
    fn what_changes_between_two_verdicts_is_logged_once_and_in_order() {
        let mut log = EventLog::<16>::default();
        let fault = Diagnosis::Fault(Fault::SpeedSensor);
        for v in [
            verdict(0, Phase::Learning),
            verdict(1, Phase::Monitoring),
            alarm(2, Diagnosis::Unknown),
            alarm(3, fault),
            alarm(4, fault),
            alarm(5, Diagnosis::Healthy),
        ] {
            log.observe(&v);
        }
        let seen: [Option<(u64, EventKind)>; 9] = core::array::from_fn(|_| log.pop().map(|e| (e.sample, e.kind)));
        assert_eq!(
            seen,
            [
                Some((0, EventKind::Phase(Phase::Learning))),
                Some((1, EventKind::Phase(Phase::Monitoring))),
                Some((2, EventKind::RelayUp(Full))),
                Some((2, EventKind::Located(Diagnosis::Unknown))),
                Some((3, EventKind::Cleared(Diagnosis::Unknown))),
                Some((3, EventKind::Located(fault))),
                Some((5, EventKind::RelayDown(Full))),
                Some((5, EventKind::Cleared(fault))),
                None,
            ]
        );
    }

    #[test]
    fn a_refused_window_is_logged_with_its_reason() {
        let mut log = EventLog::<8>::default();
        let refused = Some(LearnError::TooShort { samples: 3 });
        log.observe(&verdict(0, Phase::ModelDue));
        log.observe(&Verdict { refused, ..verdict(1, Phase::Learning) });
        assert!(log.iter().any(|e| e.kind == EventKind::LearningRefused(LearnError::TooShort { samples: 3 })));
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
