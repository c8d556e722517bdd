//! The mission in `paper` mode.

use std::path::PathBuf;
use std::time::Instant;

use monitor_core::paper::event::Event;
use monitor_core::paper::{Baseline, EventLog, Monitor, Phase, Verdict};
use monitor_core::sample::Absence;
use monitor_core::units::RadPerSec;
use serde::Serialize;

use super::{Faults, MissionError, feed, recovery, sample, settle_s, truth};
use crate::fault::Fault;
use crate::names::{self, ByModel, ChannelNames, explain_config};
use crate::output::OutputDir;
use crate::plant::PlantSample;
use crate::record::paper::{LogicalOutputs, Recording};
use crate::replay::paper::{Alarm, AlarmBuilder};
use crate::scenario::Scenario;
use crate::score::{FaultScore, Method, Score, score};
use crate::settings::PaperSettings;
use crate::trace::{TraceRow, TraceWriter};

/// Capacity of the event log between two drains: one sample makes at most nine events.
const EVENTS: usize = 16;

/// What came of one scenario.
#[derive(Clone, Debug)]
pub struct Flight {
    /// The scenario flown.
    pub scenario: Scenario,
    /// The first baseline learned.
    pub baseline: Baseline,
    /// Signals and intervals.
    pub recording: Recording,
    /// Its alarms, with the share of each channel.
    pub alarms: Vec<Alarm>,
    /// The tables.
    pub score: Score,
    /// Everything that happened.
    pub events: Vec<Event>,
}

/// Flies a scenario. `tick` is called with the number of samples flown since the last call.
///
/// # Errors
/// [`MissionError`] when the settings or the learning window are refused, or the trace cannot be written.
pub fn fly(
    scenario: &Scenario,
    settings: &PaperSettings,
    seed: u64,
    mut trace: Option<&mut TraceWriter<Verdict>>,
    tick: impl Fn(u64),
) -> Result<Flight, MissionError> {
    let rate_hz = scenario.rate_hz();
    let mut monitor = monitor_for(scenario, settings)?;
    let mut log = EventLog::<EVENTS>::default();
    let mut events = Vec::new();
    let mut recording = Recording::new(rate_hz);
    let mut baseline = None;
    let mut alarms = AlarmBuilder::new(rate_hz, monitor.thresholds());
    let samples = feed(scenario, seed, tick, |index, measured| {
        let verdict = *give(&mut monitor, measured);
        log.observe(&verdict);
        events.extend(std::iter::from_fn(|| log.pop()));
        if verdict.phase() == Phase::ModelDue {
            monitor
                .finish_learning()
                .map_err(|error| MissionError::Learning(ChannelNames::motor().explain_learning(error)))?;
            baseline = baseline.or(monitor.baseline().copied());
        }
        let x = measured.channels();
        recording.push(index, measured.set_point, x, &verdict);
        alarms.push(index, &verdict, || monitor.contributions(x.map(|x| x as f32)));
        if let Some(trace) = &mut trace {
            let set_point = Some(measured.set_point);
            trace.write(TraceRow { row: index, t_s: measured.t_s, set_point, x, said: &verdict })?;
        }
        Ok(())
    })?;
    let score = score_scenario(scenario, &recording.outputs, samples);
    Ok(Flight {
        scenario: scenario.clone(),
        baseline: baseline.ok_or(MissionError::NeverLearned)?,
        recording,
        alarms: alarms.finish(),
        score,
        events,
    })
}

/// Gives a monitor what the plant measured, or a slot without a sample.
pub(crate) fn give<'a>(monitor: &'a mut Monitor, measured: &PlantSample) -> &'a Verdict {
    if measured.missing {
        return monitor.skip(Absence::Missing);
    }
    monitor.step(RadPerSec(measured.set_point as f32), sample(measured))
}

/// Scores what a monitor said over `samples` samples of a scenario.
#[must_use]
pub fn score_scenario(scenario: &Scenario, outputs: &LogicalOutputs, samples: u64) -> Score {
    score(&truth(scenario), &outputs.observed(), scenario.rate_hz(), recovery(scenario), samples)
}

/// The monitor a scenario is flown with: settles until the learning window begins, learns over it, then judges.
///
/// # Errors
/// [`MissionError::Settings`] names the setting that is out of range.
pub fn monitor_for(scenario: &Scenario, settings: &PaperSettings) -> Result<Monitor, MissionError> {
    let learn_s = scenario.learn.end_s - scenario.learn.start_s;
    // A tolerance of zero: the simulated set point is exact.
    let config = settings.config(scenario.rate_hz(), settle_s(scenario), learn_s, 0.0);
    Monitor::new(&config).map_err(|error| MissionError::Settings(explain_config(error)))
}

/// How to fly a mission.
#[derive(Clone, Debug)]
pub struct Mission {
    /// What is flown.
    pub scenario: Scenario,
    /// The monitor's settings.
    pub settings: PaperSettings,
    /// Seed of the sensor noise.
    pub seed: u64,
    /// How faults are introduced in the tables.
    pub faults: Faults,
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
    /// Samples the whole mission flies, for a progress bar.
    #[must_use]
    pub fn samples(&self) -> u64 {
        3 * (self.scenario.duration_s * self.scenario.rate_hz()).round() as u64
    }

    /// Flies the mission on all cores; traces go to `out`.
    ///
    /// # Errors
    /// As [`fly`].
    pub fn fly(&self, out: &OutputDir, tick: impl Fn(u64) + Sync) -> Result<Flights, MissionError> {
        let begun = Instant::now();
        let tables = match self.faults {
            Faults::Step => self.scenario.clone(),
            Faults::Ramp => self.scenario.with_ramps(),
        };
        let ramps = self.scenario.with_ramps();
        let speed_dependent = tables.with_speed_dependent_load();
        let mut trace = TraceWriter::create(out, "trace.csv", &ChannelNames::motor())?;
        let mut trace_ramp = TraceWriter::create(out, "trace-ramp.csv", &ChannelNames::motor())?;
        let flight = |scenario: &Scenario, trace| fly(scenario, &self.settings, self.seed, trace, &tick);
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

/// The value a ramp had reached when it was detected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RampRow {
    /// Identifier of the fault.
    pub id: String,
    /// Value when the first pair relay went up (Table 2's method), none if it was not detected.
    pub value_at_detection: Option<f64>,
    /// Value when the full model's relay went up (Table 1's method).
    pub value_at_detection_pca: Option<f64>,
    /// Value at the end of the ramp.
    pub amplitude: f64,
    /// Unit of the values.
    pub unit: &'static str,
}

/// The result of a mission, as machines read it.
#[derive(Clone, Debug, Serialize)]
pub struct MissionReport {
    /// Which monitor flew.
    pub mode: &'static str,
    /// Name of the scenario.
    pub scenario: String,
    /// How faults were introduced in the tables.
    pub fault_profile: Faults,
    /// Seed of the sensor noise.
    pub seed: u64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Share of the variance each component explains, by model (figures 5 and 8).
    pub explained: ByModel<Vec<f64>>,
    /// Components retained, by model.
    pub retained: ByModel<usize>,
    /// Threshold of each residual, in units of the mean T2 in control.
    pub limits: ByModel<f64>,
    /// Tables 1 and 2.
    pub faults: Vec<FaultScore>,
    /// The ramp table.
    pub ramp: Vec<RampRow>,
    /// Table 2 again with a load that depends on speed: where the paper's truth table fails.
    pub speed_dependent_load: Vec<FaultScore>,
    /// Alarms outside of faults and recovery, over the flights of the tables and of the ramps.
    pub false_alarms: usize,
    /// Samples given to the monitor over all flights.
    pub samples: u64,
    /// Size of the monitor, bytes.
    pub monitor_bytes: usize,
    /// Wall time of the flights, s.
    pub wall_s: f64,
    /// What a person should know about the result.
    pub notes: Vec<String>,
    /// Where the page and the traces are.
    pub files: Vec<PathBuf>,
}

impl Flights {
    /// The result as machines read it.
    #[must_use]
    pub fn report(&self, mission: &Mission) -> MissionReport {
        let baseline = &self.tables.baseline;
        let table_2 = |score: &Score| score.faults.iter().filter(|f| f.method == Method::Ppca).cloned().collect();
        MissionReport {
            mode: "paper",
            scenario: mission.scenario.name.clone(),
            fault_profile: mission.faults,
            seed: mission.seed,
            rate_hz: mission.scenario.rate_hz(),
            explained: names::explained(baseline),
            retained: names::retained(baseline),
            limits: mission.settings.thresholds,
            faults: self.tables.score.faults.clone(),
            ramp: self.ramp_rows(),
            speed_dependent_load: table_2(&self.speed_dependent.score),
            false_alarms: self.tables.score.false_alarms + self.ramps.score.false_alarms,
            samples: [&self.tables, &self.ramps, &self.speed_dependent]
                .iter()
                .map(|f| f.recording.signals.samples)
                .sum(),
            monitor_bytes: size_of::<Monitor>(),
            wall_s: self.wall_s,
            notes: mission.settings.doubt(mission.scenario.rate_hz()).into_iter().collect(),
            files: self.traces.clone(),
        }
    }

    fn ramp_rows(&self) -> Vec<RampRow> {
        let detected = |method, id: &str| {
            self.ramps.score.faults.iter().find(|f| f.method == method && f.id == id).and_then(|f| f.detected_s)
        };
        let row = |fault: &Fault| RampRow {
            id: fault.id.clone(),
            value_at_detection: detected(Method::Ppca, &fault.id).map(|t| fault.value(t)),
            value_at_detection_pca: detected(Method::Pca, &fault.id).map(|t| fault.value(t)),
            amplitude: fault.amplitude,
            unit: fault.unit(),
        };
        self.ramps.scenario.faults.iter().map(row).collect()
    }
}
