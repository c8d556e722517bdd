//! However a log is written, and whatever is missing from it: what can be judged is judged, the same.

use serde_json::Value;

use crate::desk::{Desk, MOTOR, SAMPLE, edited, healthy};

/// The alarms of the plain sample.
fn plain() -> Value {
    Desk::with_sample().replay(SAMPLE, "", 1)["alarms"].take()
}

#[test]
fn line_ends_byte_order_mark_and_delimiter_make_no_difference() {
    let desk = Desk::with_sample();
    let crlf = SAMPLE.replace('\n', "\r\n");
    let writings = [
        crlf.clone(),
        format!("\u{feff}{SAMPLE}"),
        format!("\u{feff}{}", crlf.replace(',', ";")),
        SAMPLE.replace(',', ";"),
        SAMPLE.replace(',', "\t"),
        SAMPLE.replace(',', ", "),
        SAMPLE.replacen('\n', "\n\n", 5),
        format!("{SAMPLE}\n\n"),
    ];
    for log in writings {
        let report = desk.replay(&log, "", 1);
        assert_eq!(report["alarms"], plain(), "{:?}", &log[..60]);
        assert_eq!(report["samples"], 3000);
    }
    assert_eq!(desk.replay(&SAMPLE.replace(',', "|"), "--delimiter |", 1)["alarms"], plain());
}

#[test]
fn columns_may_be_given_by_name_or_number_and_a_header_may_be_missing() {
    let numbers = "--speed 3 --current 4 --voltage 5 --rate-hz 50 --learn 5s..25s --mode paper";
    let desk = Desk::with_sample();
    assert_eq!(desk.json(&format!("replay log.csv {numbers}"), 1)["alarms"], plain());
    let (_, headerless) = SAMPLE.split_once('\n').unwrap();
    desk.write("log.csv", headerless);
    let report = desk.json(&format!("replay log.csv {numbers} --set-point 2"), 1);
    assert_eq!(report["alarms"], plain());
    assert_eq!(report["samples"], 3000);
    desk.refuses(&format!("replay log.csv {MOTOR}"), &["no header", "number from 1 to 5"]);
}

#[test]
fn a_column_of_text_is_ignored_unless_it_is_named() {
    let desk = Desk::with_sample();
    let with_text = edited(|row, cells| {
        cells[0] = format!("2024-05-01 10:00:{:02}", row % 60);
        cells[1] = "auto".to_owned();
    });
    assert_eq!(desk.replay(&with_text, "", 1)["alarms"], plain());
    desk.refuses(&format!("replay replayed.csv {MOTOR} --set-point set_point"), &["row 0", "`auto`", "`set_point`"]);
}

#[test]
fn values_that_are_not_finite_are_counted_and_noted_and_the_rest_is_judged() {
    let gaps = [
        (400, 2, "nan"),
        (500, 3, "inf"),
        (501, 3, "-inf"),
        (1500, 4, "NA"),
        (1510, 2, ""),
        (1520, 3, "null"),
        (2000, 4, "NaN"),
    ];
    let holed = edited(|row, cells| {
        if let Some((_, column, text)) = gaps.iter().find(|(at, ..)| *at == row) {
            cells[*column] = (*text).to_owned();
        }
    });
    let desk = Desk::with_sample();
    let report = desk.replay(&holed, "", 1);
    assert_eq!(report["skipped"], 7);
    assert_eq!(report["samples"], 3000);
    assert_eq!(report["learned"]["quality"]["skipped"], 3);
    assert_eq!(report["learned"]["n"], 997);
    let alarms = report["alarms"].as_array().unwrap();
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    assert_eq!(alarms[0]["located"], "F2");
    assert!((1750..1760).contains(&alarms[0]["start_row"].as_u64().unwrap()), "{alarms:?}");

    let text = desk.run(&format!("replay replayed.csv {MOTOR}")).code(1).get_output().stdout.clone();
    assert!(String::from_utf8(text).unwrap().contains("note: 7 rows with a value that is not finite were skipped"));
    assert!(desk.read("monitor-out/replay.html").contains("7 rows with a value that is not finite"));
    assert_eq!(desk.read("monitor-out/replay.csv").lines().filter(|line| line.contains(",1,,")).count(), 4);
}

#[test]
fn gaps_alone_are_no_fault() {
    let holed = edited(|row, cells| {
        if row % 10 == 0 {
            cells[2 + row / 10 % 3] = "nan".to_owned();
        }
    });
    let holed: String = holed.split_inclusive('\n').take(1701).collect();
    let report = Desk::with_sample().replay(&holed, "", 0);
    assert_eq!(report["skipped"], 170);
}

#[test]
fn a_log_cut_in_the_middle_of_its_last_row_is_reported_and_judged_up_to_it() {
    let desk = Desk::with_sample();
    let whole: usize = SAMPLE.split_inclusive('\n').take(2801).map(str::len).sum();
    let next = &SAMPLE[whole..].lines().next().unwrap();
    let fields_missing = next.len() - next.split(',').next_back().unwrap().len() - 1;
    for cut in [1, 8, fields_missing] {
        let report = desk.replay(&SAMPLE[..whole + cut], "", 1);
        assert_eq!(report["alarms"], plain());
        assert_eq!(report["samples"], 2800);
        let note = report["notes"][0].as_str().unwrap();
        assert!(note.contains("in the middle of row 2800 (line 2802)"), "{note}");
    }
}

#[test]
fn a_number_that_was_cut_raises_no_alarm() {
    // 9.669 V cut to 9: far out of control, and yet nothing is wrong with the motor.
    let healthy = healthy();
    let cut = &healthy[..healthy.rfind('.').unwrap()];
    let report = Desk::with_sample().replay(cut, "", 0);
    assert_eq!(report["samples"], 1700);
    assert_eq!(report["coverage"]["monitoring"], 449);
    assert!(report["notes"][0].as_str().unwrap().contains("may be cut"), "{}", report["notes"]);
}
