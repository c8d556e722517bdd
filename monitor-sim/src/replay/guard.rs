//! A replay in `guard` mode: one pass, in which the monitor seeds and learns over a window of the log and judges the rest, or
//! judges from the beginning by models of another run.

mod alarm;
mod pass;
mod report;

use monitor_core::guard::{Config, MotorConstants};
use monitor_core::moments::Moments;

use super::{ReplayError, Source, TICK_ROWS};
use crate::guardian::{self, Alarming, Guardian, Said};
use crate::models::{Models, Place};
use crate::names::{ChannelNames, explain_guard_config};
use crate::output::OutputError;
use crate::trace::{TraceRow, TraceWriter};
use crate::window::RowWindow;

pub use alarm::Alarm;
pub(crate) use alarm::AlarmBuilder;
pub(crate) use pass::WARM_UP;
pub use pass::{Pass, Step};
pub use report::{GuardReplayReport, Learned, Replayed};

/// Share of the window that each of the two seeding windows takes.
const SEED_SHARE: u64 = 10;

/// Fewest rows of a seeding window, and of what is learned behind both.
const LEAST_SEED: u64 = Moments::<3>::MIN_SAMPLES as u64;
const LEAST_LEARN: u64 = 4 * LEAST_SEED;

/// What judging starts from.
#[derive(Clone, Debug)]
pub enum Learn {
    /// A window of the log, to be learned.
    Window(RowWindow),
    /// Models of an earlier run.
    Stored {
        /// Where they are.
        place: Place,
        /// Length of the learning window at a set point that is not among them, s; as long as the time scales want it if none.
        relearn_s: Option<f64>,
    },
}

/// What to replay, and how.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The log.
    pub source: Source,
    /// What judging starts from.
    pub learn: Learn,
    /// When an alarm is raised and withdrawn.
    pub alarming: Alarming,
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
        let mut pass = self.begin()?;
        let (mut begin, mut written) = (Some(trace), None);
        while let Some(Step { row, set_point, x, judged }) = pass.next_step()? {
            if let Some(said) = judged {
                if let Some(begin) = begin.take() {
                    written = begin(pass.names())?;
                }
                if let Some(trace) = &mut written {
                    let t_s = row as f64 / self.source.rate_hz;
                    let set_point = self.source.set_point.as_ref().map(|_| set_point);
                    trace.write(TraceRow { row, t_s, set_point, x, said: &said })?;
                }
            }
            if row % TICK_ROWS == 0 {
                tick(pass.bytes_read());
            }
        }
        let trace = written.map(TraceWriter::finish).transpose()?;
        pass.finish(trace)
    }

    /// Refuses settings that make no sense, whatever the log.
    ///
    /// # Errors
    /// [`ReplayError`] names the setting.
    pub fn check(&self) -> Result<(), ReplayError> {
        self.source.check_rate()?;
        self.source.resolved_injections()?;
        let mut guardian = self.guardian(&self.config()?)?;
        // Of a directory, each log will name its own file.
        if let Learn::Stored { place: Place::File(path), .. } = &self.learn {
            self.restore(&Models::read(path)?, &mut guardian)?;
        }
        Ok(())
    }

    /// Opens the log, to be replayed row by row.
    ///
    /// # Errors
    /// [`ReplayError`] when the log cannot be opened, or a setting makes no sense.
    pub fn begin(&self) -> Result<Pass, ReplayError> {
        Pass::new(self)
    }

    /// Rows of a learning window at a set point that nothing is known of.
    fn learn_rows(&self) -> Result<u64, ReplayError> {
        let rate_hz = self.source.rate_hz;
        match &self.learn {
            Learn::Window(window) => Ok(window.rows(rate_hz).map(|rows| rows.end.saturating_sub(rows.start))?),
            Learn::Stored { relearn_s: Some(relearn_s), .. } => Ok((relearn_s * rate_hz).round() as u64),
            Learn::Stored { relearn_s: None, .. } => {
                let learned = 1.0 - 2.0 / SEED_SHARE as f64;
                Ok((guardian::ample_learn_s(rate_hz) * rate_hz / learned).ceil() as u64)
            }
        }
    }

    /// The `--relearn` with which another log is judged by what this one leaves.
    ///
    /// # Errors
    /// [`ReplayError`] when the learning window makes no sense.
    pub fn relearn_s(&self) -> Result<f64, ReplayError> {
        Ok(self.learn_rows()? as f64 / self.source.rate_hz)
    }

    /// Gives a monitor what was learned before, if the log's set points can be among it.
    fn restore(&self, models: &Models, guardian: &mut Guardian) -> Result<(), ReplayError> {
        guardian.restore(models)?;
        let constant = |at: f32| f64::from(at).abs() <= self.set_point_tolerance;
        if self.source.set_point.is_none() && !models.set_points().any(constant) {
            return Err(ReplayError::Settings(format!(
                "the models are of the set points {}, and a log without one counts as 0: name its column with --set-point",
                models.listed()
            )));
        }
        Ok(())
    }

    /// The monitor's settings: two tenths of the window seed the clip of spikes, the rest is learned from.
    fn config(&self) -> Result<Config, ReplayError> {
        let config = config(self.learn_rows()?, self.source.rate_hz, &self.alarming, self.settle_s)?;
        Ok(Config { set_point_tolerance: self.set_point_tolerance as f32, ..config })
    }

    fn guardian(&self, config: &Config) -> Result<Guardian, ReplayError> {
        Guardian::new(config, self.motor).map_err(|error| ReplayError::Settings(explain_guard_config(error)))
    }
}

/// The monitor's settings for a learning window of so many rows.
pub(crate) fn config(rows: u64, rate_hz: f64, alarming: &Alarming, settle_s: f64) -> Result<Config, ReplayError> {
    let seed = (rows / SEED_SHARE).max(LEAST_SEED);
    let learn = rows.saturating_sub(2 * seed);
    if learn < LEAST_LEARN {
        return Err(ReplayError::Learning(format!(
            "the learning window holds {rows} rows, and guard mode needs at least {} (two times {LEAST_SEED} to tell \
             spikes by, {LEAST_LEARN} to learn from): choose a longer --learn (with --models: --relearn); --mode paper needs {LEAST_SEED}",
            2 * LEAST_SEED + LEAST_LEARN
        )));
    }
    let [seed_s, learn_s] = [seed, learn].map(|rows| rows as f64 / rate_hz);
    Ok(guardian::settings(rate_hz, alarming, settle_s, seed_s, learn_s))
}
