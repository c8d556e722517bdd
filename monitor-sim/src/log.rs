//! Reads chosen columns of a recorded log (CSV, or Parquet), one row at a time.
//!
//! The reader of text finds out by itself how the file is written: delimiter, header, byte-order mark,
//! line ends. It holds one row and one read buffer, however long the log is.
//!
//! It leaves out: decimal commas, thousands separators, time stamps, comment lines, line ends that
//! are a lone carriage return. A quoted field may hold the delimiter; only in the header may it run
//! over a line end, as elsewhere a forgotten quote would swallow rows in silence.
//!
//! It promises: no bytes make it panic; a row is either read whole or named in an error; a log cut
//! off in the middle of its last row is read up to there, and says so.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::str::FromStr;

use csv::ByteRecord;
use thiserror::Error;

mod any;
mod error;
mod layout;
#[cfg(feature = "parquet")]
mod parquet;

pub use any::Log;
pub use error::LogError;
pub(crate) use error::{not_a_number, open_error};
use layout::{Layout, Selection, Source, csv_format, is_blank, line_ends};
pub(crate) use layout::{decode, find_column, parse_value, sniff_delimiter};
#[cfg(feature = "parquet")]
pub use parquet::ParquetLog;

/// The read buffer. Between 8 KiB and 256 KiB the speed is the same; 64 KiB keeps the calls few.
const BUFFER_BYTES: usize = 64 * 1024;

/// A column of a log, as given on the command line: its name in the header, or its number from 1.
///
/// Digits alone mean the number, unless a column of the header has exactly that name.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ColumnRef(String);

/// A reference to a column that is empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("a column must be named; give its name in the header, or its number counted from 1")]
pub struct EmptyColumnRef;

impl FromStr for ColumnRef {
    type Err = EmptyColumnRef;

    fn from_str(text: &str) -> Result<Self, EmptyColumnRef> {
        let text = text.trim();
        if text.is_empty() { Err(EmptyColumnRef) } else { Ok(Self(text.to_owned())) }
    }
}

impl fmt::Display for ColumnRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl ColumnRef {
    fn is_number(&self) -> bool {
        self.0.bytes().all(|byte| byte.is_ascii_digit())
    }

    /// The place of a column given by number, if the log has that many `columns`.
    fn number_index(&self, columns: usize) -> Option<usize> {
        let number: usize = self.0.parse().ok()?;
        number.checked_sub(1).filter(|index| *index < columns)
    }
}

/// What separates the fields of a log: `,`, `;`, `|`, `tab` or another single character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Delimiter(u8);

/// A text that cannot be a delimiter.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{0}` cannot separate columns; give `,`, `;`, `tab` or another single character that no number holds")]
pub struct BadDelimiter(String);

impl FromStr for Delimiter {
    type Err = BadDelimiter;

    fn from_str(text: &str) -> Result<Self, BadDelimiter> {
        match text.as_bytes() {
            b"tab" | b"\\t" | b"\t" => Ok(Self(b'\t')),
            b" " => Ok(Self(b' ')),
            &[byte] if byte.is_ascii_punctuation() && !b"\"+-.".contains(&byte) => Ok(Self(byte)),
            _ => Err(BadDelimiter(text.to_owned())),
        }
    }
}

impl Delimiter {
    /// As it stands in a file.
    pub(crate) const fn byte(self) -> u8 {
        self.0
    }
}

impl fmt::Display for Delimiter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            b'\t' => f.write_str("tab"),
            byte => write!(f, "{}", char::from(byte)),
        }
    }
}

/// How to read a log, where the reader shall not find it out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LogOptions {
    /// The delimiter; `None`: found from the first rows, among comma, semicolon and tab.
    pub delimiter: Option<Delimiter>,
}

/// One row of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<'a> {
    /// The row, from 0, without the header.
    pub row: u64,
    /// The line of the file, from 1.
    pub line: u64,
    /// The values, in the order of the channels. A missing value (empty, `NA`, `null`, `nan`) is NaN.
    pub values: &'a [f64],
}

/// The row that a log breaks off in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TruncatedTail {
    /// The row, from 0; it was not read.
    pub row: u64,
    /// The line of the file, from 1.
    pub line: u64,
}

/// Reads the chosen columns of a log.
///
/// ```
/// use monitor_sim::log::{LogOptions, LogReader};
///
/// let file = "time;speed;current\n0.0;100.5;3.2\n0.1;100.7;\n";
/// let channels = [("speed".to_owned(), "speed".parse()?), ("current".to_owned(), "3".parse()?)];
/// let mut log = LogReader::from_reader("demo.csv", file.as_bytes(), &channels, LogOptions::default())?;
/// while let Some(row) = log.next_row()? {
///     println!("{} {:?}", row.row, row.values); // 0 [100.5, 3.2], then 1 [100.7, NaN]
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LogReader {
    path: String,
    total_bytes: Option<u64>,
    csv: csv::Reader<Source>,
    record: ByteRecord,
    columns: Vec<String>,
    fields: usize,
    has_header: bool,
    /// The place of each channel in a record.
    selected: Vec<usize>,
    values: Vec<f64>,
    rows_read: u64,
    finished: bool,
    ends_without_newline: bool,
    truncated_tail: Option<TruncatedTail>,
}

impl LogReader {
    /// Opens the log `path` to read one column for each of the `channels` (a name for messages, and
    /// the column).
    ///
    /// # Errors
    /// A [`LogError`] if the file cannot be read, holds no row, or has not the columns asked for.
    pub fn open(
        path: impl AsRef<Path>,
        channels: &[(String, ColumnRef)],
        options: LogOptions,
    ) -> Result<Self, LogError> {
        let name = path.as_ref().display().to_string();
        let opened = File::open(path).and_then(|file| file.metadata().map(|data| (file, data)));
        let (file, metadata) = match opened {
            Ok(opened) => opened,
            Err(cause) => return Err(open_error(name, cause)),
        };
        if metadata.is_dir() {
            return Err(LogError::IsADirectory { path: name });
        }
        // A pipe has no length to be known beforehand.
        let total_bytes = metadata.is_file().then_some(metadata.len());
        let mut log = Self::from_reader(&name, file, channels, options)?;
        log.total_bytes = total_bytes;
        Ok(log)
    }

    /// Reads a log that is not a file; `name` stands for it in messages.
    ///
    /// # Errors
    /// As [`LogReader::open`].
    pub fn from_reader(
        name: &str,
        input: impl Read + Send + 'static,
        channels: &[(String, ColumnRef)],
        options: LogOptions,
    ) -> Result<Self, LogError> {
        let source =
            Source::new(Box::new(input)).map_err(|cause| LogError::Read { path: name.to_owned(), line: 1, cause })?;
        let layout = Layout::find(name, &source.head, options.delimiter)?;
        let selection = Selection::find(&layout, channels)?;
        let mut log = Self {
            path: name.to_owned(),
            total_bytes: None,
            csv: csv_format(layout.delimiter).buffer_capacity(BUFFER_BYTES).from_reader(source),
            record: ByteRecord::new(),
            fields: layout.first.len(),
            columns: selection.columns,
            has_header: selection.has_header,
            values: vec![f64::NAN; selection.indices.len()],
            selected: selection.indices,
            rows_read: 0,
            finished: false,
            ends_without_newline: false,
            truncated_tail: None,
        };
        if log.has_header {
            log.read_record()?;
            if layout.second.is_none() && layout.is_whole {
                return Err(LogError::HeaderOnly { path: log.path });
            }
        }
        Ok(log)
    }

    /// The next row, or `None` at the end of the log, after an error, and at a row that the log
    /// breaks off in (see [`LogReader::truncated_tail`]).
    ///
    /// # Errors
    /// A [`LogError`] that names the row and the line.
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>, LogError> {
        if self.finished {
            return Ok(None);
        }
        let row = self.rows_read;
        let Some(line) = self.read_record()? else {
            self.finished = true;
            return Ok(None);
        };
        if let Err(error) = self.parse_record(row, line) {
            self.finished = true;
            if self.ends_without_newline {
                self.truncated_tail = Some(TruncatedTail { row, line });
                return Ok(None);
            }
            return Err(error);
        }
        self.rows_read += 1;
        Ok(Some(Row { row, line, values: &self.values }))
    }

    /// The names of all columns of the log; `column 1` and so on if it has no header.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Whether the first line is a header.
    pub fn has_header(&self) -> bool {
        self.has_header
    }

    /// The bytes taken from the file up to now, with those read ahead (at most 128 KiB).
    pub fn bytes_read(&self) -> u64 {
        self.csv.get_ref().handed_out
    }

    /// The length of the file when it was opened; `None` for what is not a file.
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// The row the log breaks off in, known when [`LogReader::next_row`] has returned `None`.
    ///
    /// That is a last row without a line end that has not the fields of the first line, or a chosen
    /// field that is not a number.
    pub fn truncated_tail(&self) -> Option<TruncatedTail> {
        self.truncated_tail
    }

    /// Whether the last row has no line end, known when it has been read.
    ///
    /// If all its fields are there it is read as a whole row, though its last number may be cut.
    pub fn ends_without_newline(&self) -> bool {
        self.ends_without_newline
    }

    /// Reads the next record that is not blank; returns the line it begins on.
    fn read_record(&mut self) -> Result<Option<u64>, LogError> {
        loop {
            let begin = self.csv.position().byte();
            self.csv.get_mut().row_begin = begin;
            let line_before = self.csv.position().line();
            match self.csv.read_byte_record(&mut self.record) {
                Ok(true) => {}
                Ok(false) => return Ok(None),
                Err(error) => {
                    self.finished = true;
                    return Err(self.read_error(error, line_before));
                }
            }
            if is_blank(&self.record) {
                continue;
            }
            // The csv reader asks beyond the end of the file only for a record without a line end.
            self.ends_without_newline = self.csv.get_ref().at_end;
            let line_after = self.csv.position().line();
            let last_line = if self.ends_without_newline { line_after } else { line_after.saturating_sub(1) };
            return Ok(Some(last_line.saturating_sub(line_ends(&self.record))));
        }
    }

    fn read_error(&self, error: csv::Error, line: u64) -> LogError {
        let path = self.path.clone();
        if self.csv.get_ref().row_too_long {
            return LogError::RowTooLong { path, line };
        }
        let cause = match error.into_kind() {
            csv::ErrorKind::Io(cause) => cause,
            other => io::Error::other(format!("{other:?}")),
        };
        LogError::Read { path, line, cause }
    }

    /// Puts the chosen fields of the record into `values`.
    fn parse_record(&mut self, row: u64, line: u64) -> Result<(), LogError> {
        if self.record.as_slice().contains(&0) {
            return Err(LogError::NotText { path: self.path.clone(), line });
        }
        if line_ends(&self.record) > 0 {
            return Err(LogError::QuoteOverLines { row, line });
        }
        if self.record.len() != self.fields {
            let (found, expected) = (self.record.len(), self.fields);
            return Err(LogError::Ragged { row, line, found, expected });
        }
        for (value, index) in self.values.iter_mut().zip(&self.selected) {
            let field = self.record.get(*index).unwrap_or_default();
            match parse_value(field) {
                Some(number) => *value = number,
                None => {
                    let column = self.columns.get(*index).cloned().unwrap_or_default();
                    return Err(not_a_number(field, row, line, column));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
