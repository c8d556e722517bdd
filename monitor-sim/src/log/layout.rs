//! How a log is written: found out from its first bytes.

use std::fmt;
use std::io::{self, ErrorKind, Read};

use csv::ByteRecord;

use super::{ColumnRef, Delimiter, LogError};
use crate::inject::nearest_name;

/// The first bytes of the log, kept to find its delimiter and header.
pub(super) const HEAD_BYTES: usize = 64 * 1024;
/// The rows of the head that are looked at.
const HEAD_ROWS: usize = 16;
/// A row longer than this is no row of numbers but a forgotten quote or another kind of file;
/// it would otherwise grow to the size of the log.
pub(super) const MAX_ROW_BYTES: u64 = 1024 * 1024;

/// The bytes of the log on their way to the csv reader.
pub(super) struct Source {
    pub(super) input: Box<dyn Read + Send>,
    /// The first bytes, read beforehand.
    pub(super) head: Vec<u8>,
    pub(super) handed_out: u64,
    /// Where the row that is being read begins.
    pub(super) row_begin: u64,
    pub(super) row_too_long: bool,
    pub(super) at_end: bool,
}

impl Source {
    pub(super) fn new(mut input: Box<dyn Read + Send>) -> io::Result<Self> {
        let mut head = Vec::new();
        input.by_ref().take(HEAD_BYTES as u64).read_to_end(&mut head)?;
        Ok(Self { input, head, handed_out: 0, row_begin: 0, row_too_long: false, at_end: false })
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Source").field("handed_out", &self.handed_out).finish_non_exhaustive()
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
        let head_rest = usize::try_from(self.handed_out).ok().and_then(|at| self.head.get(at..));
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
pub(super) fn csv_format(delimiter: u8) -> csv::ReaderBuilder {
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

pub(super) fn is_blank(record: &ByteRecord) -> bool {
    record.len() <= 1 && record.as_slice().trim_ascii().is_empty()
}

pub(super) fn line_ends(record: &ByteRecord) -> u64 {
    record.as_slice().iter().filter(|byte| **byte == b'\n').count() as u64
}

/// The text of a field: UTF-8, or else Latin-1, in which any byte is a character.
pub(crate) fn decode(field: &[u8]) -> String {
    let field = field.trim_ascii();
    match std::str::from_utf8(field) {
        Ok(text) => text.to_owned(),
        Err(_) => field.iter().copied().map(char::from).collect(),
    }
}

/// The number in a field; NaN if it says that there is none; `None` for any other text.
pub(crate) fn parse_value(field: &[u8]) -> Option<f64> {
    let field = field.trim_ascii();
    if let Some(number) = std::str::from_utf8(field).ok().and_then(|text| text.parse().ok()) {
        return Some(number);
    }
    let missing: [&[u8]; 4] = [b"", b"na", b"n/a", b"null"];
    missing.iter().any(|word| field.eq_ignore_ascii_case(word)).then_some(f64::NAN)
}

pub(super) fn has_decimal_comma(field: &[u8]) -> bool {
    let comma = |byte: &&u8| **byte == b',';
    field.iter().filter(comma).count() == 1
        && std::str::from_utf8(field.trim_ascii()).is_ok_and(|text| text.replace(',', ".").parse::<f64>().is_ok())
}

/// How the log is written, from its first rows.
pub(super) struct Layout {
    pub(super) delimiter: u8,
    pub(super) first: ByteRecord,
    pub(super) second: Option<ByteRecord>,
    /// Whether the head is the whole file.
    pub(super) is_whole: bool,
}

impl Layout {
    pub(super) fn find(path: &str, head: &[u8], delimiter: Option<Delimiter>) -> Result<Self, LogError> {
        let is_whole = head.len() < HEAD_BYTES;
        let delimiter = match delimiter {
            Some(Delimiter(byte)) => byte,
            None => sniff_delimiter(head),
        };
        let mut records = head_records(head, delimiter).into_iter();
        let first = records.next().ok_or_else(|| LogError::Empty { path: path.to_owned() })?;
        if first.as_slice().contains(&0) {
            return Err(LogError::NotText { path: path.to_owned(), line: 1 });
        }
        Ok(Self { delimiter, first, second: records.next(), is_whole })
    }
}

/// The first records of the head that are not blank.
pub(super) fn head_records(head: &[u8], delimiter: u8) -> Vec<ByteRecord> {
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
pub(crate) fn sniff_delimiter(head: &[u8]) -> u8 {
    const CANDIDATES: [u8; 3] = [b'\t', b';', b','];
    let counts = CANDIDATES.map(|delimiter| {
        let mut counts: Vec<usize> = head_records(head, delimiter).iter().map(ByteRecord::len).collect();
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
pub(super) struct Selection {
    pub(super) has_header: bool,
    pub(super) columns: Vec<String>,
    pub(super) indices: Vec<usize>,
}

impl Selection {
    pub(super) fn find(layout: &Layout, channels: &[(String, ColumnRef)]) -> Result<Self, LogError> {
        let names: Vec<String> = layout.first.iter().map(decode).collect();
        let has_header = has_header(layout, &names, channels)?;
        let columns =
            if has_header { names } else { (1..=names.len()).map(|number| format!("column {number}")).collect() };
        let indices = find_columns(channels, &columns, has_header)?;
        Ok(Self { has_header, columns, indices })
    }
}

/// The place of each channel's column.
pub(super) fn find_columns(
    channels: &[(String, ColumnRef)],
    columns: &[String],
    has_header: bool,
) -> Result<Vec<usize>, LogError> {
    let mut indices: Vec<usize> = Vec::with_capacity(channels.len());
    for (channel, column) in channels {
        let index = find_column(channel, column, columns, has_header)?;
        let same = channels.iter().zip(&indices).find(|(_, taken)| **taken == index);
        if let Some(((first, _), _)) = same {
            return Err(LogError::SameColumn {
                first: first.clone(),
                second: channel.clone(),
                column: column.to_string(),
            });
        }
        indices.push(index);
    }
    Ok(indices)
}

/// Whether the first row is a header.
///
/// It is one if a column has text there and a number in the next row, if a column asked for by
/// name is in it, or if a column asked for by number has text there. A time stamp alone, text in
/// both rows, makes no header.
pub(super) fn has_header(
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
    let mut by_name = channels.iter().filter(|(_, column)| !column.is_number()).peekable();
    if by_name.peek().is_some() {
        return match by_name.find(|(_, column)| !names.contains(&column.0)) {
            None => Ok(true),
            Some((channel, column)) => {
                Err(LogError::NoHeader { channel: channel.clone(), column: column.to_string(), columns: names.len() })
            }
        };
    }
    Ok(channels.iter().any(|(_, column)| {
        let index = column.number_index(names.len());
        index.and_then(|index| layout.first.get(index)).is_some_and(is_text)
    }))
}

pub(crate) fn find_column(
    channel: &str,
    column: &ColumnRef,
    columns: &[String],
    has_header: bool,
) -> Result<usize, LogError> {
    let named: Vec<usize> = if has_header {
        (0..).zip(columns).filter(|(_, name)| **name == column.0).map(|(index, _)| index).collect()
    } else {
        Vec::new()
    };
    match named.as_slice() {
        [index] => Ok(*index),
        [] if column.is_number() => column.number_index(columns.len()).ok_or_else(|| LogError::ColumnOutOfRange {
            channel: channel.to_owned(),
            column: column.to_string(),
            columns: columns.to_vec(),
        }),
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
