//! The paper's empirical way to a threshold (III.B): fly borderline cases, with and without faults, and set it between.
//!
//! 1. Fault-free missions with many noise seeds show how far each residual goes by itself. The threshold is that,
//!    times a margin fixed beforehand.
//! 2. Missions with faults of borderline size show what each residual holds when it has to be up; a threshold that
//!    does not lie below is reported.
//! 3. Fresh seeds, none of those that set the thresholds, show the trade-off: false alarms per hour and delay for a
//!    sweep of margins.

pub mod page;

use std::ops::Range;
use std::time::Instant;

use monitor_core::paper::{Monitor, Phase, Verdict};
use monitor_core::sample::ModelId;
use rayon::prelude::*;
use serde::Serialize;

use crate::fault::{Fault, FaultPoint};
use crate::mission::MissionError;
use crate::mission::paper::{give, monitor_for, score_scenario};
use crate::names::{ByModel, ChannelNames};
use crate::plant::Plant;
use crate::record::paper::LogicalOutputs;
use crate::scenario::Scenario;
use crate::score::{Method, Score};
use crate::settings::{FoundBy, PaperSettings};

/// Margins of the sweep, from where noise alone raises alarms to where small faults are missed.
const SWEEP: [f64; 8] = [0.9, 0.95, 1.0, 1.1, 1.25, 1.5, 2.0, 4.0];

/// How to tune.
#[derive(Clone, Debug)]
pub struct Tune {
    /// The mission that is flown.
    pub scenario: Scenario,
    /// Everything but the thresholds is taken from here.
    pub settings: PaperSettings,
    /// Runs of each kind.
    pub runs: u64,
    /// Seed of the first run.
    pub first_seed: u64,
    /// Threshold over the largest fault-free residual.
    pub margin: f64,
    /// Size of the borderline faults, as a share of the scenario's.
    pub borderline_size: f64,
}

/// One line of the trade-off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepRow {
    /// Threshold over the largest fault-free residual.
    pub margin: f64,
    /// Seed of the first run, which is behind those that set the thresholds.
    pub first_seed: u64,
    /// Fault-free runs.
    pub runs: usize,
    /// Hours of them that were monitored.
    pub hours: f64,
    /// Alarms in fault-free missions.
    pub false_alarms: usize,
    /// Alarms per hour monitored.
    pub false_alarms_per_hour: f64,
    /// By fault of the scenario, at borderline size.
    pub faults: Vec<SweepFault>,
}

/// How one fault fared at one margin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepFault {
    /// Identifier.
    pub id: String,
    /// Runs in which a pair relay went up.
    pub detected: usize,
    /// Runs flown.
    pub runs: usize,
    /// Longest delay until a pair relay was up, s; none if any run missed the fault.
    pub worst_delay_s: Option<f64>,
    /// Mean share of the interval over which the right name stood.
    pub right_name_share: f64,
}

/// The result of tuning.
#[derive(Clone, Debug, Serialize)]
pub struct TuneReport {
    /// The settings with the thresholds that were found.
    pub settings: PaperSettings,
    /// What thresholds and residuals are counted in.
    pub residual_unit: &'static str,
    /// The trade-off, on seeds that were not used to set the thresholds.
    pub sweep: Vec<SweepRow>,
    /// Hours of fault-free mission behind each line of it.
    pub hours: f64,
    /// Models whose borderline residuals do not all lie above the threshold.
    pub not_separated: Vec<String>,
    /// Wall time, s.
    pub wall_s: f64,
}

impl SweepRow {
    /// Whether it is of this margin.
    #[must_use]
    pub fn is_at(&self, margin: f64) -> bool {
        (self.margin - margin).abs() < 1e-9
    }
}

impl Tune {
    /// Samples that will be flown, for a progress bar.
    #[must_use]
    pub fn samples(&self) -> u64 {
        4 * self.runs * (self.scenario.duration_s * self.scenario.rate_hz()).round() as u64
    }

    /// Tunes on all cores. `tick` is called with the number of samples flown.
    ///
    /// # Errors
    /// [`MissionError`] when the settings or a learning window are refused.
    pub fn run(&self, tick: impl Fn(u64) + Sync) -> Result<TuneReport, MissionError> {
        let begun = Instant::now();
        let healthy = self.scenario.without_faults();
        let borderline = self.scenario.scaled_faults(self.borderline_size);
        // Behind the last seed comes the first.
        let seeds = |runs: Range<u64>| runs.into_par_iter().map(|run| self.first_seed.wrapping_add(run));
        let setting = 0..self.runs;
        let checking = self.runs..2 * self.runs;

        let unlimited =
            PaperSettings { thresholds: ByModel::from_fn(|_| f64::from(f32::MAX)), ..self.settings.clone() };
        let largest = seeds(setting.clone())
            .map(|seed| self.extremes(&healthy, &unlimited, seed, &tick).map(|e| e.largest))
            .try_reduce(|| ByModel::from_fn(|_| 0.0), |a, b| Ok(pairwise(&a, &b, f64::max)))?;
        if ModelId::ALL.iter().any(|model| *largest.get(*model) <= 0.0) {
            return Err(MissionError::NothingJudged);
        }
        let smallest = seeds(setting)
            .map(|seed| self.extremes(&borderline, &unlimited, seed, &tick).map(|e| e.smallest_under_fault))
            .try_reduce(|| ByModel::from_fn(|_| f64::INFINITY), |a, b| Ok(pairwise(&a, &b, f64::min)))?;

        let at_margin = |margin: f64| PaperSettings {
            thresholds: ByModel::from_fn(|model| rounded_up(margin * largest.get(model))),
            found_by: Some(FoundBy {
                scenario: self.scenario.name.clone(),
                rate_hz: self.scenario.rate_hz(),
                runs: self.runs,
                first_seed: self.first_seed,
                margin,
                largest_fault_free: rounded(&largest),
                borderline_size: self.borderline_size,
                smallest_borderline: rounded(&smallest),
            }),
            ..self.settings.clone()
        };
        let settings = at_margin(self.margin);
        let candidates = SWEEP.map(at_margin);
        let fly = |scenario: &Scenario, seed| self.scores(scenario, &candidates, seed, &tick);
        let healthy_scores = seeds(checking.clone()).map(|seed| fly(&healthy, seed)).collect::<Result<Vec<_>, _>>()?;
        let borderline_scores = seeds(checking).map(|seed| fly(&borderline, seed)).collect::<Result<Vec<_>, _>>()?;
        let hours = self.runs as f64 * (healthy.duration_s - healthy.learn.end_s) / 3600.0;
        let sweep = SWEEP.iter().enumerate().map(|(k, margin)| {
            let of_margin = |scores: &[Vec<Score>]| scores.iter().filter_map(|s| s.get(k).cloned()).collect::<Vec<_>>();
            self.sweep_row(*margin, &of_margin(&healthy_scores), &of_margin(&borderline_scores), hours)
        });
        let names = ChannelNames::motor();
        let not_separated = ModelId::ALL.iter().filter(|m| smallest.get(**m) <= settings.thresholds.get(**m));
        Ok(TuneReport {
            residual_unit: "mean T2 in control",
            sweep: sweep.collect(),
            hours,
            not_separated: not_separated.map(|m| names.model(*m)).collect(),
            settings,
            wall_s: begun.elapsed().as_secs_f64(),
        })
    }

    /// How far the residuals of one mission go.
    fn extremes(
        &self,
        scenario: &Scenario,
        settings: &PaperSettings,
        seed: u64,
        tick: &(impl Fn(u64) + Sync),
    ) -> Result<Extremes, MissionError> {
        let mut monitors = [monitor_for(scenario, settings)?];
        let mut extremes =
            Extremes { largest: ByModel::from_fn(|_| 0.0), smallest_under_fault: ByModel::from_fn(|_| f64::INFINITY) };
        // Behind the onset every pair moves until the loop has settled.
        let settle_s = scenario.learn.start_s;
        fly(scenario, seed, &mut monitors, tick, |_, t_s, _, verdict| {
            let Some(residuals) = verdict.residuals() else { return };
            for model in ModelId::ALL {
                let residual = f64::from(*residuals.get(model));
                let largest = extremes.largest.get_mut(model);
                *largest = largest.max(residual);
                let held = |f: &Fault| t_s >= f.start_s + settle_s && t_s < f.end_s && must_rise(f.point, model);
                if scenario.faults.iter().any(held) {
                    let smallest = extremes.smallest_under_fault.get_mut(model);
                    *smallest = smallest.min(residual);
                }
            }
        })?;
        Ok(extremes)
    }

    /// One mission scored at each candidate's thresholds.
    fn scores(
        &self,
        scenario: &Scenario,
        candidates: &[PaperSettings],
        seed: u64,
        tick: &(impl Fn(u64) + Sync),
    ) -> Result<Vec<Score>, MissionError> {
        let mut monitors = candidates.iter().map(|s| monitor_for(scenario, s)).collect::<Result<Vec<_>, _>>()?;
        let mut outputs = vec![LogicalOutputs::default(); candidates.len()];
        let samples = fly(scenario, seed, &mut monitors, tick, |k, _, index, verdict| {
            if let Some(outputs) = outputs.get_mut(k) {
                outputs.push(index, verdict);
            }
        })?;
        Ok(outputs.iter().map(|o| score_scenario(scenario, o, samples)).collect())
    }

    fn sweep_row(&self, margin: f64, healthy: &[Score], borderline: &[Score], hours: f64) -> SweepRow {
        let false_alarms = healthy.iter().map(|s| s.false_alarms).sum();
        let table_2 =
            |score: &Score| score.faults.iter().filter(|f| f.method == Method::Ppca).cloned().collect::<Vec<_>>();
        let ids: Vec<String> =
            borderline.first().map(|s| table_2(s).into_iter().map(|f| f.id).collect()).unwrap_or_default();
        let fault = |id: String| {
            let rows: Vec<_> = borderline.iter().flat_map(table_2).filter(|f| f.id == id).collect();
            let delays: Vec<f64> = rows.iter().filter_map(|f| f.detected_s.map(|t| t - f.start_s)).collect();
            SweepFault {
                detected: delays.len(),
                runs: rows.len(),
                worst_delay_s: (delays.len() == rows.len()).then(|| delays.iter().copied().fold(0.0, f64::max)),
                right_name_share: rows.iter().filter_map(|f| f.located_share).sum::<f64>() / rows.len().max(1) as f64,
                id,
            }
        };
        SweepRow {
            margin,
            first_seed: self.first_seed.wrapping_add(self.runs),
            runs: healthy.len(),
            hours,
            false_alarms,
            false_alarms_per_hour: false_alarms as f64 / hours,
            faults: ids.into_iter().map(fault).collect(),
        }
    }
}

/// How far the residuals of missions went.
struct Extremes {
    largest: ByModel<f64>,
    /// Of the residuals that (1.8) wants up, while the fault stood and the loop had settled.
    smallest_under_fault: ByModel<f64>,
}

/// Whether the truth table (1.8) wants a model's relay up under a fault.
const fn must_rise(point: FaultPoint, model: ModelId) -> bool {
    use monitor_core::sample::Pair::{CurrentVoltage, SpeedCurrent, SpeedVoltage};
    match (point, model) {
        (FaultPoint::LoadTorque, _) => true,
        (FaultPoint::SpeedSensor | FaultPoint::CurrentSensor, ModelId::Full | ModelId::Pair(CurrentVoltage)) => true,
        (FaultPoint::SpeedSensor, ModelId::Pair(pair)) => matches!(pair, SpeedVoltage),
        (FaultPoint::CurrentSensor, ModelId::Pair(pair)) => matches!(pair, SpeedCurrent),
        // It has no line for any other fault.
        _ => false,
    }
}

/// Flies one plant through several monitors; returns the number of samples.
fn fly(
    scenario: &Scenario,
    seed: u64,
    monitors: &mut [Monitor],
    tick: &(impl Fn(u64) + Sync),
    mut seen: impl FnMut(usize, f64, u64, &Verdict),
) -> Result<u64, MissionError> {
    let mut samples = 0;
    for measured in Plant::new(scenario, seed) {
        for (k, monitor) in monitors.iter_mut().enumerate() {
            let verdict = *give(monitor, &measured);
            if verdict.phase() == Phase::ModelDue {
                let refused = |error| MissionError::Learning(ChannelNames::motor().explain_learning(error));
                monitor.finish_learning().map_err(refused)?;
            }
            seen(k, measured.t_s, samples, &verdict);
        }
        samples += 1;
    }
    tick(samples);
    Ok(samples)
}

fn pairwise(a: &ByModel<f64>, b: &ByModel<f64>, f: fn(f64, f64) -> f64) -> ByModel<f64> {
    ByModel::from_fn(|model| f(*a.get(model), *b.get(model)))
}

/// Four decimals are what a person can use of a residual.
fn rounded(residuals: &ByModel<f64>) -> ByModel<f64> {
    ByModel::from_fn(|model| (residuals.get(model) * 1e4).round() / 1e4)
}

/// Three decimals are enough for a threshold, and upwards is the side of fewer false alarms.
fn rounded_up(threshold: f64) -> f64 {
    (threshold * 1000.0).ceil() / 1000.0
}
