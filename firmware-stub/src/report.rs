//! What the main loop hears and answers, as `defmt` lines that a person understands: what, since when, how large against
//! its limit. Times are of the sampling clock, in seconds since the start.

use core::num::NonZeroU64;

use monitor_core::event::EventKind;
use monitor_core::sample::{Bank, ModelId};
use monitor_core::{Config, Diagnosis, Phase};

use crate::background::{Answer, Learned};
use crate::fault::Reason;
use crate::sampling::{Note, Snapshot};

/// What turns samples into times and residuals into a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Samples per second; a board's rate is a whole number of hertz.
    rate_hz: NonZeroU64,
    limits: Bank<f32>,
}

impl Report {
    /// For a monitor with these settings.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let rate_hz = NonZeroU64::new(config.sample_rate_hz as u64).unwrap_or(NonZeroU64::MIN);
        Report { rate_hz, limits: config.thresholds }
    }

    /// Milliseconds from the start to a sample.
    fn ms(&self, sample: u64) -> u64 {
        sample.wrapping_mul(1000) / self.rate_hz
    }

    /// Logs a note.
    pub fn note(&self, note: Note) {
        match note {
            Note::Event { event, residual, alarm_since } => self.event(event.sample, event.kind, residual, alarm_since),
            Note::Rejecting { sample, why } => {
                defmt::warn!("{=u64:ms} s: samples are turned away, {}", self.ms(sample), why);
            }
            Note::Accepting { sample, after } => {
                defmt::info!("{=u64:ms} s: samples are judged again after {=u32}", self.ms(sample), after);
            }
            Note::Overrun { sample } => {
                defmt::warn!("{=u64:ms} s: sampling overran, the next slot had begun", self.ms(sample));
            }
        }
    }

    fn event(&self, sample: u64, kind: EventKind, t2: f32, since: Option<u64>) {
        let at = self.ms(sample);
        match kind {
            EventKind::Located(Diagnosis::Fault(fault)) => defmt::warn!(
                "{=u64:ms} s: fault {}, alarm since {=u64:ms} s, T2 {=f32} of limit {=f32}",
                at,
                fault,
                self.ms(since.unwrap_or(sample)),
                t2,
                *self.limits.get(ModelId::Full)
            ),
            EventKind::Located(_) => defmt::warn!("{=u64:ms} s: something is wrong, but no known fault", at),
            EventKind::Cleared(diagnosis) => defmt::info!("{=u64:ms} s: cleared {}", at, diagnosis),
            EventKind::RelayUp(model) => {
                defmt::info!("{=u64:ms} s: {} up, T2 {=f32} of limit {=f32}", at, model, t2, *self.limits.get(model));
            }
            EventKind::RelayDown(model) => defmt::info!("{=u64:ms} s: {} down", at, model),
            EventKind::LearningRefused(error) => defmt::warn!("{=u64:ms} s: learning refused, {}", at, error),
            EventKind::Phase(Phase::Settling(why)) => defmt::info!("{=u64:ms} s: settling, {}", at, why),
            EventKind::Phase(phase) => defmt::info!("{=u64:ms} s: {}", at, phase),
            kind => defmt::info!("{=u64:ms} s: {}", at, kind),
        }
    }

    /// Logs how a learning window ended where no event says it: a refusal is an event.
    pub fn learned(&self, learned: Learned, in_vain: u32) {
        match learned {
            Learned::Installed | Learned::Refused(_) => {}
            Learned::InVain => {
                defmt::info!("the set point changed while a model was made, {=u32} in vain so far", in_vain)
            }
        }
    }

    /// Logs an answer.
    pub fn answer(&self, answer: Answer) {
        match answer {
            Answer::Contributions(Some([speed, current, voltage])) => defmt::info!(
                "contributions to T2: speed {=f32}, armature current {=f32}, armature voltage {=f32}",
                speed,
                current,
                voltage
            ),
            Answer::Contributions(None) => defmt::info!("contributions to T2: none, nothing is judged yet"),
            Answer::Statistics(state) => self.statistics(&state),
            Answer::Verdict(state) => defmt::info!("{}", state.verdict),
            Answer::SetPoint(set_point) => defmt::info!("set point {=f32} rad/s", set_point.0),
        }
    }

    fn statistics(&self, state: &Snapshot) {
        let counts = state.counts;
        defmt::info!(
            "{=u64:ms} s: {=u32} slots turned away, {=u32} of them late or missing, {=u32} overruns, {=u32} notes dropped",
            self.ms(state.verdict.sample()),
            counts.rejected,
            counts.absent,
            counts.overruns,
            counts.dropped
        );
        if let Some(baseline) = state.baseline {
            let ([m1, m2, m3], [s1, s2, s3]) = (baseline.mean(), baseline.sigma());
            defmt::info!("speed {=f32} rad/s, sigma {=f32}", m1, s1);
            defmt::info!("armature current {=f32} A, sigma {=f32}", m2, s2);
            defmt::info!("armature voltage {=f32} V, sigma {=f32}", m3, s3);
        }
    }
}

/// Logs why the last run ended, at the start of this one.
pub fn last_run(reason: Reason) {
    defmt::error!("the last run ended in: {}", reason);
}
