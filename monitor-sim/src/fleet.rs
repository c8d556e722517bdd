//! Many logs at once: each is replayed as it would be alone, and becomes one row of a summary.
//!
//! Logs are shared out over all cores; each core holds one at a time, in memory that does not grow with it. A log that cannot
//! be judged is a row with the reason, and does not stop the others.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::models::{Place, SAVE_MODELS};
use crate::output::PendingFile;
use crate::replay::{ReplayError, guard, paper};

pub mod inputs;
pub mod row;
pub mod summary;

use row::Row;

/// How the logs are replayed; the path in it stands for each of them.
#[derive(Clone, Debug)]
pub enum How {
    /// In `guard` mode.
    Guard(guard::Replay),
    /// In `paper` mode.
    Paper(paper::Replay),
}

/// Logs that are replayed in the same way.
#[derive(Clone, Debug)]
pub struct Fleet {
    /// The logs.
    pub files: Vec<PathBuf>,
    /// How each is replayed.
    pub how: How,
    /// The directory in which what is known of each log's set points at its end is kept, of `guard` mode.
    pub save_models: Option<PathBuf>,
}

/// What came of all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Outcome {
    /// Logs without a fault.
    pub healthy: usize,
    /// Logs with one or more.
    pub faulty: usize,
    /// Logs that could not be judged.
    pub refused: usize,
}

impl Fleet {
    /// Bytes of all logs, for a progress bar.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.files.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|data| data.len()).sum()
    }

    /// Replays all logs, on all cores; the rows are in the order of the logs. `tick` is called with the bytes read since the
    /// last call.
    ///
    /// # Errors
    /// [`ReplayError`] when a setting makes no sense, whatever the log.
    pub fn run(&self, tick: impl Fn(u64) + Sync) -> Result<Vec<Row>, ReplayError> {
        match &self.how {
            How::Guard(replay) => replay.check()?,
            How::Paper(replay) => replay.check()?,
        }
        // Logs differ in length: each is taken by whoever is free.
        Ok(self.files.par_iter().with_max_len(1).map(|file| self.row(file, &tick)).collect())
    }

    fn row(&self, file: &Path, tick: impl Fn(u64)) -> Row {
        let mut read = 0;
        let progress = |bytes: u64| {
            tick(bytes.saturating_sub(read));
            read = bytes;
        };
        let name = file.display().to_string();
        match &self.how {
            How::Guard(replay) => {
                let mut replay = replay.clone();
                replay.source.path = file.to_owned();
                match replay.run(|_| Ok(None), progress).and_then(|replayed| self.saved(file, replayed)) {
                    Ok(replayed) => Row::of_guard(name, &replayed.report),
                    Err(error) => Row::refused(name, "guard", replay.source.rate_hz, &error),
                }
            }
            How::Paper(replay) => {
                let mut replay = replay.clone();
                replay.source.path = file.to_owned();
                match replay.run(|_| Ok(None), progress) {
                    Ok(replayed) => Row::of_paper(name, &replayed.report, &replayed.names),
                    Err(error) => Row::refused(name, "paper", replay.source.rate_hz, &error),
                }
            }
        }
    }

    fn saved(&self, log: &Path, replayed: guard::Replayed) -> Result<guard::Replayed, ReplayError> {
        if let Some(directory) = &self.save_models {
            let path = Place::Directory(directory.clone()).of(log);
            replayed.report.known.write(PendingFile::create(&path, SAVE_MODELS)?)?;
        }
        Ok(replayed)
    }
}

impl Outcome {
    /// Counts rows.
    #[must_use]
    pub fn of(rows: &[Row]) -> Self {
        let count = |holds: fn(&Row) -> bool| rows.iter().filter(|row| holds(row)).count();
        Outcome {
            healthy: count(|row| row.alarms == Some(0)),
            faulty: count(|row| row.alarms.is_some_and(|alarms| alarms > 0)),
            refused: count(|row| row.error.is_some()),
        }
    }

    /// The exit code: 2 if a log was refused, else 1 if a fault was found, else 0.
    #[must_use]
    pub const fn exit(&self) -> u8 {
        match self {
            Outcome { refused: 1.., .. } => 2,
            Outcome { faulty: 1.., .. } => 1,
            _ => 0,
        }
    }
}
