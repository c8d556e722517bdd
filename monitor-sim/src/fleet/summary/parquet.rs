//! The summary in Parquet: one row group, a column for each of [`COLUMNS`], null where a value is not known.

use std::path::PathBuf;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::fleet::row::{COLUMNS, Cell, Kind, Row};
use crate::output::{OutputError, PendingFile};

pub(super) fn write(rows: &[Row], mut file: PendingFile) -> Result<PathBuf, OutputError> {
    // The writer takes what it writes to; a borrowed file is still there when it fails.
    match write_to(rows, &mut file) {
        Ok(()) => file.finish(),
        Err(error) => Err(file.failed(std::io::Error::other(error))),
    }
}

fn write_to(rows: &[Row], file: &mut PendingFile) -> Result<(), ParquetError> {
    // Snappy is what every reader of Parquet knows.
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(file, schema()?, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (position, (_, kind)) in COLUMNS.iter().enumerate() {
        let cells = rows.iter().filter_map(|row| row.cells().into_iter().nth(position));
        match kind {
            Kind::Text => column::<ByteArrayType>(
                &mut group,
                cells.map(|cell| match cell {
                    Cell::Text(text) => text.map(|text| ByteArray::from(text.into_bytes())),
                    _ => None,
                }),
            )?,
            Kind::Whole => column::<Int64Type>(
                &mut group,
                cells.map(|cell| if let Cell::Whole(number) = cell { number } else { None }),
            )?,
            Kind::Real => column::<DoubleType>(
                &mut group,
                cells.map(|cell| if let Cell::Real(number) = cell { number } else { None }),
            )?,
        }
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn schema() -> Result<TypePtr, ParquetError> {
    let field = |(name, kind): (&str, Kind)| {
        let (physical, logical) = match kind {
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Kind::Whole => (Physical::INT64, None),
            Kind::Real => (Physical::DOUBLE, None),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        field.with_logical_type(logical).build().map(Arc::new)
    };
    let fields = COLUMNS.into_iter().map(field).collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("summary").with_fields(fields).build()?))
}

fn column<T: DataType>(
    group: &mut SerializedRowGroupWriter<&mut PendingFile>,
    cells: impl Iterator<Item = Option<T::T>>,
) -> Result<(), ParquetError> {
    let cells: Vec<_> = cells.collect();
    let there: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<T::T> = cells.into_iter().flatten().collect();
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("the summary has more columns than its schema".to_owned()));
    };
    column.typed::<T>().write_batch(&values, Some(&there), None)?;
    column.close()
}
