//! The mission in `guard` mode.

use std::path::PathBuf;
use std::time::Instant;

use monitor_core::guard::{Config, Quality, SCALES};
use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::Baseline;
use monitor_core::pca::ExplainedShare;

use super::{Faults, MissionError, feed, recovery, sample_at, truth};
use crate::guardian::{self, Alarming, Guardian, Said};
use crate::models::Models;
use crate::names::{ChannelNames, explain_guard_config};
use crate::output::OutputDir;
use crate::plant::PlantSample;
use crate::record::guard::Recording;
use crate::replay::guard::{Alarm, AlarmBuilder};
use crate::scenario::Scenario;
use crate::score::Truth;
use crate::score::guard::{Flown, Score, Seen};
use crate::study::raw::{self, RawBaseline};
use crate::study::watch::Known;
use crate::trace::{TraceRow, TraceWriter};

mod report;

pub use report::{GuardReport, RampRow};

/// What came of one scenario.
#[derive(Clone, Debug)]
pub struct Flight {
    /// The scenario flown.
    pub scenario: Scenario,
    /// Principal components of the learning window, which the monitor's metrics are made of.
    pub baseline: Baseline,
    /// What the monitor said of its learning window.
    pub quality: Quality,
    /// Limit of the distance at each time scale, when the flight ended.
    pub limits: [f32; SCALES],
    /// Signals and intervals.
    pub recording: Recording,
    /// Its alarms, with the share of each channel.
    pub alarms: Vec<Alarm>,
    /// The tables.
    pub score: Score,
    /// What was known of each set point when the flight ended.
    pub models: Models,
}

/// The settings a scenario is flown with: the monitor settles and seeds before the learning window, and learns over it.
#[must_use]
pub fn settings(scenario: &Scenario, alarming: &Alarming) -> Config {
    let (rate_hz, learn) = (scenario.rate_hz(), scenario.learn);
    let [settle_s, seed_s, learn_s] = guardian::spent(rate_hz, learn.start_s, learn.end_s);
    Config {
        converter_steps: Known::of(scenario).adc_steps.map(|step| step as f32),
        ..guardian::settings(rate_hz, alarming, settle_s, seed_s, learn_s)
    }
}

/// Flies a scenario, by stored models if there are any. `tick` is called with the number of samples flown since the last call.
///
/// # Errors
/// [`MissionError`] when the settings, the models or the learning window are refused, or the trace cannot be written.
pub fn fly(
    scenario: &Scenario,
    config: &Config,
    models: Option<&Models>,
    seed: u64,
    mut trace: Option<&mut TraceWriter<Said>>,
    tick: impl Fn(u64),
) -> Result<Flight, MissionError> {
    let mut guardian = guardian(scenario, config)?;
    models.map_or(Ok(()), |models| guardian.restore(models))?;
    let mut recording = Recording::new(scenario.rate_hz());
    let mut witness = Witness::new(scenario);
    let mut alarms = AlarmBuilder::new(scenario.rate_hz(), ChannelNames::motor());
    let samples = feed(scenario, seed, tick, |index, measured| {
        let said = give(&mut guardian, measured);
        if let Some(Err(error)) = said.learned {
            return Err(learning_refused(error));
        }
        witness.push(index, measured, &said);
        let x = measured.channels();
        recording.push(index, measured.set_point, x, &said);
        alarms.push(index, &said, || guardian.contributions(x.map(|x| x as f32)));
        if let Some(trace) = &mut trace {
            let set_point = Some(measured.set_point);
            trace.write(TraceRow { row: index, t_s: measured.t_s, set_point, x, said: &said })?;
        }
        Ok(())
    })?;
    let guard = guardian.guard();
    if recording.coverage.phases.monitoring == 0 {
        return Err(guard.refused().map_or(MissionError::NeverLearned, learning_refused));
    }
    Ok(Flight {
        scenario: scenario.clone(),
        baseline: witness.baseline()?,
        quality: *guard.quality(),
        limits: guard.limits().unwrap_or([f32::NAN; SCALES]),
        score: witness.score(&recording, samples),
        alarms: alarms.finish(),
        recording,
        models: Models::of(guard),
    })
}

fn learning_refused(error: LearnError) -> MissionError {
    MissionError::Learning(ChannelNames::motor().explain_learning(error))
}

/// The monitor a scenario is flown with; it knows the constants of the motor as its user would state them.
pub(crate) fn guardian(scenario: &Scenario, config: &Config) -> Result<Guardian, MissionError> {
    let motor = Known::of(scenario).motor_constants();
    Guardian::new(config, Some(motor)).map_err(|error| MissionError::Settings(explain_guard_config(error)))
}

/// Gives a monitor what the plant measured, or a slot without a sample.
pub(crate) fn give(guardian: &mut Guardian, measured: &PlantSample) -> Said {
    if measured.missing {
        return guardian.skip();
    }
    guardian.step(measured.set_point as f32, measured.channels().map(|x| x as f32))
}

/// Knows what is injected, and watches raw samples and sizes of faults for the tables.
struct Witness<'a> {
    scenario: &'a Scenario,
    truth: Vec<Truth>,
    learn: std::ops::Range<u64>,
    recovery: u64,
    window: raw::Moments,
    components: Option<Moments<3>>,
    one_sample: Option<RawBaseline>,
    seen: Vec<Seen>,
}

impl<'a> Witness<'a> {
    fn new(scenario: &'a Scenario) -> Self {
        let learn = scenario.learn;
        Witness {
            scenario,
            truth: truth(scenario),
            learn: sample_at(scenario, learn.start_s)..sample_at(scenario, learn.end_s),
            recovery: recovery(scenario),
            window: raw::Moments::default(),
            components: None,
            one_sample: None,
            seen: vec![Seen::default(); scenario.faults.len()],
        }
    }

    fn push(&mut self, index: u64, measured: &PlantSample, said: &Said) {
        let x = measured.channels();
        if self.learn.contains(&index) && !measured.missing {
            self.window.push(x);
            let x = x.map(|x| x as f32);
            self.components.get_or_insert_with(|| Moments::around(x)).push(x);
        } else if index == self.learn.end {
            self.one_sample = self.window.baseline();
        }
        for (truth, seen) in self.truth.iter().zip(&mut self.seen) {
            if (truth.start..truth.end).contains(&index)
                && let Some((name, size)) = said.found.and_then(|found| found.size.map(|size| (found.name, size)))
            {
                seen.push_size(name, size);
            }
            // A stray sample beyond a limit of one in a million much later is no sign of a loop that recovers.
            let recovering = (truth.end..truth.end + self.recovery).contains(&index);
            if recovering && !measured.missing && self.one_sample.as_ref().is_some_and(|limit| limit.is_beyond(x)) {
                seen.recovered = Some(index + 1);
            }
        }
    }

    fn baseline(&self) -> Result<Baseline, MissionError> {
        // All components: the monitor retains them.
        let all = ExplainedShare::new(1.0).map_err(|error| MissionError::Settings(format!("{error:?}")))?;
        let moments = self.components.as_ref().ok_or(MissionError::NeverLearned)?;
        Baseline::learn(moments, all).map_err(learning_refused)
    }

    fn score(&self, recording: &Recording, samples: u64) -> Score {
        let flown = Flown {
            faults: &self.scenario.faults,
            truth: &self.truth,
            outputs: &recording.outputs,
            seen: &self.seen,
            rate_hz: self.scenario.rate_hz(),
            recovery: self.recovery,
            samples,
        };
        flown.score()
    }
}

/// How to fly a mission.
#[derive(Clone, Debug)]
pub struct Mission {
    /// What is flown.
    pub scenario: Scenario,
    /// When an alarm is raised and withdrawn.
    pub alarming: Alarming,
    /// Seed of the sensor noise.
    pub seed: u64,
    /// How faults are introduced in the tables.
    pub faults: Faults,
    /// What was learned before; the monitor learns for itself if none.
    pub models: Option<Models>,
}

/// The flights of a mission.
#[derive(Clone, Debug)]
pub struct Flights {
    /// The scenario of the tables.
    pub tables: Flight,
    /// The same with every fault as a ramp.
    pub ramps: Flight,
    /// The same as the tables with a load that depends on speed.
    pub speed_dependent: Flight,
    /// The traces of the tables and of the ramps.
    pub traces: Vec<PathBuf>,
    /// Wall time of all of them, s.
    pub wall_s: f64,
}

impl Mission {
    /// The monitor's settings.
    #[must_use]
    pub fn settings(&self) -> Config {
        settings(&self.scenario, &self.alarming)
    }

    /// Samples the whole mission flies, for a progress bar.
    #[must_use]
    pub fn samples(&self) -> u64 {
        3 * sample_at(&self.scenario, self.scenario.duration_s)
    }

    /// Flies the mission on all cores; traces go to `out`.
    ///
    /// # Errors
    /// As [`fly`].
    pub fn fly(&self, out: &OutputDir, tick: impl Fn(u64) + Sync) -> Result<Flights, MissionError> {
        let begun = Instant::now();
        let ramps = self.scenario.with_ramps();
        let tables = if self.faults == Faults::Step { self.scenario.clone() } else { ramps.clone() };
        let speed_dependent = tables.with_speed_dependent_load();
        let mut trace = TraceWriter::create(out, "trace.csv", &ChannelNames::motor())?;
        let mut trace_ramp = TraceWriter::create(out, "trace-ramp.csv", &ChannelNames::motor())?;
        let config = self.settings();
        let flight = |scenario: &Scenario, trace| fly(scenario, &config, self.models.as_ref(), self.seed, trace, &tick);
        let (tables, (ramps, speed_dependent)) = rayon::join(
            || flight(&tables, Some(&mut trace)),
            || rayon::join(|| flight(&ramps, Some(&mut trace_ramp)), || flight(&speed_dependent, None)),
        );
        let (tables, ramps, speed_dependent) = (tables?, ramps?, speed_dependent?);
        // Not before: a flight may fail where another does not, and then no trace shall be left.
        let traces = vec![trace.finish()?, trace_ramp.finish()?];
        Ok(Flights { tables, ramps, speed_dependent, traces, wall_s: begun.elapsed().as_secs_f64() })
    }
}
