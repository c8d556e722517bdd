//! The monitors as benchmarks drive them: learn some samples, judge others, as the replay of a log would.

mod guard;
mod paper;

use serde::Serialize;

use super::BenchError;
use super::protocol::Protocol;
use crate::guardian::summary::Settings;
use crate::names::ChannelNames;
use crate::replay::ReplayError;
use crate::replay::paper::{MARGIN, Replay};
use crate::settings::PaperSettings;
use crate::study::watch::Mode;

/// One row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Set point; zero where the protocol has none.
    pub set_point: f64,
    /// The three channels; not a number where a reading is missing.
    pub x: [f64; 3],
}

impl Sample {
    fn is_finite(&self) -> bool {
        self.set_point.is_finite() && self.x.iter().all(|value| value.is_finite())
    }

    fn channels(&self) -> [f32; 3] {
        self.x.map(|value| value as f32)
    }
}

/// What the monitor is told; the same for every run, and nothing of it comes from labels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judge {
    /// Which monitor.
    pub mode: Mode,
    /// Rows per second.
    pub rate_hz: f64,
    /// Settling time after a change of the set point, s.
    pub settle_s: f64,
    /// Largest movement of the set point that is not a change.
    pub set_point_tolerance: f64,
    /// In `guard` mode: false alarms that are tolerable per hour.
    pub false_alarms_per_hour: Option<f64>,
    /// In `paper` mode: threshold over the largest residual of what was learned from.
    pub margin: Option<f64>,
    /// In `paper` mode: cutoff of the residuals' low-pass, Hz.
    pub cutoff_hz: Option<f64>,
    #[serde(skip)]
    names: ChannelNames,
    #[serde(skip)]
    paper: PaperSettings,
}

/// What was learned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned {
    /// Standard deviation of each channel.
    pub sigma: [f64; 3],
    /// In `guard` mode, its settings.
    pub settings: Option<Settings>,
}

/// A stretch of judged samples over which an alarm stood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarm {
    /// First sample of it.
    pub start: usize,
    /// The sample behind its last.
    pub end: usize,
    /// Share of each channel in the deviation, as the replay reports it.
    pub shares: Option<[f64; 3]>,
}

/// What was said of the judged samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// What it was said by.
    pub learned: Learned,
    /// Whether an alarm stood at each sample.
    pub alarm: Vec<bool>,
    /// The same in stretches.
    pub alarms: Vec<Alarm>,
    /// Samples that were judged by what was learned: neither settling nor learning anew after a change of the set point.
    pub watched: usize,
}

/// Why nothing was judged.
#[derive(Debug)]
pub enum Refusal {
    /// What should be learned from was refused, with the reason.
    Learning(String),
    /// The monitor refuses its settings.
    Settings(String),
}

impl Judge {
    /// A monitor for the recordings of a protocol, with the settings that a replay would choose.
    ///
    /// # Errors
    /// When the built-in settings of the paper's mode do not parse; a test keeps them parsing.
    pub fn new(protocol: &Protocol, mode: Mode, false_alarms_per_hour: f64) -> Result<Self, BenchError> {
        let paper = PaperSettings::default_motor().map_err(|error| BenchError::Settings(error.to_string()))?;
        let data = &protocol.data;
        let of = |wanted, value| (mode == wanted).then_some(value);
        Ok(Judge {
            mode,
            rate_hz: data.rate_hz,
            settle_s: data.settle_s,
            set_point_tolerance: data.set_point_tolerance,
            false_alarms_per_hour: of(Mode::Guard, false_alarms_per_hour),
            margin: of(Mode::Paper, MARGIN),
            cutoff_hz: of(Mode::Paper, Replay::default_cutoff_hz(data.rate_hz)),
            names: ChannelNames(protocol.names()),
            paper,
        })
    }

    /// Names of the channels, in their order.
    #[must_use]
    pub const fn names(&self) -> &[String; 3] {
        &self.names.0
    }

    /// Learns from some samples and judges others by that, one after the other: what is said of a sample depends on none
    /// behind it.
    ///
    /// # Errors
    /// [`Refusal`] when nothing was judged.
    pub fn judge(&self, learn: &[Sample], samples: &[Sample]) -> Result<Judged, Refusal> {
        match self.mode {
            Mode::Guard => self.by_guard(learn, samples),
            Mode::Paper => self.by_paper(learn, samples),
        }
    }
}

/// A window that a replay refuses is one that a benchmark refuses.
fn refused(error: ReplayError) -> Refusal {
    match error {
        ReplayError::Learning(why) => Refusal::Learning(why),
        other => Refusal::Settings(other.to_string()),
    }
}
