use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use parquet::basic::{Compression, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use tempfile::TempDir;

use super::*;
use crate::log::{Log, LogOptions};

/// Every kind of number, and what is none.
const SCHEMA: &str = "
    message log {
        REQUIRED DOUBLE double;
        OPTIONAL FLOAT single;
        REQUIRED INT32 whole;
        REQUIRED INT64 wide;
        REQUIRED INT32 unsigned (UINT_32);
        REQUIRED INT64 decimal (DECIMAL(9, 2));
        REQUIRED BOOLEAN flag;
        REQUIRED BYTE_ARRAY text (UTF8);
        REQUIRED group list (LIST) { REPEATED group list { OPTIONAL DOUBLE element; } }
    }
";

const GROUP: i32 = 5000;

/// Two row groups of so many rows that each takes more than one batch; every third `single` is null.
fn bytes(compression: Compression) -> Vec<u8> {
    let schema = Arc::new(parse_message_type(SCHEMA).unwrap());
    let properties = WriterProperties::builder().set_compression(compression).build();
    let mut file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties)).unwrap();
    for group in 0..2 {
        let rows = || group * GROUP..(group + 1) * GROUP;
        let mut writer = file.next_row_group().unwrap();
        while let Some(mut column) = writer.next_column().unwrap() {
            let wide: Vec<i64> = rows().map(|k| i64::from(k) * if k % 2 == 0 { 1 } else { -1 }).collect();
            let narrow: Vec<i32> = rows().map(|k| -k).collect();
            let there: Vec<i16> = rows().map(|k| i16::from(k % 3 != 0)).collect();
            match column.untyped() {
                ColumnWriter::DoubleColumnWriter(w) => {
                    let values: Vec<f64> = rows().map(|k| 0.1 * f64::from(k)).collect();
                    let levels = vec![2; values.len()];
                    let lists = vec![0; values.len()];
                    // Levels of the list; a column that has none leaves them be.
                    w.write_batch(&values, Some(&levels), Some(&lists)).unwrap();
                }
                ColumnWriter::FloatColumnWriter(w) => {
                    let values: Vec<f32> = rows().filter(|k| k % 3 != 0).map(|k| k as f32).collect();
                    w.write_batch(&values, Some(&there), None).unwrap();
                }
                ColumnWriter::Int32ColumnWriter(w) => {
                    w.write_batch(&narrow, None, None).unwrap();
                }
                ColumnWriter::Int64ColumnWriter(w) => {
                    w.write_batch(&wide, None, None).unwrap();
                }
                ColumnWriter::BoolColumnWriter(w) => {
                    w.write_batch(&rows().map(|k| k % 2 == 1).collect::<Vec<_>>(), None, None).unwrap();
                }
                ColumnWriter::ByteArrayColumnWriter(w) => {
                    w.write_batch(&rows().map(|_| "healthy".into()).collect::<Vec<_>>(), None, None).unwrap();
                }
                _ => unreachable!(),
            }
            column.close().unwrap();
        }
        writer.close().unwrap();
    }
    file.into_inner().unwrap()
}

fn file(bytes: &[u8]) -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    // The name says nothing: the first bytes do.
    let path = directory.path().join("log.csv");
    std::fs::File::create(&path).unwrap().write_all(bytes).unwrap();
    (directory, path)
}

fn channels(columns: &[&str]) -> Vec<(String, ColumnRef)> {
    columns.iter().map(|column| ((*column).to_owned(), column.parse().unwrap())).collect()
}

fn open(path: &Path, columns: &[&str]) -> Result<Log, LogError> {
    Log::open(path, &channels(columns), LogOptions::default())
}

#[test]
fn every_kind_of_number_reads_as_it_was_written_whatever_the_compression() {
    let (zstd, lz4) = (Compression::ZSTD(ZstdLevel::default()), Compression::LZ4_RAW);
    for compression in
        [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::GZIP(Default::default()), zstd, lz4]
    {
        let (_directory, path) = file(&bytes(compression));
        let mut log = open(&path, &["double", "single", "whole", "4", "unsigned", "decimal", "flag"]).unwrap();
        let mut rows = 0;
        while let Some(Row { row, line, values }) = log.next_row().unwrap() {
            let k = i32::try_from(row).unwrap();
            let odd = f64::from(k % 2);
            let sign = 1.0 - 2.0 * odd;
            let [double, single, whole, wide, unsigned, decimal, flag] = values else { panic!("{values:?}") };
            assert_eq!((row, line), (rows, rows + 2));
            assert_eq!((*double, *whole, *wide), (0.1 * f64::from(k), f64::from(-k), sign * f64::from(k)));
            assert!(if k % 3 == 0 { single.is_nan() } else { *single == f64::from(k) }, "{k} {single}");
            assert_eq!(*unsigned, f64::from((-k).cast_unsigned()));
            assert!((decimal - sign * f64::from(k) / 100.0).abs() < 1e-9 && *flag == odd, "{decimal} {flag}");
            rows += 1;
        }
        assert_eq!(rows, 2 * GROUP as u64);
        assert_eq!(log.bytes_read(), std::fs::metadata(&path).unwrap().len());
        assert!(log.next_row().unwrap().is_none() && !log.ends_without_newline());
    }
}

#[test]
fn columns_that_hold_no_numbers_or_are_not_there_are_told_with_the_remedy() {
    let (_directory, path) = file(&bytes(Compression::SNAPPY));
    for (columns, words) in [
        (["double", "text"], ["`text`", "BYTE_ARRAY"]),
        (["double", "list.list.element"], ["lists of DOUBLE", "another column"]),
        (["double", "singel"], ["`singel`", "`single`"]),
        (["double", "17"], ["17", "count from 1"]),
        (["double", "1"], ["double", "its own"]),
    ] {
        let error = open(&path, &columns).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn no_damage_to_a_file_makes_the_reader_panic_or_read_for_ever() {
    let whole = bytes(Compression::SNAPPY);
    let mut refused = 0;
    for damage in 0..300 {
        let mut bytes = whole.clone();
        if damage % 3 == 0 {
            bytes.truncate(4 + damage * (whole.len() - 4) / 300);
        } else {
            // Half of them in the footer, which the rest is found by.
            let at = if damage % 2 == 0 { damage * whole.len() / 300 } else { whole.len() - 1 - 3 * damage };
            bytes[at] ^= 0x55;
        }
        let (_directory, path) = file(&bytes);
        let Ok(mut log) = open(&path, &["double", "single", "whole"]) else {
            refused += 1;
            continue;
        };
        let mut rows = 0;
        let failed = loop {
            match log.next_row() {
                Ok(Some(_)) => rows += 1,
                Ok(None) => break false,
                Err(_) => break true,
            }
        };
        refused += u32::from(failed);
        assert!(rows <= 2 * GROUP as u64 && log.next_row().unwrap().is_none());
    }
    assert!(refused > 100, "{refused} of 300 damages were noticed");
    let panics = guarded("log.parquet", || -> Result<(), ParquetError> { panic!("as the crate does over some files") });
    assert!(panics.unwrap_err().to_string().contains("`log.parquet` cannot be read (its pages are damaged)"));
}
