//! Reads chosen columns of a log in Parquet, one row at a time.
//!
//! It holds some thousand rows, and of each column the page that they are from: how large that is, the writer of the file
//! has decided. Every column of numbers can be read: integers, decimals, single and double precision. A null is a missing
//! value, as an empty field of a text is.

use std::fmt;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::error::open_error;
use super::layout::find_columns;
use super::{ColumnRef, LogError, Row};

/// Rows that are decoded at once.
const BATCH: usize = 4096;

/// A log in Parquet.
pub struct ParquetLog {
    path: String,
    file: SerializedFileReader<File>,
    total_bytes: u64,
    total_rows: u64,
    selected: Vec<Selected>,
    /// Row groups begun.
    groups_begun: usize,
    /// Rows of the batch, and how many of them were handed out.
    batch: usize,
    at: usize,
    values: Vec<f64>,
    rows_read: u64,
    failed: bool,
}

/// A column that is read.
struct Selected {
    column: usize,
    number: Number,
    reader: Option<ColumnReader>,
    batch: Vec<f64>,
}

/// How a column holds its numbers.
#[derive(Clone, Copy, Debug)]
struct Number {
    /// Level at which a value is there.
    level: i16,
    unsigned: bool,
    /// What a decimal's digits are multiplied by.
    unit: f64,
}

impl fmt::Debug for ParquetLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ParquetLog")
            .field("path", &self.path)
            .field("rows_read", &self.rows_read)
            .finish_non_exhaustive()
    }
}

impl ParquetLog {
    /// Opens the log `path`, as [`LogReader::open`](super::LogReader::open) does one of text.
    ///
    /// # Errors
    /// A [`LogError`] if the file cannot be read, holds no row, or has not the columns asked for.
    pub fn open(path: &Path, channels: &[(String, ColumnRef)]) -> Result<Self, LogError> {
        let name = path.display().to_string();
        let file = File::open(path).map_err(|cause| open_error(name.clone(), cause))?;
        let total_bytes = file.metadata().map(|data| data.len()).unwrap_or(0);
        let file = guarded(&name, || SerializedFileReader::new(file))?;
        if !lies_inside(file.metadata(), total_bytes) {
            return Err(LogError::Parquet { path: name, cause: "its columns lie outside of it".to_owned() });
        }
        let schema = file.metadata().file_metadata().schema_descr_ptr();
        let columns: Vec<String> = schema.columns().iter().map(|column| column.path().parts().join(".")).collect();
        let number = |index: usize| {
            let (column, name) = (schema.column(index), columns.get(index).cloned().unwrap_or_default());
            let number =
                Number::of(&column).ok_or_else(|| LogError::NotNumbers { column: name, kind: kind(&column) })?;
            Ok(Selected { column: index, number, reader: None, batch: Vec::new() })
        };
        let indices = find_columns(channels, &columns, true)?;
        let selected: Vec<Selected> = indices.into_iter().map(number).collect::<Result<_, LogError>>()?;
        let total_rows = u64::try_from(file.metadata().file_metadata().num_rows()).unwrap_or(0);
        if total_rows == 0 {
            return Err(LogError::HeaderOnly { path: name });
        }
        Ok(ParquetLog {
            path: name,
            file,
            total_bytes,
            total_rows,
            values: vec![f64::NAN; selected.len()],
            selected,
            groups_begun: 0,
            batch: 0,
            at: 0,
            rows_read: 0,
            failed: false,
        })
    }

    /// The next row, or `None` at the end of the log and after an error. Its line is that of a text with one header line.
    ///
    /// # Errors
    /// [`LogError::Parquet`] when the file is damaged.
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>, LogError> {
        if self.failed || (self.at == self.batch && !self.fill()?) {
            return Ok(None);
        }
        for (value, selected) in self.values.iter_mut().zip(&self.selected) {
            *value = selected.batch.get(self.at).copied().unwrap_or(f64::NAN);
        }
        let row = self.rows_read;
        self.at += 1;
        self.rows_read += 1;
        Ok(Some(Row { row, line: row + 2, values: &self.values }))
    }

    /// The bytes that the rows read so far take, if all rows take the same.
    pub fn bytes_read(&self) -> u64 {
        let share = self.rows_read as f64 / self.total_rows.max(1) as f64;
        (share * self.total_bytes as f64) as u64
    }

    /// Decodes the next batch; false at the end of the log.
    fn fill(&mut self) -> Result<bool, LogError> {
        let path = self.path.clone();
        let filled = guarded(&path, || self.next_batch());
        self.failed = filled.is_err();
        filled
    }

    fn next_batch(&mut self) -> Result<bool, ParquetError> {
        loop {
            let mut rows = None;
            for selected in &mut self.selected {
                let read = selected.read()?;
                if rows.is_some_and(|rows| rows != read) {
                    return Err(ParquetError::General("its columns have different numbers of rows".to_owned()));
                }
                rows = Some(read);
            }
            (self.at, self.batch) = (0, rows.unwrap_or(0));
            if self.batch > 0 {
                return Ok(true);
            }
            if self.groups_begun == self.file.num_row_groups() {
                return Ok(false);
            }
            let group = self.file.get_row_group(self.groups_begun)?;
            for selected in &mut self.selected {
                selected.reader = Some(group.get_column_reader(selected.column)?);
            }
            self.groups_begun += 1;
        }
    }
}

impl Number {
    /// How a column holds its numbers; none if it holds something else, or lists.
    fn of(column: &ColumnDescriptor) -> Option<Self> {
        let kept =
            matches!(column.physical_type(), Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE);
        let is_decimal = column.converted_type() == ConvertedType::DECIMAL
            || matches!(column.logical_type_ref(), Some(LogicalType::Decimal(_)));
        let unsigned = matches!(column.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64)
            || matches!(column.logical_type_ref(), Some(LogicalType::Integer(integer)) if !integer.is_signed);
        (kept && column.max_rep_level() == 0).then(|| Number {
            level: column.max_def_level(),
            unsigned,
            unit: if is_decimal { 10_f64.powi(-column.type_scale()) } else { 1.0 },
        })
    }

    fn of_i32(self, value: i32) -> f64 {
        if self.unsigned { f64::from(value.cast_unsigned()) } else { f64::from(value) * self.unit }
    }

    fn of_i64(self, value: i64) -> f64 {
        if self.unsigned { value.cast_unsigned() as f64 } else { value as f64 * self.unit }
    }
}

impl Selected {
    /// Decodes the next rows of the row group into `batch`; returns how many.
    fn read(&mut self) -> Result<usize, ParquetError> {
        self.batch.clear();
        let (batch, number) = (&mut self.batch, self.number);
        match &mut self.reader {
            None => Ok(0),
            Some(ColumnReader::DoubleColumnReader(reader)) => read::<DoubleType>(reader, number, batch, |value| *value),
            Some(ColumnReader::FloatColumnReader(reader)) => {
                read::<FloatType>(reader, number, batch, |value| f64::from(*value))
            }
            Some(ColumnReader::Int32ColumnReader(reader)) => {
                read::<Int32Type>(reader, number, batch, |value| number.of_i32(*value))
            }
            Some(ColumnReader::Int64ColumnReader(reader)) => {
                read::<Int64Type>(reader, number, batch, |value| number.of_i64(*value))
            }
            Some(ColumnReader::BoolColumnReader(reader)) => {
                read::<BoolType>(reader, number, batch, |value| f64::from(u8::from(*value)))
            }
            Some(_) => Err(ParquetError::General("a column is not what the schema says".to_owned())),
        }
    }
}

fn read<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    number: Number,
    batch: &mut Vec<f64>,
    value: impl Fn(&T::T) -> f64,
) -> Result<usize, ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let (rows, ..) = reader.read_records(BATCH, Some(&mut levels), None, &mut values)?;
    let mut values = values.iter().map(value);
    if number.level == 0 {
        batch.extend(values);
    } else {
        batch.extend(
            levels
                .iter()
                .map(|level| if *level == number.level { values.next() } else { None })
                .map(|value| value.unwrap_or(f64::NAN)),
        );
    }
    Ok(rows)
}

/// Whether every column lies inside the file: the Parquet crate panics over one that does not.
fn lies_inside(metadata: &ParquetMetaData, bytes: u64) -> bool {
    let chunk_lies_inside = |chunk: &ColumnChunkMetaData| {
        let start = chunk.dictionary_page_offset().unwrap_or_else(|| chunk.data_page_offset());
        let ends = u64::try_from(start).ok().zip(u64::try_from(chunk.compressed_size()).ok());
        ends.and_then(|(start, length)| start.checked_add(length)).is_some_and(|end| end <= bytes)
    };
    metadata.row_groups().iter().flat_map(RowGroupMetaData::columns).all(chunk_lies_inside)
}

/// What a column holds, in Parquet's words.
fn kind(column: &ColumnDescriptor) -> String {
    let lists = if column.max_rep_level() > 0 { "lists of " } else { "" };
    format!("{lists}{}", column.physical_type())
}

/// Runs code of the Parquet crate: what it cannot read is an error, and so is what a damaged file makes it panic over (twice
/// in 6,000 files with some bytes changed at random).
fn guarded<T>(path: &str, run: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, LogError> {
    let failed = |cause: String| LogError::Parquet { path: path.to_owned(), cause };
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(done) => done.map_err(|error| failed(error.to_string())),
        Err(_) => Err(failed("its pages are damaged".to_owned())),
    }
}

#[cfg(test)]
mod tests;
