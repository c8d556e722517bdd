//! A log that cannot be used is refused with what is wrong and where, and nothing is written.

use std::fs;

use crate::desk::{Desk, MOTOR, SAMPLE, edited};

/// Refuses to replay `log` with the usual options.
fn refuses_log(log: impl AsRef<[u8]>, words: &[&str]) {
    let desk = Desk::with("log.csv", "");
    desk.write("log.csv", log);
    desk.refuses(&format!("replay log.csv {MOTOR}"), words);
}

#[test]
fn a_log_that_is_not_there_is_named() {
    let desk = Desk::with_sample();
    desk.refuses(&format!("replay lgo.csv {MOTOR}"), &["no log `lgo.csv`", "check the path"]);
    desk.refuses(&format!("replay log.csv/lgo.csv {MOTOR}"), &["`log.csv/lgo.csv`", "check the path"]);
}

#[test]
fn a_directory_in_place_of_a_log_is_named() {
    let desk = Desk::with_sample();
    fs::create_dir(desk.path("logs")).unwrap();
    desk.refuses(&format!("replay logs {MOTOR}"), &["no log below the directory 'logs'", ".csv"]);
    desk.refuses(
        "watch logs --speed 1 --current 2 --voltage 3 --rate-hz 50 --learn 5s..25s --print-at 1",
        &["`logs` is a directory"],
    );
}

#[cfg(unix)]
#[test]
fn a_log_nobody_may_read_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::with_sample();
    fs::set_permissions(desk.path("log.csv"), fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(desk.path("log.csv")).is_ok() {
        // Root reads everything; what is left to try is a path that no one can open.
        desk.refuses(&format!("replay log.csv/under {MOTOR}"), &["cannot be opened"]);
    } else {
        desk.refuses(&format!("replay log.csv {MOTOR}"), &["no permission", "`log.csv`"]);
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_as_a_log_because_it_is_read_three_times() {
    let desk = Desk::with_sample();
    let before = desk.files();
    let command = format!("replay /dev/stdin {MOTOR}");
    let output = desk.command(&command).write_stdin(SAMPLE).assert().get_output().clone();
    desk.refused(&command, &output, &["not a regular file", "save it"], &before);
}

#[test]
fn a_log_without_a_row_is_refused() {
    refuses_log("", &["is empty"]);
    refuses_log("\n \r\n\n", &["is empty"]);
    refuses_log("t_s,set_point,speed,current,voltage\n", &["header but no data row"]);
}

#[test]
fn a_file_that_is_not_text_is_refused() {
    refuses_log([SAMPLE.as_bytes(), b"60.0,300,30\x000,2,9\n"].concat(), &["not a text file", "line 3002"]);
    refuses_log(b"\x00\x01\x02\x03", &["not a text file"]);
}

#[test]
fn an_unknown_column_is_refused_with_the_columns_there_are_and_the_nearest() {
    let desk = Desk::with_sample();
    desk.refuses(
        "replay log.csv --speed speed --current curent --voltage voltage --rate-hz 50 --learn 5s..25s",
        &["`curent`", "did you mean `current`?", "`t_s`, `set_point`, `speed`, `current`, `voltage`"],
    );
    desk.refuses(&format!("replay log.csv {MOTOR} --set-point setpoint"), &["`setpoint`", "did you mean `set_point`?"]);
}

#[test]
fn a_column_number_out_of_range_is_refused_with_the_range() {
    let desk = Desk::with_sample();
    for number in ["0", "6", "-1", "99999999999999999999"] {
        let command = format!("replay log.csv --speed 3 --current 4 --voltage {number} --rate-hz 50 --learn 5s..25s");
        desk.refuses(&command, &[number, "voltage", "`current`"]);
    }
    desk.refuses(
        "replay log.csv --speed 3 --current 4 --voltage 6 --rate-hz 50 --learn 5s..25s",
        &["column number 6", "5 columns"],
    );
}

#[test]
fn a_row_with_a_field_too_many_or_too_few_is_refused_with_its_number() {
    let with_row = |at: usize, change: fn(&mut Vec<String>)| {
        edited(|row, cells| {
            if row == at {
                change(cells);
            }
        })
    };
    refuses_log(with_row(1998, |cells| cells.push("7".into())), &["row 1998", "line 2000", "6 fields"]);
    refuses_log(with_row(40, |cells| cells.truncate(4)), &["row 40", "line 42", "4 fields"]);
}

#[test]
fn text_in_a_number_column_is_refused_with_row_column_and_value() {
    // In the pass that learns and, behind the window, in the one that judges.
    for at in [700, 2100] {
        let with = |text: &str| {
            edited(|row, cells| {
                if row == at {
                    cells[3] = text.to_owned();
                }
            })
        };
        let row = format!("row {at} (line {})", at + 2);
        refuses_log(with("2.0A"), &[&row, "`current`", "`2.0A`", "not a number"]);
        refuses_log(with("\"1,98\""), &[&row, "`current`", "`1,98`", "decimal comma"]);
    }
}

#[test]
fn a_channel_that_is_constant_over_the_learning_window_is_named() {
    for (column, name) in [(2, "speed"), (3, "current"), (4, "voltage")] {
        let constant = edited(|_, cells| cells[column] = "2.5".to_owned());
        refuses_log(constant, &[&format!("'{name}' is constant"), "choose another"]);
    }
}

#[test]
fn a_set_point_that_changes_inside_the_learning_window_is_refused_with_the_row() {
    let moved = edited(|row, cells| {
        if row >= 600 {
            cells[1] = "310".to_owned();
        }
    });
    let desk = Desk::with("log.csv", &moved);
    desk.refuses(&format!("replay log.csv {MOTOR} --set-point set_point"), &["from 300 to 310", "row 600"]);
}
