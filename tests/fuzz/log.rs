//! The log reader: any bytes are rows, or an error that says what to do.

use std::io::Cursor;

use bolero::{TypeGenerator, check};
use monitor_sim::log::{LogError, LogOptions, LogReader};

use super::TEST_TIME;

/// What logs are made of. By themselves bytes would hardly ever make a header and a row.
const WORDS: [&str; 24] = [
    "speed", "current", "voltage", "time", ",", ";", "\t", "|", " ", "\n", "\r\n", "\r", "\"", "\"\"", "\u{feff}",
    "nan", "NA", "null", "1.5", "-3e4", "1,5", "1e999", "\0", "µ",
];

#[derive(Clone, Debug, TypeGenerator)]
enum Piece {
    Byte(u8),
    Word(#[generator(0..WORDS.len())] usize),
    Number(i16),
    /// One row of three numbers.
    Row([i8; 3]),
    /// Now and then more than the reader holds at once.
    Run {
        #[generator(0..WORDS.len())]
        word: usize,
        #[generator(0..18_u8)]
        doublings: u8,
    },
}

/// Columns that are asked for, and delimiters.
const COLUMNS: [&str; 7] = ["speed", "current", "voltage", "1", "2", "0", "99999999999999999999999"];
const DELIMITERS: [&str; 4] = [",", ";", "tab", " "];

#[derive(Clone, Debug, TypeGenerator)]
struct Input {
    header: bool,
    pieces: Vec<Piece>,
    #[generator([0..COLUMNS.len(), 0..COLUMNS.len(), 0..COLUMNS.len()])]
    columns: [usize; 3],
    /// Beyond the last one: the reader finds it out.
    #[generator(0..2 * DELIMITERS.len())]
    delimiter: usize,
}

impl Input {
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = if self.header { b"speed,current,voltage\n".to_vec() } else { Vec::new() };
        let mut long = false;
        for piece in &self.pieces {
            match piece {
                Piece::Byte(byte) => bytes.push(*byte),
                Piece::Word(index) => bytes.extend_from_slice(WORDS[*index].as_bytes()),
                Piece::Number(number) => bytes.extend_from_slice(number.to_string().as_bytes()),
                Piece::Row([a, b, c]) => bytes.extend_from_slice(format!("{a},{b},{c}\n").as_bytes()),
                // One long run is enough, and keeps an input quick.
                Piece::Run { word, doublings } => {
                    let doublings = if long { doublings % 8 } else { *doublings };
                    bytes.extend_from_slice(WORDS[*word].repeat(1 << doublings).as_bytes());
                    long |= doublings >= 8;
                }
            }
        }
        bytes
    }
}

#[test]
fn any_bytes_are_rows_or_an_error() {
    check!().with_test_time(TEST_TIME).with_type::<Input>().for_each(|input| {
        let bytes = input.bytes();
        let lines = 1 + bytes.iter().filter(|byte| **byte == b'\n').count() as u64;
        let channels = input.columns.map(|index| (COLUMNS[index].to_owned(), COLUMNS[index].parse().unwrap()));
        let delimiter = DELIMITERS.get(input.delimiter).map(|text| text.parse().unwrap());
        match LogReader::from_reader("log.csv", Cursor::new(bytes), &channels, LogOptions { delimiter }) {
            Ok(log) => read(log, lines),
            Err(error) => judge_error(&error),
        }
    });
}

fn read(mut log: LogReader, lines: u64) {
    let (mut rows, mut line_before) = (0, 0);
    loop {
        match log.next_row() {
            Ok(Some(row)) => {
                assert_eq!((row.row, row.values.len()), (rows, 3), "rows are numbered from 0 and have every channel");
                assert!(
                    row.line > line_before && row.line <= lines,
                    "line {} of {lines} after {line_before}",
                    row.line
                );
                (rows, line_before) = (rows + 1, row.line);
            }
            Ok(None) => break,
            Err(error) => {
                judge_error(&error);
                break;
            }
        }
    }
    if let Some(tail) = log.truncated_tail() {
        assert!(tail.row == rows && tail.line > line_before && log.ends_without_newline());
    }
    assert!(matches!(log.next_row(), Ok(None)), "a log that has ended goes on");
}

fn judge_error(error: &LogError) {
    assert!(error.to_string().len() > 20, "`{error}` tells nobody what to do");
}
