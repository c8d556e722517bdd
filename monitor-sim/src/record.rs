//! What a mission and a replay keep of a run: decimated signals for the pictures, intervals for the tables.

use crate::envelope::Envelope;
use crate::intervals::{Interval, Intervals};

pub mod guard;
pub mod paper;

/// The signals of a run, in memory that does not grow with its length.
#[derive(Clone, Debug)]
pub struct Signals {
    rate_hz: f64,
    /// Set point.
    pub set_point: Envelope,
    /// The three channels, in the order of their positions.
    pub channels: [Envelope; 3],
    /// Samples taken.
    pub samples: u64,
}

impl Signals {
    /// No signals yet, of a run at `rate_hz` samples per second.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        let channels = core::array::from_fn(|_| Envelope::default());
        Signals { rate_hz, set_point: Envelope::default(), channels, samples: 0 }
    }

    /// Seconds since the beginning of the run at which sample `index` was taken.
    #[must_use]
    pub fn seconds(&self, index: u64) -> f64 {
        index as f64 / self.rate_hz
    }

    /// Takes sample `index`.
    pub fn push(&mut self, index: u64, set_point: f64, x: [f64; 3]) {
        let t = self.seconds(index);
        self.set_point.push(t, set_point);
        for (envelope, value) in self.channels.iter_mut().zip(x) {
            envelope.push(t, value);
        }
        self.samples += 1;
    }

    /// Keeps the samples around the last one, at which something happened.
    pub fn mark(&mut self) {
        self.channels.iter_mut().chain([&mut self.set_point]).for_each(Envelope::mark);
    }
}

/// When a run was in each of its phases.
#[derive(Clone, Debug, Default)]
pub struct Phases(Vec<(&'static str, Intervals)>);

impl Phases {
    /// Takes the phase of sample `index`, in words.
    pub fn push(&mut self, index: u64, phase: &'static str) {
        if !self.0.iter().any(|(known, _)| *known == phase) {
            self.0.push((phase, Intervals::default()));
        }
        for (known, stood) in &mut self.0 {
            stood.push(index, *known == phase);
        }
    }

    /// The phases there were, in the order in which they came.
    pub fn all(&self) -> impl Iterator<Item = (&'static str, Vec<Interval>)> + '_ {
        self.0.iter().map(|(phase, stood)| (*phase, stood.all()))
    }
}

/// How many samples a run spent in each phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct PhaseCounts {
    /// Waiting for the loop to settle.
    pub settling: u64,
    /// Gathering a learning window, or waiting for its model.
    pub learning: u64,
    /// Judged.
    pub monitoring: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_phase_is_where_it_was_in_the_order_in_which_they_came() {
        let mut phases = Phases::default();
        for (index, phase) in (5..).zip(["settling", "settling", "learning", "monitoring", "settling"]) {
            phases.push(index, phase);
        }
        let at = |start, end| Interval { start, end };
        let expected =
            [("settling", vec![at(5, 7), at(9, 10)]), ("learning", vec![at(7, 8)]), ("monitoring", vec![at(8, 9)])];
        assert_eq!(phases.all().collect::<Vec<_>>(), expected);
    }
}
