//! One pass over a log: learn over a window, judge what lies behind it.

use std::ops::Range;
use std::path::PathBuf;

use monitor_core::guard::{Config, Monitor, SCALES};
use monitor_core::moments::LearnError;

use super::alarm::AlarmBuilder;
use super::{GuardReplayReport, Learn, Learned, Replay, Replayed};
use crate::guardian::{self, Guardian, Said};
use crate::inject::ResolvedInjection;
use crate::log::Log;
use crate::models::Models;
use crate::names::ChannelNames;
use crate::record::guard::Recording;
use crate::replay::{Reading, Refusal, ReplayError, next_reading, notes};

/// Slots without a reading after which the core's watch over its sensors counts as warm, whatever it was before: it counts
/// slots, and begins to learn their noise only then.
pub(crate) const WARM_UP: u64 = 256;

/// Half-window means further apart than this many sigma are noted.
const SHIFT_TO_NOTE_SIGMA: f64 = 0.5;

/// How far the pass has come.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// In front of the window.
    Before,
    /// In the window; with its set point.
    Learning(f64),
    /// Behind it; from the row with which the model was complete. Or from the first row on, by models of another run.
    Judging { learned: Model },
}

/// What the window left behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    pub(super) end_row: u64,
    pub(super) mean: [f64; 3],
    pub(super) sigma: [f64; 3],
    pub(super) quality: monitor_core::guard::Quality,
}

impl Model {
    const NONE: Self = Model {
        end_row: 0,
        mean: [f64::NAN; 3],
        sigma: [f64::NAN; 3],
        quality: monitor_core::guard::Quality {
            samples: 0,
            clipped_share: 0.0,
            condition: 0.0,
            drift_sigmas: 0.0,
            slow_variance_ratio: 0.0,
        },
    };

    fn of(guard: &Monitor, end_row: u64) -> Self {
        let [mean, sigma] = guard.model().map_or([[f32::NAN; 3]; 2], |model| [model.mean(), model.sigma()]);
        Model { end_row, mean: mean.map(f64::from), sigma: sigma.map(f64::from), quality: *guard.quality() }
    }
}

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
    pub judged: Option<Said>,
}

/// One pass over a log, row by row, in memory that does not grow with its length.
#[derive(Debug)]
pub struct Pass {
    replay: Replay,
    log: Log,
    injections: Vec<ResolvedInjection>,
    window: Range<u64>,
    config: Config,
    guardian: Guardian,
    settle_slots: u64,
    state: State,
    recording: Recording,
    alarms: AlarmBuilder,
    refused: Vec<Refusal>,
    anew: Vec<String>,
    skipped: u64,
    names: ChannelNames,
    models: Option<PathBuf>,
}

impl Pass {
    pub(super) fn new(replay: &Replay) -> Result<Self, ReplayError> {
        let source = &replay.source;
        source.check_rate()?;
        let injections = source.resolved_injections()?;
        let (names, config) = (source.names(), replay.config()?);
        let mut guardian = replay.guardian(&config)?;
        let (window, state, models) = match &replay.learn {
            Learn::Window(window) => (window.rows(source.rate_hz)?, State::Before, None),
            Learn::Stored { place, .. } => {
                let file = place.of(&source.path);
                replay.restore(&Models::read(&file)?, &mut guardian)?;
                (0..0, State::Judging { learned: Model::NONE }, Some(file))
            }
        };
        Ok(Pass {
            guardian,
            settle_slots: (replay.settle_s * source.rate_hz) as u64,
            state,
            recording: Recording::new(source.rate_hz),
            alarms: AlarmBuilder::new(source.rate_hz, names.clone()),
            refused: Vec::new(),
            anew: Vec::new(),
            skipped: 0,
            names,
            models,
            injections,
            window,
            config,
            log: source.open()?,
            replay: replay.clone(),
        })
    }

    /// Takes the next row; none at the end of the log.
    ///
    /// # Errors
    /// [`ReplayError`] when the row cannot be read, or the learning window is refused.
    pub fn next_step(&mut self) -> Result<Option<Step>, ReplayError> {
        let Some(reading) = next_reading(&mut self.log, &self.injections)? else { return Ok(None) };
        let cut = self.log.ends_without_newline();
        let judged = self.take(&reading, cut)?;
        let Reading { row, set_point, x } = reading;
        Ok(Some(Step { row, set_point, x, judged }))
    }

    /// Names of the channels.
    #[must_use]
    pub const fn names(&self) -> &ChannelNames {
        &self.names
    }

    /// The monitor's settings.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Whether the set point is read from the log.
    #[must_use]
    pub const fn has_set_point(&self) -> bool {
        self.replay.source.set_point.is_some()
    }

    /// Bytes of the log taken so far.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.log.bytes_read()
    }

    /// The monitor, once the learning window has begun.
    #[must_use]
    pub fn guardian(&self) -> Option<&Guardian> {
        (self.state != State::Before).then_some(&self.guardian)
    }

    /// Takes a row; returns what was said of it if it was to be judged.
    fn take(&mut self, reading: &Reading, cut: bool) -> Result<Option<Said>, ReplayError> {
        let Reading { row, set_point, x } = *reading;
        self.skipped += u64::from(!reading.is_finite());
        match self.state {
            // A last row without a line end may be cut inside its last number; one wrong value would raise an alarm.
            _ if cut => self.recording.signals.push(row, set_point, x),
            State::Before => {
                self.recording.signals.push(row, set_point, x);
                if row >= self.window.start && reading.is_finite() {
                    self.open_gate(set_point);
                    self.state = State::Learning(set_point);
                    self.learn(reading)?;
                }
            }
            State::Learning(from) => {
                self.recording.signals.push(row, set_point, x);
                if (set_point - from).abs() > self.replay.set_point_tolerance {
                    return Err(ReplayError::SetPointChanges { row, from, to: set_point });
                }
                self.learn(reading)?;
            }
            State::Judging { .. } => return Ok(Some(self.judge(reading))),
        }
        Ok(None)
    }

    /// Lets the settling time go by beforehand, in slots without a reading: the window begins where its user says that the
    /// motor has settled.
    fn open_gate(&mut self, set_point: f64) {
        for _ in 0..self.settle_slots + WARM_UP {
            self.guardian.step(set_point as f32, [f32::NAN; 3]);
        }
    }

    fn learn(&mut self, reading: &Reading) -> Result<(), ReplayError> {
        let State::Learning(from) = self.state else { return Ok(()) };
        self.recording.phases.push(reading.row, "learning");
        // A set point that is no number is a row without a sample, as one of a channel is.
        let set_point = if reading.set_point.is_finite() { reading.set_point } else { from };
        let x = if reading.set_point.is_finite() { reading.channels() } else { [f32::NAN; 3] };
        let said = self.guardian.step(set_point as f32, x);
        let refused = self.guardian.guard().refused().or(said.learned.and_then(Result::err));
        if let Some(error) = refused {
            return Err(self.learning_refused(error));
        }
        if said.learned.is_some() {
            self.state = State::Judging { learned: Model::of(self.guardian.guard(), reading.row + 1) };
        }
        Ok(())
    }

    fn judge(&mut self, reading: &Reading) -> Said {
        let Reading { row, set_point, x } = *reading;
        let said = self.guardian.step(set_point as f32, reading.channels());
        if let Some(Err(error)) = said.learned {
            self.refused.push(Refusal { row, reason: self.names.explain_learning(error) });
        }
        let guardian = &self.guardian;
        if let (Some(models), Some(Ok(()))) = (&self.models, said.learned) {
            self.anew.push(format!(
                "set point {set_point} is none of those in '{}': it was learned up to row {row}, and taken for healthy",
                models.display()
            ));
        }
        if let State::Judging { learned } = &mut self.state
            && learned.mean.iter().all(|mean| mean.is_nan())
        {
            *learned = Model::of(guardian.guard(), if said.learned.is_some() { row + 1 } else { 0 });
        }
        self.recording.push(row, set_point, x, &said);
        self.alarms.push(row, &said, || guardian.contributions(reading.channels()));
        said
    }

    fn learning_refused(&self, error: LearnError) -> ReplayError {
        ReplayError::Learning(self.names.explain_learning(error))
    }

    /// Makes the report of what was said; behind the last row.
    ///
    /// # Errors
    /// [`ReplayError`] when the log ended before anything was learned.
    pub fn finish(self, trace: Option<PathBuf>) -> Result<Replayed, ReplayError> {
        let (window, config) = (&self.window, &self.config);
        let rows = self.recording.signals.samples;
        let State::Judging { learned } = self.state else {
            if rows < window.end {
                return Err(ReplayError::WindowOutside { window: window.clone(), rows });
            }
            return Err(ReplayError::Learning(
                "the learning window has too few rows in which every value is finite: choose another or a longer one"
                    .to_owned(),
            ));
        };
        let Replay { source, motor, .. } = &self.replay;
        let alarms = self.alarms.finish();
        let mut notes = notes(&self.log, rows, self.recording.coverage.phases.monitoring);
        notes.extend(self.anew);
        let moved = f64::from(learned.quality.drift_sigmas);
        if moved > SHIFT_TO_NOTE_SIGMA {
            notes.push(format!(
                "a channel's mean moves by {moved:.2} sigma from the first half of what was learned from to the second: it is \
                 not stationary, and small faults are hidden"
            ));
        }
        if motor.is_none() && !alarms.is_empty() && self.names == ChannelNames::motor() {
            notes.push(
                "faults get names from the motor's constants: give --resistance, --torque-constant and --load-slope"
                    .to_owned(),
            );
        }
        let limits = self.guardian.guard().limits().unwrap_or([f32::NAN; SCALES]);
        let report = GuardReplayReport {
            mode: "guard",
            log: source.path.clone(),
            channels: self.names.0.clone(),
            has_set_point: source.set_point.is_some(),
            rate_hz: source.rate_hz,
            samples: rows,
            skipped: self.skipped,
            models: self.models,
            learned: Learned::of(window, &learned),
            limits: guardian::summary::ScaleLimits::of(limits),
            coverage: self.recording.coverage,
            refused: self.refused,
            exit: u8::from(!alarms.is_empty()),
            alarms,
            known: Models::of(self.guardian.guard()),
            injected: source.injections.iter().map(ToString::to_string).collect(),
            settings: config.into(),
            notes,
            files: trace.into_iter().collect(),
        };
        Ok(Replayed { report, recording: self.recording, names: self.names })
    }
}
