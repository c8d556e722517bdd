//! What a replay finds, says and writes.

use serde_json::Value;

use crate::desk::{Desk, MOTOR, SAMPLE, assert_keys, healthy};

/// A mission of 60 s at 50 Hz whose set point is lowered at 30 s.
const SET_POINT_CHANGE: &str = r#"
name = "set point change"
duration_s = 60.0
record_every = 20
start = "steady"
fault = []

[learn]
start_s = 5.0
end_s = 25.0

[[set_point]]
at_s = 0.0
rad_per_s = 300.0

[[set_point]]
at_s = 30.0
rad_per_s = 250.0
"#;

/// The only alarm of a report.
fn only_alarm(report: &Value) -> &Value {
    let alarms = report["alarms"].as_array().unwrap();
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    &alarms[0]
}

#[test]
fn the_fault_of_the_sample_is_found_where_it_begins_and_located() {
    let report = Desk::with_sample().replay(SAMPLE, "", 1);
    let alarm = only_alarm(&report);
    assert_eq!(alarm["located"], "F2");
    let (start_row, end_row) = (alarm["start_row"].as_u64().unwrap(), alarm["end_row"].as_u64().unwrap());
    assert!((1750..=1755).contains(&start_row), "{start_row}");
    assert!((2499..2600).contains(&end_row), "{end_row}");
    assert_eq!(alarm["start_s"].as_f64().unwrap(), start_row as f64 / 50.0);
    assert!(alarm["peak"].as_f64().unwrap() > 10.0);
}

#[test]
fn the_report_for_machines_has_every_key_and_the_exit_code() {
    let desk = Desk::with_sample();
    for (log, code) in [(SAMPLE, 1), (&healthy(), 0)] {
        let report = desk.replay(log, "", code);
        assert_eq!(report["exit"], code);
        let keys = ["samples", "skipped", "learned", "limits", "coverage", "alarms", "injected", "notes", "files"];
        assert_keys(&report, &keys);
        assert_keys(&report["learned"], &["n", "mean", "sigma", "quality"]);
        assert_eq!(report["learned"]["n"], 1000);
        assert_eq!(report["skipped"], 0);
        let mean = report["learned"]["mean"][0].as_f64().unwrap();
        assert!((mean - 300.0).abs() < 0.1, "{mean}");
        for alarm in report["alarms"].as_array().unwrap() {
            assert_keys(alarm, &["start_row", "end_row", "start_s", "located", "peak"]);
        }
    }
}

#[test]
fn the_healthy_part_of_the_sample_raises_no_alarm() {
    let desk = Desk::with_sample();
    let report = desk.replay(&healthy(), "", 0);
    assert_eq!(report["alarms"], Value::Array(vec![]));
    assert_eq!(report["coverage"]["monitoring"], 450);
    let done = desk.run(&format!("replay replayed.csv {MOTOR}")).code(0);
    assert!(String::from_utf8_lossy(&done.get_output().stdout).contains("No fault found."));
}

#[test]
fn a_fault_added_to_a_healthy_log_is_found() {
    let desk = Desk::with_sample();
    let cases = [
        ("current:+0.3@1400", 1400..1410, Some("F3")),
        ("current:-0.3@1400..1500", 1400..1410, Some("F3")),
        ("current:ramp+0.5@1400..1600", 1405..1500, Some("F3")),
        ("current:x1.2@1400", 1400..1410, Some("F3")),
        // A sensor alone, without the loop that follows it: (1.8) has no line for that.
        ("speed:+3@1400", 1400..1410, None),
    ];
    for (injection, start, located) in cases {
        let report = desk.replay(&healthy(), &format!("--inject {injection}"), 1);
        let alarm = only_alarm(&report);
        assert!(start.contains(&alarm["start_row"].as_u64().unwrap()), "{injection}: {alarm}");
        if let Some(located) = located {
            assert_eq!(alarm["located"], located, "{injection}");
        }
        assert_eq!(report["injected"][0], injection);
    }
}

#[test]
fn any_three_channels_are_judged_as_those_of_the_motor_are() {
    let general = "--channel n=speed --channel i=current --channel u=5 --rate-hz 50 --learn 5s..25s --mode paper";
    let desk = Desk::with_sample();
    let motor = desk.replay(SAMPLE, "", 1);
    let report = desk.json(&format!("replay log.csv {general}"), 1);
    assert_eq!(report["alarms"], motor["alarms"]);
    assert_eq!(report["channels"], serde_json::json!(["n", "i", "u"]));
    // Without the motor's names a pattern is not the name of a cause.
    let text = desk.run(&format!("replay log.csv {general}")).code(1).get_output().stdout.clone();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("F2 pattern") && !text.contains("speed sensor"), "{text}");
}

#[test]
fn a_change_of_the_set_point_is_no_fault_when_the_set_point_is_known() {
    let desk = Desk::with("my.toml", SET_POINT_CHANGE);
    desk.run("--scenario my.toml").success();
    let log = desk.read("monitor-out/trace.csv");
    let report = desk.replay(&log, "--set-point set_point --settle 5 --relearn 10", 0);
    assert_eq!(report["alarms"], Value::Array(vec![]));
    assert_eq!(report["coverage"]["settling"], 250);
    let learning = report["coverage"]["learning"].as_u64().unwrap();
    assert!((500..=501).contains(&learning), "{learning}");
    assert_eq!(report["coverage"]["monitoring"], 1750 - 250 - learning);
    let text = desk.run(&format!("replay replayed.csv {MOTOR} --set-point set_point --settle 5 --relearn 10"));
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    assert!(text.contains("14.3 % went to settling") && text.contains("% to learning"), "{text}");
    // The same log without its set point: every value has moved.
    let ungated = desk.replay(&log, "", 1);
    let start_row = only_alarm(&ungated)["start_row"].as_u64().unwrap();
    assert!((1500..1510).contains(&start_row), "{start_row}");
}

#[test]
fn a_window_that_leaves_no_row_to_judge_is_noted() {
    let desk = Desk::with_sample();
    let report = desk.json(
        "replay log.csv --speed speed --current current --voltage voltage --rate-hz 50 --learn 0..3000 --mode paper",
        0,
    );
    assert!(report["notes"][0].as_str().unwrap().contains("no row was judged"), "{}", report["notes"]);
}

#[test]
fn the_page_stands_alone_and_the_trace_has_a_row_for_each_row_judged() {
    let desk = Desk::with_sample();
    let report = desk.replay(SAMPLE, "--out results", 1);
    assert_eq!(
        report["files"],
        serde_json::json!(["results/replay.html", "results/replay.csv", "results/baseline.toml"])
    );
    let page = desk.read("results/replay.html");
    for outside in ["://", "<script ", "src=", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.matches("role=\"img\"").count() >= 10);
    for told in [
        "data-name=\"learning\" data-spans=\"5 25\"",
        "data-name=\"monitoring\" data-spans=\"25 60\"",
        "%. 35.00 s: speed ",
    ] {
        assert!(page.contains(told), "{told}");
    }
    let mut trace = csv::Reader::from_path(desk.path("results/replay.csv")).unwrap();
    let header = trace.headers().unwrap().clone();
    let rows: Vec<_> = trace.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 1750);
    assert_eq!(&rows[0][0], "1250");
    let located = header.iter().position(|name| name == "located").unwrap();
    assert_eq!((&rows[0][located], &rows[1000][located]), ("", "F2"));
}

#[test]
fn a_baseline_that_was_learned_once_judges_another_log_from_its_first_row() {
    let desk = Desk::with_sample();
    let learned = desk.replay(SAMPLE, "--out first", 1);
    // Rows 1300 to 2999 of the sample as a log of their own: the fault begins in its row 450.
    let mut lines = SAMPLE.split_inclusive('\n');
    let later: String = lines.by_ref().take(1).collect::<String>() + &lines.skip(1300).collect::<String>();
    desk.write("later.csv", &later);
    let columns = "--speed speed --current current --voltage voltage --rate-hz 50 --mode paper";
    let report = desk.json(&format!("replay later.csv {columns} --baseline first/baseline.toml --no-trace"), 1);
    assert_eq!(report["limits"], learned["limits"]);
    assert_eq!(report["learned"]["mean"], learned["learned"]["mean"]);
    assert_eq!(report["learned"]["start_row"], Value::Null);
    assert_eq!(report["coverage"]["monitoring"], 1700);
    let alarm = only_alarm(&report);
    assert_eq!((&alarm["start_row"], &alarm["located"]), (&Value::from(450), &Value::from("F2")));
    assert_eq!(report["files"], serde_json::json!(["monitor-out/replay.html"]), "no trace, and no baseline learned");
}

#[test]
fn a_set_point_that_returns_is_judged_by_what_was_learned_there_when_asked_to() {
    let desk = Desk::with(
        "there-and-back.toml",
        &format!("{SET_POINT_CHANGE}\n[[set_point]]\nat_s = 35.0\nrad_per_s = 300.0\n"),
    );
    desk.run("--scenario there-and-back.toml --out mission").success();
    let log = desk.read("mission/trace.csv");
    let judged = |options: &str| {
        let report = desk.replay(&log, &format!("--set-point set_point {options}"), 0);
        report["coverage"]["monitoring"].as_u64().unwrap()
    };
    // 25 s to 30 s is judged either way; then settling to 40 s, and 20 s of learning that the recalled baseline spares.
    assert!((250..=260).contains(&judged("")), "{}", judged(""));
    assert!((1240..=1260).contains(&judged("--recall")), "{}", judged("--recall"));
}
