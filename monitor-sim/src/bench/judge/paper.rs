//! `paper` mode: a baseline of the samples to learn from, thresholds over their largest residual, then judge.

use monitor_core::moments::Moments;
use monitor_core::paper::{Baseline, Config, Monitor, Phase};
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::Bank;

use super::{Alarm, Judge, Judged, Learned, Refusal, Sample};
use crate::names::explain_config;
use crate::record::paper::Peak;
use crate::replay::paper::{AlarmBuilder, NO_LIMIT};

impl Judge {
    pub(super) fn by_paper(&self, learn: &[Sample], samples: &[Sample]) -> Result<Judged, Refusal> {
        let share = ExplainedShare::new(self.paper.explained_share as f32)
            .map_err(|error| Refusal::Settings(explain_config(error.into())))?;
        let healthy: Vec<&Sample> = learn.iter().filter(|sample| sample.is_finite()).collect();
        let first = healthy.first().ok_or_else(|| {
            Refusal::Learning("none of the rows to learn from holds a set point and three readings".to_owned())
        })?;
        let mut moments = Moments::<3>::around(first.channels());
        healthy.iter().for_each(|sample| moments.push(sample.channels()));
        let baseline =
            Baseline::learn(&moments, share).map_err(|error| Refusal::Learning(self.names.explain_learning(error)))?;
        let set_point = first.set_point as f32;
        let mut unlimited = self.monitor(Bank::from_fn(|_| NO_LIMIT), learn.len())?.starting_from(baseline, set_point);
        let mut peak = Peak::default();
        for sample in &healthy {
            let said = unlimited.step_channels(sample.set_point as f32, sample.channels());
            said.residuals().into_iter().for_each(|residuals| peak.push(residuals));
        }
        let margin = self.margin.unwrap_or_default() as f32;
        let thresholds = Bank::from_fn(|model| margin * peak.residuals.get(model));
        let monitor = self.monitor(thresholds, learn.len())?.starting_from(baseline, set_point);
        Ok(self.judge_by(&baseline, set_point, monitor, samples))
    }

    fn judge_by(&self, baseline: &Baseline, set_point: f32, mut monitor: Monitor, samples: &[Sample]) -> Judged {
        let mut alarms = AlarmBuilder::new(self.rate_hz, monitor.thresholds());
        let (mut alarm, mut watched) = (Vec::with_capacity(samples.len()), 0);
        for (row, sample) in samples.iter().enumerate() {
            let at = sample.set_point as f32;
            let mut verdict = *monitor.step_channels(at, sample.channels());
            if verdict.phase() == Phase::ModelDue {
                // A window that is refused is learned anew; the alarm says nothing meanwhile.
                let _refused = monitor.finish_learning().is_err();
                verdict = *monitor.verdict();
            }
            alarm.push(verdict.relays().any());
            watched += usize::from(verdict.phase() == Phase::Monitoring);
            alarms.push(row as u64, &verdict, || monitor.contributions(sample.channels()));
            // The set point that was learned has returned: what stands there now may be a fault and is not learned.
            let known = f64::from((at - set_point).abs()) <= self.set_point_tolerance;
            if known && verdict.phase() == Phase::Learning {
                monitor.recall(*baseline);
            }
        }
        let alarms = alarms.finish().into_iter().map(|alarm| Alarm {
            start: alarm.start_row as usize,
            end: alarm.end_row as usize + 1,
            shares: Some(alarm.contributions),
        });
        let learned = Learned { sigma: baseline.sigma().map(f64::from), settings: None };
        Judged { learned, alarm, alarms: alarms.collect(), watched }
    }

    fn monitor(&self, thresholds: Bank<f32>, learn: usize) -> Result<Monitor, Refusal> {
        let cutoff_hz = self.cutoff_hz.unwrap_or(self.paper.cutoff_hz);
        let config = Config {
            settle_s: self.settle_s as f32,
            learn_s: (learn as f64 / self.rate_hz) as f32,
            set_point_tolerance: self.set_point_tolerance as f32,
            explained_share: self.paper.explained_share as f32,
            cutoff_hz: cutoff_hz as f32,
            hysteresis: self.paper.hysteresis as f32,
            ..Config::paper(self.rate_hz as f32, thresholds)
        };
        Monitor::new(&config).map_err(|error| Refusal::Settings(explain_config(error)))
    }
}
