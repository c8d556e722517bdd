//! What tuning finds can be flown and replayed with.

use crate::desk::{Desk, MOTOR, SAMPLE, assert_keys};

const TUNE: &str = "tune --scenario short.toml --runs 2";

#[test]
fn thresholds_that_tuning_wrote_are_accepted_by_missions_and_replays() {
    let desk = Desk::with_short();
    desk.write("log.csv", SAMPLE);
    let tuned = desk.json(&format!("{TUNE} --out limits.toml"), 0);
    let thresholds = &tuned["settings"]["thresholds"];
    let mission = desk.json("--scenario short.toml --mode paper --limits limits.toml", 0);
    assert_eq!(mission["limits"], *thresholds);
    assert_eq!(mission["false_alarms"], 0);
    assert_eq!(mission["faults"][1]["located"], "F3");
    let replay = desk.json(&format!("replay log.csv {MOTOR} --limits limits.toml"), 1);
    assert_eq!(replay["limits"], *thresholds);
}

#[test]
fn without_a_file_the_thresholds_are_printed_as_the_file_would_hold_them() {
    let desk = Desk::with_short();
    let printed = desk.run(TUNE).success().stderr("");
    let text = String::from_utf8(printed.get_output().stdout.clone()).unwrap();
    let file = &text[text.find("# Thresholds").unwrap()..];
    let table: toml::Table = file.parse().unwrap();
    assert!(table["thresholds"]["full"].as_float().unwrap() > 1.0, "{table}");
    assert_eq!(desk.files().len(), 1, "a file was written: {:?}", desk.files().keys());

    let told = desk.run(&format!("{TUNE} --out limits.toml")).success();
    assert_eq!(desk.read("limits.toml"), file);
    assert!(String::from_utf8_lossy(&told.get_output().stdout).contains("Written: limits.toml"));
}

#[test]
fn a_page_shows_the_trade_off_and_what_is_recommended() {
    let desk = Desk::with_short();
    let told = desk.run(&format!("{TUNE} --out limits.toml --page tune.html")).success();
    assert!(String::from_utf8_lossy(&told.get_output().stdout).contains("Written: tune.html"));
    let page = desk.read("tune.html");
    let thresholds = desk.read("limits.toml").replace('"', "&quot;");
    for word in ["Recommended: 1.5 times", "F3 current sensor: ", "r=\"8\"", &thresholds] {
        assert!(page.contains(word), "{word}");
    }
    assert!(!page.contains("://"));
    desk.refuses(&format!("{TUNE} --out both.html --page both.html"), &["--out and --page", "both.html"]);
    desk.refuses(&format!("{TUNE} --page missing/tune.html"), &["missing/tune.html", "--page"]);
}

#[test]
fn the_study_of_the_trade_off_is_tuning_by_another_name() {
    let desk = Desk::with_short();
    let [study, tune] = [format!("study {TUNE}"), TUNE.to_owned()].map(|command| {
        let text = String::from_utf8(desk.run(&command).success().get_output().stdout.clone()).unwrap();
        // But for the time it took.
        let (first, rest) = text.split_once('\n').unwrap();
        (first.rsplit_once(", in ").unwrap().0.to_owned(), rest.to_owned())
    });
    assert_eq!(study, tune);
}

#[test]
fn the_trade_off_for_machines_is_one_document() {
    let report = Desk::with_short().json(TUNE, 0);
    assert_keys(&report, &["settings", "residual_unit", "sweep", "hours", "not_separated", "wall_s"]);
    let sweep = report["sweep"].as_array().unwrap();
    assert_keys(&sweep[0], &["margin", "hours", "runs", "false_alarms", "false_alarms_per_hour", "faults"]);
    let setting = &report["settings"]["found_by"];
    let behind = setting["first_seed"].as_u64().unwrap() + setting["runs"].as_u64().unwrap();
    assert_eq!(sweep[0]["first_seed"], behind, "fresh seeds");
    let alarms: Vec<_> = sweep.iter().map(|row| row["false_alarms"].as_u64().unwrap()).collect();
    assert_eq!((alarms[0] > 0, alarms[alarms.len() - 1]), (true, 0), "{alarms:?}");
    assert_eq!(report["settings"]["found_by"]["runs"], 2);
}

#[test]
fn the_same_first_seed_gives_the_same_thresholds_and_the_last_seed_is_one_too() {
    let desk = Desk::with_short();
    let thresholds = |seed: &str| desk.json(&format!("{TUNE} --seed {seed}"), 0)["settings"]["thresholds"].take();
    assert_eq!(thresholds("5"), thresholds("5"));
    assert_ne!(thresholds("5"), thresholds("18446744073709551615"));
}

#[test]
fn a_mission_that_judges_nothing_cannot_be_tuned_on() {
    let desk = Desk::with_short();
    desk.write("my.toml", crate::desk::SHORT.replace("end_s = 12.0", "end_s = 30.0"));
    desk.refuses("tune --scenario my.toml --runs 1 --out limits.toml", &["nothing was judged", "duration_s"]);
}
