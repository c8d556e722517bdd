//! Replays a recorded log through the monitor: learn over a window, set limits on it, judge the rest.
//!
//! The log is streamed, three times over: once to learn the baseline, once over the learning window to see how far a
//! healthy residual goes, once to judge. Memory does not grow with the log.

mod alarm;
mod report;

use std::ops::Range;
use std::path::PathBuf;

use monitor_core::moments::{LearnError, Moments};
use monitor_core::monitor::ConfigError;
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::Bank;
use monitor_core::{Baseline, Config, Monitor, Phase};

use crate::inject::{InjectError, Injection, ResolvedInjection};
use crate::log::{ColumnRef, LogError, LogOptions, LogReader, TruncatedTail};
use crate::names::{ByModel, ChannelNames, explain_config};
use crate::output::OutputError;
use crate::record::{Peak, PhaseCounts, Recording};
use crate::trace::{TraceRow, TraceWriter};
use crate::window::{RowWindow, WindowError};

pub use alarm::Alarm;
use alarm::AlarmBuilder;
use report::learned;
pub use report::{Learned, Quality, Refusal, ReplayReport};

/// The residual of a run whose limits are still sought meets no relay.
const NO_LIMIT: f32 = f32::MAX;

/// How many rows are read between two reports of progress.
const TICK_ROWS: u64 = 8192;

/// Why a log could not be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The log could not be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The learning window makes no sense.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// An injection makes no sense.
    #[error(transparent)]
    Inject(#[from] InjectError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The log is a pipe or a device.
    #[error("the log '{}' is not a regular file: it is read three times, so save it to a file first", .0.display())]
    NotAFile(PathBuf),
    /// The rate is not a number above zero.
    #[error("the sampling rate must be finite and above zero, not {0}: give the log's rows per second with --rate-hz")]
    Rate(f64),
    /// The window reaches past the log.
    #[error("the learning window is rows {} to {}, but the log has {rows} rows: choose a window inside it", window.start, window.end)]
    WindowOutside {
        /// The window, in rows.
        window: Range<u64>,
        /// Rows of the log.
        rows: u64,
    },
    /// The set point changes inside the window.
    #[error(
        "the set point changes from {from} to {to} at row {row}, inside the learning window: the method learns at a \
         constant set point, so choose another window (or widen --set-point-tolerance)"
    )]
    SetPointChanges {
        /// Row of the change.
        row: u64,
        /// Set point the window began with.
        from: f64,
        /// Set point at that row.
        to: f64,
    },
    /// The window was refused.
    #[error("{0}")]
    Learning(String),
    /// The monitor refused a setting.
    #[error("{0}")]
    Settings(String),
}

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

/// What to replay, and how.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The log.
    pub path: PathBuf,
    /// The three channels: a name and a column each.
    pub channels: [(String, ColumnRef); 3],
    /// The column of the set point; without it, the set point counts as constant.
    pub set_point: Option<ColumnRef>,
    /// How the log is written.
    pub log: LogOptions,
    /// Rows per second.
    pub rate_hz: f64,
    /// Where to learn.
    pub learn: RowWindow,
    /// Settling time after a change of the set point, s.
    pub settle_s: f64,
    /// Length of the learning window after a change of the set point, s; that of `learn` if none.
    pub relearn_s: Option<f64>,
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
    /// Faults to add to the recorded values.
    pub injections: Vec<Injection>,
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
        let PhaseCounts { settling, learning, monitoring } = self.report.coverage;
        let behind = settling + learning + monitoring;
        let share = |samples: u64| 100.0 * samples as f64 / behind.max(1) as f64;
        let [judged, settling, learning] = [monitoring, settling, learning].map(share);
        format!(
            "Of the {behind} rows behind the learning window {judged:.1} % were judged; {settling:.1} % went to settling \
             and {learning:.1} % to learning after changes of the set point."
        )
    }
}

/// A sample of the log with its row.
#[derive(Clone, Copy, Debug)]
struct Reading {
    row: u64,
    set_point: f64,
    x: [f64; 3],
}

impl Reading {
    fn is_finite(&self) -> bool {
        self.set_point.is_finite() && self.x.iter().all(|value| value.is_finite())
    }

    fn channels(&self) -> [f32; 3] {
        self.x.map(|value| value as f32)
    }
}

impl Replay {
    /// The cutoff that suits a sampling rate when none is given: the paper's 1 Hz, but never above a twentieth of the
    /// rate, so that a slow log is still smoothed over some ten samples.
    #[must_use]
    pub fn default_cutoff_hz(rate_hz: f64) -> f64 {
        f64::min(1.0, rate_hz / 20.0)
    }

    /// Bytes of the log, for a progress bar: the judging pass reads all of it.
    #[must_use]
    pub fn bytes(&self) -> Option<u64> {
        std::fs::metadata(&self.path).ok().filter(std::fs::Metadata::is_file).map(|data| data.len())
    }

    /// Replays the log. `trace` begins the trace, once the log has been found fit to learn from; `tick` is called with the bytes read so far by the judging pass.
    ///
    /// # Errors
    /// [`ReplayError`]: nothing is left half-written.
    pub fn run(
        &self,
        trace: impl FnOnce(&ChannelNames) -> Result<TraceWriter, OutputError>,
        tick: impl FnMut(u64),
    ) -> Result<Replayed, ReplayError> {
        if !(self.rate_hz > 0.0 && self.rate_hz.is_finite()) {
            return Err(ReplayError::Rate(self.rate_hz));
        }
        let window = self.learn.rows(self.rate_hz)?;
        let names = ChannelNames(self.channels.clone().map(|(name, _)| name));
        let injections = self.resolved_injections(&names)?;
        let share = ExplainedShare::new(self.explained_share as f32).map_err(|e| settings(e.into()))?;
        // Settings are refused before a long log is read.
        self.config(&window, Bank::from_fn(|_| NO_LIMIT)).and_then(|config| Monitor::new(&config).map_err(settings))?;

        // What is missing or a directory is told of when it is opened.
        if std::fs::metadata(&self.path).is_ok_and(|data| !data.is_file() && !data.is_dir()) {
            return Err(ReplayError::NotAFile(self.path.clone()));
        }
        let learning = self.learn(&window, &injections, &names)?;
        let baseline = Baseline::learn(&learning.moments, share).map_err(|e| learning_refused(&names, e))?;
        let calibration = self.calibrate(&window, &injections, &baseline, learning.set_point)?;
        let thresholds = match self.limits {
            Limits::Fixed(thresholds) => thresholds,
            Limits::FromLearning { margin } => {
                ByModel::from_fn(|model| margin * f64::from(*calibration.peak.residuals.get(model)))
            }
        };
        let config = self.config(&window, ByModel::from_fn(|model| *thresholds.get(model) as f32).bank())?;
        let monitor = Monitor::new(&config).map_err(settings)?.starting_from(baseline, learning.set_point as f32);
        let judged = self.judge(&window, &injections, &names, monitor, trace(&names)?, tick)?;

        let learned = learned(&window, &learning, &baseline, &calibration, &names);
        let report = ReplayReport {
            mode: "paper",
            log: self.path.clone(),
            channels: names.0.clone(),
            has_set_point: self.set_point.is_some(),
            rate_hz: self.rate_hz,
            samples: judged.recording.samples,
            skipped: judged.skipped,
            learned,
            cutoff_hz: self.cutoff(),
            limits: thresholds,
            coverage: judged.recording.phases,
            refused: judged.refused,
            exit: u8::from(!judged.alarms.is_empty()),
            alarms: judged.alarms,
            injected: self.injections.iter().map(ToString::to_string).collect(),
            notes: judged.notes,
            files: judged.trace.into_iter().collect(),
        };
        Ok(Replayed { report, recording: judged.recording, names })
    }

    fn cutoff(&self) -> f64 {
        self.cutoff_hz.unwrap_or_else(|| Self::default_cutoff_hz(self.rate_hz))
    }

    fn config(&self, window: &Range<u64>, thresholds: Bank<f32>) -> Result<Config, ReplayError> {
        let window_s = (window.end - window.start) as f64 / self.rate_hz;
        Ok(Config {
            settle_s: self.settle_s as f32,
            learn_s: self.relearn_s.unwrap_or(window_s) as f32,
            set_point_tolerance: self.set_point_tolerance as f32,
            explained_share: self.explained_share as f32,
            cutoff_hz: self.cutoff() as f32,
            hysteresis: self.hysteresis as f32,
            ..Config::paper(self.rate_hz as f32, thresholds)
        })
    }

    fn resolved_injections(&self, names: &ChannelNames) -> Result<Vec<ResolvedInjection>, ReplayError> {
        let known: Vec<&str> = names.0.iter().map(String::as_str).collect();
        Ok(self.injections.iter().map(|injection| injection.resolve(&known)).collect::<Result<_, _>>()?)
    }

    fn open(&self) -> Result<LogReader, LogError> {
        let mut columns = self.channels.to_vec();
        columns.extend(self.set_point.iter().map(|column| ("set point".to_owned(), column.clone())));
        LogReader::open(&self.path, &columns, self.log)
    }

    /// First pass: the moments of the window, and those of its two halves.
    fn learn(
        &self,
        window: &Range<u64>,
        injections: &[ResolvedInjection],
        names: &ChannelNames,
    ) -> Result<Learning, ReplayError> {
        let mut log = self.open()?;
        let mut learning = Learning::default();
        let middle = window.start + (window.end - window.start) / 2;
        let mut began_at = None;
        let mut rows = 0;
        while rows < window.end {
            let Some(reading) = next_reading(&mut log, injections)? else {
                return Err(ReplayError::WindowOutside { window: window.clone(), rows });
            };
            rows = reading.row + 1;
            if !window.contains(&reading.row) {
                continue;
            }
            if !reading.is_finite() {
                learning.skipped += 1;
                continue;
            }
            let from = *began_at.get_or_insert(reading.set_point);
            if (reading.set_point - from).abs() > self.set_point_tolerance {
                return Err(ReplayError::SetPointChanges { row: reading.row, from, to: reading.set_point });
            }
            learning.moments.push(reading.channels());
            let half = if reading.row < middle { &mut learning.first_half } else { &mut learning.second_half };
            half.push(reading.channels());
        }
        learning.set_point = began_at.ok_or_else(|| learning_refused(names, LearnError::TooShort { samples: 0 }))?;
        Ok(learning)
    }

    /// Second pass: how far the residuals of the window itself go.
    fn calibrate(
        &self,
        window: &Range<u64>,
        injections: &[ResolvedInjection],
        baseline: &Baseline,
        set_point: f64,
    ) -> Result<Calibration, ReplayError> {
        let config = self.config(window, Bank::from_fn(|_| NO_LIMIT))?;
        let mut monitor = Monitor::new(&config).map_err(settings)?.starting_from(*baseline, set_point as f32);
        let mut calibration = Calibration::default();
        let mut log = self.open()?;
        while let Some(reading) = next_reading(&mut log, injections)? {
            if reading.row >= window.end {
                break;
            }
            if reading.row < window.start || !reading.is_finite() {
                continue;
            }
            let verdict = monitor.step_channels(reading.set_point as f32, reading.channels());
            if let Some(residuals) = verdict.residuals {
                calibration.peak.push(residuals);
            }
            let z = baseline
                .deviation(reading.channels())
                .into_iter()
                .zip(baseline.sigma())
                .map(|(d, s)| f64::from((d / s).abs()));
            for (largest, z) in calibration.largest_deviation.iter_mut().zip(z) {
                *largest = f64::max(*largest, z);
            }
        }
        Ok(calibration)
    }

    /// Third pass: record everything, judge what lies behind the window.
    fn judge(
        &self,
        window: &Range<u64>,
        injections: &[ResolvedInjection],
        names: &ChannelNames,
        mut monitor: Monitor,
        mut trace: TraceWriter,
        mut tick: impl FnMut(u64),
    ) -> Result<Judged, ReplayError> {
        let mut log = self.open()?;
        let mut judged = Judged::new(self.rate_hz);
        let mut alarms = AlarmBuilder::new(self.rate_hz, monitor.thresholds());
        while let Some(reading) = next_reading(&mut log, injections)? {
            let Reading { row, set_point, x } = reading;
            judged.skipped += u64::from(!reading.is_finite());
            // A last row without a line end may be cut inside its last number; one wrong value would raise an alarm.
            if row < window.end || log.ends_without_newline() {
                judged.recording.push_signals(row, set_point, x);
            } else {
                let verdict = monitor.step_channels(set_point as f32, reading.channels());
                if verdict.phase == Phase::ModelDue
                    && let Err(error) = monitor.finish_learning()
                {
                    judged.refused.push(Refusal { row, reason: names.explain_learning(error) });
                }
                judged.recording.push(row, set_point, x, &verdict);
                alarms.push(row, &verdict, || monitor.contributions(reading.channels()));
                let set_point = self.set_point.as_ref().map(|_| set_point);
                let t_s = judged.recording.seconds(row);
                trace.write(TraceRow { row, t_s, set_point, x, verdict: &verdict })?;
            }
            if row % TICK_ROWS == 0 {
                tick(log.bytes_read());
            }
        }
        judged.alarms = alarms.finish();
        judged.notes = notes(&log, &judged.recording);
        judged.trace = Some(trace.finish()?);
        Ok(judged)
    }
}

/// What the first pass gathered.
#[derive(Clone, Debug, Default)]
struct Learning {
    moments: Moments<3>,
    first_half: Moments<3>,
    second_half: Moments<3>,
    set_point: f64,
    skipped: u64,
}

/// What the second pass saw.
#[derive(Clone, Debug, Default)]
struct Calibration {
    peak: Peak,
    largest_deviation: [f64; 3],
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

fn next_reading(log: &mut LogReader, injections: &[ResolvedInjection]) -> Result<Option<Reading>, LogError> {
    let Some(row) = log.next_row()? else { return Ok(None) };
    let (index, values) = (row.row, row.values);
    // Three channels, and the set point behind them where there is one.
    let mut x = [f64::NAN; 3];
    for (value, from) in x.iter_mut().zip(values) {
        *value = *from;
    }
    let set_point = values.get(3).copied().unwrap_or(0.0);
    for injection in injections {
        injection.apply(index, &mut x);
    }
    Ok(Some(Reading { row: index, set_point, x }))
}

fn settings(error: ConfigError) -> ReplayError {
    ReplayError::Settings(explain_config(error))
}

fn learning_refused(names: &ChannelNames, error: LearnError) -> ReplayError {
    ReplayError::Learning(names.explain_learning(error))
}

fn notes(log: &LogReader, recording: &Recording) -> Vec<String> {
    let rows = recording.samples;
    let mut notes = Vec::new();
    if recording.phases.monitoring == 0 {
        notes
            .push("no row was judged, so no fault could be found; choose a shorter --learn or a longer log".to_owned());
    }
    if let Some(TruncatedTail { row, line }) = log.truncated_tail() {
        notes.push(format!(
            "the log ends in the middle of row {row} (line {line}); the {rows} whole rows before it were read"
        ));
    } else if log.ends_without_newline() {
        notes.push("the last row has no line end, so its last number may be cut; it was not judged".to_owned());
    }
    notes
}
