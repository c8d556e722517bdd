//! Why a log could not be read, and what helps.

use std::io::{self, ErrorKind};

use thiserror::Error;

use super::layout::{MAX_ROW_BYTES, decode, has_decimal_comma};
use crate::inject::did_you_mean;

/// Column names listed in a message.
const MAX_LISTED: usize = 40;
/// Characters of a wrong field shown in a message.
const MAX_SHOWN: usize = 40;

/// Why a log could not be read. Rows count from 0 without the header, lines from 1 with it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogError {
    /// No file of that name.
    #[error("there is no log `{path}`; check the path")]
    NotFound {
        /// The file.
        path: String,
    },
    /// The file may not be read.
    #[error("no permission to read the log `{path}`; change its permissions or copy it")]
    NotReadable {
        /// The file.
        path: String,
    },
    /// The path is a directory.
    #[error("`{path}` is a directory; give the log file in it")]
    IsADirectory {
        /// The directory.
        path: String,
    },
    /// The file could not be opened, for another reason.
    #[error("the log `{path}` cannot be opened ({cause}); check the path")]
    Open {
        /// The file.
        path: String,
        /// What the system said.
        cause: io::Error,
    },
    /// Reading failed.
    #[error(
        "reading the log `{path}` failed near line {line} ({cause}); check the disk, or copy the log and try again"
    )]
    Read {
        /// The file.
        path: String,
        /// The line that was being read.
        line: u64,
        /// What the system said.
        cause: io::Error,
    },
    /// The file holds nothing but blank lines.
    #[error("the log `{path}` is empty; give a log with at least one row")]
    Empty {
        /// The file.
        path: String,
    },
    /// The file has a header and no row.
    #[error("the log `{path}` has a header but no data row; give a log with at least one row")]
    HeaderOnly {
        /// The file.
        path: String,
    },
    /// The file holds NUL bytes.
    #[error("the log `{path}` is not a text file (NUL byte in line {line}); export it as CSV in UTF-8")]
    NotText {
        /// The file.
        path: String,
        /// The line of the byte.
        line: u64,
    },
    /// A file in Parquet is damaged, or written in a way that is not known here.
    #[error(
        "the Parquet log `{path}` cannot be read ({cause}); write it anew, compressed by snappy, zstd, gzip or lz4 if at all, or export it as CSV"
    )]
    Parquet {
        /// The file.
        path: String,
        /// What is wrong with it.
        cause: String,
    },
    /// A column of a log in Parquet holds no numbers.
    #[error("column `{column}` of the log holds {kind}, and no numbers; cast it to DOUBLE, or choose another column")]
    NotNumbers {
        /// The column.
        column: String,
        /// What it holds.
        kind: String,
    },
    /// The log is in Parquet, and the program was built without it.
    #[error(
        "the log `{path}` is in Parquet, which this program was built without; build it with its feature `parquet`, or export the log as CSV"
    )]
    WithoutParquet {
        /// The file.
        path: String,
    },
    /// A row is longer than any row of numbers.
    #[error(
        "line {line} of the log `{path}` begins a row of more than {} bytes; close its quotes, or give a CSV file with line ends",
        MAX_ROW_BYTES
    )]
    RowTooLong {
        /// The file.
        path: String,
        /// The line where the row begins.
        line: u64,
    },
    /// A column was asked for by a name that the header does not have.
    #[error("the log has no column `{column}` for the {channel}{}; its columns are {}", did_you_mean(.nearest), listed(.columns))]
    UnknownColumn {
        /// The channel that the column was for.
        channel: String,
        /// The column as asked for.
        column: String,
        /// The column that was likely meant.
        nearest: Option<String>,
        /// The columns of the log.
        columns: Vec<String>,
    },
    /// A column was asked for by a number that the log does not have.
    #[error("the log has no column number {column} for the {channel}; its {} columns count from 1: {}", .columns.len(), listed(.columns))]
    ColumnOutOfRange {
        /// The channel that the column was for.
        channel: String,
        /// The number as asked for.
        column: String,
        /// The columns of the log.
        columns: Vec<String>,
    },
    /// The header has the name more than once.
    #[error("the log has the column `{column}` for the {channel} more than once; give its number: {}", numbers(.places))]
    AmbiguousColumn {
        /// The channel that the column was for.
        channel: String,
        /// The column as asked for.
        column: String,
        /// The numbers of the columns of that name, from 1.
        places: Vec<usize>,
    },
    /// A column was asked for by name in a log without a header.
    #[error(
        "the log has no header, so the column `{column}` for the {channel} cannot be found by name; give its number from 1 to {columns}"
    )]
    NoHeader {
        /// The channel that the column was for.
        channel: String,
        /// The column as asked for.
        column: String,
        /// How many columns the log has.
        columns: usize,
    },
    /// Two channels read the same column.
    #[error(
        "the {first} and the {second} both read column `{column}`; give each its own, as two equal channels leave the covariance singular"
    )]
    SameColumn {
        /// One channel.
        first: String,
        /// The other channel.
        second: String,
        /// The column of both.
        column: String,
    },
    /// A row has more or fewer fields than the first line.
    #[error(
        "row {row} (line {line}) has {found} fields where the first line has {expected}; repair or remove that line"
    )]
    Ragged {
        /// The row.
        row: u64,
        /// The line.
        line: u64,
        /// Fields in the row.
        found: usize,
        /// Fields in the first line.
        expected: usize,
    },
    /// A quoted field runs over the end of its line.
    #[error(
        "row {row} (line {line}) has a quoted field that runs over the line end; close the quote or remove the line break"
    )]
    QuoteOverLines {
        /// The row.
        row: u64,
        /// The line where the row begins.
        line: u64,
    },
    /// A field of a chosen column is not a number.
    #[error(
        "row {row} (line {line}): `{text}` in column `{column}` is not a number; correct it, empty it, or choose another column"
    )]
    NotANumber {
        /// The row.
        row: u64,
        /// The line.
        line: u64,
        /// The column.
        column: String,
        /// The field.
        text: String,
    },
    /// A field of a chosen column is written with a decimal comma.
    #[error(
        "row {row} (line {line}): `{text}` in column `{column}` has a decimal comma; export the log with decimal points"
    )]
    DecimalComma {
        /// The row.
        row: u64,
        /// The line.
        line: u64,
        /// The column.
        column: String,
        /// The field.
        text: String,
    },
}

pub(super) fn listed(columns: &[String]) -> String {
    let mut list = columns.iter().take(MAX_LISTED).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if columns.len() > MAX_LISTED {
        list += &format!(" and {} more", columns.len() - MAX_LISTED);
    }
    list
}

pub(super) fn numbers(places: &[usize]) -> String {
    places.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ")
}

pub(crate) fn open_error(path: String, cause: io::Error) -> LogError {
    match cause.kind() {
        ErrorKind::NotFound => LogError::NotFound { path },
        ErrorKind::PermissionDenied => LogError::NotReadable { path },
        ErrorKind::IsADirectory => LogError::IsADirectory { path },
        _ => LogError::Open { path, cause },
    }
}

pub(crate) fn not_a_number(field: &[u8], row: u64, line: u64, column: String) -> LogError {
    let whole = decode(field);
    let mut text: String = whole.chars().take(MAX_SHOWN).collect();
    if text.len() < whole.len() {
        text.push('…');
    }
    if has_decimal_comma(field) {
        LogError::DecimalComma { row, line, column, text }
    } else {
        LogError::NotANumber { row, line, column, text }
    }
}
