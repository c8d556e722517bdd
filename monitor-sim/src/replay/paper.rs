//! A replay in `paper` mode: learn over a window, set limits on it, judge the rest.
//!
//! The log is streamed, three times over: once to learn the baseline, once over the learning window to see how far a
//! healthy residual goes, once to judge. Memory does not grow with the log.

mod alarm;
mod learn;
mod pass;
mod report;

use std::path::PathBuf;

use monitor_core::moments::LearnError;
use monitor_core::paper::monitor::ConfigError;
use monitor_core::paper::{Config, Monitor, Verdict};
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::Bank;

use super::{Reading, Refusal, ReplayError, Source, TICK_ROWS, coverage, notes};
use crate::names::{ByModel, ChannelNames, explain_config};
use crate::output::OutputError;
use crate::record::paper::Recording;
use crate::stored::StoredBaseline;
use crate::trace::{TraceRow, TraceWriter};
use crate::window::RowWindow;

pub use alarm::Alarm;
pub(crate) use alarm::AlarmBuilder;
pub use pass::{Pass, Step};
pub use report::{Learned, Quality, ReplayReport};

/// The residual of a run whose limits are still sought meets no relay.
pub(crate) const NO_LIMIT: f32 = f32::MAX;

/// Threshold over the largest residual of the learning window, if the user says nothing.
pub const MARGIN: f64 = 1.5;

/// Where the thresholds come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// This many times the largest residual of the learning window.
    FromLearning {
        /// How many times.
        margin: f64,
    },
    /// Given.
    Fixed(ByModel<f64>),
}

/// What judging starts from.
#[derive(Clone, Debug)]
pub enum Learn {
    /// A window of the log, to be learned.
    Window(RowWindow),
    /// A baseline that an earlier replay learned.
    Stored(Box<StoredBaseline>),
}

/// What to replay, and how.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The log.
    pub source: Source,
    /// What judging starts from.
    pub learn: Learn,
    /// Settling time after a change of the set point, s.
    pub settle_s: f64,
    /// Length of the learning window after a change of the set point, s; that of `learn` if none.
    pub relearn_s: Option<f64>,
    /// Whether to judge by the first baseline again when its set point returns, instead of learning anew.
    pub recall: bool,
    /// Largest movement of the set point that is not a change, in its unit.
    pub set_point_tolerance: f64,
    /// Cutoff of the residuals' low-pass, Hz; see [`Replay::default_cutoff_hz`] if none.
    pub cutoff_hz: Option<f64>,
    /// How far below its threshold a residual must fall to bring its relay down, as a share of it.
    pub hysteresis: f64,
    /// Share of the variance that the retained components explain.
    pub explained_share: f64,
    /// Where the thresholds come from.
    pub limits: Limits,
}

/// A replay that has run: the report, and what the page is drawn from.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The result.
    pub report: ReplayReport,
    /// Signals and intervals.
    pub recording: Recording,
    /// Names of the channels.
    pub names: ChannelNames,
    /// What was learned, to be judged by another time.
    pub baseline: StoredBaseline,
}

impl Replayed {
    /// What a person should know about the log and the window, a sentence each.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let report = &self.report;
        let warnings = report.learned.quality.warnings.iter().map(|warning| format!("warning: {warning}"));
        let notes = report.notes.iter().map(|note| format!("note: {note}"));
        let skipped = (report.skipped > 0)
            .then(|| format!("note: {} rows with a value that is not finite were skipped", report.skipped));
        let refused = report.refused.iter().map(|r| format!("note: up to row {}: {}; learning again", r.row, r.reason));
        let injected = report.injected.iter().map(|injected| format!("note: fault added to the log: {injected}"));
        warnings.chain(notes).chain(skipped).chain(refused).chain(injected).collect()
    }

    /// How much of the log was judged, in a sentence.
    #[must_use]
    pub fn coverage(&self) -> String {
        coverage(self.report.coverage)
    }
}

impl Replay {
    /// The cutoff that suits a sampling rate when none is given: the paper's 1 Hz, but never above a twentieth of the
    /// rate, so that a slow log is still smoothed over some ten samples.
    #[must_use]
    pub fn default_cutoff_hz(rate_hz: f64) -> f64 {
        f64::min(1.0, rate_hz / 20.0)
    }

    /// Replays the log. `trace` begins the trace, if one is wanted, once the log has been found fit to learn from;
    /// `tick` is called with the bytes read so far by the judging pass.
    ///
    /// # Errors
    /// [`ReplayError`]: nothing is left half-written.
    pub fn run(
        &self,
        trace: impl FnOnce(&ChannelNames) -> Result<Option<TraceWriter<Verdict>>, OutputError>,
        tick: impl FnMut(u64),
    ) -> Result<Replayed, ReplayError> {
        let pass = self.begin()?;
        let (names, start) = (pass.names().clone(), pass.start.clone());
        let judged = self.judge(pass, trace(&names)?, tick)?;

        let report = ReplayReport {
            mode: "paper",
            log: self.source.path.clone(),
            channels: names.0.clone(),
            has_set_point: self.source.set_point.is_some(),
            rate_hz: self.source.rate_hz,
            samples: judged.recording.signals.samples,
            skipped: judged.skipped,
            learned: start.learned.clone(),
            cutoff_hz: self.cutoff(),
            limits: start.thresholds,
            coverage: judged.recording.coverage,
            refused: judged.refused,
            exit: u8::from(!judged.alarms.is_empty()),
            alarms: judged.alarms,
            injected: self.source.injections.iter().map(ToString::to_string).collect(),
            notes: judged.notes,
            files: judged.trace.into_iter().collect(),
        };
        let stored = StoredBaseline {
            channels: names.0.clone(),
            rate_hz: self.source.rate_hz,
            set_point: start.set_point,
            cutoff_hz: self.cutoff(),
            thresholds: start.thresholds,
            ..StoredBaseline::of(&start.baseline)
        };
        Ok(Replayed { report, recording: judged.recording, names, baseline: stored })
    }

    /// Learns, and opens the log to be judged row by row.
    ///
    /// # Errors
    /// [`ReplayError`] when a setting makes no sense, or the log cannot be read or learned from.
    pub fn begin(&self) -> Result<Pass, ReplayError> {
        // Settings are refused before a long log is read.
        self.check()?;
        let share = ExplainedShare::new(self.explained_share as f32).map_err(|e| settings(e.into()))?;
        // What is missing or a directory is told of when it is opened.
        if std::fs::metadata(&self.source.path).is_ok_and(|data| !data.is_file() && !data.is_dir()) {
            return Err(ReplayError::NotAFile(self.source.path.clone()));
        }
        let (names, injections) = (self.source.names(), self.source.resolved_injections()?);
        let start = match &self.learn {
            Learn::Window(window) => {
                self.start_from_window(&window.rows(self.source.rate_hz)?, &injections, &names, share)?
            }
            Learn::Stored(stored) => self.start_from_stored(stored, &names, share)?,
        };
        Pass::new(self, start)
    }

    /// Refuses settings that make no sense, whatever the log.
    ///
    /// # Errors
    /// [`ReplayError`] names the setting.
    pub fn check(&self) -> Result<(), ReplayError> {
        self.source.check_rate()?;
        self.source.resolved_injections()?;
        self.config(Bank::from_fn(|_| NO_LIMIT)).and_then(|config| Monitor::new(&config).map_err(settings)).map(drop)
    }

    fn cutoff(&self) -> f64 {
        let stored = match &self.learn {
            Learn::Window(_) => None,
            Learn::Stored(stored) => Some(stored.cutoff_hz),
        };
        self.cutoff_hz.or(stored).unwrap_or_else(|| Self::default_cutoff_hz(self.source.rate_hz))
    }

    /// How long the monitor learns after a change of the set point: as long as before it, if nothing else was said.
    fn relearn(&self) -> Result<f64, ReplayError> {
        let samples = match &self.learn {
            Learn::Window(window) => window.rows(self.source.rate_hz).map(|rows| rows.end - rows.start)?,
            Learn::Stored(stored) => u64::from(stored.samples),
        };
        Ok(self.relearn_s.unwrap_or(samples as f64 / self.source.rate_hz))
    }

    fn config(&self, thresholds: Bank<f32>) -> Result<Config, ReplayError> {
        Ok(Config {
            settle_s: self.settle_s as f32,
            learn_s: self.relearn()? as f32,
            set_point_tolerance: self.set_point_tolerance as f32,
            explained_share: self.explained_share as f32,
            cutoff_hz: self.cutoff() as f32,
            hysteresis: self.hysteresis as f32,
            ..Config::paper(self.source.rate_hz as f32, thresholds)
        })
    }

    /// Third pass: record everything, judge what lies behind the window.
    fn judge(
        &self,
        mut pass: Pass,
        mut trace: Option<TraceWriter<Verdict>>,
        mut tick: impl FnMut(u64),
    ) -> Result<Judged, ReplayError> {
        let mut judged = Judged::new(self.source.rate_hz);
        let mut alarms = AlarmBuilder::new(self.source.rate_hz, pass.monitor().thresholds());
        while let Some(Step { row, set_point, x, judged: verdict, refused }) = pass.next_step()? {
            let reading = Reading { row, set_point, x };
            judged.skipped += u64::from(!reading.is_finite());
            if let Some(verdict) = verdict {
                if let Some(error) = refused {
                    judged.refused.push(Refusal { row, reason: pass.names().explain_learning(error) });
                }
                judged.recording.push(row, set_point, x, &verdict);
                alarms.push(row, &verdict, || pass.monitor().contributions(reading.channels()));
                if let Some(trace) = &mut trace {
                    let set_point = self.source.set_point.as_ref().map(|_| set_point);
                    let t_s = judged.recording.signals.seconds(row);
                    trace.write(TraceRow { row, t_s, set_point, x, said: &verdict })?;
                }
            } else {
                judged.recording.signals.push(row, set_point, x);
                if pass.is_learned_from(row) {
                    judged.recording.phases.push(row, "learning");
                }
            }
            if row % TICK_ROWS == 0 {
                tick(pass.log().bytes_read());
            }
        }
        judged.alarms = alarms.finish();
        judged.notes = notes(pass.log(), judged.recording.signals.samples, judged.recording.coverage.monitoring);
        judged.trace = trace.map(TraceWriter::finish).transpose()?;
        Ok(judged)
    }
}

/// What the third pass made.
#[derive(Debug)]
struct Judged {
    recording: Recording,
    alarms: Vec<Alarm>,
    refused: Vec<Refusal>,
    skipped: u64,
    notes: Vec<String>,
    trace: Option<PathBuf>,
}

impl Judged {
    fn new(rate_hz: f64) -> Self {
        let recording = Recording::new(rate_hz);
        Judged { recording, alarms: Vec::new(), refused: Vec::new(), skipped: 0, notes: Vec::new(), trace: None }
    }
}

fn settings(error: ConfigError) -> ReplayError {
    ReplayError::Settings(explain_config(error))
}

fn learning_refused(names: &ChannelNames, error: LearnError) -> ReplayError {
    ReplayError::Learning(names.explain_learning(error))
}
