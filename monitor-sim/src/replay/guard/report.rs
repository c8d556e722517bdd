//! The result of a replay in `guard` mode, as machines read it. Keys that the paper's mode has as well mean the same.

use std::ops::Range;
use std::path::PathBuf;

use serde::Serialize;

use super::Alarm;
use super::pass::Model;
use crate::guardian::summary::{ScaleLimits, Settings, WindowQuality};
use crate::models::Models;
use crate::names::ChannelNames;
use crate::record::guard::{Coverage, Recording};
use crate::replay::{Refusal, coverage};

/// What was learned from the window; or what stored models say of the first set point that was judged by them.
#[derive(Clone, Debug, Serialize)]
pub struct Learned {
    /// Samples learned from: the window behind its two seeding windows; none of this log if models were stored.
    pub n: u32,
    /// First row of the window; zero if models were stored.
    pub start_row: u64,
    /// First row behind it; zero if models were stored.
    pub end_row: u64,
    /// Mean of each channel, in the order of `channels`.
    pub mean: [f64; 3],
    /// Standard deviation of each channel.
    pub sigma: [f64; 3],
    /// How good the window was; none if models were stored.
    pub quality: Option<WindowQuality>,
}

impl Learned {
    pub(super) fn of(window: &Range<u64>, model: &Model) -> Self {
        let Model { end_row, mean, sigma, quality } = *model;
        Learned {
            n: quality.samples,
            start_row: window.start,
            end_row,
            mean,
            sigma,
            quality: WindowQuality::of(&quality),
        }
    }
}

/// The result of a replay, as machines read it.
#[derive(Clone, Debug, Serialize)]
pub struct GuardReplayReport {
    /// Which monitor judged.
    pub mode: &'static str,
    /// The log.
    pub log: PathBuf,
    /// Names of the three channels.
    pub channels: [String; 3],
    /// Whether the set point was read from the log.
    pub has_set_point: bool,
    /// Rows per second.
    pub rate_hz: f64,
    /// Rows of the log.
    pub samples: u64,
    /// Rows with a value that is not finite.
    pub skipped: u64,
    /// The file of the models that the log was judged by; none if it was learned from.
    pub models: Option<PathBuf>,
    /// What was learned.
    pub learned: Learned,
    /// Limit of the distance at each time scale, at the end of the log; not a number while nothing was judged then.
    pub limits: ScaleLimits,
    /// Rows judged, and rows that were not because the set point had changed.
    pub coverage: Coverage,
    /// Learning windows refused after a change of the set point.
    pub refused: Vec<Refusal>,
    /// The alarms, in order.
    pub alarms: Vec<Alarm>,
    /// What is known of each set point at the end of the log.
    #[serde(skip)]
    pub known: Models,
    /// The faults that were added to the log.
    pub injected: Vec<String>,
    /// The monitor's settings.
    pub settings: Settings,
    /// What a person should know about the file.
    pub notes: Vec<String>,
    /// Where the page and the trace are.
    pub files: Vec<PathBuf>,
    /// Exit code: 0 no fault, 1 a fault was reported.
    pub exit: u8,
}

/// A replay that has run: the report, and what the page is drawn from.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The result.
    pub report: GuardReplayReport,
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
        let notes = report.notes.iter().map(|note| format!("note: {note}"));
        let skipped =
            (report.skipped > 0).then(|| format!("note: {} rows have a value that is not finite", report.skipped));
        let refused = report.refused.iter().map(|r| format!("note: up to row {}: {}; learning again", r.row, r.reason));
        let injected = report.injected.iter().map(|injected| format!("note: fault added to the log: {injected}"));
        let models = report.models.iter().map(|file| format!("note: judged by the models of '{}'", file.display()));
        models.chain(notes).chain(skipped).chain(refused).chain(injected).collect()
    }

    /// How much of the log was judged, in a sentence or two.
    #[must_use]
    pub fn coverage(&self) -> String {
        let Coverage { phases, withheld } = self.report.coverage;
        let judged = coverage(phases);
        if withheld == 0 {
            return judged;
        }
        format!("{judged} Another {withheld} rows were at set points that were reached while a fault was suspected.")
    }
}
