//! The main job: fly a scenario through a monitor, sample by sample, and score what it said.
//!
//! What both modes share is here; each has its own monitor, tables and report in a module of its own.

use monitor_core::sample::Sample;
use monitor_core::units::{Amperes, RadPerSec, Volts};
use serde::Serialize;

use crate::fault::Fault;
use crate::models::ModelsError;
use crate::output::OutputError;
use crate::plant::{Plant, PlantSample};
use crate::scenario::Scenario;
use crate::score::Truth;

pub mod guard;
pub mod paper;

/// How many samples are flown between two reports of progress.
const TICK: u64 = 10_000;

/// Why a mission could not be flown.
#[derive(Debug, thiserror::Error)]
pub enum MissionError {
    /// The monitor refused its settings.
    #[error("the monitor refuses its settings: {0}")]
    Settings(String),
    /// The learning window was refused.
    #[error("learning failed: {0}")]
    Learning(String),
    /// Stored models do not fit.
    #[error(transparent)]
    Models(#[from] ModelsError),
    /// The monitor had not learned by the end of the scenario.
    #[error("the scenario ends before the monitor has learned: lengthen duration_s or bring learn.end_s forward")]
    NeverLearned,
    /// There is no residual to set a threshold by.
    #[error(
        "the scenario ends with its learning window, so nothing was judged: lengthen duration_s or bring learn.end_s forward"
    )]
    NothingJudged,
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// How faults are introduced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Faults {
    /// At once (figures 6 to 11).
    Step,
    /// Growing over the fault's interval (the second figure 11).
    Ramp,
}

/// A measurement as the core takes it.
#[must_use]
pub fn sample(measured: &PlantSample) -> Sample {
    Sample {
        speed: RadPerSec(measured.speed as f32),
        armature_current: Amperes(measured.armature_current as f32),
        armature_voltage: Volts(measured.armature_voltage as f32),
    }
}

/// Feeds a scenario's samples to `seen`, each with its index, and returns how many there were. `tick` is called with the number
/// of samples flown since the last call.
///
/// # Errors
/// The first that `seen` has.
fn feed(
    scenario: &Scenario,
    seed: u64,
    tick: impl Fn(u64),
    mut seen: impl FnMut(u64, &PlantSample) -> Result<(), MissionError>,
) -> Result<u64, MissionError> {
    let mut index = 0;
    for measured in Plant::new(scenario, seed) {
        seen(index, &measured)?;
        index += 1;
        if index % TICK == 0 {
            tick(TICK);
        }
    }
    tick(index % TICK);
    Ok(index)
}

/// What is injected, in samples.
fn truth(scenario: &Scenario) -> Vec<Truth> {
    let truth = |fault: &Fault| Truth {
        id: fault.id.clone(),
        start: sample_at(scenario, fault.start_s),
        end: sample_at(scenario, fault.end_s),
    };
    scenario.faults.iter().map(truth).collect()
}

/// The sample that is taken at an instant.
fn sample_at(scenario: &Scenario, t_s: f64) -> u64 {
    (t_s * scenario.rate_hz()).round() as u64
}

/// Samples for which the loop may recover from a fault: as long as it is given to settle before anything is learned.
fn recovery(scenario: &Scenario) -> u64 {
    sample_at(scenario, settle_s(scenario))
}

/// The learning window begins when the loop has settled, so its beginning is the settling time.
fn settle_s(scenario: &Scenario) -> f64 {
    scenario.learn.start_s
}
