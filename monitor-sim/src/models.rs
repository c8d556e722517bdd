//! What `guard` mode has learned of each set point, as a file: the core's records one behind the other, as a board keeps them
//! in its flash.

use std::io::Write;
use std::path::{Path, PathBuf};

use monitor_core::guard::{Monitor, RestoreError, Stored};

use crate::output::{OutputError, PendingFile};

/// What flash holds where nothing was written: a dump may end in it.
const ERASED: u8 = 0xff;

/// The option that chooses where they are written.
pub const SAVE_MODELS: &str = "--save-models";

/// Ending of the files in a directory of models.
const ENDING: &str = "models";

/// Models of set points.
#[derive(Clone, Debug, PartialEq)]
pub struct Models {
    stored: Vec<Stored>,
    /// Where they were read, for what there is to say of them.
    path: PathBuf,
}

/// Why a file's models cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the models of '{}' cannot be used: {why}", path.display())]
pub struct ModelsError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, and what helps.
    pub why: String,
}

/// Where models are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a file, whatever is judged.
    File(PathBuf),
    /// In a directory, with a file for each log.
    Directory(PathBuf),
}

impl Place {
    /// The place at a path: a directory if there is one.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        if path.is_dir() { Place::Directory(path.to_owned()) } else { Place::File(path.to_owned()) }
    }

    /// The file for a log.
    #[must_use]
    pub fn of(&self, log: &Path) -> PathBuf {
        match self {
            Place::File(path) => path.clone(),
            Place::Directory(path) => path.join(log.file_name().unwrap_or_default()).with_extension(ENDING),
        }
    }
}

impl Models {
    /// What a monitor knows by now.
    #[must_use]
    pub fn of(guard: &Monitor) -> Self {
        Models { stored: guard.stored().collect(), path: PathBuf::new() }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`ModelsError`] when it cannot be read, holds no model, or one that was cut or damaged.
    pub fn read(path: &Path) -> Result<Self, ModelsError> {
        let refused = |why: String| ModelsError { path: path.to_owned(), why };
        let bytes = std::fs::read(path).map_err(|error| {
            refused(format!("{error}; give a file that --save-models wrote, or learn instead (a log: with --learn)"))
        })?;
        let mut stored = Vec::new();
        for (place, record) in bytes.chunks(Stored::BYTES).enumerate() {
            if record.iter().any(|byte| *byte != ERASED) {
                let record = Stored::of_bytes(record);
                stored.push(record.map_err(|error| refused(format!("model {}: {}", place + 1, damaged(error))))?);
            }
        }
        if stored.is_empty() {
            return Err(refused("it holds none; write it with --save-models".to_owned()));
        }
        Ok(Models { stored, path: path.to_owned() })
    }

    /// The set points.
    pub fn set_points(&self) -> impl Iterator<Item = f32> {
        self.stored.iter().map(Stored::set_point)
    }

    /// The same in words.
    #[must_use]
    pub fn listed(&self) -> String {
        self.set_points().map(|at| at.to_string()).collect::<Vec<_>>().join(", ")
    }

    /// Gives a monitor all of them.
    ///
    /// # Errors
    /// [`ModelsError`] when they were learned under other settings than the monitor's.
    pub fn restore(&self, guard: &mut Monitor) -> Result<(), ModelsError> {
        self.stored.iter().try_for_each(|stored| {
            let refused = |error| ModelsError { path: self.path.clone(), why: foreign(stored.set_point(), error) };
            guard.restore(stored).map_err(refused)
        })
    }

    /// Writes them.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written; then what was there is as it was.
    pub fn write(&self, mut file: PendingFile) -> Result<PathBuf, OutputError> {
        for stored in &self.stored {
            file.write_all(stored.bytes()).map_err(|source| file.failed(source))?;
        }
        file.finish()
    }
}

/// What is wrong with a record's bytes, and what helps.
fn damaged(error: RestoreError) -> String {
    match error {
        RestoreError::Length => {
            format!("the file ends in it, short of its {} bytes; copy the file anew", Stored::BYTES)
        }
        RestoreError::Format => {
            "these bytes are none, or one of another version; give a file that --save-models wrote".to_owned()
        }
        _ => "bytes of it were lost or changed; copy the file anew, or write it again with --save-models".to_owned(),
    }
}

/// Why a model does not suit a monitor, and what helps.
fn foreign(set_point: f32, error: RestoreError) -> String {
    let why = match error {
        RestoreError::SampleRate(rate_hz) => {
            return format!(
                "the one of set point {set_point} was learned at {rate_hz} Hz, and noise at another rate is another noise; \
                 judge what was sampled at that rate, or learn anew"
            );
        }
        RestoreError::TimeConstants => {
            "was learned with other time constants, which follow from the length of the learning window: give that of then by \
             --relearn, or by the scenario's [learn]"
        }
        RestoreError::FalseAlarmRate => {
            "has limits for another rate of false alarms: give --false-alarms-per-hour the value it was learned with"
        }
        _ => "holds numbers that are no model's; write it again with --save-models",
    };
    format!("the one of set point {set_point} {why}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_has_a_file_for_each_log_whatever_the_form_of_the_log() {
        let directory = tempfile::tempdir().unwrap();
        let place = Place::at(directory.path());
        let expected = directory.path().join("motor 1.models");
        assert_eq!(place.of(Path::new("logs/motor 1.csv")), expected);
        assert_eq!(place.of(Path::new("motor 1.parquet")), expected);
        let file = directory.path().join("all.models");
        assert_eq!(Place::at(&file).of(Path::new("a.csv")), file);
    }
}
