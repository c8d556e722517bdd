//! What is kept of a run in `guard` mode.

use monitor_core::guard::{Phase, SCALES};
use serde::Serialize;

use super::{PhaseCounts, Phases, Signals};
use crate::envelope::Envelope;
use crate::guardian::Said;
use crate::intervals::{Interval, Intervals};
use crate::names::name::Name;

/// A run, in memory that does not grow with its length but with how often something changed.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Set point and channels.
    pub signals: Signals,
    /// Distance over its limit, of each time scale.
    pub severity: [Envelope; SCALES],
    /// Alarm, recovery and names.
    pub outputs: Outputs,
    /// When it was in each phase.
    pub phases: Phases,
    /// Samples spent in each phase.
    pub coverage: Coverage,
    /// Samples that were not judged.
    pub rejected: u64,
}

/// The logical outputs of a run.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// Where an alarm stood.
    pub alarm: Intervals,
    /// Where the loop recovered.
    pub recovering: Intervals,
    names: [Intervals; Name::ALL.len()],
}

/// How many samples a run spent in each phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// Settling, learning, judged.
    #[serde(flatten)]
    pub phases: PhaseCounts,
    /// Not judged, because nothing is known of the set point and a fault was suspected when it was reached.
    pub withheld: u64,
}

impl Outputs {
    /// Takes what was said of sample `index`. Returns whether it is anything else than before.
    pub fn push(&mut self, index: u64, said: &Said) -> bool {
        let mut changes = self.alarm.push(index, said.verdict.alarm());
        changes |= self.recovering.push(index, said.verdict.recovering());
        for (name, stood) in Name::ALL.into_iter().zip(&mut self.names) {
            changes |= stood.push(index, said.found.is_some_and(|found| found.name == name));
        }
        changes
    }

    /// Where a name stood.
    #[must_use]
    pub fn of(&self, name: Name) -> Vec<Interval> {
        self.names.get(name as usize).map(Intervals::all).unwrap_or_default()
    }

    /// The names that stood at all.
    pub fn names(&self) -> impl Iterator<Item = (Name, Vec<Interval>)> + '_ {
        Name::ALL.into_iter().map(|name| (name, self.of(name))).filter(|(_, stood)| !stood.is_empty())
    }
}

impl Recording {
    /// An empty record of a run at `rate_hz` samples per second.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        Recording {
            signals: Signals::new(rate_hz),
            severity: core::array::from_fn(|_| Envelope::default()),
            outputs: Outputs::default(),
            phases: Phases::default(),
            coverage: Coverage::default(),
            rejected: 0,
        }
    }

    /// Takes sample `index` and what was said of it.
    pub fn push(&mut self, index: u64, set_point: f64, x: [f64; 3], said: &Said) {
        let t = self.signals.seconds(index);
        self.signals.push(index, set_point, x);
        let severity = said.verdict.severity().map_or([f64::NAN; SCALES], |severity| severity.map(f64::from));
        for (envelope, severity) in self.severity.iter_mut().zip(severity) {
            envelope.push(t, severity);
        }
        if self.outputs.push(index, said) {
            self.signals.mark();
            self.severity.iter_mut().for_each(Envelope::mark);
        }
        let Coverage { phases, withheld } = &mut self.coverage;
        let (phase, samples) = match said.verdict.phase() {
            Phase::Settling => ("settling", &mut phases.settling),
            Phase::Seeding | Phase::Learning | Phase::ModelDue => ("learning", &mut phases.learning),
            Phase::Monitoring => ("monitoring", &mut phases.monitoring),
            Phase::Withheld => ("withheld", withheld),
        };
        *samples += 1;
        self.phases.push(index, phase);
        self.rejected += u64::from(said.verdict.rejected());
    }
}
