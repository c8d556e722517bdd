//! Replays a recorded log through a monitor: learn over a window, judge the rest.
//!
//! The log is streamed, so memory does not grow with it. What both modes share is here; each has its own learning, alarms
//! and report in a module of its own.

use std::ops::Range;
use std::path::PathBuf;

use serde::Serialize;

use crate::inject::{InjectError, Injection, ResolvedInjection};
use crate::log::{ColumnRef, Log, LogError, LogOptions, TruncatedTail};
use crate::models::ModelsError;
use crate::names::ChannelNames;
use crate::output::OutputError;
use crate::record::PhaseCounts;
use crate::window::WindowError;

pub mod guard;
pub mod paper;

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
    /// Stored models do not fit.
    #[error(transparent)]
    Models(#[from] ModelsError),
    /// The stored baseline does not fit.
    #[error("the stored baseline cannot be used: {0}")]
    Baseline(String),
    /// The monitor refused a setting.
    #[error("{0}")]
    Settings(String),
}

/// A recorded log, and what its columns are.
#[derive(Clone, Debug)]
pub struct Source {
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
    /// Faults to add to the recorded values.
    pub injections: Vec<Injection>,
}

impl Source {
    /// Bytes of the log, for a progress bar: the judging pass reads all of it.
    #[must_use]
    pub fn bytes(&self) -> Option<u64> {
        std::fs::metadata(&self.path).ok().filter(std::fs::Metadata::is_file).map(|data| data.len())
    }

    /// Names of the channels.
    #[must_use]
    pub fn names(&self) -> ChannelNames {
        ChannelNames(self.channels.clone().map(|(name, _)| name))
    }

    fn check_rate(&self) -> Result<(), ReplayError> {
        if self.rate_hz > 0.0 && self.rate_hz.is_finite() { Ok(()) } else { Err(ReplayError::Rate(self.rate_hz)) }
    }

    fn resolved_injections(&self) -> Result<Vec<ResolvedInjection>, ReplayError> {
        let names = self.names();
        let known: Vec<&str> = names.0.iter().map(String::as_str).collect();
        Ok(self.injections.iter().map(|injection| injection.resolve(&known)).collect::<Result<_, _>>()?)
    }

    fn open(&self) -> Result<Log, LogError> {
        let mut columns = self.channels.to_vec();
        columns.extend(self.set_point.iter().map(|column| ("set point".to_owned(), column.clone())));
        Log::open(&self.path, &columns, self.log)
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

fn next_reading(log: &mut Log, injections: &[ResolvedInjection]) -> Result<Option<Reading>, LogError> {
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

/// A learning window that the monitor refused while it replayed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refusal {
    /// Row at which the window ended.
    pub row: u64,
    /// Why it was refused.
    pub reason: String,
}

/// How much of the log was judged, in a sentence.
fn coverage(PhaseCounts { settling, learning, monitoring }: PhaseCounts) -> String {
    let behind = settling + learning + monitoring;
    let share = |samples: u64| 100.0 * samples as f64 / behind.max(1) as f64;
    let [judged, settling, learning] = [monitoring, settling, learning].map(share);
    format!(
        "Of {behind} rows to judge {judged:.1} % were judged; {settling:.1} % went to settling and {learning:.1} % to \
         learning after changes of the set point."
    )
}

fn notes(log: &Log, rows: u64, judged: u64) -> Vec<String> {
    let mut notes = Vec::new();
    if judged == 0 {
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
