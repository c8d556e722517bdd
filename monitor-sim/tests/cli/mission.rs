//! What the main job prints and writes.

use std::process::Stdio;

use serde_json::Value;

use crate::desk::{Desk, MOTOR, SHORT, assert_keys, healthy};

const SCENARIO: &str = include_str!("../../scenarios/figure-1.toml");

/// A report without what no two runs share.
fn repeatable(mut report: Value) -> Value {
    let object = report.as_object_mut().unwrap();
    assert!(object.remove("wall_s").unwrap().as_f64().unwrap() > 0.0);
    assert!(object.remove("files").is_some());
    report
}

fn faults<'a>(report: &'a Value, method: &str) -> Vec<&'a Value> {
    report["faults"].as_array().unwrap().iter().filter(|fault| fault["method"] == method).collect()
}

#[test]
fn in_paper_mode_the_papers_mission_is_flown_into_monitor_out() {
    let desk = Desk::with("unrelated.txt", "");
    let done = desk.run("--mode paper").success().stderr("");
    let text = String::from_utf8(done.get_output().stdout.clone()).unwrap();
    for part in ["Table 1.", "Table 2.", "Located right: 3 of 3. False alarms: 0.", "monitor-out/mission.html"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert_eq!(desk.files().len(), 4, "{:?}", desk.files().keys());

    let page = desk.read("monitor-out/mission.html");
    for outside in ["://", "<script ", "src=", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for figure in ["(figure 1)", "figures 5 and 8", "figures 6 and 7", "figures 10 and 11", "the second figure 11"] {
        let heading =
            page.split("<h2>").skip(1).find(|section| section.split("</h2>").next().unwrap().contains(figure));
        assert!(heading.unwrap_or_else(|| panic!("no {figure}")).contains("<svg"), "{figure} has no picture");
    }

    let mut trace = csv::Reader::from_path(desk.path("monitor-out/trace.csv")).unwrap();
    let header = trace.headers().unwrap().clone();
    let column = |name| header.iter().position(|found| found == name).unwrap();
    let (t_s, speed, voltage) = (column("t_s"), column("speed"), column("voltage"));
    let (phase, t2, located) = (column("phase"), column("t2_full"), column("located"));
    let mut rows = 0;
    for row in trace.records().map(Result::unwrap) {
        assert_eq!(row[0].parse::<u64>().unwrap(), rows);
        assert!((row[t_s].parse::<f64>().unwrap() - rows as f64 / 1000.0).abs() < 1e-6);
        assert!((speed..=voltage).all(|channel| row[channel].parse::<f64>().unwrap().is_finite()));
        assert_eq!(row[t2].parse::<f64>().is_ok(), &row[phase] == "monitoring", "row {rows}");
        assert!(["", "F1", "F2", "F3", "unknown"].contains(&&row[located]), "{}", &row[located]);
        rows += 1;
    }
    assert_eq!(rows, 140_000);
}

#[test]
fn the_default_scenario_is_printed_and_flies_as_the_default_mission_does() {
    let desk = Desk::with("unrelated.txt", "");
    let printed = desk.run("scenario").success().stdout(SCENARIO);
    desk.write("my.toml", &printed.get_output().stdout);
    let report = repeatable(desk.json("--scenario my.toml --mode paper", 0));
    assert_eq!(report, repeatable(desk.json("--mode paper", 0)));

    assert_eq!((&report["mode"], &report["seed"], &report["rate_hz"]), (&"paper".into(), &1.into(), &1000.0.into()));
    for method in ["pca", "ppca"] {
        let faults = faults(&report, method);
        let ids: Vec<_> = faults.iter().map(|fault| fault["id"].as_str().unwrap()).collect();
        assert_eq!(ids, ["F1", "F2", "F3"]);
        for fault in faults {
            assert_keys(fault, &["start_s", "end_s", "detected_s", "cleared_s", "located", "located_s"]);
            let located = if method == "ppca" { fault["id"].clone() } else { Value::Null };
            assert_eq!(fault["located"], located, "{fault}");
            assert_eq!(fault["located_s"].is_null(), method == "pca", "{fault}");
            let time = |key: &str| fault[key].as_f64().unwrap();
            assert!(time("start_s") <= time("detected_s") && time("detected_s") < time("start_s") + 1.0, "{fault}");
            assert!(time("end_s") <= time("cleared_s") && time("cleared_s") < time("end_s") + 5.0, "{fault}");
        }
    }
    let ramp = report["ramp"].as_array().unwrap();
    assert_eq!(ramp.len(), 3);
    for row in ramp {
        assert_keys(row, &["id", "value_at_detection", "unit"]);
        assert!(row["value_at_detection"].as_f64().unwrap() < row["amplitude"].as_f64().unwrap());
    }
    assert_keys(&report, &["explained", "retained", "limits", "false_alarms"]);
    for model in ["full", "speed_current", "current_voltage", "speed_voltage"] {
        assert!(report["limits"][model].as_f64().unwrap() > 1.0);
        assert!(report["retained"][model].as_u64().unwrap() >= 1);
        let explained: f64 = report["explained"][model].as_array().unwrap().iter().map(|e| e.as_f64().unwrap()).sum();
        assert!((explained - 1.0).abs() < 1e-5, "{explained}");
    }
    assert_eq!(report["false_alarms"], 0);
}

#[test]
fn the_same_seed_gives_the_same_mission_and_another_seed_another() {
    let desk = Desk::with_short();
    let fly = |seed: &str| {
        let report = repeatable(desk.json(&format!("--scenario short.toml --seed {seed} --out out-{seed}"), 0));
        (report, desk.read(&format!("out-{seed}/trace.csv")))
    };
    let (report, trace) = fly("7");
    let (again, trace_again) = fly("7");
    assert_eq!(report, again);
    assert!(trace == trace_again, "the traces differ");
    let (other, other_trace) = fly("18446744073709551615");
    assert_ne!(report["explained"], other["explained"]);
    assert!(trace != other_trace, "another seed made the same trace");
}

#[test]
fn faults_may_grow_in_place_of_coming_at_once() {
    let desk = Desk::with_short();
    let step = desk.json("--scenario short.toml --mode paper", 0);
    assert_ne!(desk.read("monitor-out/trace.csv"), desk.read("monitor-out/trace-ramp.csv"));
    let ramp = desk.json("--scenario short.toml --mode paper --faults ramp", 0);
    assert!(desk.read("monitor-out/trace.csv") == desk.read("monitor-out/trace-ramp.csv"));
    assert_eq!((&step["fault_profile"], &ramp["fault_profile"]), (&"step".into(), &"ramp".into()));
    let detected = |report: &Value| faults(report, "ppca")[0]["detected_s"].as_f64().unwrap();
    assert!(detected(&step) < 15.1 && detected(&ramp) > detected(&step) + 0.1);
    let value = ramp["ramp"][0]["value_at_detection"].as_f64().unwrap();
    assert!((value - 0.05 * (detected(&ramp) - 15.0)).abs() < 1e-6, "0.5 A over 10 s make 0.05 A/s, not {value}");
}

#[test]
fn results_go_where_they_are_sent_and_nowhere_else() {
    let desk = Desk::with_short();
    let report = desk.json("--scenario short.toml --out a/b", 0);
    assert_eq!(report["files"], serde_json::json!(["a/b/mission.html", "a/b/trace.csv", "a/b/trace-ramp.csv"]));
    assert_eq!(desk.files().len(), 4, "{:?}", desk.files().keys());
    assert!(!desk.path("monitor-out").exists());
}

#[test]
fn a_scenario_sampled_at_another_rate_than_its_thresholds_is_noted() {
    let desk = Desk::with("my.toml", &SHORT.replace("start = ", "record_every = 20\nstart = "));
    let notes = desk.json("--scenario my.toml --mode paper", 0)["notes"].take();
    assert!(notes[0].as_str().unwrap().contains("tune --scenario"), "{notes}");
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let desk = Desk::with_short();
    desk.write("log.csv", healthy());
    let found = format!("replay log.csv {MOTOR} --inject current:+0.3@1400");
    let cases = [
        ("--scenario short.toml", 0),
        ("--scenario short.toml --json", 0),
        ("--scenario short.toml --mode paper", 0),
        ("tune --scenario short.toml --runs 1", 0),
        ("scenario", 0),
        (&found, 1),
    ];
    for (arguments, code) in cases {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = std::process::Command::new(assert_cmd::cargo::cargo_bin!("monitor-sim"))
            .current_dir(desk.path(""))
            .args(arguments.split_whitespace())
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{arguments}");
        assert_eq!(output.status.code(), Some(code), "{arguments}");
    }
}

#[test]
fn every_command_has_a_help_with_examples() {
    let desk = Desk::with("unrelated.txt", "");
    let helps = ["--help", "-h", "help", "replay --help", "replay -h", "help replay", "tune --help", "scenario --help"];
    for help in helps {
        let done = desk.run(help).success().stderr("");
        let text = String::from_utf8(done.get_output().stdout.clone()).unwrap();
        let (_, examples) = text.split_once("Examples:").unwrap_or_else(|| panic!("{help}\n{text}"));
        assert!(examples.contains("  monitor-sim "), "{help}\n{text}");
    }
    desk.run("--version").success().stdout(predicates::str::starts_with("monitor-sim "));
}
