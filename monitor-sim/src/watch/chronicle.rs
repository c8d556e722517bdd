//! What happened in a run: events in words, and what is counted up to a slot.

use std::collections::VecDeque;

use monitor_core::guard::Loss;

use super::feed::Subject;
use super::slot::{Phase, Slot};
use crate::names::name::Name;
use crate::tables::significant;

/// Events that are kept; the oldest go first.
const KEPT: usize = 2000;

/// How an event is to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Worth knowing.
    Plain,
    /// Something is wrong.
    Wrong,
    /// Something is right again.
    Right,
    /// What the monitor does not know.
    Injected,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, s.
    pub t_s: f64,
    /// How to look at it.
    pub kind: Kind,
    /// What.
    pub text: String,
}

/// What is counted up to a slot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// When the alarm that stands was raised, s.
    pub since_s: Option<f64>,
    /// Alarms so far.
    pub alarms: u32,
    /// Slots judged.
    pub judged: u64,
    /// Slots since the first that was judged.
    pub behind: u64,
}

impl Tally {
    /// Share of the slots that were judged, since the first that was; none before it.
    #[must_use]
    pub fn covered(&self) -> Option<f64> {
        (self.behind > 0).then(|| self.judged as f64 / self.behind as f64)
    }
}

/// The events of a run, in memory that does not grow with its length.
#[derive(Clone, Debug, Default)]
pub struct Chronicle {
    events: VecDeque<Event>,
    tally: Tally,
    phase: Option<Phase>,
    set_point: Option<f64>,
    named: Option<Name>,
    lost: [Option<Loss>; 3],
    injected: usize,
}

impl Chronicle {
    /// Takes a slot; returns what is counted up to it.
    pub fn take(&mut self, slot: &Slot, subject: &Subject) -> Tally {
        self.inject(slot, subject);
        self.set_point(slot, subject);
        self.phase(slot, subject);
        self.lost(slot, subject);
        self.alarm(slot);
        self.tally.judged += u64::from(slot.says.judged);
        self.tally.behind += u64::from(self.tally.judged > 0);
        self.tally
    }

    /// The events up to a time, the latest first.
    pub fn up_to(&self, t_s: f64) -> impl Iterator<Item = &Event> {
        self.events.iter().rev().skip_while(move |event| event.t_s > t_s)
    }

    fn push(&mut self, t_s: f64, kind: Kind, text: String) {
        if self.events.len() == KEPT {
            self.events.pop_front();
        }
        self.events.push_back(Event { t_s, kind, text });
    }

    fn inject(&mut self, slot: &Slot, subject: &Subject) {
        while let Some((_, text)) = subject.injected.get(self.injected).filter(|(at_s, _)| *at_s <= slot.t_s) {
            self.push(slot.t_s, Kind::Injected, text.clone());
            self.injected += 1;
        }
    }

    fn set_point(&mut self, slot: &Slot, subject: &Subject) {
        let now = slot.set_point;
        if !now.is_finite() || self.set_point.is_some_and(|was| (now - was).abs() <= subject.set_point_tolerance) {
            return;
        }
        let text = match self.set_point {
            Some(was) => format!("set point {} to {}", significant(was), significant(now)),
            None => format!("set point {}", significant(now)),
        };
        self.push(slot.t_s, Kind::Plain, text);
        self.set_point = Some(now);
    }

    fn phase(&mut self, slot: &Slot, subject: &Subject) {
        if let Some(error) = slot.says.refused {
            let why = subject.names.explain_learning(error);
            self.push(slot.t_s, Kind::Wrong, format!("learning refused: {why}"));
        }
        if self.phase != Some(slot.says.phase) {
            self.phase = Some(slot.says.phase);
            self.push(slot.t_s, Kind::Plain, slot.says.phase.words().to_owned());
        }
    }

    fn lost(&mut self, slot: &Slot, subject: &Subject) {
        for (position, now) in slot.says.lost.into_iter().enumerate() {
            let (Some(before), Some(name)) = (self.lost.get_mut(position), subject.names.0.get(position)) else {
                continue;
            };
            if *before == now {
                continue;
            }
            *before = now;
            match now {
                Some(loss) => self.push(slot.t_s, Kind::Wrong, format!("{name} {}", how(loss))),
                None => self.push(slot.t_s, Kind::Right, format!("{name} reads again")),
            }
        }
    }

    fn alarm(&mut self, slot: &Slot) {
        let says = &slot.says;
        match self.tally.since_s {
            None if says.alarm => {
                self.tally.since_s = Some(slot.t_s);
                self.tally.alarms += 1;
                self.push(slot.t_s, Kind::Wrong, "alarm raised".to_owned());
            }
            Some(since_s) if !says.alarm => {
                (self.tally.since_s, self.named) = (None, None);
                self.push(slot.t_s, Kind::Right, format!("alarm withdrawn after {:.3} s", slot.t_s - since_s));
            }
            _ => {}
        }
        if says.alarm
            && let Some(name) = says.name
            && self.named != Some(name)
        {
            self.named = Some(name);
            self.push(slot.t_s, Kind::Wrong, format!("named {}", name.shown()));
        }
    }
}

impl Phase {
    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Phase::Waiting => "before the learning window",
            Phase::Settling => "settling",
            Phase::Learning => "learning",
            Phase::Monitoring => "monitoring",
            Phase::Withheld => "not judged: unknown set point",
        }
    }
}

/// How a channel is lost.
#[must_use]
pub const fn how(loss: Loss) -> &'static str {
    match loss {
        Loss::Stuck => "stuck",
        _ => "silent",
    }
}
