//! What was learned of one log or flight judges another.

use std::fs;

use serde_json::Value;

use crate::desk::{Desk, GUARD, SAMPLE, SHORT, healthy};

/// How the sample is read, without where to learn.
const COLUMNS: &str = "--speed speed --current current --voltage voltage --rate-hz 50";
const CONSTANTS: &str = "--resistance 0.33 --torque-constant 0.0275 --load-slope 0";

/// Bytes of one model.
const BYTES: usize = 332;

/// The sample from within its fault on, which ends at row 700 of it.
fn faulty_from_the_first_row() -> String {
    let (header, rows) = SAMPLE.split_once('\n').unwrap();
    format!("{header}\n{}", rows.split_inclusive('\n').skip(1800).collect::<String>())
}

/// A directory with what was learned of the healthy part of the sample, and with `log.csv`.
fn learned(log: &str) -> Desk {
    let desk = Desk::with("healthy.csv", &healthy());
    desk.write("log.csv", log);
    desk.run(&format!("replay healthy.csv {GUARD} --save-models m.models --out learned")).success();
    desk
}

#[test]
fn a_fault_that_stands_from_the_first_row_on_is_found_and_named_by_what_was_learned_of_another_log() {
    let desk = learned(&faulty_from_the_first_row());
    let report = desk.json(&format!("replay log.csv {COLUMNS} --models m.models --relearn 20 {CONSTANTS}"), 1);
    let alarm = &report["alarms"][0];
    assert!(alarm["start_row"].as_u64().unwrap() < 400, "as soon as it is seen to stand: {alarm}");
    assert!((700..750).contains(&alarm["end_row"].as_u64().unwrap()), "{alarm}");
    assert_eq!(alarm["located"], "F2", "{alarm}");
    assert_eq!((&report["models"], &report["learned"]["quality"]), (&"m.models".into(), &Value::Null));
    // The log alone takes the fault for healthy, and its end for a fault.
    let alone = desk.json(&format!("replay log.csv {COLUMNS} --learn 0..500"), 1);
    assert!(alone["alarms"][0]["start_row"].as_u64().unwrap() >= 700, "{alone}");
}

#[test]
fn what_is_needed_to_judge_another_log_is_told_and_holds_and_the_file_may_be_the_one_that_was_read() {
    let desk = learned(&healthy());
    let before = fs::read(desk.path("m.models")).unwrap();
    assert_eq!(before.len(), BYTES);
    let saved = desk.json(&format!("replay healthy.csv {GUARD} --save-models m.models"), 0);
    assert!(saved["files"].as_array().unwrap().contains(&"m.models".into()), "{saved}");
    let notes: Vec<_> = saved["notes"].as_array().unwrap().iter().map(|note| note.as_str().unwrap()).collect();
    let how = notes.iter().find_map(|note| note.split('`').nth(1)).unwrap();
    let report = desk.json(&format!("replay log.csv {COLUMNS} {how} --save-models m.models"), 0);
    assert_eq!(report["alarms"], Value::Array(vec![]));
    assert!(report["coverage"]["monitoring"].as_u64().unwrap() > 1500, "{}", report["coverage"]);
    // It has become sharper meanwhile.
    let after = fs::read(desk.path("m.models")).unwrap();
    assert!(after.len() == BYTES && after != before);
    let limit = |models: &[u8]| {
        desk.write("m.models", models);
        desk.json(&format!("replay log.csv {COLUMNS} {how}"), 0)["limits"]["middle"].as_f64().unwrap()
    };
    assert!(limit(&after) < limit(&before));
}

#[test]
fn a_dump_of_flash_is_read_up_to_where_nothing_was_written() {
    let desk = learned(&healthy());
    let models = fs::read(desk.path("m.models")).unwrap();
    desk.write("dump.bin", [&models[..], &[0xff; 1000]].concat());
    let judged = |file: &str| desk.json(&format!("replay log.csv {COLUMNS} --models {file} --relearn 20"), 0);
    assert_eq!(judged("dump.bin")["limits"], judged("m.models")["limits"]);
}

#[test]
fn models_that_do_not_fit_are_refused_with_what_does_not_and_what_helps() {
    let desk = learned(SAMPLE);
    let models = fs::read(desk.path("m.models")).unwrap();
    let judge = format!("replay log.csv {COLUMNS} --relearn 20 --models");
    let refuses = |bytes: &[u8], words: &[&str]| {
        desk.write("other.models", bytes);
        desk.refuses(&format!("{judge} other.models"), &[&["'other.models'"], words].concat());
    };
    let mut damaged = models.clone();
    damaged[100] ^= 1;
    refuses(&damaged, &["model 1", "lost or changed", "copy"]);
    refuses(&[&models[..], &models[..300]].concat(), &["model 2", "332 bytes", "copy"]);
    refuses(SAMPLE.as_bytes(), &["model 1", "another version", "--save-models"]);
    for nothing in [vec![], vec![0xff; 2048]] {
        refuses(&nothing, &["none", "--save-models"]);
    }
    desk.refuses(&format!("{judge} gone.models"), &["'gone.models'", "--save-models", "--learn"]);
    let with = |columns: &str, options: &str, words: &[&str]| {
        desk.refuses(&format!("replay log.csv {columns} --models m.models {options}"), words);
    };
    with(&COLUMNS.replace("50", "100"), "--relearn 10", &["'m.models'", "50 Hz", "learn anew"]);
    with(COLUMNS, "", &["'m.models'", "time constants", "--relearn"]);
    with(COLUMNS, "--relearn nan", &["--relearn"]);
    with(COLUMNS, "--relearn 20 --false-alarms-per-hour 1", &["'m.models'", "--false-alarms-per-hour"]);
    with(COLUMNS, "--learn 0..500", &["--learn", "--models"]);
    with(COLUMNS, "--mode paper", &["--models", "guard mode"]);
    desk.refuses(&format!("replay log.csv {GUARD} --mode paper --save-models n"), &["--save-models", "guard mode"]);
    desk.refuses(&format!("replay log.csv {GUARD} --save-models gone/m"), &["gone/m", "--save-models"]);
    desk.refuses(&format!("replay log.csv {GUARD} --save-models log.csv"), &["log.csv", "--save-models"]);
    // A run that is refused writes no models.
    desk.refuses(
        &format!("replay log.csv {COLUMNS} --learn 1400..2200 --save-models n.models --out learned"),
        &["choose"],
    );
}

#[test]
fn a_set_point_that_is_not_among_the_models_is_never_taken_for_a_known_one() {
    let desk = Desk::with("healthy.csv", &healthy());
    desk.run(&format!("replay healthy.csv {GUARD} --set-point set_point --save-models m.models")).success();
    let judge = "--models m.models --relearn 20";
    let all = ["--learn <A..B>", "--models <FILE|DIR>", "--baseline <FILE>"];
    desk.refuses(&format!("replay healthy.csv {COLUMNS}"), &all);
    desk.refuses(&format!("replay healthy.csv {COLUMNS} {judge} --learn 0..200"), &["--learn", "--models"]);
    desk.refuses(&format!("replay healthy.csv {COLUMNS} {judge}"), &["set points 300", "--set-point"]);
    desk.write("other.csv", healthy().replace(",300,", ",200,"));
    let report = desk.json(&format!("replay other.csv {COLUMNS} --set-point set_point {judge}"), 0);
    let notes = report["notes"].to_string();
    assert!(notes.contains("set point 200 is none of those in 'm.models'"), "{notes}");
    assert_eq!(report["learned"]["n"], 800);
}

#[test]
fn each_log_of_a_fleet_is_judged_by_a_file_of_its_own_in_a_directory_or_all_by_one() {
    let desk = Desk::with("first/a.csv", &healthy());
    desk.write("first/b.csv", healthy());
    desk.json(&format!("replay first {GUARD} --save-models learned --out o"), 0);
    assert!(desk.path("learned/a.models").exists() && desk.path("learned/b.models").exists());
    desk.write("second/a.csv", healthy());
    desk.write("second/b.csv", faulty_from_the_first_row());
    let judge = format!("replay second {COLUMNS} --relearn 20 {CONSTANTS} --out o");
    for models in ["learned", "learned/a.models"] {
        let report = desk.json(&format!("{judge} --models {models}"), 1);
        assert_eq!(report["outcome"], serde_json::json!({ "healthy": 1, "faulty": 1, "refused": 0 }));
        assert_eq!(
            (&report["logs"][1]["name"], &report["logs"][1]["learned"]),
            (&"F2 speed sensor".into(), &Value::Null)
        );
    }
    fs::remove_file(desk.path("learned/a.models")).unwrap();
    let report = desk.json(&format!("{judge} --models learned"), 2);
    assert!(report["logs"][0]["error"].as_str().unwrap().contains("learned/a.models"), "{report}");
    desk.refuses(&format!("{judge} --models gone.models"), &["'gone.models'"]);
    desk.refuses(
        &format!("replay first second {GUARD} --save-models twice"),
        &["first/a.csv", "second/a.csv", "rename"],
    );
}

#[test]
fn a_mission_is_judged_from_its_settling_on_by_what_another_flight_learned() {
    let desk = Desk::with_short();
    let learned = desk.json("--scenario short.toml --save-models m.models", 0);
    assert!(learned["files"].as_array().unwrap().contains(&"m.models".into()));
    // A fault in what would be the learning window.
    desk.write("early.toml", SHORT.replace("start_s = 15.0", "start_s = 4.0"));
    let report = desk.json("--scenario early.toml --seed 2 --models m.models", 0);
    let fault = &report["faults"][0];
    assert!(fault["detected_s"].as_f64().unwrap() < 4.05 && fault["located"] == "F3", "{fault}");
    assert_eq!((&report["false_alarms"], &report["quality"]), (&0.into(), &Value::Null));
    desk.refuses("--scenario short.toml --models short.toml", &["'short.toml'", "model 1"]);
    desk.refuses("--scenario short.toml --models m.models --false-alarms-per-hour 1", &["--false-alarms-per-hour"]);
    desk.refuses("--mode paper --models m.models", &["--models", "guard mode"]);
    desk.refuses("--scenario short.toml --save-models gone/m", &["gone/m", "--save-models"]);
    desk.refuses("--scenario short.toml --models gone.models", &["'gone.models'", "No such file", "or learn instead"]);
}

#[test]
fn a_mission_and_a_log_are_watched_by_what_was_learned_before() {
    let desk = learned(&faulty_from_the_first_row());
    let frame = |arguments: &str| {
        let printed = desk.run(&format!("watch {arguments}")).success().stderr("").get_output().stdout.clone();
        String::from_utf8(printed).unwrap()
    };
    let log = format!("log.csv {COLUMNS} {CONSTANTS} --models m.models --relearn 20");
    let text = frame(&format!("{log} --print-at 9"));
    assert!(text.contains("ALARM  F2 speed sensor"), "{text}");

    desk.write("short.toml", SHORT);
    desk.run("--scenario short.toml --save-models flown.models").success();
    // A fault in what would be the learning window.
    desk.write("early.toml", SHORT.replace("start_s = 15.0", "start_s = 4.0"));
    let early = "--scenario early.toml --seed 2 --print-at 7";
    let text = frame(&format!("{early} --models flown.models"));
    assert!(text.contains("ALARM  F3 current sensor"), "{text}");
    assert!(frame(early).contains("learning what healthy means"));

    desk.refuses(&format!("watch {early} --mode paper --models flown.models"), &["--models", "guard mode"]);
    desk.refuses(&format!("watch {log} --mode paper --print-at 3"), &["--models", "guard mode"]);
    desk.refuses(&format!("watch {log} --learn 0..100 --print-at 3"), &["--learn", "--models"]);
    desk.refuses(&format!("watch {early} --models early.toml"), &["'early.toml'", "model 1"]);
    desk.refuses(&format!("watch {early} --models flown.models --relearn 9"), &["--relearn", "LOG"]);
    desk.refuses(&format!("watch log.csv {COLUMNS} --models flown.models --print-at 3"), &["flown.models", "1000 Hz"]);
}
