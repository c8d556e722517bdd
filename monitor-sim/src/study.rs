//! Studies: many missions over random seeds, faults and motors, on all cores, with the code that flies.
//!
//! A study is cut into units of work that know nothing of each other; each has a seed of its own, and what they find is
//! gathered in their order. So the result is the same for any number of threads, and a unit that is already in the
//! [`ledger`] need not be flown again. What depends on the clock is kept apart from the result.

pub mod watch;
mod guard_watch;
mod paper_watch;
pub mod calibrate;
pub mod flight;
pub mod raw;
pub mod poisson;
pub mod ledger;
pub mod summary;
pub mod faults;
pub mod white;
pub mod false_alarms;
pub mod delay;
pub mod ramp;
pub mod localization;
mod jitter;
pub mod robustness;
pub mod speed;
pub mod page;

use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::output::OutputError;
use crate::page::Block;
use crate::scenario::ScenarioError;
use crate::tables::TextTable;
use ledger::Ledger;

/// Why a study could not be made.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The monitor refused its settings.
    #[error("the monitor refuses its settings: {0}")]
    Settings(String),
    /// The built-in settings do not parse.
    #[error("the settings of the default motor cannot be read: {0}")]
    DefaultSettings(#[from] toml::de::Error),
    /// A mission of the study cannot be flown.
    #[error("a mission of the study cannot be flown: {0}")]
    Scenario(#[from] ScenarioError),
    /// A run ended before anything was judged.
    #[error(
        "nothing was judged in a fault-free run{}; lengthen it with --calibration-judged",
        .0.as_ref().map(|why| format!(" ({why})")).unwrap_or_default()
    )]
    NothingLearned(Option<String>),
    /// The file of finished units is of something else.
    #[error("{0}")]
    Ledger(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The threads asked for cannot be had.
    #[error("cannot start the threads: {0}; ask for fewer with --threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A result has no form in JSON.
    #[error("a result cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// What a study found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// The result in a sentence; empty where it takes a table.
    pub summary: String,
    /// What the page pictures.
    pub figures: Vec<Block>,
    /// One object a row; keys say the unit.
    pub rows: Vec<Value>,
    /// The same for people.
    pub tables: Vec<TextTable>,
    /// Control periods that were flown.
    pub steps: u64,
}

/// A study: its fields are its settings.
pub trait Study: Serialize + Sync {
    /// What all units need beforehand, such as limits for the one motor they fly.
    type Shared: Sync;
    /// What one unit found.
    type Unit: Serialize + DeserializeOwned + Send + Sync;
    /// Its name on the command line.
    const NAME: &'static str;

    /// How many units there are.
    fn units(&self) -> u64;

    /// Makes what all units need.
    ///
    /// # Errors
    /// [`StudyError`] when a monitor refuses its settings.
    fn prepare(&self) -> Result<Self::Shared, StudyError>;

    /// Does one unit, of those below [`units`](Self::units).
    ///
    /// # Errors
    /// [`StudyError`] when a monitor refuses its settings or a mission cannot be flown.
    fn unit(&self, shared: &Self::Shared, unit: u64) -> Result<Self::Unit, StudyError>;

    /// What all units found together, in their order.
    fn findings(&self, shared: &Self::Shared, units: &[Self::Unit]) -> Findings;
}

/// How a study is run; none of it changes the result.
#[derive(Clone, Copy, Debug, Default)]
pub struct Run<'a> {
    /// Threads; all cores if none.
    pub threads: Option<usize>,
    /// Where finished units are kept, to go on after an interruption.
    pub resume: Option<&'a Path>,
}

/// The result of a study, as machines read it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Its name on the command line.
    pub study: &'static str,
    /// Everything the result depends on.
    pub settings: Value,
    /// Version of the program.
    pub version: &'static str,
    /// Units of work.
    pub units: u64,
    /// Control periods that were flown.
    pub steps: u64,
    /// The rows.
    pub rows: Vec<Value>,
    /// The rows for people.
    #[serde(skip)]
    pub tables: Vec<TextTable>,
    /// The result in a sentence.
    #[serde(skip)]
    pub summary: String,
    /// What the page pictures.
    #[serde(skip)]
    pub figures: Vec<Block>,
    /// Units that were read from the file of finished ones.
    #[serde(skip)]
    pub resumed: u64,
    /// Wall time, s. Not in JSON: the result does not depend on it.
    #[serde(skip)]
    pub wall_s: f64,
    /// Threads it ran on.
    #[serde(skip)]
    pub threads: usize,
}

/// Runs a study. `tick` is called with the number of units that have been finished since the last call.
///
/// # Errors
/// [`StudyError`] of the first unit that fails, or of the file of finished units.
pub fn run<S: Study>(study: &S, run: Run<'_>, tick: impl Fn(u64) + Sync) -> Result<Report, StudyError> {
    let begun = Instant::now();
    let settings = serde_json::to_value(study)?;
    let ledger = run.resume.map(|path| Ledger::open(path, S::NAME, &settings)).transpose()?;
    let resumed = ledger.as_ref().map_or(0, |ledger| ledger.finished());
    tick(resumed);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(run.threads.unwrap_or(0)).build()?;
    let findings = pool.install(|| {
        let shared = study.prepare()?;
        let units = (0..study.units()).into_par_iter().map(|n| one(study, &shared, ledger.as_ref(), n, &tick));
        let units: Vec<S::Unit> = units.collect::<Result<_, _>>()?;
        Ok::<_, StudyError>(study.findings(&shared, &units))
    })?;
    Ok(Report {
        study: S::NAME,
        settings,
        version: env!("CARGO_PKG_VERSION"),
        units: study.units(),
        steps: findings.steps,
        rows: findings.rows,
        tables: findings.tables,
        summary: findings.summary,
        figures: findings.figures,
        resumed,
        wall_s: begun.elapsed().as_secs_f64(),
        threads: pool.current_num_threads(),
    })
}

/// One unit: from the ledger, or flown and entered there.
fn one<S: Study>(
    study: &S,
    shared: &S::Shared,
    ledger: Option<&Ledger>,
    n: u64,
    tick: &impl Fn(u64),
) -> Result<S::Unit, StudyError> {
    if let Some(found) = ledger.and_then(|ledger| ledger.get(n)) {
        return Ok(serde_json::from_value(found.clone())?);
    }
    let found = study.unit(shared, n)?;
    if let Some(ledger) = ledger {
        ledger.enter(n, &found)?;
    }
    tick(1);
    Ok(found)
}

/// A seed for the `n`-th draw of a `purpose`, from the study's: one round of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014)
/// for each number, so that neighbours have nothing in common.
#[must_use]
pub fn seed_of(study: u64, purpose: u64, n: u64) -> u64 {
    let mix = |x: u64| {
        let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    mix(mix(mix(study) ^ purpose) ^ n)
}

/// What seeds are drawn for. Part of the recorded behaviour.
pub(crate) mod purpose {
    pub(crate) const MOTOR: u64 = 1;
    pub(crate) const CALIBRATION: u64 = 2;
    pub(crate) const FLIGHT: u64 = 3;
    pub(crate) const DRAW: u64 = 4;
}
