//! Which logs a fleet has: those that are named, and those below the directories that are named.

use std::fs;
use std::path::{Path, PathBuf};

/// Endings of files that are taken for logs where they are not named themselves.
const ENDINGS: [&str; 5] = ["csv", "tsv", "txt", "parquet", "pq"];

/// Why a directory was refused.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// It cannot be read.
    #[error("cannot read the directory '{}': {source}; change its permissions, or name its logs", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No log is in it.
    #[error("no log below the directory '{}': a log there ends in .csv, .tsv, .txt, .parquet or .pq, or is named itself", .0.display())]
    NoLog(PathBuf),
}

/// The logs, directories in the order of their names. What `spared` says is none: results of an earlier run.
///
/// # Errors
/// [`InputError`] when a directory cannot be read or holds no log. A file that is not there is told of when it is read.
pub fn logs(given: &[PathBuf], spared: impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>, InputError> {
    let mut logs = Vec::new();
    for path in given {
        if !path.is_dir() {
            logs.push(path.clone());
            continue;
        }
        let before = logs.len();
        gather(path, &spared, &mut logs)?;
        if logs.len() == before {
            return Err(InputError::NoLog(path.clone()));
        }
    }
    Ok(logs)
}

fn gather(directory: &Path, spared: &impl Fn(&Path) -> bool, logs: &mut Vec<PathBuf>) -> Result<(), InputError> {
    let failed = |source| InputError::Directory { path: directory.to_owned(), source };
    let entries: Result<Vec<_>, _> = fs::read_dir(directory).map_err(failed)?.collect();
    let mut entries = entries.map_err(failed)?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        if entry.file_name().to_string_lossy().starts_with('.') || spared(&path) {
            continue;
        }
        // Directories behind links are left out: they may lead back.
        if entry.file_type().map_err(failed)?.is_dir() {
            gather(&path, spared, logs)?;
        } else if is_log(&path) && path.is_file() {
            logs.push(path);
        }
    }
    Ok(())
}

fn is_log(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
}
