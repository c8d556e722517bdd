//! The summary as files: CSV for people and spreadsheets, Parquet for query engines. Both hold the same.

use std::path::PathBuf;

use super::row::{COLUMNS, Cell, Row};
use crate::output::{OutputDir, OutputError, PendingFile};

#[cfg(feature = "parquet")]
mod parquet;

/// Names of the files.
pub const FILES: [&str; 2] = ["summary.csv", "summary.parquet"];

/// Writes the summary; returns the files.
///
/// # Errors
/// [`OutputError`] when a file cannot be written.
pub fn write(rows: &[Row], out: &OutputDir) -> Result<Vec<PathBuf>, OutputError> {
    let [csv, parquet] = FILES;
    let files = vec![write_csv(rows, out.create(csv)?)?];
    #[cfg(feature = "parquet")]
    let files = [files, vec![parquet::write(rows, out.create(parquet)?)?]].concat();
    #[cfg(not(feature = "parquet"))]
    let _ = parquet;
    Ok(files)
}

fn write_csv(rows: &[Row], file: PendingFile) -> Result<PathBuf, OutputError> {
    let mut csv = csv::Writer::from_writer(file);
    let written = (|| {
        csv.write_record(COLUMNS.map(|(name, _)| name))?;
        rows.iter().try_for_each(|row| csv.write_record(row.cells().iter().map(text)))?;
        Ok(csv.flush()?)
    })();
    if let Err(error) = written {
        let error: csv::Error = error;
        return Err(csv.get_ref().failed(error.into()));
    }
    match csv.into_inner() {
        Ok(file) => file.finish(),
        Err(error) => {
            let source = std::io::Error::new(error.error().kind(), error.error().to_string());
            Err(error.into_inner().get_ref().failed(source))
        }
    }
}

/// A value as it is written in CSV: every digit that tells it from its neighbours; empty where there is none.
#[must_use]
pub fn text(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone().unwrap_or_default(),
        Cell::Whole(number) => number.map(|number| number.to_string()).unwrap_or_default(),
        Cell::Real(number) => number.map(|number| number.to_string()).unwrap_or_default(),
    }
}
