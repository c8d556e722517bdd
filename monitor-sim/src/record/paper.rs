//! What is kept of a run in `paper` mode.

use monitor_core::paper::localize::Fault;
use monitor_core::paper::{Phase, Verdict};
use monitor_core::sample::{Bank, ModelId};

use super::{PhaseCounts, Phases, Signals};
use crate::envelope::Envelope;
use crate::intervals::Intervals;
use crate::names::{ByModel, diagnosis_id, fault_id};
use crate::score::{Observed, union};

/// A run, in memory that does not grow with its length but with how often something changed.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Set point and channels.
    pub signals: Signals,
    /// The smoothed residuals.
    pub residuals: ByModel<Envelope>,
    /// Relays and diagnoses.
    pub outputs: LogicalOutputs,
    /// When it was in each phase.
    pub phases: Phases,
    /// Samples spent in each phase.
    pub coverage: PhaseCounts,
    /// Samples turned away because they were not finite.
    pub rejected: u64,
}

/// The logical outputs of a run (figures 7 and 11): where each relay was up, where each diagnosis stood.
#[derive(Clone, Debug)]
pub struct LogicalOutputs {
    /// Where each relay was up.
    pub relays: ByModel<Intervals>,
    /// Where each diagnosis stood: F1, F2, F3, unknown.
    pub diagnoses: [(&'static str, Intervals); 4],
}

impl Default for LogicalOutputs {
    fn default() -> Self {
        let [f1, f2, f3] = Fault::ALL.map(|fault| (fault_id(fault), Intervals::default()));
        LogicalOutputs {
            relays: ByModel::from_fn(|_| Intervals::default()),
            diagnoses: [f1, f2, f3, ("unknown", Intervals::default())],
        }
    }
}

impl LogicalOutputs {
    /// Takes what the monitor said of sample `index`. Returns whether it is anything else than before.
    pub fn push(&mut self, index: u64, verdict: &Verdict) -> bool {
        let mut changes = false;
        for model in ModelId::ALL {
            changes |= self.relays.get_mut(model).push(index, *verdict.relays().get(model));
        }
        for (id, stood) in &mut self.diagnoses {
            changes |= stood.push(index, diagnosis_id(verdict.diagnosis()) == Some(*id));
        }
        changes
    }

    /// What the scores are made of.
    #[must_use]
    pub fn observed(&self) -> Observed {
        let pairs = [&self.relays.speed_current, &self.relays.current_voltage, &self.relays.speed_voltage];
        Observed {
            full: self.relays.full.all(),
            any_pair: pairs.iter().fold(Vec::new(), |up, relay| union(&up, &relay.all())),
            located: self.diagnoses.iter().map(|(id, stood)| ((*id).to_owned(), stood.all())).collect(),
        }
    }
}

impl Recording {
    /// An empty record of a run at `rate_hz` samples per second.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        Recording {
            signals: Signals::new(rate_hz),
            residuals: ByModel::from_fn(|_| Envelope::default()),
            outputs: LogicalOutputs::default(),
            phases: Phases::default(),
            coverage: PhaseCounts::default(),
            rejected: 0,
        }
    }

    /// Takes sample `index` and what the monitor said of it.
    pub fn push(&mut self, index: u64, set_point: f64, x: [f64; 3], verdict: &Verdict) {
        let t = self.signals.seconds(index);
        self.signals.push(index, set_point, x);
        for model in ModelId::ALL {
            let residual = verdict.residuals().map_or(f64::NAN, |r| f64::from(*r.get(model)));
            self.residuals.get_mut(model).push(t, residual);
        }
        if self.outputs.push(index, verdict) {
            self.signals.mark();
            ModelId::ALL.iter().for_each(|model| self.residuals.get_mut(*model).mark());
        }
        let (phase, samples) = match verdict.phase() {
            Phase::Settling(_) => ("settling", &mut self.coverage.settling),
            Phase::Learning | Phase::ModelDue => ("learning", &mut self.coverage.learning),
            Phase::Monitoring => ("monitoring", &mut self.coverage.monitoring),
        };
        *samples += 1;
        self.phases.push(index, phase);
        self.rejected += u64::from(verdict.rejected().is_some());
    }
}

/// The largest of each residual against its threshold, over a stretch of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Largest residual of each model.
    pub residuals: Bank<f32>,
}

impl Peak {
    /// Takes the residuals of one sample.
    pub fn push(&mut self, residuals: Bank<f32>) {
        let before = self.residuals;
        self.residuals = Bank::from_fn(|model| before.get(model).max(*residuals.get(model)));
    }
}
