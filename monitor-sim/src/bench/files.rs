//! The files that are runs.

use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::BenchError;
use super::protocol::Protocol;

/// Every .csv file below the directory, but those that the protocol skips, in the order of their paths.
pub(super) fn runs_below(directory: &Path, protocol: &Protocol) -> Result<Vec<PathBuf>, BenchError> {
    let (path, get_it) = (directory.to_owned(), protocol.get_it.clone());
    if !directory.is_dir() {
        return Err(BenchError::NoDirectory { path, get_it });
    }
    let mut runs = Vec::new();
    for entry in WalkDir::new(directory).follow_links(true).sort_by_file_name() {
        let entry = entry?;
        let below = super::name(directory, entry.path());
        let skipped = protocol.data.skip.iter().any(|word| below.contains(word));
        let is_csv = entry.path().extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
        if entry.file_type().is_file() && is_csv && !skipped {
            runs.push(entry.into_path());
        }
    }
    if runs.is_empty() {
        return Err(BenchError::NoRuns { path, get_it });
    }
    Ok(runs)
}
