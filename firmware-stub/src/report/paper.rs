//! The lines of `paper` mode.

use monitor_core::paper::event::EventKind;
use monitor_core::paper::{Diagnosis, Phase};

use super::{Report, Spoken, healthy};
use crate::background::Named;
use crate::mode::paper::{News, Paper};

impl Spoken for Paper {
    fn log_news(report: &Report<Self>, News { event, residual, limit, alarm_since }: News) {
        let at = report.us(event.sample);
        match event.kind {
            EventKind::Located(Diagnosis::Fault(fault)) => defmt::warn!(
                "{=u64:us} s: fault {}, alarm since {=u64:us} s, T2 {=f32} of limit {=f32}",
                at,
                fault,
                report.us(alarm_since.unwrap_or(event.sample)),
                residual,
                limit
            ),
            EventKind::Located(_) => defmt::warn!("{=u64:us} s: something is wrong, but no known fault", at),
            EventKind::Cleared(diagnosis) => defmt::info!("{=u64:us} s: cleared {}", at, diagnosis),
            EventKind::RelayUp(model) => {
                defmt::info!("{=u64:us} s: {} up, T2 {=f32} of limit {=f32}", at, model, residual, limit);
            }
            EventKind::RelayDown(model) => defmt::info!("{=u64:us} s: {} down", at, model),
            EventKind::LearningRefused(error) => defmt::warn!("{=u64:us} s: learning refused, {}", at, error),
            EventKind::Phase(Phase::Settling(why)) => defmt::info!("{=u64:us} s: settling, {}", at, why),
            EventKind::Phase(phase) => defmt::info!("{=u64:us} s: {}", at, phase),
            kind => defmt::info!("{=u64:us} s: {}", at, kind),
        }
    }

    /// Never called: names are news.
    fn log_named(_: &Report<Self>, _: &Named<Diagnosis>) {}

    fn log_by_channel(contributions: Option<[f32; 3]>) {
        match contributions {
            Some([speed, current, voltage]) => defmt::info!(
                "contributions to T2: speed {=f32}, armature current {=f32}, armature voltage {=f32}",
                speed,
                current,
                voltage
            ),
            None => defmt::info!("contributions to T2: none, nothing is judged yet"),
        }
    }

    fn log_verdict(&self, report: &Report<Self>, diagnosis: &Diagnosis) {
        let verdict = self.monitor().verdict();
        defmt::info!(
            "{=u64:us} s: {}, {}, T2 {=f32} of limit {=f32}",
            report.us(verdict.sample()),
            verdict.phase(),
            diagnosis,
            verdict.residuals().map_or(0.0, |residuals| residuals.full),
            self.monitor().thresholds().full
        );
    }

    fn log_statistics(&self) {
        if let Some(baseline) = self.monitor().baseline() {
            healthy(baseline.mean(), baseline.sigma());
        }
    }
}
