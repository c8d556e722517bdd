//! A log of either kind, told apart by its first bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

#[cfg(feature = "parquet")]
use super::ParquetLog;
use super::{ColumnRef, LogError, LogOptions, LogReader, Row, TruncatedTail};

/// The first bytes of a file in Parquet.
const PARQUET: [u8; 4] = *b"PAR1";

/// A log that is open.
#[derive(Debug)]
pub enum Log {
    /// Of text.
    Text(Box<LogReader>),
    /// In Parquet.
    #[cfg(feature = "parquet")]
    Parquet(Box<ParquetLog>),
}

impl Log {
    /// Opens a log of text or in Parquet. The options are of text.
    ///
    /// # Errors
    /// As [`LogReader::open`]; and where a file in Parquet is damaged or there is no reader for it.
    pub fn open(path: &Path, channels: &[(String, ColumnRef)], options: LogOptions) -> Result<Self, LogError> {
        if is_parquet(path) {
            #[cfg(feature = "parquet")]
            return Ok(Log::Parquet(Box::new(ParquetLog::open(path, channels)?)));
            #[cfg(not(feature = "parquet"))]
            return Err(LogError::WithoutParquet { path: path.display().to_string() });
        }
        Ok(Log::Text(Box::new(LogReader::open(path, channels, options)?)))
    }

    /// See [`LogReader::next_row`].
    ///
    /// # Errors
    /// A [`LogError`].
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>, LogError> {
        match self {
            Log::Text(log) => log.next_row(),
            #[cfg(feature = "parquet")]
            Log::Parquet(log) => log.next_row(),
        }
    }

    /// The bytes of the file that were read up to now, more or less.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        match self {
            Log::Text(log) => log.bytes_read(),
            #[cfg(feature = "parquet")]
            Log::Parquet(log) => log.bytes_read(),
        }
    }

    /// See [`LogReader::truncated_tail`]; a file in Parquet has its end or cannot be opened.
    #[must_use]
    pub fn truncated_tail(&self) -> Option<TruncatedTail> {
        match self {
            Log::Text(log) => log.truncated_tail(),
            #[cfg(feature = "parquet")]
            Log::Parquet(_) => None,
        }
    }

    /// See [`LogReader::ends_without_newline`].
    #[must_use]
    pub fn ends_without_newline(&self) -> bool {
        match self {
            Log::Text(log) => log.ends_without_newline(),
            #[cfg(feature = "parquet")]
            Log::Parquet(_) => false,
        }
    }
}

/// Whether a file begins as one in Parquet does. A pipe is not opened: what is read of it is gone. What cannot be read here
/// is told of by the reader of text.
fn is_parquet(path: &Path) -> bool {
    let mut head = [0; PARQUET.len()];
    std::fs::metadata(path).is_ok_and(|data| data.is_file())
        && File::open(path).and_then(|mut file| file.read_exact(&mut head)).is_ok()
        && head == PARQUET
}
