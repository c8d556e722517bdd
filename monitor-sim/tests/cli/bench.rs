//! Benchmarks on recorded data: scored by their protocol, refused with a sentence, and never with a label in view.

use std::fmt::Write as _;

use serde_json::Value;

use crate::desk::{Desk, assert_keys};

/// A run of SKAB's form, made by a rule: 400 healthy rows and 300 behind them, of which rows 500 to 600 are anomalous, when the
/// current is off by so many sigmas.
fn run(seed: u64, sigmas: f64) -> String {
    let mut text = "datetime;Current;Voltage;Volume Flow RateRMS;anomaly;changepoint\n".to_owned();
    let mut state = seed;
    let mut normal = || {
        let uniform = |state: &mut u64| {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*state >> 40) as f64 / f64::from(1 << 24)
        };
        (0..12).map(|_| uniform(&mut state)).sum::<f64>() - 6.0
    };
    for row in 0..700_u32 {
        let faulty = (500..600).contains(&row);
        let off = if faulty { sigmas } else { 0.0 };
        let [current, voltage, flow] = [1.0 + 0.1 * (normal() + off), 230.0 + normal(), 32.0 + 0.5 * normal()];
        let (minute, second) = (row / 60 % 60, row % 60);
        let change = u8::from(row == 500 || row == 600);
        let _ = writeln!(
            text,
            "2020-03-09 10:{minute:02}:{second:02};{current:.5};{voltage:.4};{flow:.4};{}.0;{change}.0",
            u8::from(faulty)
        );
    }
    text
}

fn desk() -> Desk {
    let desk = Desk::with("data/valve1/0.csv", &run(1, 5.0));
    desk.write("data/valve1/1.csv", run(2, -5.0));
    desk
}

#[test]
fn skab_is_scored_over_all_runs_beside_an_alarm_that_always_stands_and_published_scores() {
    let desk = desk();
    let report = desk.json("bench skab data", 0);
    assert_keys(&report, &["runs", "f1", "far", "mar", "nab", "channels", "settings"]);
    assert_eq!(report["runs"], 2);
    let number = |key: &str| report[key].as_f64().unwrap();
    assert!(number("f1") > 0.85 && number("far") < 15.0 && number("mar") < 5.0, "{report}");
    for profile in ["standard", "low_fp", "low_fn"] {
        assert!(report["nab"][profile].as_f64().unwrap() > 40.0, "{}", report["nab"]);
    }
    // Labels are looked at by the score alone: without them the alarms are the same, and every one is a false one.
    let unlabelled = run(1, 5.0).replace(";1.0;", ";0.0;");
    desk.write("healthy/0.csv", unlabelled);
    let healthy = desk.json("bench skab healthy", 0);
    assert!(healthy["far"].as_f64().unwrap() > 20.0, "{healthy}");
    let told = desk.run("bench skab data").success().get_output().stdout.clone();
    let told = String::from_utf8(told).unwrap();
    // 200 of 600 rows are anomalous: always alarming has a precision of a third and finds all, F1 a half.
    assert!(told.contains("always alarm") && told.contains("0.500") && told.contains("published: Conv-AE"), "{told}");
}

#[test]
fn a_run_that_cannot_be_learned_is_told_and_counted_as_no_alarm() {
    let desk = desk();
    let learned = run(3, 5.0);
    let constant = learned.lines().map(|line| line.to_owned() + "\n").enumerate();
    let constant: String = constant
        .map(|(row, line)| {
            let mut cells: Vec<&str> = line.split(';').collect();
            if row > 0 {
                cells[2] = "230.0";
            }
            cells.join(";")
        })
        .collect();
    desk.write("data/valve1/2.csv", constant);
    let report = desk.json("bench skab data", 0);
    assert_eq!(report["runs"], 3);
    assert!(report.to_string().contains("constant"), "{report}");
    assert!((30.0..40.0).contains(&report["mar"].as_f64().unwrap()), "a third of the anomalies is missed: {report}");
}

#[test]
fn a_benchmark_writes_a_page_and_a_description_of_ones_own_runs() {
    let desk = desk();
    desk.run("bench skab data --mode paper --out result").success();
    let page = desk.read("result/bench.html");
    assert!(page.contains("<svg") && page.contains("always alarm"));
    let own = r#"
name = "own"
title = "My own"
[data]
rate_hz = 1.0
[[channel]]
name = "current"
column = "Current"
[[channel]]
name = "voltage"
column = "Voltage"
[[channel]]
name = "flow"
column = "3"
[learn]
rows = 400
[labels]
anomaly = "anomaly"
"#;
    desk.write("own.toml", own.replace("column = \"3\"", "column = \"4\""));
    let report = desk.json("bench own.toml data", 0);
    assert!(report["f1"].as_f64().unwrap() > 0.85, "{report}");
    let example = desk.run("bench --example").success().get_output().stdout.clone();
    assert!(String::from_utf8(example).unwrap().contains("[labels]"));
}

#[test]
fn what_is_not_there_is_told_with_the_remedy() {
    let desk = desk();
    desk.refuses("bench skab nowhere", &["nowhere", "github.com/waico/SKAB"]);
    desk.refuses("bench cnc-spindle nowhere", &["nowhere", "University of Michigan"]);
    desk.refuses("bench tides data", &["tides", "skab", "cnc-spindle", ".toml"]);
    desk.refuses("bench skab", &["DIR"]);
    desk.write("empty/readme.txt", "no runs");
    desk.refuses("bench skab empty", &["empty"]);
    desk.write("other/0.csv", run(1, 0.0).replace("Voltage", "Tension"));
    desk.refuses("bench skab other", &["0.csv", "Voltage"]);
    desk.write("bare/0.csv", run(1, 0.0).replace("anomaly", "comment"));
    desk.refuses("bench skab bare", &["0.csv", "anomaly", "without labels"]);
    desk.refuses("bench skab data --mode paper --false-alarms-per-hour 1", &["--false-alarms-per-hour"]);
}

#[test]
fn drifts_are_added_to_a_healthy_run_and_the_channel_is_named() {
    let spindle = |seed: u64| {
        let mut text =
            "S1_CommandVelocity,S1_ActualVelocity,S1_CurrentFeedback,S1_OutputVoltage,Machining_Process,tool_condition\n"
                .to_owned();
        for (row, line) in run(seed, 0.0).lines().skip(1).chain(run(seed + 9, 0.0).lines().skip(1)).enumerate() {
            let cells: Vec<f64> = line.split(';').skip(1).take(3).map(|cell| cell.parse().unwrap()).collect();
            let process = if row < 30 { "Prep" } else { "Layer 1 Up" };
            let command = if row < 1300 { 53.3 } else { 40.0 };
            let _ = writeln!(text, "{command},{},{},{},{process},unworn", 53.3 + cells[0], cells[1], cells[2]);
        }
        text
    };
    let desk = Desk::with("mill/experiment_01.csv", &spindle(1));
    desk.write("mill/experiment_02.csv", spindle(20));
    let report = desk.json("bench cnc-spindle mill", 0);
    assert_eq!((&report["healthy_pairs"], &report["false_alarms"]), (&2.into(), &0.into()), "{report}");
    let drifts: &Vec<Value> = report["drifts"].as_array().unwrap();
    assert_eq!(drifts.len(), 12);
    let counts = ["injected", "found", "named_right"].map(|key| &report[key]);
    assert_eq!(counts, [12; 3], "{report}");
    // Thirty rows in front of the layer do not count, and the last hundred are too few to learn another set point.
    for run in report["judged"].as_array().unwrap() {
        let [recorded, rows, judged] =
            ["recorded_rows", "rows", "judged_rows"].map(|key| run[key].as_f64().unwrap_or_else(|| panic!("{run}")));
        assert_eq!(recorded, rows + 30.0, "{run}");
        assert_eq!(run["judged_share"].as_f64().unwrap(), judged / rows, "{run}");
        assert_eq!(judged, rows - 100.0, "{run}");
    }
    let told = desk.run("bench cnc-spindle mill").success();
    let told = String::from_utf8(told.get_output().stdout.clone()).unwrap();
    let share = report["judged"][0]["judged_share"].as_f64().unwrap();
    assert!(told.contains("judged, %") && told.contains(&format!(" {:.1} ", 100.0 * share)), "{told}");
}
