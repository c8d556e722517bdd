//! Alarms: what the verdicts of a replay amount to.

use monitor_core::paper::Verdict;
use monitor_core::sample::{Bank, ModelId};
use serde::Serialize;

use crate::names::{diagnosis_id, model_key};

/// A stretch of rows over which some relay was up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// First row of the alarm.
    pub start_row: u64,
    /// Last row of it.
    pub end_row: u64,
    /// Seconds from the first row of the log to the first of the alarm.
    pub start_s: f64,
    /// Seconds from the first row of the log to the last of the alarm.
    pub end_s: f64,
    /// Whether it still stood when the log ended.
    pub ongoing: bool,
    /// The diagnosis that stood longest; none when no pair relay was up.
    pub located: Option<String>,
    /// The largest residual over its threshold.
    pub peak: f64,
    /// The model of that residual.
    pub peak_model: &'static str,
    /// Share of each channel in the T2 of the full model at that row.
    pub contributions: [f64; 3],
}

/// Makes alarms of verdicts.
#[derive(Debug)]
pub(crate) struct AlarmBuilder {
    rate_hz: f64,
    thresholds: Bank<f32>,
    done: Vec<Alarm>,
    open: Option<OpenAlarm>,
}

#[derive(Debug)]
struct OpenAlarm {
    alarm: Alarm,
    /// Samples each diagnosis has stood.
    stood: Vec<(&'static str, u64)>,
}

impl AlarmBuilder {
    pub(crate) fn new(rate_hz: f64, thresholds: Bank<f32>) -> Self {
        AlarmBuilder { rate_hz, thresholds, done: Vec::new(), open: None }
    }

    /// Takes a verdict; `contributions` is asked when it is the worst of its alarm so far.
    pub(crate) fn push(&mut self, row: u64, verdict: &Verdict, contributions: impl FnOnce() -> Option<[f32; 3]>) {
        if !verdict.relays().any() {
            self.close();
            return;
        }
        let t_s = row as f64 / self.rate_hz;
        let open = self.open.get_or_insert_with(|| OpenAlarm {
            alarm: Alarm {
                start_row: row,
                end_row: row,
                start_s: t_s,
                end_s: t_s,
                ongoing: true,
                located: None,
                peak: 0.0,
                peak_model: model_key(ModelId::Full),
                contributions: [0.0; 3],
            },
            stood: Vec::new(),
        });
        open.alarm.end_row = row;
        open.alarm.end_s = t_s;
        if let Some(id) = diagnosis_id(verdict.diagnosis()) {
            match open.stood.iter_mut().find(|(stood, _)| *stood == id) {
                Some((_, samples)) => *samples += 1,
                None => open.stood.push((id, 1)),
            }
        }
        let Some(residuals) = verdict.residuals() else { return };
        let ratios = ModelId::ALL.map(|model| (model, residuals.get(model) / self.thresholds.get(model)));
        let worst = ratios.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((model, ratio)) = worst.filter(|(_, ratio)| f64::from(*ratio) > open.alarm.peak) {
            open.alarm.peak = f64::from(ratio);
            open.alarm.peak_model = model_key(model);
            if let Some(contributions) = contributions() {
                let total: f32 = contributions.iter().sum();
                open.alarm.contributions = contributions.map(|c| if total > 0.0 { f64::from(c / total) } else { 0.0 });
            }
        }
    }

    fn close(&mut self) {
        if let Some(OpenAlarm { mut alarm, stood }) = self.open.take() {
            alarm.ongoing = false;
            self.done.push(located(alarm, &stood));
        }
    }

    pub(crate) fn finish(mut self) -> Vec<Alarm> {
        if let Some(OpenAlarm { alarm, stood }) = self.open.take() {
            self.done.push(located(alarm, &stood));
        }
        self.done
    }
}

fn located(mut alarm: Alarm, stood: &[(&'static str, u64)]) -> Alarm {
    alarm.located = stood.iter().max_by_key(|(_, samples)| *samples).map(|(id, _)| (*id).to_owned());
    alarm
}
