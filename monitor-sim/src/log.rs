//! Reads chosen columns of a recorded log (CSV), one row at a time.
//!
//! The reader finds out by itself how the file is written: delimiter, header, byte-order mark, line
//! ends. It holds one row and one read buffer, however long the log is.
//!
//! It leaves out: decimal commas, thousands separators, time stamps, comment lines, line ends that
//! are a lone carriage return. A quoted field may hold the delimiter; only in the header may it run
//! over a line end, as elsewhere a forgotten quote would swallow rows in silence.
//!
//! It promises: no bytes make it panic; a row is either read whole or named in an error; a log cut
//! off in the middle of its last row is read up to there, and says so.

use std::fmt;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::str::FromStr;

use csv::ByteRecord;
use thiserror::Error;

use crate::inject::{did_you_mean, nearest_name};

/// The first bytes of the log, kept to find its delimiter and header.
const HEAD_BYTES: usize = 64 * 1024;
/// The rows of the head that are looked at.
const HEAD_ROWS: usize = 16;
/// The read buffer. Between 8 KiB and 256 KiB the speed is the same; 64 KiB keeps the calls few.
const BUFFER_BYTES: usize = 64 * 1024;
/// A row longer than this is no row of numbers but a forgotten quote or another kind of file;
/// it would otherwise grow to the size of the log.
const MAX_ROW_BYTES: u64 = 1024 * 1024;
/// Column names listed in a message.
const MAX_LISTED: usize = 40;
/// Characters of a wrong field shown in a message.
const MAX_SHOWN: usize = 40;

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
        if text.is_empty() {
            Err(EmptyColumnRef)
        } else {
            Ok(Self(text.to_owned()))
        }
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
#[error(
    "`{0}` cannot separate columns; give `,`, `;`, `tab` or another single character that no number holds"
)]
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
    #[error(
        "the log `{path}` is not a text file (NUL byte in line {line}); export it as CSV in UTF-8"
    )]
    NotText {
        /// The file.
        path: String,
        /// The line of the byte.
        line: u64,
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

fn listed(columns: &[String]) -> String {
    let mut list = columns
        .iter()
        .take(MAX_LISTED)
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    if columns.len() > MAX_LISTED {
        list += &format!(" and {} more", columns.len() - MAX_LISTED);
    }
    list
}

fn numbers(places: &[usize]) -> String {
    places
        .iter()
        .map(usize::to_string)
        .collect::<Vec<_>>()
        .join(" or ")
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
        let source = Source::new(Box::new(input)).map_err(|cause| LogError::Read {
            path: name.to_owned(),
            line: 1,
            cause,
        })?;
        let layout = Layout::find(name, &source.head, options.delimiter)?;
        let selection = Selection::find(&layout, channels)?;
        let mut log = Self {
            path: name.to_owned(),
            total_bytes: None,
            csv: csv_format(layout.delimiter)
                .buffer_capacity(BUFFER_BYTES)
                .from_reader(source),
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
        Ok(Some(Row {
            row,
            line,
            values: &self.values,
        }))
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
            let last_line = if self.ends_without_newline {
                line_after
            } else {
                line_after.saturating_sub(1)
            };
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
            return Err(LogError::NotText {
                path: self.path.clone(),
                line,
            });
        }
        if line_ends(&self.record) > 0 {
            return Err(LogError::QuoteOverLines { row, line });
        }
        if self.record.len() != self.fields {
            let (found, expected) = (self.record.len(), self.fields);
            return Err(LogError::Ragged {
                row,
                line,
                found,
                expected,
            });
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

fn open_error(path: String, cause: io::Error) -> LogError {
    match cause.kind() {
        ErrorKind::NotFound => LogError::NotFound { path },
        ErrorKind::PermissionDenied => LogError::NotReadable { path },
        ErrorKind::IsADirectory => LogError::IsADirectory { path },
        _ => LogError::Open { path, cause },
    }
}

fn not_a_number(field: &[u8], row: u64, line: u64, column: String) -> LogError {
    let whole = decode(field);
    let mut text: String = whole.chars().take(MAX_SHOWN).collect();
    if text.len() < whole.len() {
        text.push('…');
    }
    if has_decimal_comma(field) {
        LogError::DecimalComma {
            row,
            line,
            column,
            text,
        }
    } else {
        LogError::NotANumber {
            row,
            line,
            column,
            text,
        }
    }
}

/// The bytes of the log on their way to the csv reader.
struct Source {
    input: Box<dyn Read + Send>,
    /// The first bytes, read beforehand.
    head: Vec<u8>,
    handed_out: u64,
    /// Where the row that is being read begins.
    row_begin: u64,
    row_too_long: bool,
    at_end: bool,
}

impl Source {
    fn new(mut input: Box<dyn Read + Send>) -> io::Result<Self> {
        let mut head = Vec::new();
        input
            .by_ref()
            .take(HEAD_BYTES as u64)
            .read_to_end(&mut head)?;
        Ok(Self {
            input,
            head,
            handed_out: 0,
            row_begin: 0,
            row_too_long: false,
            at_end: false,
        })
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Source")
            .field("handed_out", &self.handed_out)
            .finish_non_exhaustive()
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // A log that grows while it is read ends where its end was met first.
        if self.at_end {
            return Ok(0);
        }
        if self.handed_out.saturating_sub(self.row_begin) > MAX_ROW_BYTES {
            self.row_too_long = true;
            return Err(ErrorKind::InvalidData.into());
        }
        let head_rest = usize::try_from(self.handed_out)
            .ok()
            .and_then(|at| self.head.get(at..));
        let count = match head_rest {
            Some(mut rest) if !rest.is_empty() => rest.read(buffer)?,
            _ => loop {
                match self.input.read(buffer) {
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    other => break other?,
                }
            },
        };
        self.at_end = count == 0 && !buffer.is_empty();
        self.handed_out += count as u64;
        Ok(count)
    }
}

/// How both the head and the log are split into records.
fn csv_format(delimiter: u8) -> csv::ReaderBuilder {
    let mut format = csv::ReaderBuilder::new();
    format
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        // With a line feed as the only line end, lines are counted right in files of either kind;
        // the carriage return before it is trimmed with the last field.
        .terminator(csv::Terminator::Any(b'\n'));
    format
}

fn is_blank(record: &ByteRecord) -> bool {
    record.len() <= 1 && record.as_slice().trim_ascii().is_empty()
}

fn line_ends(record: &ByteRecord) -> u64 {
    record
        .as_slice()
        .iter()
        .filter(|byte| **byte == b'\n')
        .count() as u64
}

/// The text of a field: UTF-8, or else Latin-1, in which any byte is a character.
fn decode(field: &[u8]) -> String {
    let field = field.trim_ascii();
    match std::str::from_utf8(field) {
        Ok(text) => text.to_owned(),
        Err(_) => field.iter().copied().map(char::from).collect(),
    }
}

/// The number in a field; NaN if it says that there is none; `None` for any other text.
fn parse_value(field: &[u8]) -> Option<f64> {
    let field = field.trim_ascii();
    if let Some(number) = std::str::from_utf8(field)
        .ok()
        .and_then(|text| text.parse().ok())
    {
        return Some(number);
    }
    let missing: [&[u8]; 4] = [b"", b"na", b"n/a", b"null"];
    missing
        .iter()
        .any(|word| field.eq_ignore_ascii_case(word))
        .then_some(f64::NAN)
}

fn has_decimal_comma(field: &[u8]) -> bool {
    let comma = |byte: &&u8| **byte == b',';
    field.iter().filter(comma).count() == 1
        && std::str::from_utf8(field.trim_ascii())
            .is_ok_and(|text| text.replace(',', ".").parse::<f64>().is_ok())
}

/// How the log is written, from its first rows.
struct Layout {
    delimiter: u8,
    first: ByteRecord,
    second: Option<ByteRecord>,
    /// Whether the head is the whole file.
    is_whole: bool,
}

impl Layout {
    fn find(path: &str, head: &[u8], delimiter: Option<Delimiter>) -> Result<Self, LogError> {
        let is_whole = head.len() < HEAD_BYTES;
        let delimiter = match delimiter {
            Some(Delimiter(byte)) => byte,
            None => sniff_delimiter(head),
        };
        let mut records = head_records(head, delimiter).into_iter();
        let first = records.next().ok_or_else(|| LogError::Empty {
            path: path.to_owned(),
        })?;
        if first.as_slice().contains(&0) {
            return Err(LogError::NotText {
                path: path.to_owned(),
                line: 1,
            });
        }
        Ok(Self {
            delimiter,
            first,
            second: records.next(),
            is_whole,
        })
    }
}

/// The first records of the head that are not blank.
fn head_records(head: &[u8], delimiter: u8) -> Vec<ByteRecord> {
    csv_format(delimiter)
        .from_reader(head)
        .byte_records()
        .map_while(Result::ok)
        .filter(|record| !is_blank(record))
        .take(HEAD_ROWS)
        .collect()
}

/// The delimiter that splits the first rows into the same number of fields, above one.
///
/// Comma comes last: in a file with semicolons or tabs it may be a decimal comma. If none splits
/// the rows evenly, as when one of them is damaged, the one that splits the first row most is taken.
fn sniff_delimiter(head: &[u8]) -> u8 {
    const CANDIDATES: [u8; 3] = [b'\t', b';', b','];
    let counts = CANDIDATES.map(|delimiter| {
        let mut counts: Vec<usize> = head_records(head, delimiter)
            .iter()
            .map(ByteRecord::len)
            .collect();
        // The head, or the log itself, may end in the middle of a row.
        if counts.len() > 1 && counts.len() < HEAD_ROWS && !head.ends_with(b"\n") {
            counts.pop();
        }
        (delimiter, counts)
    });
    let first_count = |counts: &[usize]| counts.first().copied().unwrap_or(0);
    let even = counts.iter().find(|(_, counts)| {
        let first = first_count(counts);
        first > 1 && counts.iter().all(|count| *count == first)
    });
    even.or_else(|| counts.iter().max_by_key(|(_, counts)| first_count(counts)))
        .filter(|(_, counts)| first_count(counts) > 1)
        .map_or(b',', |(delimiter, _)| *delimiter)
}

/// Which columns are read.
struct Selection {
    has_header: bool,
    columns: Vec<String>,
    indices: Vec<usize>,
}

impl Selection {
    fn find(layout: &Layout, channels: &[(String, ColumnRef)]) -> Result<Self, LogError> {
        let names: Vec<String> = layout.first.iter().map(decode).collect();
        let has_header = has_header(layout, &names, channels)?;
        let columns = if has_header {
            names
        } else {
            (1..=names.len())
                .map(|number| format!("column {number}"))
                .collect()
        };
        let mut indices: Vec<usize> = Vec::with_capacity(channels.len());
        for (channel, column) in channels {
            let index = find_column(channel, column, &columns, has_header)?;
            let same = channels
                .iter()
                .zip(&indices)
                .find(|(_, taken)| **taken == index);
            if let Some(((first, _), _)) = same {
                return Err(LogError::SameColumn {
                    first: first.clone(),
                    second: channel.clone(),
                    column: column.to_string(),
                });
            }
            indices.push(index);
        }
        Ok(Self {
            has_header,
            columns,
            indices,
        })
    }
}

/// Whether the first row is a header.
///
/// It is one if a column has text there and a number in the next row, if a column asked for by
/// name is in it, or if a column asked for by number has text there. A time stamp alone, text in
/// both rows, makes no header.
fn has_header(
    layout: &Layout,
    names: &[String],
    channels: &[(String, ColumnRef)],
) -> Result<bool, LogError> {
    // A decimal comma is a wrong number rather than a name; it is told of when its row is read.
    let is_text = |field: &[u8]| parse_value(field).is_none() && !has_decimal_comma(field);
    let text_over_number = layout.second.as_ref().is_some_and(|second| {
        let mut pairs = layout.first.iter().zip(second.iter());
        pairs.any(|(first, second)| is_text(first) && !is_text(second))
    });
    if text_over_number || layout.first.iter().all(is_text) {
        return Ok(true);
    }
    let mut by_name = channels
        .iter()
        .filter(|(_, column)| !column.is_number())
        .peekable();
    if by_name.peek().is_some() {
        return match by_name.find(|(_, column)| !names.contains(&column.0)) {
            None => Ok(true),
            Some((channel, column)) => Err(LogError::NoHeader {
                channel: channel.clone(),
                column: column.to_string(),
                columns: names.len(),
            }),
        };
    }
    Ok(channels.iter().any(|(_, column)| {
        let index = column.number_index(names.len());
        index
            .and_then(|index| layout.first.get(index))
            .is_some_and(is_text)
    }))
}

fn find_column(
    channel: &str,
    column: &ColumnRef,
    columns: &[String],
    has_header: bool,
) -> Result<usize, LogError> {
    let named: Vec<usize> = if has_header {
        (0..)
            .zip(columns)
            .filter(|(_, name)| **name == column.0)
            .map(|(index, _)| index)
            .collect()
    } else {
        Vec::new()
    };
    match named.as_slice() {
        [index] => Ok(*index),
        [] if column.is_number() => {
            column
                .number_index(columns.len())
                .ok_or_else(|| LogError::ColumnOutOfRange {
                    channel: channel.to_owned(),
                    column: column.to_string(),
                    columns: columns.to_vec(),
                })
        }
        [] => Err(LogError::UnknownColumn {
            channel: channel.to_owned(),
            column: column.to_string(),
            nearest: nearest_name(&column.0, columns.iter().map(String::as_str)),
            columns: columns.to_vec(),
        }),
        places => Err(LogError::AmbiguousColumn {
            channel: channel.to_owned(),
            column: column.to_string(),
            places: places.iter().map(|index| index + 1).collect(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::time::Instant;

    use proptest::prelude::*;

    use super::*;

    const THREE: [(&str, &str); 3] = [
        ("speed", "speed"),
        ("current", "current"),
        ("voltage", "voltage"),
    ];

    fn channels(pairs: &[(&str, &str)]) -> Vec<(String, ColumnRef)> {
        pairs
            .iter()
            .map(|(name, column)| ((*name).to_owned(), column.parse().unwrap()))
            .collect()
    }

    fn open(text: impl AsRef<[u8]>, pairs: &[(&str, &str)]) -> Result<LogReader, LogError> {
        let bytes = Cursor::new(text.as_ref().to_vec());
        LogReader::from_reader("log.csv", bytes, &channels(pairs), LogOptions::default())
    }

    /// The row number, line and values of each row.
    type Rows = Vec<(u64, u64, Vec<f64>)>;

    /// The rows up to the end or the first error, and the reader after it.
    fn drain(mut log: LogReader) -> (Rows, LogReader, Option<LogError>) {
        let mut rows = Vec::new();
        loop {
            match log.next_row() {
                Ok(Some(row)) => rows.push((row.row, row.line, row.values.to_vec())),
                Ok(None) => return (rows, log, None),
                Err(error) => return (rows, log, Some(error)),
            }
        }
    }

    fn rows(text: impl AsRef<[u8]>, pairs: &[(&str, &str)]) -> Rows {
        let (rows, _, error) = drain(open(text, pairs).unwrap());
        assert!(error.is_none(), "{error:?}");
        rows
    }

    fn values(rows: Rows) -> Vec<f64> {
        rows.into_iter().flat_map(|(_, _, values)| values).collect()
    }

    /// The message of the error that the log gives, at opening or while it is read.
    fn refusal(text: impl AsRef<[u8]>, pairs: &[(&str, &str)]) -> String {
        match open(text, pairs) {
            Err(error) => error.to_string(),
            Ok(log) => drain(log)
                .2
                .expect("the log was read without an error")
                .to_string(),
        }
    }

    #[test]
    fn values_come_in_the_order_of_the_channels_with_their_row_and_line() {
        let log = "time,voltage,speed,current\n0,24,100,3\n1,25,101,4\n";
        assert_eq!(
            rows(log, &THREE),
            [
                (0, 2, vec![100.0, 3.0, 24.0]),
                (1, 3, vec![101.0, 4.0, 25.0])
            ]
        );
    }

    #[test]
    fn comma_semicolon_and_tab_are_told_apart() {
        for delimiter in [",", ";", "\t"] {
            let log = "speed,current,voltage\n1,2,3\n4,5,6\n".replace(',', delimiter);
            assert_eq!(rows(&log, &THREE)[1].2, [4.0, 5.0, 6.0], "{delimiter:?}");
        }
        // Commas inside quotes, and in the text of an ignored column, do not count.
        let log = "\"time, s\";speed;note\n0;1;a,b,c\n1;2;\"d;e\"\n";
        assert_eq!(rows(log, &[("speed", "speed")])[1].2, [2.0]);
        // One damaged row among the first does not hide the delimiter.
        let log = "speed;current;voltage\n1;2\n4;5;6\n";
        assert!(refusal(log, &THREE).contains("has 2 fields where the first line has 3"));
    }

    #[test]
    fn a_delimiter_that_is_given_is_not_searched_for() {
        let bytes = "speed|a,b\n1|2,3\n".as_bytes();
        let options = LogOptions {
            delimiter: Some("|".parse().unwrap()),
        };
        let log = LogReader::from_reader("x", bytes, &channels(&[("speed", "speed")]), options);
        assert_eq!(drain(log.unwrap()).0, [(0, 2, vec![1.0])]);
        assert_eq!("tab".parse::<Delimiter>().unwrap().to_string(), "tab");
        for text in ["", "1", "a", "\"", ".", "-", "\n", ",,", "é"] {
            assert!(text.parse::<Delimiter>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn byte_order_mark_carriage_returns_quotes_blank_lines_and_spaces_change_no_value() {
        let log =
            b"\xEF\xBB\xBF\"speed\", current ,voltage\r\n\r\n\"1\", 2 ,3\r\n\n   \r\n4,5,\"6\"\r\n";
        assert_eq!(
            rows(log, &THREE),
            [(0, 3, vec![1.0, 2.0, 3.0]), (1, 6, vec![4.0, 5.0, 6.0])]
        );
    }

    #[test]
    fn a_header_may_have_line_ends_in_its_quotes_and_lines_are_still_counted_from_the_file() {
        let log = "\"speed\n(rad/s)\",current\n1,2\n";
        assert_eq!(rows(log, &[("current", "current")]), [(0, 3, vec![2.0])]);
    }

    #[test]
    fn missing_and_non_finite_values_are_read_as_such() {
        let log = "speed,current\n,NA\nnan,n/a\n-inf,NULL\n1e-3,.5\n";
        let values = values(rows(log, &[("speed", "speed"), ("current", "current")]));
        assert!(values[..4].iter().all(|value| value.is_nan()) && values[5].is_nan());
        assert_eq!(values[4], f64::NEG_INFINITY);
        assert_eq!(values[6..], [1e-3, 0.5]);
    }

    #[test]
    fn a_log_without_a_header_is_read_by_column_numbers_from_its_first_row() {
        let by_number = [("speed", "3"), ("current", "2")];
        assert_eq!(
            rows("0,1,2\n3,4,5\n", &by_number)[0],
            (0, 1, vec![2.0, 1.0])
        );
        // A time stamp is text in both rows and makes no header.
        let log = "2020-03-09;1;2\n2020-03-10;4;5\n";
        assert_eq!(rows(log, &by_number)[0], (0, 1, vec![2.0, 1.0]));
        let mut log = open("0,1,2\n", &by_number).unwrap();
        assert!(!log.has_header() && log.columns() == ["column 1", "column 2", "column 3"]);
        assert!(log.next_row().unwrap().is_some());
    }

    #[test]
    fn digits_mean_the_number_of_a_column_unless_a_header_has_that_very_name() {
        let log = "time,1,0\n7,8,9\n";
        assert_eq!(
            rows(log, &[("speed", "1"), ("current", "3")])[0],
            (0, 2, vec![8.0, 9.0])
        );
        // The only text of this header is in a column that is not chosen.
        let log = "time,0,2\n7,8,9\n";
        assert_eq!(
            rows(log, &[("speed", "0"), ("current", "2")])[0],
            (0, 2, vec![8.0, 9.0])
        );
    }

    #[test]
    fn names_asked_of_a_log_without_a_header_are_refused_with_the_numbers() {
        assert_eq!(
            refusal("1,2\n3,4\n", &[("speed", "velocity")]),
            "the log has no header, so the column `velocity` for the speed cannot be found by name; \
             give its number from 1 to 2"
        );
    }

    #[test]
    fn a_header_of_numbers_and_names_is_found_by_its_names() {
        let log = "t,0.5,1.5\nx,2,3\n";
        assert_eq!(
            rows(log, &[("speed", "1.5"), ("current", "0.5")])[0],
            (0, 2, vec![3.0, 2.0])
        );
    }

    #[test]
    fn text_in_a_column_chosen_by_number_is_its_header_even_over_a_damaged_first_row() {
        let message = refusal("speed,7\nstop,2\n", &[("speed", "1")]);
        assert!(
            message.starts_with("row 0 (line 2): `stop` in column `speed`"),
            "{message}"
        );
    }

    #[test]
    fn an_unknown_column_is_told_with_the_nearest_name_and_all_columns() {
        assert_eq!(
            refusal("time,Speed,current\n0,1,2\n", &[("speed", "speed")]),
            "the log has no column `speed` for the speed (did you mean `Speed`?); \
             its columns are `time`, `Speed`, `current`"
        );
        assert!(!refusal("a,b\n1,2\n", &[("speed", "velocity")]).contains("did you mean"));
        // A first row of text alone is a header, also over a damaged first row.
        let message = refusal("speed,note\nstop,x\n", &[("speed", "velocity")]);
        assert!(
            message.ends_with("its columns are `speed`, `note`"),
            "{message}"
        );
        let wide = format!("{}z\n1\n", "a,".repeat(99));
        assert!(refusal(wide, &[("speed", "velocity")]).ends_with("`a` and 60 more"));
    }

    #[test]
    fn a_column_number_out_of_range_is_refused_with_the_count() {
        for number in ["0", "3", "99999999999999999999999"] {
            let message = refusal("a,b\n1,2\n", &[("speed", number)]);
            assert_eq!(
                message,
                format!(
                    "the log has no column number {number} for the speed; its 2 columns count from 1: `a`, `b`"
                )
            );
        }
    }

    #[test]
    fn a_column_for_two_channels_or_a_name_that_stands_twice_is_refused() {
        let same = refusal("a,b\n1,2\n", &[("speed", "a"), ("current", "1")]);
        assert!(
            same.starts_with("the speed and the current both read column `1`"),
            "{same}"
        );
        assert_eq!(
            refusal("a,b,a\n1,2,3\n", &[("speed", "a")]),
            "the log has the column `a` for the speed more than once; give its number: 1 or 3"
        );
    }

    #[test]
    fn text_in_ignored_columns_of_whatever_encoding_is_ignored() {
        let log = b"Temp \xB0C,speed,note\n1,2,\xFF\xFE\nx,3,\xC3\n";
        assert_eq!(values(rows(log, &[("speed", "speed")])), [2.0, 3.0]);
        assert_eq!(
            open(log, &[("speed", "speed")]).unwrap().columns()[0],
            "Temp °C"
        );
    }

    #[test]
    fn text_in_a_chosen_column_is_an_error_with_row_line_column_and_text() {
        assert_eq!(
            refusal("time,speed\n0,1\n\n1,stop\n2,3\n", &[("speed", "speed")]),
            "row 1 (line 4): `stop` in column `speed` is not a number; \
             correct it, empty it, or choose another column"
        );
        let long = format!("speed,b\n1,2\n{},2\n", "é".repeat(1000));
        assert!(refusal(long, &[("speed", "speed")]).contains(&format!("`{}…`", "é".repeat(40))));
    }

    #[test]
    fn a_decimal_comma_is_told_as_such() {
        let expected = "row 0 (line 2): `1,5` in column `speed` has a decimal comma; \
                        export the log with decimal points";
        assert_eq!(
            refusal("speed;current\n1,5;2,5\n", &[("speed", "speed")]),
            expected
        );
        // And also where there is no header, and commas divide the rows as evenly as semicolons.
        let message = refusal("1,5;2,5\n1,5;2,5\n", &[("speed", "1")]);
        assert!(
            message.starts_with("row 0 (line 1): `1,5` in column `column 1`"),
            "{message}"
        );
    }

    #[test]
    fn a_row_with_other_fields_than_the_first_line_is_an_error_with_both_counts() {
        for (log, row, found) in [
            ("a,b,c\n1,2,3\n4,5\n6,7,8", 1, 2),
            ("a,b,c\n1,2,3,4\n", 0, 4),
        ] {
            assert_eq!(
                refusal(log, &[("speed", "a")]),
                format!(
                    "row {row} (line {}) has {found} fields where the first line has 3; \
                     repair or remove that line",
                    row + 2
                )
            );
        }
    }

    #[test]
    fn a_log_that_breaks_off_in_its_last_row_is_read_up_to_there_and_says_where() {
        for tail in ["4,5", "4,", "4", "4,5,-", "4,5,6e", "\"4,5", "\0\0\0\0"] {
            let text = format!("speed,current,voltage\r\n1,2,3\r\n\r\n{tail}");
            let (rows, log, error) = drain(open(text, &THREE).unwrap());
            assert!(error.is_none(), "{tail}: {error:?}");
            assert_eq!(rows, [(0, 2, vec![1.0, 2.0, 3.0])], "{tail}");
            assert_eq!(
                log.truncated_tail(),
                Some(TruncatedTail { row: 1, line: 4 }),
                "{tail}"
            );
            assert!(log.ends_without_newline());
        }
    }

    #[test]
    fn the_same_row_with_a_line_end_after_it_is_an_error() {
        for tail in ["4,5\n", "4,5,-\n", "\0\n", "4,5\n\n", "4,5\n   "] {
            let text = format!("speed,current,voltage\n1,2,3\n{tail}");
            let (_, log, error) = drain(open(text, &THREE).unwrap());
            assert!(
                error.is_some() && log.truncated_tail().is_none(),
                "{tail:?}"
            );
        }
    }

    #[test]
    fn a_whole_last_row_without_a_line_end_is_read_and_told() {
        let (rows, log, _) = drain(open("speed,b\n1,2\n3,4", &[("speed", "speed")]).unwrap());
        assert_eq!(values(rows), [1.0, 3.0]);
        assert!(log.ends_without_newline() && log.truncated_tail().is_none());
        let (_, log, _) = drain(open("speed,b\n1,2\n3,4\n", &[("speed", "speed")]).unwrap());
        assert!(!log.ends_without_newline());
    }

    #[test]
    fn a_short_log_that_breaks_off_still_shows_its_delimiter() {
        let log = "speed;a,b,c;d\n1;1,2,3;4\n2;1,2";
        assert_eq!(values(rows(log, &[("speed", "speed")])), [1.0]);
    }

    #[test]
    fn a_log_that_grows_while_it_is_read_ends_where_its_end_was_met() {
        struct Growing(Vec<&'static str>);
        impl Read for Growing {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                self.0.pop().unwrap_or_default().as_bytes().read(buffer)
            }
        }
        let input = Growing(vec!["3\n4,5\n", "", "", "a,b\n1,2"]);
        let channels = channels(&[("x", "a")]);
        let log = LogReader::from_reader("log.csv", input, &channels, LogOptions::default());
        let (rows, _, error) = drain(log.unwrap());
        assert_eq!(values(rows), [1.0]);
        assert!(error.is_none(), "{error:?}");
    }

    #[test]
    fn after_the_end_and_after_an_error_there_are_no_more_rows() {
        let (_, mut log, error) = drain(open("a,b\n1,2\n3\n4,5\n", &[("x", "a")]).unwrap());
        assert!(error.is_some());
        assert_eq!(log.next_row().unwrap(), None);
    }

    #[test]
    fn empty_logs_and_logs_of_a_header_only_are_refused() {
        for text in ["", "\n\n", "  \r\n", "\u{feff}"] {
            assert!(
                refusal(text, &[("x", "1")]).contains("is empty"),
                "{text:?}"
            );
        }
        for text in ["a,b", "a,b\n", "a,b\r\n\r\n"] {
            assert!(
                refusal(text, &[("x", "a")]).contains("no data row"),
                "{text:?}"
            );
        }
    }

    #[test]
    fn a_file_with_nul_bytes_is_refused_as_no_text() {
        assert_eq!(
            refusal("a,b\n1,2\n1,\0\n", &[("x", "a")]),
            "the log `log.csv` is not a text file (NUL byte in line 3); export it as CSV in UTF-8"
        );
        let utf16 = b"\xFF\xFEa\0,\0b\0\n\0";
        assert!(refusal(utf16, &[("x", "a")]).contains("not a text file"));
    }

    #[test]
    fn a_forgotten_quote_is_an_error_and_swallows_no_rows() {
        let log = "a,b\n1,x\n2,\"y\n3,z\n4,\"w\"\n5,v\n";
        assert_eq!(
            refusal(log, &[("x", "a")]),
            "row 1 (line 3) has a quoted field that runs over the line end; \
             close the quote or remove the line break"
        );
    }

    #[test]
    fn a_row_without_end_stops_at_a_mebibyte_and_not_at_the_end_of_the_log() {
        let input = "a,b\n1,\"".as_bytes().chain(io::repeat(b'x'));
        let log = LogReader::from_reader(
            "log.csv",
            input,
            &channels(&[("x", "a")]),
            LogOptions::default(),
        );
        let (_, log, error) = drain(log.unwrap());
        assert!(
            matches!(error, Some(LogError::RowTooLong { line: 2, .. })),
            "{error:?}"
        );
        assert!(log.bytes_read() < 2 * MAX_ROW_BYTES);
    }

    #[test]
    fn a_read_error_in_the_middle_is_told_after_the_rows_before_it() {
        struct Broken;
        impl Read for Broken {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::Error::other("bad sector"))
            }
        }
        let good = format!("a,b\n{}", "1,2\n".repeat(HEAD_BYTES / 4));
        let input = Cursor::new(good).chain(Broken);
        let log = LogReader::from_reader(
            "log.csv",
            input,
            &channels(&[("x", "a")]),
            LogOptions::default(),
        );
        let (rows, _, error) = drain(log.unwrap());
        assert_eq!(rows.len(), HEAD_BYTES / 4);
        let message = error.unwrap().to_string();
        assert!(
            message.contains("near line 16386 (bad sector)"),
            "{message}"
        );
    }

    #[test]
    fn paths_that_are_no_log_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let open = |path: &Path| {
            LogReader::open(path, &channels(&[("x", "a")]), LogOptions::default()).unwrap_err()
        };
        assert!(matches!(open(folder.path()), LogError::IsADirectory { .. }));
        assert!(matches!(
            open(&folder.path().join("none.csv")),
            LogError::NotFound { .. }
        ));
        let denied = open_error("x".to_owned(), ErrorKind::PermissionDenied.into());
        assert!(matches!(denied, LogError::NotReadable { .. }));
    }

    #[test]
    fn a_log_of_mebibytes_is_read_whole_and_the_bytes_read_grow_up_to_its_length() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let text = format!("a,b\n{}", "1,2\n".repeat(500_000));
        std::fs::write(&path, &text).unwrap();
        let mut log =
            LogReader::open(&path, &channels(&[("x", "a")]), LogOptions::default()).unwrap();
        assert_eq!(log.total_bytes(), Some(text.len() as u64));
        log.next_row().unwrap();
        assert!(log.bytes_read() <= 128 * 1024);
        let (rows, log, _) = drain(log);
        assert_eq!((rows.len(), log.bytes_read()), (499_999, text.len() as u64));
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic_or_run_on(
            bytes in proptest::collection::vec(
                prop_oneof![any::<u8>(), proptest::sample::select(b"\n\r,;\"\t01a.\0 ".to_vec())], 0..400),
            column in "[a1-3]",
        ) {
            let length = bytes.len();
            if let Ok(log) = open(bytes, &[("x", column.as_str())]) {
                let (rows, log, _) = drain(log);
                prop_assert!(rows.len() <= length);
                prop_assert!(log.bytes_read() <= length as u64);
            }
        }

        #[test]
        fn a_damaged_log_gives_an_error_or_rows_with_rising_numbers_and_lines(
            rows in 1_usize..40, damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes = b"time,speed,current,voltage\r\n".to_vec();
            for row in 0..rows {
                bytes.extend(format!("{row},\"{row}.5\",-2e-3,24\r\n").bytes());
            }
            for (place, byte) in damage {
                let place = place.index(bytes.len());
                bytes[place] = byte;
            }
            bytes.truncate(cut.index(bytes.len()) + 1);
            if let Ok(log) = open(&bytes, &THREE) {
                let (rows, _, _) = drain(log);
                for (expected, (row, ..)) in (0..).zip(&rows) {
                    prop_assert_eq!(*row, expected);
                }
                prop_assert!(rows.windows(2).all(|pair| pair[0].1 < pair[1].1));
            }
        }

        #[test]
        fn a_log_cut_anywhere_gives_its_whole_rows_and_never_an_error(cut in 0_usize..89) {
            let text = "speed,current,voltage\n".to_owned() + &"10.25,2.5,24.0\n".repeat(6);
            // Cut in or right after the first row at the earliest, before any row there is a refusal.
            let kept = &text[..text.len() - 1 - cut];
            let (rows, log, error) = drain(open(kept, &THREE).unwrap());
            prop_assert!(error.is_none(), "{:?}", error);
            let whole = kept.matches('\n').count() - 1;
            prop_assert!(rows.len() == whole || rows.len() == whole + 1);
            prop_assert_eq!(log.truncated_tail().is_some(), rows.len() == whole && !kept.ends_with('\n'));
        }
    }

    /// Reads `text` over and over, `times` times, holding it once.
    struct Again {
        text: Vec<u8>,
        at: usize,
        times: usize,
    }

    impl Read for Again {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            if self.at == self.text.len() {
                self.at = 0;
                self.times -= 1;
            }
            if self.times == 0 {
                return Ok(0);
            }
            let count = (&self.text[self.at..]).read(buffer)?;
            self.at += count;
            Ok(count)
        }
    }

    /// A measurement: `cargo test --release -p monitor-sim --lib -- --ignored --nocapture million_rows`
    #[test]
    #[ignore = "measures wall time, which a busy machine spoils"]
    fn a_log_of_twelve_columns_is_read_at_more_than_a_million_rows_a_second() {
        const ROWS: usize = 10_000;
        const TIMES: usize = 1000;
        let mut text = Vec::new();
        for row in 0..ROWS {
            let x = row as f64;
            text.extend(
                format!(
                    "{row},{:.1},{:.2},{:.3},283.0,53.3,0.0,{:.3},0.946,319.0,{:.2},Layer 1 Up\n",
                    277.0 + x,
                    53.3 + x.sin(),
                    x.cos(),
                    20.0 + x.sin(),
                    118.0 + x.cos(),
                )
                .bytes(),
            );
        }
        let input = Again {
            text,
            at: 0,
            times: TIMES,
        };
        let columns = channels(&[("speed", "3"), ("current", "8"), ("voltage", "11")]);
        let begin = Instant::now();
        let mut log =
            LogReader::from_reader("log.csv", input, &columns, LogOptions::default()).unwrap();
        let mut rows = 0_usize;
        while log.next_row().unwrap().is_some() {
            rows += 1;
        }
        let seconds = begin.elapsed().as_secs_f64();
        let rate = rows as f64 / seconds;
        println!(
            "{rows} rows, {} bytes in {seconds:.2} s: {rate:.3e} rows/s",
            log.bytes_read()
        );
        assert_eq!(rows, ROWS * TIMES);
        assert!(rate > 1e6, "{rate}");
    }
}
