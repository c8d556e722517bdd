//! The judging pass over a log, row by row.

use monitor_core::moments::LearnError;
use monitor_core::paper::{Monitor, Phase, Verdict};

use super::learn::Start;
use super::{Replay, settings};
use crate::inject::ResolvedInjection;
use crate::log::Log;
use crate::names::{ByModel, ChannelNames};
use crate::replay::{Reading, ReplayError, next_reading};

/// One row of a log, and what was said of it.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The row.
    pub row: u64,
    /// Its set point; zero in a log that has none.
    pub set_point: f64,
    /// Its channels.
    pub x: [f64; 3],
    /// What was said of it, if it lies behind the learning window.
    pub judged: Option<Verdict>,
    /// With the last row of a later learning window: why it was refused, if it was.
    pub refused: Option<LearnError>,
}

/// A log under judgement, in memory that does not grow with its length. What was learned from was read before.
#[derive(Debug)]
pub struct Pass {
    log: Log,
    injections: Vec<ResolvedInjection>,
    names: ChannelNames,
    pub(super) start: Start,
    monitor: Monitor,
    recalls: bool,
    recall_due: bool,
    set_point_tolerance: f64,
    has_set_point: bool,
}

impl Pass {
    pub(super) fn new(replay: &Replay, start: Start) -> Result<Self, ReplayError> {
        let source = &replay.source;
        let config = replay.config(ByModel::from_fn(|model| *start.thresholds.get(model) as f32).bank())?;
        let monitor = Monitor::new(&config).map_err(settings)?.starting_from(start.baseline, start.set_point as f32);
        Ok(Pass {
            log: source.open()?,
            injections: source.resolved_injections()?,
            names: source.names(),
            start,
            monitor,
            recalls: replay.recall,
            recall_due: false,
            set_point_tolerance: replay.set_point_tolerance,
            has_set_point: source.set_point.is_some(),
        })
    }

    /// Takes the next row; none at the end of the log.
    ///
    /// # Errors
    /// [`ReplayError`] when the row cannot be read.
    pub fn next_step(&mut self) -> Result<Option<Step>, ReplayError> {
        let Some(reading) = next_reading(&mut self.log, &self.injections)? else { return Ok(None) };
        let Reading { row, set_point, x } = reading;
        let mut step = Step { row, set_point, x, judged: None, refused: None };
        // A last row without a line end may be cut inside its last number; one wrong value would raise an alarm.
        if row >= self.start.row && !self.log.ends_without_newline() {
            if std::mem::take(&mut self.recall_due) {
                self.monitor.recall(self.start.baseline);
            }
            let verdict = *self.monitor.step_channels(set_point as f32, reading.channels());
            step.judged = Some(verdict);
            if verdict.phase() == Phase::ModelDue {
                step.refused = self.monitor.finish_learning().err();
            }
            // The same set point again: judge by what was learned there, instead of learning what may be a fault.
            let known = (set_point - self.start.set_point).abs() <= self.set_point_tolerance;
            self.recall_due = self.recalls && known && verdict.phase() == Phase::Learning;
        }
        Ok(Some(step))
    }

    /// The monitor.
    #[must_use]
    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// Names of the channels.
    #[must_use]
    pub const fn names(&self) -> &ChannelNames {
        &self.names
    }

    /// Whether the set point is read from the log.
    #[must_use]
    pub const fn has_set_point(&self) -> bool {
        self.has_set_point
    }

    /// Whether a row lies in the window that was learned from.
    #[must_use]
    pub fn is_learned_from(&self, row: u64) -> bool {
        self.start.learned.start_row.is_some_and(|start| (start..self.start.row).contains(&row))
    }

    pub(super) const fn log(&self) -> &Log {
        &self.log
    }
}
