//! `study speed`: control periods per second, what share of the time plant and monitor take, and how the monitor's kernels grow
//! with the channels.
//!
//! Measured by the clock, so it is no [`Study`](super::Study): another run gives other figures.

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

mod kernels;
mod page;

use super::calibrate::Asked;
use super::false_alarms::limits_of;
use super::faults::figure_1_motor;
use super::flight::fly;
use super::watch::{Known, Limits, Mode};
use super::{StudyError, purpose, seed_of};
use crate::plant::{Plant, PlantSample};
use crate::random_motor::random_motor;
use crate::scenario::Scenario;
use crate::tables::{TextTable, significant};

pub use kernels::KernelRow;
pub use page::page;

/// Repetitions of each measurement, of which the fastest counts: what else runs on the machine only makes it slower.
const REPETITIONS: usize = 5;

/// What to measure.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// Which monitor.
    pub mode: Mode,
    /// Seed of the random motor and the noise.
    pub seed: u64,
    /// What the limits are for.
    pub asked: Asked,
    /// Control periods of each measurement and thread.
    pub steps: u64,
}

/// One measurement.
#[derive(Clone, Debug, Serialize)]
pub struct SpeedRow {
    /// Which motor.
    pub motor: &'static str,
    /// What ran.
    pub what: &'static str,
    /// Seed of the random motor and the noise.
    pub seed: u64,
    /// Measurements, of which this is the fastest.
    pub repetitions: usize,
    /// Threads it ran on, each with a motor of its own.
    pub threads: usize,
    /// Control periods, all threads.
    pub steps: u64,
    /// Fastest wall time, s.
    pub wall_s: f64,
    /// Control periods per second and thread.
    pub steps_per_s_and_thread: f64,
    /// Share of the time that the monitor takes: what is left when the plant alone is subtracted. With a monitor only.
    pub monitor_share: Option<f64>,
}

/// The measurements.
#[derive(Clone, Debug, Serialize)]
pub struct SpeedReport {
    /// `speed`.
    pub study: &'static str,
    /// What was asked for.
    pub settings: Speed,
    /// The measurements.
    pub rows: Vec<SpeedRow>,
    /// Those of the monitor's kernels.
    pub kernels: Vec<KernelRow>,
}

impl Speed {
    /// Measures.
    ///
    /// # Errors
    /// [`StudyError`] when the monitor refuses its settings or threads cannot be had.
    pub fn run(&self, tick: impl Fn()) -> Result<SpeedReport, StudyError> {
        let mut rows = Vec::new();
        let random = random_motor(seed_of(self.seed, purpose::MOTOR, 0));
        for (name, motor) in [("figure 1", figure_1_motor(0.0)), ("random", random)] {
            let duration_s = motor.learn.end_s + self.steps as f64 / motor.rate_hz();
            let scenario = Scenario { duration_s, ..motor };
            scenario.validate()?;
            let limits = limits_of(self.mode, &self.asked, &scenario, self.seed)?;
            let alone = |plant: fn(&Scenario, u64) -> Plant| plant(&scenario, self.seed).map(consumed).sum::<u64>();
            let row = |what, threads, work: &dyn Fn() -> Result<u64, StudyError>| self.row(name, what, threads, work);
            rows.push(row("plant, Runge-Kutta", 1, &|| Ok(alone(Plant::new)))?);
            tick();
            let plant = row("plant, exponential", 1, &|| Ok(alone(Plant::exponential)))?;
            tick();
            for threads in thread_counts() {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
                let watched = || self.watched(&scenario, &limits, threads);
                let mut watched = row("plant, exponential, and monitor", threads, &|| pool.install(watched))?;
                let share = 1.0 - watched.steps_per_s_and_thread / plant.steps_per_s_and_thread;
                watched.monitor_share = (threads == 1).then_some(share);
                rows.push(watched);
                tick();
            }
            rows.insert(rows.len() - thread_counts().len(), plant);
        }
        let kernels = kernels::measure(self.seed);
        tick();
        Ok(SpeedReport { study: "speed", settings: self.clone(), rows, kernels })
    }

    /// Measurements that [`run`](Self::run) makes.
    #[must_use]
    pub fn measurements(&self) -> u64 {
        2 * (2 + thread_counts().len() as u64) + 1
    }

    fn row(
        &self,
        motor: &'static str,
        what: &'static str,
        threads: usize,
        work: impl Fn() -> Result<u64, StudyError>,
    ) -> Result<SpeedRow, StudyError> {
        let (steps, wall_s) = fastest(work);
        let (steps, seed, repetitions) = (steps?, self.seed, REPETITIONS);
        let steps_per_s_and_thread = steps as f64 / wall_s / threads as f64;
        let monitor_share = None;
        Ok(SpeedRow { motor, what, seed, repetitions, threads, steps, wall_s, steps_per_s_and_thread, monitor_share })
    }

    /// One flight on each thread.
    fn watched(&self, scenario: &Scenario, limits: &Limits, threads: usize) -> Result<u64, StudyError> {
        let flight = |n| {
            let mut watch = self.mode.watch(&Known::of(scenario), limits)?;
            let plant = Plant::exponential(scenario, self.seed.wrapping_add(n));
            Ok::<u64, StudyError>(fly(plant, watch.as_mut(), |_, _, said| {
                black_box(said);
            }))
        };
        (0..threads as u64).into_par_iter().map(flight).sum()
    }
}

/// One thread, then twice as many up to all cores.
fn thread_counts() -> Vec<usize> {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let doubled = std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < cores);
    doubled.chain([cores]).collect()
}

fn consumed(sample: PlantSample) -> u64 {
    black_box(sample);
    1
}

/// What the work returned, and the fastest time it took, s.
fn fastest<T>(work: impl Fn() -> T) -> (T, f64) {
    let timed = || {
        let begun = Instant::now();
        let done = work();
        (done, begun.elapsed().as_secs_f64())
    };
    (1..REPETITIONS).fold(timed(), |best, _| {
        let next = timed();
        if next.1 < best.1 { next } else { best }
    })
}

impl SpeedReport {
    /// The measurements for people.
    #[must_use]
    pub fn tables(&self) -> [TextTable; 2] {
        [self.periods(), kernels::table(&self.kernels)]
    }

    fn periods(&self) -> TextTable {
        let header = ["motor", "what", "threads", "million periods per s and thread", "ns each", "monitor, %"];
        let mut table = TextTable::new("Control periods per second: the fastest of five, on this machine now", header);
        for row in &self.rows {
            table.rows.push(vec![
                row.motor.to_owned(),
                row.what.to_owned(),
                row.threads.to_string(),
                significant(row.steps_per_s_and_thread / 1e6),
                format!("{:.0}", 1e9 / row.steps_per_s_and_thread),
                row.monitor_share.map_or_else(|| "-".to_owned(), |share| format!("{:.0}", 100.0 * share)),
            ]);
        }
        table
    }
}
