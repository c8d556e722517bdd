//! What a replay in guard mode, the default, finds, says and writes.

use serde_json::Value;

use crate::desk::{Desk, GUARD, SAMPLE, edited, first_rows, healthy};

/// The constants of the sample's motor, a tenth off.
const CONSTANTS: &str = "--resistance 0.33 --torque-constant 0.0275 --load-slope 0";

fn judged(log: &str, options: &str, code: i32) -> Value {
    let desk = Desk::with("judged.csv", log);
    desk.json(&format!("replay judged.csv {GUARD} {options}"), code)
}

fn only_alarm(report: &Value) -> &Value {
    let alarms = report["alarms"].as_array().unwrap();
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    &alarms[0]
}

#[test]
fn the_fault_of_the_sample_is_found_named_and_sized_by_constants_that_are_a_tenth_off() {
    let report = judged(SAMPLE, CONSTANTS, 1);
    let alarm = only_alarm(&report);
    assert_eq!((&report["mode"], &report["exit"]), (&"guard".into(), &1.into()));
    assert!((1750..=1751).contains(&alarm["start_row"].as_u64().unwrap()), "{alarm}");
    assert!((2500..2550).contains(&alarm["end_row"].as_u64().unwrap()), "{alarm}");
    assert_eq!((&alarm["located"], &alarm["size"]["unit"]), (&"F2".into(), &"rad/s".into()));
    let size = alarm["size"]["value"].as_f64().unwrap();
    assert!((size / 5.0 - 1.0).abs() < 0.15, "5 rad/s, by a torque constant that is a tenth off: {size}");
    assert_eq!(report["learned"]["n"], 800, "a thousand rows, but for two tenths");
}

#[test]
fn without_constants_an_offset_of_1_5_sigma_is_unknown_and_the_channel_that_moved_is_told() {
    let healthy = judged(&healthy(), "", 0);
    assert_eq!((&healthy["alarms"], &healthy["coverage"]["monitoring"]), (&Value::Array(vec![]), &450.into()));
    for (position, injection) in
        ["speed:+0.16@1400", "current:+0.03@1400", "voltage:-0.03@1400"].into_iter().enumerate()
    {
        let report = judged(&first_rows(1700), &format!("--inject {injection}"), 1);
        let alarm = &report["alarms"][0];
        assert!((1400..1600).contains(&alarm["start_row"].as_u64().unwrap()), "{alarm}");
        assert_eq!(alarm["located"], "unknown");
        assert!(alarm["contributions"][position].as_f64().unwrap() > 0.8, "{injection}: {alarm}");
        assert!(report["notes"][0].as_str().unwrap().contains("--resistance"), "{}", report["notes"]);
    }
}

#[test]
fn page_trace_and_tables_go_where_they_are_sent() {
    let desk = Desk::with_sample();
    let done = desk.run(&format!("replay log.csv {GUARD} {CONSTANTS} --out results")).code(1).stderr("");
    let text = String::from_utf8(done.get_output().stdout.clone()).unwrap();
    for part in ["guard mode", "Learned from rows 250 to 1249", "F2 speed sensor", "Written: results/replay.html"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let page = desk.read("results/replay.html");
    assert!(page.matches("role=\"img\"").count() >= 9 && !page.contains("://"));
    for told in [
        "--rate-hz 50\n--channel speed=speed\n",
        "data-name=\"learning\" data-spans=\"5 25\"",
        "data-name=\"monitoring\" data-spans=\"25 60\"",
        "%. 35.02 s: speed ", // the first reading by itself is turned away
    ] {
        assert!(page.contains(told), "{told}");
    }
    let mut trace = csv::Reader::from_path(desk.path("results/replay.csv")).unwrap();
    let located = trace.headers().unwrap().iter().position(|name| name == "located").unwrap();
    let rows: Vec<_> = trace.records().map(Result::unwrap).collect();
    assert_eq!((rows.len(), &rows[0][0]), (1750, "1250"));
    assert_eq!((&rows[0][located], &rows[1000][located]), ("", "F2"));
    assert_eq!(desk.files().len(), 3, "{:?}", desk.files().keys());
}

#[test]
fn a_sensor_that_sticks_or_falls_silent_is_told_by_name() {
    let sticks = edited(|row, cells| {
        if (1400..1650).contains(&row) {
            cells[3] = "1.98".to_owned();
        }
    });
    let silent = edited(|row, cells| {
        if (1400..1650).contains(&row) {
            cells[4] = "nan".to_owned();
        }
    });
    for (log, lost) in [(sticks, "current stuck"), (silent, "voltage silent")] {
        let log: String = log.split_inclusive('\n').take(1701).collect();
        let report = judged(&log, "", 1);
        let alarms = report["alarms"].as_array().unwrap();
        assert!(alarms.iter().any(|alarm| alarm["lost"][0] == lost), "{lost}: {alarms:?}");
    }
}

#[test]
fn a_log_of_one_row_a_second_is_judged_as_one_of_fifty_is() {
    let columns = "--speed speed --current current --voltage voltage";
    let desk = Desk::with_sample();
    let found = |rate: &str, window: &str| {
        let report = desk.json(&format!("replay log.csv {columns} --rate-hz {rate} --learn {window} --settle 0"), 1);
        (only_alarm(&report)["start_row"].as_u64().unwrap(), report)
    };
    let (row, report) = found("1", "250..1250");
    assert!((1750..=1751).contains(&row), "{row}");
    let [fast, middle, slow] = [0, 1, 2].map(|n| report["settings"]["time_constants_s"][n].as_f64().unwrap());
    assert!((fast - 1.0).abs() < 1e-3 && (middle - 16.0).abs() < 1e-3 && slow >= 160.0, "{fast} {middle} {slow}");
    // So few rows are fewer than the core's watch over its sensors wants to see first.
    assert!((1750..=1751).contains(&found("1", "1050..1250").0));
    // A window of 400 rows holds 320 behind its seeds: 24 times a middle scale of 13.
    assert!((1750..=1751).contains(&found("1", "850..1250").0));
}

#[test]
fn a_set_point_that_returns_is_judged_by_what_was_learned_there_once_the_loop_has_settled() {
    let scenario = r#"
name = "there and back"
duration_s = 80.0
record_every = 20
start = "steady"
learn = { start_s = 5.0, end_s = 25.0 }
set_point = [{ at_s = 0.0, rad_per_s = 300.0 }, { at_s = 30.0, rad_per_s = 250.0 }, { at_s = 60.0, rad_per_s = 300.0 }]
"#;
    let desk = Desk::with("my.toml", scenario);
    desk.run("--scenario my.toml --mode paper --out mission").success();
    let log = desk.read("mission/trace.csv");
    let report = judged(&log, "--set-point set_point --settle 5", 0);
    assert_eq!(report["alarms"], Value::Array(vec![]));
    // 250 rows in front of the change; at the new set point what settling (250 rows) and as much learning as at first (1000)
    // leave of 1500; and when it has returned 1000 without the two seconds in which the loop follows and the middle scale falls silent.
    let judged_rows = report["coverage"]["monitoring"].as_u64().unwrap();
    assert!((1350..1480).contains(&judged_rows), "{}", report["coverage"]);
    // One that ends while the loop settles has no limits to tell.
    let settling: Vec<&str> = log.lines().take(1600).collect();
    let desk = Desk::with("judged.csv", &settling.join("\n"));
    let told = desk.run(&format!("replay judged.csv {GUARD} --set-point set_point --settle 5")).success();
    let told = String::from_utf8_lossy(&told.get_output().stdout).into_owned();
    assert!(told.contains("no limit stands") && !told.contains("NaN"), "{told}");
    let moved = judged_error(&log, "--set-point set_point --learn 1000..1600");
    assert!(moved.contains("changes from 300 to 250 at row 1500"), "{moved}");
}

fn judged_error(log: &str, options: &str) -> String {
    let desk = Desk::with("judged.csv", log);
    let columns = GUARD.replace("--learn 5s..25s", "");
    let done = desk.run(&format!("replay judged.csv {columns} {options}")).code(2).stdout("");
    String::from_utf8(done.get_output().stderr.clone()).unwrap()
}

#[test]
fn a_log_may_come_through_a_pipe_because_it_is_read_once() {
    let desk = Desk::new();
    let mut command = desk.command(&format!("replay /dev/stdin {GUARD} --json"));
    let output = command.write_stdin(SAMPLE).assert().code(1).get_output().stdout.clone();
    let report: Value = serde_json::from_slice(&output).unwrap();
    assert_eq!(only_alarm(&report)["start_row"], only_alarm(&judged(SAMPLE, "", 1))["start_row"]);
}

#[test]
fn what_guard_mode_cannot_do_is_refused_or_noted_with_what_helps() {
    let desk = Desk::with_sample();
    let replay = format!("replay log.csv {GUARD}");
    let columns = GUARD.replace("--learn 5s..25s", "");
    desk.write("baseline.toml", "");
    desk.refuses(
        &format!("replay log.csv {columns} --baseline baseline.toml"),
        &["stored baseline", "--models", "--mode paper"],
    );
    for option in ["--margin 2", "--cutoff-hz 1", "--relearn 5", "--limits baseline.toml"] {
        let name = option.split(' ').next().unwrap();
        desk.refuses(&format!("{replay} {option}"), &[name, "--mode paper"]);
    }
    for option in ["--false-alarms-per-hour 1", "--raise-hold 1", CONSTANTS] {
        desk.refuses(&format!("{replay} --mode paper {option}"), &["guard mode"]);
    }
    desk.refuses(&format!("{replay} --resistance 0.3"), &["--torque-constant", "--load-slope"]);
    desk.refuses(
        &format!("{replay} --resistance 0 --torque-constant 1 --load-slope 0"),
        &["--resistance", "above zero"],
    );
    let other = "--channel a=speed --channel b=current --channel c=voltage --rate-hz 50 --learn 5s..25s";
    desk.refuses(&format!("replay log.csv {other} {CONSTANTS}"), &["--speed"]);
    desk.refuses(&format!("{replay} --settle -1"), &["settling time"]);
    desk.refuses(&format!("{replay} --set-point-tolerance nan"), &["tolerance"]);
    desk.refuses(&format!("replay log.csv {columns} --learn 1400..2200"), &["something began in it", "choose"]);
    let drift = "--inject voltage:ramp+0.1@250..1250";
    desk.refuses(&format!("{replay} {drift}"), &["'voltage' moves", "choose a window"]);
    let note = desk.json(&format!("{replay} --inject voltage:ramp+0.05@250..1250"), 1)["notes"].take();
    assert!(note[0].as_str().unwrap().contains("not stationary"), "{note}");
    let constant = edited(|_, cells| cells[3] = "2.0".to_owned());
    desk.write("constant.csv", constant);
    desk.refuses(&format!("replay constant.csv {GUARD}"), &["'current' is constant"]);
}
