//! What the main loop hears and answers, as `defmt` lines that a person understands: what, since when, how large against
//! its limit. Times are of the sampling clock, in seconds since the start.

use monitor_core::paper::event::EventKind;
use monitor_core::paper::{Config, Diagnosis, Phase};
use monitor_core::sample::{Bank, ModelId};

use crate::background::{Answer, Learned};
use crate::fault::Reason;
use crate::sampling::{Note, Snapshot};

/// What turns samples into times and residuals into a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Microseconds from one sample to the next: a board's rate divides a million.
    period_us: u32,
    limits: Bank<f32>,
}

impl Report {
    /// For a monitor with these settings.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let period_us = 1_000_000 / (config.sample_rate_hz as u32).max(1);
        Report { period_us, limits: config.thresholds }
    }

    /// Microseconds from the start to a sample. No division: of 64 bits, that would be a routine of its own.
    fn us(&self, sample: u64) -> u64 {
        sample.wrapping_mul(u64::from(self.period_us))
    }

    /// Logs a note.
    #[inline(never)]
    pub fn note(&self, note: Note) {
        match note {
            Note::Event { event, residual, alarm_since } => self.event(event.sample, event.kind, residual, alarm_since),
            Note::Rejecting { sample, why } => {
                defmt::warn!("{=u64:us} s: samples are turned away, {}", self.us(sample), why);
            }
            Note::Accepting { sample, after } => {
                defmt::info!("{=u64:us} s: samples are judged again after {=u32}", self.us(sample), after);
            }
            Note::Overrun { sample } => {
                defmt::warn!("{=u64:us} s: sampling overran, the next slot had begun", self.us(sample));
            }
        }
    }

    fn event(&self, sample: u64, kind: EventKind, t2: f32, since: Option<u64>) {
        let at = self.us(sample);
        match kind {
            EventKind::Located(Diagnosis::Fault(fault)) => defmt::warn!(
                "{=u64:us} s: fault {}, alarm since {=u64:us} s, T2 {=f32} of limit {=f32}",
                at,
                fault,
                self.us(since.unwrap_or(sample)),
                t2,
                *self.limits.get(ModelId::Full)
            ),
            EventKind::Located(_) => defmt::warn!("{=u64:us} s: something is wrong, but no known fault", at),
            EventKind::Cleared(diagnosis) => defmt::info!("{=u64:us} s: cleared {}", at, diagnosis),
            EventKind::RelayUp(model) => {
                defmt::info!("{=u64:us} s: {} up, T2 {=f32} of limit {=f32}", at, model, t2, *self.limits.get(model));
            }
            EventKind::RelayDown(model) => defmt::info!("{=u64:us} s: {} down", at, model),
            EventKind::LearningRefused(error) => defmt::warn!("{=u64:us} s: learning refused, {}", at, error),
            EventKind::Phase(Phase::Settling(why)) => defmt::info!("{=u64:us} s: settling, {}", at, why),
            EventKind::Phase(phase) => defmt::info!("{=u64:us} s: {}", at, phase),
            kind => defmt::info!("{=u64:us} s: {}", at, kind),
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
    #[inline(never)]
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
            Answer::Verdict(state) => self.verdict(&state),
            Answer::SetPoint(set_point) => defmt::info!("set point {=f32} rad/s", set_point.0),
        }
    }

    fn verdict(&self, state: &Snapshot) {
        let verdict = &state.verdict;
        defmt::info!(
            "{=u64:us} s: {}, {}, T2 {=f32} of limit {=f32}",
            self.us(verdict.sample()),
            verdict.phase(),
            verdict.diagnosis(),
            verdict.residuals().map_or(0.0, |residuals| residuals.full),
            self.limits.full
        );
    }

    fn statistics(&self, state: &Snapshot) {
        let counts = state.counts;
        defmt::info!(
            "{=u64:us} s: {=u32} slots turned away, {=u32} of them late or missing, {=u32} overruns, {=u32} notes dropped",
            self.us(state.verdict.sample()),
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
