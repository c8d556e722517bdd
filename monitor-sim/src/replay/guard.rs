//! A replay in `guard` mode: one pass, in which the monitor seeds and learns over a window of the log and judges the rest.

mod alarm;
mod report;

use std::ops::Range;
use std::path::PathBuf;

use monitor_core::guard::{Config, Guard, MotorConstants};
use monitor_core::moments::{LearnError, Moments};

use super::{Reading, Refusal, ReplayError, Source, TICK_ROWS, next_reading, notes};
use crate::guardian::{self, Guardian, Said};
use crate::log::LogReader;
use crate::names::{ChannelNames, explain_guard_config};
use crate::output::OutputError;
use crate::record::guard::Recording;
use crate::trace::{TraceRow, TraceWriter};
use crate::window::RowWindow;

pub use alarm::Alarm;
pub(crate) use alarm::AlarmBuilder;
pub use report::{GuardReplayReport, Learned, Replayed};

/// Share of the window that each of the two seeding windows takes.
const SEED_SHARE: u64 = 10;

/// Fewest rows of a seeding window, and of what is learned behind both.
const LEAST_SEED: u64 = Moments::<3>::MIN_SAMPLES as u64;
const LEAST_LEARN: u64 = 4 * LEAST_SEED;

/// Slots without a reading after which the core's watch over its sensors counts as warm, whatever it was before: it counts
/// slots, and begins to learn their noise only then.
pub(crate) const WARM_UP: u64 = 256;

/// Half-window means further apart than this many sigma are noted.
const SHIFT_TO_NOTE_SIGMA: f64 = 0.5;

/// What to replay, and how.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The log.
    pub source: Source,
    /// Where to learn what healthy means.
    pub learn: RowWindow,
    /// False alarms that are tolerable per hour.
    pub false_alarms_per_hour: f64,
    /// Settling time after a change of the set point, s.
    pub settle_s: f64,
    /// Largest movement of the set point that is not a change, in its unit.
    pub set_point_tolerance: f64,
    /// The motor, by which faults get names; without it they are found, and called unknown.
    pub motor: Option<MotorConstants>,
}

impl Replay {
    /// Replays the log. `trace` begins the trace, if one is wanted, once the window has been learned from; `tick` is called
    /// with the bytes read so far.
    ///
    /// # Errors
    /// [`ReplayError`]: nothing is left half-written.
    pub fn run(
        &self,
        trace: impl FnOnce(&ChannelNames) -> Result<Option<TraceWriter<Said>>, OutputError>,
        mut tick: impl FnMut(u64),
    ) -> Result<Replayed, ReplayError> {
        self.source.check_rate()?;
        let window = self.learn.rows(self.source.rate_hz)?;
        let injections = self.source.resolved_injections()?;
        let (names, config) = (self.source.names(), self.config(&window)?);
        let mut pass = Pass {
            replay: self,
            guardian: self.guardian(&config)?,
            settle_slots: (self.settle_s * self.source.rate_hz) as u64,
            state: State::Before,
            recording: Recording::new(self.source.rate_hz),
            alarms: AlarmBuilder::new(self.source.rate_hz, names.clone()),
            refused: Vec::new(),
            skipped: 0,
            names,
        };
        let (mut begin, mut written) = (Some(trace), None);
        let mut log = self.source.open()?;
        while let Some(reading) = next_reading(&mut log, &injections)? {
            let judged = pass.take(&window, &reading, log.ends_without_newline())?;
            if let Some(said) = judged {
                if let Some(begin) = begin.take() {
                    written = begin(&pass.names)?;
                }
                if let Some(trace) = &mut written {
                    let Reading { row, set_point, x } = reading;
                    let (t_s, set_point) =
                        (pass.recording.signals.seconds(row), self.source.set_point.as_ref().map(|_| set_point));
                    trace.write(TraceRow { row, t_s, set_point, x, said: &said })?;
                }
            }
            if reading.row % TICK_ROWS == 0 {
                tick(log.bytes_read());
            }
        }
        let trace = written.map(TraceWriter::finish).transpose()?;
        pass.finish(&window, &config, &log, trace)
    }

    /// The monitor's settings: two tenths of the window seed the clip of spikes, the rest is learned from.
    fn config(&self, window: &Range<u64>) -> Result<Config, ReplayError> {
        let rows = window.end.saturating_sub(window.start);
        let config = config(rows, self.source.rate_hz, self.false_alarms_per_hour, self.settle_s)?;
        Ok(Config { set_point_tolerance: self.set_point_tolerance as f32, ..config })
    }

    fn guardian(&self, config: &Config) -> Result<Guardian, ReplayError> {
        Guardian::new(config, self.motor).map_err(|error| ReplayError::Settings(explain_guard_config(error)))
    }
}

/// The monitor's settings for a learning window of so many rows.
pub(crate) fn config(
    rows: u64,
    rate_hz: f64,
    false_alarms_per_hour: f64,
    settle_s: f64,
) -> Result<Config, ReplayError> {
    let seed = (rows / SEED_SHARE).max(LEAST_SEED);
    let learn = rows.saturating_sub(2 * seed);
    if learn < LEAST_LEARN {
        return Err(ReplayError::Learning(format!(
            "the learning window holds {rows} rows, and guard mode needs at least {} (two times {LEAST_SEED} to tell \
             spikes by, {LEAST_LEARN} to learn from): choose a longer --learn; --mode paper needs {LEAST_SEED}",
            2 * LEAST_SEED + LEAST_LEARN
        )));
    }
    let [seed_s, learn_s] = [seed, learn].map(|rows| rows as f64 / rate_hz);
    Ok(guardian::settings(rate_hz, false_alarms_per_hour, settle_s, seed_s, learn_s))
}

/// How far the pass has come.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// In front of the window.
    Before,
    /// In the window; with its set point.
    Learning(f64),
    /// Behind it; from the row with which the model was complete.
    Judging { learned: Model },
}

/// What the window left behind.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Model {
    end_row: u64,
    mean: [f64; 3],
    sigma: [f64; 3],
    quality: monitor_core::guard::Quality,
}

impl Model {
    fn of(guard: &Guard, end_row: u64) -> Self {
        let [mean, sigma] = guard.model().map_or([[f32::NAN; 3]; 2], |model| [model.mean(), model.sigma()]);
        Model { end_row, mean: mean.map(f64::from), sigma: sigma.map(f64::from), quality: *guard.quality() }
    }
}

/// One pass over a log.
struct Pass<'a> {
    replay: &'a Replay,
    guardian: Guardian,
    settle_slots: u64,
    state: State,
    recording: Recording,
    alarms: AlarmBuilder,
    refused: Vec<Refusal>,
    skipped: u64,
    names: ChannelNames,
}

impl Pass<'_> {
    /// Takes a row; returns what was said of it if it was to be judged.
    fn take(&mut self, window: &Range<u64>, reading: &Reading, cut: bool) -> Result<Option<Said>, ReplayError> {
        let Reading { row, set_point, x } = *reading;
        self.skipped += u64::from(!reading.is_finite());
        match self.state {
            // A last row without a line end may be cut inside its last number; one wrong value would raise an alarm.
            _ if cut => self.recording.signals.push(row, set_point, x),
            State::Before => {
                self.recording.signals.push(row, set_point, x);
                if row >= window.start && reading.is_finite() {
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
        self.recording.push(row, set_point, x, &said);
        let guardian = &self.guardian;
        self.alarms.push(row, &said, || guardian.contributions(reading.channels()));
        said
    }

    fn learning_refused(&self, error: LearnError) -> ReplayError {
        ReplayError::Learning(self.names.explain_learning(error))
    }

    fn finish(
        self,
        window: &Range<u64>,
        config: &Config,
        log: &LogReader,
        trace: Option<PathBuf>,
    ) -> Result<Replayed, ReplayError> {
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
        let Replay { source, motor, .. } = self.replay;
        let alarms = self.alarms.finish();
        let mut notes = notes(log, rows, self.recording.coverage.phases.monitoring);
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
        let limits = self.guardian.guard().limits().unwrap_or([f32::NAN; 3]);
        let report = GuardReplayReport {
            mode: "guard",
            log: source.path.clone(),
            channels: self.names.0.clone(),
            has_set_point: source.set_point.is_some(),
            rate_hz: source.rate_hz,
            samples: rows,
            skipped: self.skipped,
            learned: Learned::of(window, &learned),
            limits: guardian::summary::ScaleLimits::of(limits),
            coverage: self.recording.coverage,
            refused: self.refused,
            exit: u8::from(!alarms.is_empty()),
            alarms,
            injected: source.injections.iter().map(ToString::to_string).collect(),
            settings: config.into(),
            notes,
            files: trace.into_iter().collect(),
        };
        Ok(Replayed { report, recording: self.recording, names: self.names })
    }
}
