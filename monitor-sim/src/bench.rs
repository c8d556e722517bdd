//! Benchmarks on recorded data: what to learn, what to judge and how to score it is a description
//! ([`protocol`]); every file below a directory is a run; runs are judged side by side on all cores.
//!
//! The recordings stay where they are, outside of this project. Settings are those that a replay would choose, and none is
//! chosen by looking at labels.

mod condition;
mod files;
pub mod protocol;
pub mod recorded;
pub mod judge;
pub mod confusion;
pub mod nab;
pub mod labelled;
pub mod drifts;
pub mod report;
mod tables;
pub mod page;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub use condition::Condition;
use judge::Judge;
pub use judge::Sample;
use protocol::{Protocol, Task};
use recorded::Recorded;
pub use report::BenchReport;

use crate::study::watch::Mode;

/// Why a benchmark could not be run.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// Neither the name of a benchmark nor a description.
    #[error(
        "there is no benchmark `{0}`; there are skab and cnc-spindle, and any .toml file that describes one (`bench --example` prints one)"
    )]
    UnknownBenchmark(String),
    /// A description makes no sense.
    #[error("the benchmark description `{name}` cannot be used: {why}")]
    Protocol {
        /// Which.
        name: String,
        /// What is wrong, and what helps.
        why: String,
    },
    /// There is no such directory.
    #[error("there is no directory `{}` with recordings{}", path.display(), said(.get_it))]
    NoDirectory {
        /// The directory.
        path: PathBuf,
        /// Where the data can be had.
        get_it: Option<String>,
    },
    /// The directory holds no recordings.
    #[error("no .csv file that is a run lies below `{}`{}", path.display(), said(.get_it))]
    NoRuns {
        /// The directory.
        path: PathBuf,
        /// Where the data can be had.
        get_it: Option<String>,
    },
    /// The directory cannot be searched.
    #[error("the directory cannot be searched ({0}); check its permissions")]
    Search(#[from] walkdir::Error),
    /// A run cannot be used.
    #[error("the run `{}` cannot be used: {why}", path.display())]
    Run {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what helps.
        why: String,
    },
    /// The runs together cannot be used.
    #[error("{0}")]
    Runs(String),
    /// The monitor refused a setting.
    #[error("the monitor refuses its settings: {0}")]
    Settings(String),
}

/// Where to get data that is not there, behind the sentence that it is not.
fn said(get_it: &Option<String>) -> String {
    get_it.as_ref().map_or_else(|| "; check the path".to_owned(), |get_it| format!("; to get them, {get_it}"))
}

/// A benchmark: which recordings, and which monitor.
#[derive(Clone, Debug)]
pub struct Bench {
    /// How recordings are scored.
    pub protocol: Protocol,
    /// Where they are.
    pub directory: PathBuf,
    /// Which monitor judges them.
    pub mode: Mode,
    /// False alarms that are tolerable per hour, in `guard` mode.
    pub false_alarms_per_hour: f64,
}

impl Bench {
    /// The files that are runs, in the order of their paths.
    ///
    /// # Errors
    /// [`BenchError`] says where to get the data if there are none.
    pub fn files(&self) -> Result<Vec<PathBuf>, BenchError> {
        files::runs_below(&self.directory, &self.protocol)
    }

    /// Reads, judges and scores the runs; `tick` is called as each is read, and again as each is judged.
    ///
    /// # Errors
    /// [`BenchError`]: of the first run, in the order of their paths, that cannot be used.
    pub fn run(&self, files: &[PathBuf], tick: impl Fn() + Sync) -> Result<BenchReport, BenchError> {
        let judge = Judge::new(&self.protocol, self.mode, self.false_alarms_per_hour)?;
        let read = |path: &PathBuf| {
            let run = Recorded::read(&self.protocol, path, name(&self.directory, path));
            tick();
            run
        };
        let runs: Vec<Recorded> =
            files.par_iter().map(read).collect::<Vec<_>>().into_iter().collect::<Result<_, _>>()?;
        let task = self.protocol.task().map_err(BenchError::Runs)?;
        Ok(match task {
            Task::Labelled { learn_rows, labels } => {
                BenchReport::Labelled(Box::new(labelled::run(self, &judge, &runs, (learn_rows, labels), &tick)?))
            }
            Task::Drifts(asked) => BenchReport::Drifts(Box::new(drifts::run(self, &judge, &runs, asked, &tick)?)),
        })
    }
}

/// The path of a run below the directory, as it is called in tables.
fn name(directory: &Path, path: &Path) -> String {
    path.strip_prefix(directory).unwrap_or(path).display().to_string()
}
