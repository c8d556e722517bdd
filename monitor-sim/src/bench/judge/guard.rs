//! `guard` mode: seed and learn over the samples to learn from, then judge.

use monitor_core::guard::{Config, Monitor, Phase};

use super::{Alarm, Judge, Judged, Learned, Refusal, Sample, refused};
use crate::guardian::{Alarming, Guardian};
use crate::names::explain_guard_config;
use crate::replay::guard::{AlarmBuilder, WARM_UP, config};

impl Judge {
    pub(super) fn by_guard(&self, learn: &[Sample], samples: &[Sample]) -> Result<Judged, Refusal> {
        let config = self.config(learn.len())?;
        let mut guardian =
            Guardian::new(&config, None).map_err(|error| Refusal::Settings(explain_guard_config(error)))?;
        self.learn(&mut guardian, learn)?;
        let Some(model) = guardian.guard().model() else {
            return Err(Refusal::Learning("too few of the rows to learn from hold three readings".to_owned()));
        };
        let learned = Learned { sigma: model.sigma().map(f64::from), settings: Some((&config).into()) };
        let mut alarms = AlarmBuilder::new(self.rate_hz, self.names.clone());
        let (mut alarm, mut watched) = (Vec::with_capacity(samples.len()), 0);
        for (row, sample) in samples.iter().enumerate() {
            let said = guardian.step(sample.set_point as f32, sample.channels());
            alarm.push(said.verdict.alarm());
            watched += usize::from(said.verdict.phase() == Phase::Monitoring);
            alarms.push(row as u64, &said, || guardian.contributions(sample.channels()));
        }
        let alarms = alarms.finish().into_iter().map(|alarm| Alarm {
            start: alarm.start_row as usize,
            end: alarm.end_row as usize + 1,
            shares: alarm.contributions,
        });
        Ok(Judged { learned, alarm, alarms: alarms.collect(), watched })
    }

    fn config(&self, learn: usize) -> Result<Config, Refusal> {
        let asked = Alarming::at(self.false_alarms_per_hour.unwrap_or_default());
        let config = config(learn as u64, self.rate_hz, &asked, self.settle_s).map_err(refused)?;
        Ok(Config { set_point_tolerance: self.set_point_tolerance as f32, ..config })
    }

    /// The settling time goes by beforehand, as in a replay: whoever says that rows are to be learned from says that the
    /// motor has settled.
    fn learn(&self, guardian: &mut Guardian, learn: &[Sample]) -> Result<(), Refusal> {
        let mut samples = learn.iter().skip_while(|sample| !sample.is_finite()).peekable();
        let set_point = samples.peek().map_or(0.0, |first| first.set_point) as f32;
        for _ in 0..(self.settle_s * self.rate_hz) as u64 + WARM_UP {
            guardian.step(set_point, [f32::NAN; 3]);
        }
        for sample in samples {
            let x = if sample.set_point.is_finite() { sample.channels() } else { [f32::NAN; 3] };
            let at = if sample.set_point.is_finite() { sample.set_point as f32 } else { set_point };
            let said = guardian.step(at, x);
            if let Some(error) = Monitor::refused(guardian.guard()).or(said.learned.and_then(Result::err)) {
                return Err(Refusal::Learning(self.names.explain_learning(error)));
            }
        }
        Ok(())
    }
}
