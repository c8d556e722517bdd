//! What a mission in guard mode, the default, prints and writes.

use serde_json::Value;

use crate::desk::{Desk, SHORT};

fn time(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}

/// Times, names and sizes that the default scenario must reach (its load does not matter to them).
fn assert_found(row: &Value, size: f64) {
    let [start, end] = ["start_s", "end_s"].map(|key| time(row, key));
    let [detected, recovered, cleared] = ["detected_s", "recovered_s", "cleared_s"].map(|key| time(row, key));
    assert!((start..=start + 0.05).contains(&detected), "{row}");
    assert!((end..end + 1.0).contains(&recovered), "a loop of 20 rad/s is back within a second: {row}");
    assert!(cleared <= recovered + 0.25 && cleared <= end + 1.0, "{row}");
    assert_eq!(row["located"], row["id"], "{row}");
    assert!((start..start + 1.05).contains(&time(row, "located_s")), "{row}");
    assert!(time(row, "located_share") >= 0.99, "{row}");
    assert!((time(row, "size") / size - 1.0).abs() < 0.03, "{row}");
    assert!(time(row, "size_sigma") > 0.0);
}

#[test]
fn without_arguments_every_fault_is_found_cleared_named_and_sized_as_asked() {
    let desk = Desk::new();
    let report = desk.json("", 0);
    assert_eq!((&report["mode"], &report["false_alarms"]), (&"guard".into(), &0.into()));
    let sizes = [("F1", 0.03, "N m"), ("F2", 8.0, "rad/s"), ("F3", 0.5, "A")];
    for table in ["faults", "speed_dependent_load"] {
        let rows = report[table].as_array().unwrap();
        assert_eq!(rows.len(), 3);
        for (row, (id, size, unit)) in rows.iter().zip(sizes) {
            assert_eq!((&row["id"], &row["method"], &row["size_unit"]), (&id.into(), &"guard".into(), &unit.into()));
            assert_found(row, size);
        }
    }
    let paper = desk.json("--mode paper --out paper", 0);
    for key in paper.as_object().unwrap().keys() {
        assert!(report.get(key).is_some(), "guard mode lacks `{key}` of paper mode");
    }
    for key in paper["faults"][0].as_object().unwrap().keys() {
        assert!(report["faults"][0].get(key).is_some(), "a fault lacks `{key}` of paper mode");
    }
    for (ours, papers) in report["ramp"].as_array().unwrap().iter().zip(paper["ramp"].as_array().unwrap()) {
        assert_eq!((&ours["id"], &ours["unit"]), (&papers["id"], &papers["unit"]));
        assert!(time(ours, "value_at_detection") < time(papers, "value_at_detection"), "{ours} {papers}");
    }
}

#[test]
fn the_tables_the_page_and_the_trace_say_the_same_of_a_mission() {
    let desk = Desk::with_short();
    let done = desk.run("--scenario short.toml").success().stderr("");
    let text = String::from_utf8(done.get_output().stdout.clone()).unwrap();
    let report = desk.json("--scenario short.toml --mode guard --out json", 0);
    assert_found(&report["faults"][0], 0.5);
    for part in ["guard mode", "F3 current sensor", "Named right: 1 of 1. False alarms: 0.", "monitor-out/mission.html"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let page = desk.read("monitor-out/mission.html");
    for outside in ["://", "<script ", "src=", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for heading in ["What is injected", "Distances, alarms and names", "Growing faults", "A load that grows with speed"]
    {
        let section = page.split("<h2>").find(|section| section.starts_with(heading));
        assert!(section.unwrap_or_else(|| panic!("no {heading}")).contains("<svg"), "{heading} has no picture");
    }
    // Three channels and the distances of three flights, in bins of two samples and behind them the samples around events.
    assert_eq!(page.matches(" 2 15000;").count(), 15);
    for told in ["data-name=\"learning\" data-spans=\"", "contribution, %. 15.00 s: speed "] {
        assert!(page.contains(told), "{told}");
    }
    assert!(page.len() < 3_000_000, "a page of {} bytes", page.len());
    let mut trace = csv::Reader::from_path(desk.path("monitor-out/trace.csv")).unwrap();
    let header = trace.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|found| found == name).unwrap();
    let (phase, rejected, severity) = (column("phase"), column("rejected"), column("severity_fast"));
    let (alarm, located, size) = (column("alarm"), column("located"), column("size"));
    let rows: Vec<_> = trace.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 30_000);
    for row in &rows {
        let is_judged = &row[phase] == "monitoring" && &row[rejected] == "0";
        assert_eq!(row[severity].is_empty(), !is_judged, "{row:?}");
        assert_eq!(row[size].is_empty(), ["", "unknown", "ambiguous"].contains(&&row[located]), "{row:?}");
    }
    let learned = rows.iter().position(|row| &row[phase] == "model due").unwrap();
    assert!((11_999..=12_000).contains(&learned), "learn.end_s = 12: {learned}");
    let raised = rows.iter().position(|row| &row[alarm] == "1").unwrap();
    assert!((raised as f64 / 1000.0 - time(&report["faults"][0], "detected_s")).abs() < 1e-9);
    assert!(rows[16_000..25_000].iter().all(|row| &row[located] == "F3"));
}

#[test]
fn the_same_seed_gives_the_same_mission_and_fewer_false_alarms_wider_limits() {
    let desk = Desk::with_short();
    let fly = |options: &str| {
        let mut report = desk.json(&format!("--scenario short.toml {options}"), 0);
        report["wall_s"] = Value::Null;
        report
    };
    assert_eq!(fly("--seed 7"), fly("--seed 7"));
    assert_ne!(fly("--seed 7")["quality"], fly("--seed 8")["quality"]);
    let middle = |asked| time(&fly(&format!("--false-alarms-per-hour {asked}"))["limits"], "middle");
    assert!(middle("0.001") > middle("0.01") && middle("0.01") > middle("1"));
}

#[test]
fn a_fault_that_no_motor_constant_explains_is_found_and_not_given_the_name_of_another() {
    let supply = SHORT.replace("current_sensor", "voltage_sensor").replace("\"F3\"", "\"V\"");
    let desk = Desk::with("my.toml", &supply);
    let report = desk.json("--scenario my.toml", 0);
    let fault = &report["faults"][0];
    assert!(time(fault, "detected_s") < 15.05 && fault["fault"] == "voltage sensor", "{fault}");
    assert!(!["F1", "F2", "F3"].contains(&fault["located"].as_str().unwrap_or_default()), "{fault}");
}

#[test]
fn an_alarm_that_is_held_back_comes_as_much_later_and_one_that_is_held_up_goes_as_much_later() {
    let desk = Desk::with_short();
    let fault = |options: &str| {
        let report = desk.json(&format!("--scenario short.toml {options}"), 0);
        ["detected_s", "cleared_s"].map(|key| time(&report["faults"][0], key))
    };
    let [detected, cleared] = fault("");
    let [held, _] = fault("--raise-hold 0.5");
    assert!((held - detected - 0.5).abs() < 0.05, "{held} {detected}");
    let [_, kept] = fault("--clear-hold 1.02");
    assert!((kept - cleared - 1.0).abs() < 0.3, "{kept} {cleared}");
}

#[test]
fn options_of_the_other_mode_and_rates_that_make_no_sense_are_refused() {
    let desk = Desk::with_short();
    desk.write("limits.toml", include_str!("../../limits/figure-1.toml"));
    desk.refuses("--limits limits.toml", &["--limits", "--mode paper"]);
    desk.refuses("--mode paper --false-alarms-per-hour 1", &["--false-alarms-per-hour", "guard mode"]);
    desk.refuses("--mode paper --raise-hold 1", &["--raise-hold", "guard mode"]);
    desk.refuses("--mode paper --clear-hold 1", &["--clear-hold", "guard mode"]);
    desk.refuses("--raise-hold -1", &["--raise-hold"]);
    desk.refuses("--scenario short.toml --clear-hold 1e9", &["the hold of an alarm"]);
    for value in ["0", "-1", "nan", "few"] {
        desk.refuses(&format!("--false-alarms-per-hour {value}"), &["--false-alarms-per-hour"]);
    }
    for value in ["1e-30", "1e30"] {
        let command = format!("--scenario short.toml --false-alarms-per-hour {value}");
        desk.refuses(&command, &["false alarms", "--false-alarms-per-hour"]);
    }
    desk.write("hasty.toml", SHORT.replace("end_s = 12.0", "end_s = 2.1"));
    desk.refuses("--scenario hasty.toml", &["learning window", "learn for longer"]);
    desk.write("early.toml", SHORT.replace("start_s = 15.0", "start_s = 7.0"));
    desk.refuses("--scenario early.toml", &["learning failed", "something began in it"]);
}
