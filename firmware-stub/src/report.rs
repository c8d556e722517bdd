//! Events as `defmt` lines that a person understands: what, since when, how large against its limit.

use monitor_core::event::{Event, EventKind};
use monitor_core::sample::{Bank, ModelId};
use monitor_core::{Diagnosis, Phase, Verdict};

/// Logs an event of the sample that brought `verdict`.
pub fn event(event: Event, verdict: &Verdict, thresholds: &Bank<f32>) {
    let sample = event.sample;
    let residual = |model: ModelId| verdict.residuals().map_or(0.0, |residuals| *residuals.get(model));
    match event.kind {
        EventKind::Located(Diagnosis::Fault(fault)) => {
            let since = verdict.alarm_since().unwrap_or(sample);
            let (t2, limit) = (residual(ModelId::Full), thresholds.get(ModelId::Full));
            defmt::warn!(
                "sample {=u64}: fault {}, alarm since sample {=u64}, T2 {=f32}, limit {=f32}",
                sample,
                fault,
                since,
                t2,
                *limit
            );
        }
        EventKind::Located(_) => defmt::warn!("sample {=u64}: something is wrong, but no known fault", sample),
        EventKind::Cleared(diagnosis) => defmt::info!("sample {=u64}: cleared {}", sample, diagnosis),
        EventKind::RelayUp(model) => {
            defmt::info!(
                "sample {=u64}: {} up, T2 {=f32}, limit {=f32}",
                sample,
                model,
                residual(model),
                *thresholds.get(model)
            );
        }
        EventKind::RelayDown(model) => defmt::info!("sample {=u64}: {} down", sample, model),
        EventKind::LearningRefused(error) => defmt::warn!("sample {=u64}: learning refused, {}", sample, error),
        EventKind::Phase(Phase::Settling(why)) => defmt::info!("sample {=u64}: settling, {}", sample, why),
        EventKind::Phase(phase) => defmt::info!("sample {=u64}: {}", sample, phase),
        kind => defmt::info!("sample {=u64}: {}", sample, kind),
    }
}
