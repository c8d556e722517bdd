//! Logs as they come, and as they should not.

use std::io::{Cursor, ErrorKind};

use proptest::prelude::*;

use super::layout::{HEAD_BYTES, MAX_ROW_BYTES};
use super::*;

const THREE: [(&str, &str); 3] = [("speed", "speed"), ("current", "current"), ("voltage", "voltage")];

fn channels(pairs: &[(&str, &str)]) -> Vec<(String, ColumnRef)> {
    pairs.iter().map(|(name, column)| ((*name).to_owned(), column.parse().unwrap())).collect()
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
        Ok(log) => drain(log).2.expect("the log was read without an error").to_string(),
    }
}

#[test]
fn values_come_in_the_order_of_the_channels_with_their_row_and_line() {
    let log = "time,voltage,speed,current\n0,24,100,3\n1,25,101,4\n";
    assert_eq!(rows(log, &THREE), [(0, 2, vec![100.0, 3.0, 24.0]), (1, 3, vec![101.0, 4.0, 25.0])]);
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
    let options = LogOptions { delimiter: Some("|".parse().unwrap()) };
    let log = LogReader::from_reader("x", bytes, &channels(&[("speed", "speed")]), options);
    assert_eq!(drain(log.unwrap()).0, [(0, 2, vec![1.0])]);
    assert_eq!("tab".parse::<Delimiter>().unwrap().to_string(), "tab");
    for text in ["", "1", "a", "\"", ".", "-", "\n", ",,", "é"] {
        assert!(text.parse::<Delimiter>().is_err(), "{text:?}");
    }
}

#[test]
fn byte_order_mark_carriage_returns_quotes_blank_lines_and_spaces_change_no_value() {
    let log = b"\xEF\xBB\xBF\"speed\", current ,voltage\r\n\r\n\"1\", 2 ,3\r\n\n   \r\n4,5,\"6\"\r\n";
    assert_eq!(rows(log, &THREE), [(0, 3, vec![1.0, 2.0, 3.0]), (1, 6, vec![4.0, 5.0, 6.0])]);
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
    assert_eq!(rows("0,1,2\n3,4,5\n", &by_number)[0], (0, 1, vec![2.0, 1.0]));
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
    assert_eq!(rows(log, &[("speed", "1"), ("current", "3")])[0], (0, 2, vec![8.0, 9.0]));
    // The only text of this header is in a column that is not chosen.
    let log = "time,0,2\n7,8,9\n";
    assert_eq!(rows(log, &[("speed", "0"), ("current", "2")])[0], (0, 2, vec![8.0, 9.0]));
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
    assert_eq!(rows(log, &[("speed", "1.5"), ("current", "0.5")])[0], (0, 2, vec![3.0, 2.0]));
}

#[test]
fn text_in_a_column_chosen_by_number_is_its_header_even_over_a_damaged_first_row() {
    let message = refusal("speed,7\nstop,2\n", &[("speed", "1")]);
    assert!(message.starts_with("row 0 (line 2): `stop` in column `speed`"), "{message}");
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
    assert!(message.ends_with("its columns are `speed`, `note`"), "{message}");
    let wide = format!("{}z\n1\n", "a,".repeat(99));
    assert!(refusal(wide, &[("speed", "velocity")]).ends_with("`a` and 60 more"));
}

#[test]
fn a_column_number_out_of_range_is_refused_with_the_count() {
    for number in ["0", "3", "99999999999999999999999"] {
        let message = refusal("a,b\n1,2\n", &[("speed", number)]);
        assert_eq!(
            message,
            format!("the log has no column number {number} for the speed; its 2 columns count from 1: `a`, `b`")
        );
    }
}

#[test]
fn a_column_for_two_channels_or_a_name_that_stands_twice_is_refused() {
    let same = refusal("a,b\n1,2\n", &[("speed", "a"), ("current", "1")]);
    assert!(same.starts_with("the speed and the current both read column `1`"), "{same}");
    assert_eq!(
        refusal("a,b,a\n1,2,3\n", &[("speed", "a")]),
        "the log has the column `a` for the speed more than once; give its number: 1 or 3"
    );
}

#[test]
fn text_in_ignored_columns_of_whatever_encoding_is_ignored() {
    let log = b"Temp \xB0C,speed,note\n1,2,\xFF\xFE\nx,3,\xC3\n";
    assert_eq!(values(rows(log, &[("speed", "speed")])), [2.0, 3.0]);
    assert_eq!(open(log, &[("speed", "speed")]).unwrap().columns()[0], "Temp °C");
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
    assert_eq!(refusal("speed;current\n1,5;2,5\n", &[("speed", "speed")]), expected);
    // And also where there is no header, and commas divide the rows as evenly as semicolons.
    let message = refusal("1,5;2,5\n1,5;2,5\n", &[("speed", "1")]);
    assert!(message.starts_with("row 0 (line 1): `1,5` in column `column 1`"), "{message}");
}

#[test]
fn a_row_with_other_fields_than_the_first_line_is_an_error_with_both_counts() {
    for (log, row, found) in [("a,b,c\n1,2,3\n4,5\n6,7,8", 1, 2), ("a,b,c\n1,2,3,4\n", 0, 4)] {
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
        assert_eq!(log.truncated_tail(), Some(TruncatedTail { row: 1, line: 4 }), "{tail}");
        assert!(log.ends_without_newline());
    }
}

#[test]
fn the_same_row_with_a_line_end_after_it_is_an_error() {
    for tail in ["4,5\n", "4,5,-\n", "\0\n", "4,5\n\n", "4,5\n   "] {
        let text = format!("speed,current,voltage\n1,2,3\n{tail}");
        let (_, log, error) = drain(open(text, &THREE).unwrap());
        assert!(error.is_some() && log.truncated_tail().is_none(), "{tail:?}");
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
        assert!(refusal(text, &[("x", "1")]).contains("is empty"), "{text:?}");
    }
    for text in ["a,b", "a,b\n", "a,b\r\n\r\n"] {
        assert!(refusal(text, &[("x", "a")]).contains("no data row"), "{text:?}");
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
    let log = LogReader::from_reader("log.csv", input, &channels(&[("x", "a")]), LogOptions::default());
    let (_, log, error) = drain(log.unwrap());
    assert!(matches!(error, Some(LogError::RowTooLong { line: 2, .. })), "{error:?}");
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
    let log = LogReader::from_reader("log.csv", input, &channels(&[("x", "a")]), LogOptions::default());
    let (rows, _, error) = drain(log.unwrap());
    assert_eq!(rows.len(), HEAD_BYTES / 4);
    let message = error.unwrap().to_string();
    assert!(message.contains("near line 16386 (bad sector)"), "{message}");
}

#[test]
fn paths_that_are_no_log_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let open = |path: &Path| LogReader::open(path, &channels(&[("x", "a")]), LogOptions::default()).unwrap_err();
    assert!(matches!(open(folder.path()), LogError::IsADirectory { .. }));
    assert!(matches!(open(&folder.path().join("none.csv")), LogError::NotFound { .. }));
    let denied = open_error("x".to_owned(), ErrorKind::PermissionDenied.into());
    assert!(matches!(denied, LogError::NotReadable { .. }));
}

#[test]
fn a_log_of_mebibytes_is_read_whole_and_the_bytes_read_grow_up_to_its_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let text = format!("a,b\n{}", "1,2\n".repeat(500_000));
    std::fs::write(&path, &text).unwrap();
    let mut log = LogReader::open(&path, &channels(&[("x", "a")]), LogOptions::default()).unwrap();
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
