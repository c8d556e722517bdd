//! Studies: the same result for any number of threads and after an interruption, and a sentence for what makes no sense.

use monitor_sim::tables::significant;
use serde_json::Value;

use crate::desk::{Desk, assert_keys};

/// Four motors, and as little as can be judged.
const SMALL: &str =
    "study false-alarms --mode paper --motors 4 --hours 0.01 --calibration-runs 2 --calibration-judged 20 --asked 50";

fn stdout(desk: &Desk, arguments: &str) -> Vec<u8> {
    desk.run(arguments).success().stderr("").get_output().stdout.clone()
}

#[test]
fn a_study_gives_the_same_bytes_on_one_thread_and_on_two() {
    let desk = Desk::new();
    let one = stdout(&desk, &format!("{SMALL} --json --threads 1"));
    assert_eq!(one, stdout(&desk, &format!("{SMALL} --json --threads 2")));
    assert_ne!(one, stdout(&desk, &format!("{SMALL} --json --seed 2")));
}

#[test]
fn every_row_for_machines_has_its_units_seeds_and_counts() {
    let report = Desk::new().json(SMALL, 0);
    assert_keys(&report, &["study", "settings", "version", "units", "steps", "rows"]);
    assert_eq!((&report["study"], &report["settings"]["mode"]), (&"false-alarms".into(), &"paper".into()));
    let rows = report["rows"].as_array().unwrap();
    assert_keys(&rows[0], &["hours", "alarms", "alarms_per_hour", "alarms_per_hour_high_95", "asked_per_hour"]);
    assert_eq!(rows.len(), 5);
    assert_keys(&rows[1], &["motor_seed", "flight_seed", "hours", "alarms", "thresholds"]);
    let hours: f64 = rows[1..].iter().map(|row| row["hours"].as_f64().unwrap()).sum();
    assert!((hours - 0.01).abs() < 1e-6, "{hours}");
}

/// The rows of all tables in a printed text, as cells.
fn table_rows(text: &str) -> Vec<Vec<String>> {
    let mut lines = text.lines();
    let mut rows = Vec::new();
    while lines.any(|line| line.starts_with('─')) {
        let table = lines.by_ref().take_while(|line| !line.trim().is_empty());
        rows.extend(
            table.map(|line| {
                line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(str::to_owned).collect()
            }),
        );
    }
    rows
}

/// Every number in a value, however deep.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Number(number) => number.as_f64().into_iter().collect(),
        Value::String(text) => text.parse().into_iter().collect(), // a share has the unit "1"
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        Value::Object(fields) => fields.values().flat_map(numbers).collect(),
        _ => Vec::new(),
    }
}

/// Whether a cell is a number that a row has, or a share in percent that it has or that two of its counts make.
fn is_told(cell: &str, row: &Value) -> bool {
    let numbers = numbers(row);
    let percent = |share: f64| format!("{:.1}", 100.0 * share) == cell;
    let is = |x: f64| significant(x) == cell || significant(x.abs()) == cell || x.to_string() == cell || percent(x);
    numbers.iter().any(|x| is(*x)) || numbers.iter().any(|of| numbers.iter().any(|count| percent(count / of)))
}

#[test]
fn every_number_that_people_are_told_is_in_the_row_for_machines_with_its_seed_and_its_counts() {
    let quick = "--calibration-runs 2 --calibration-judged 30 --out rows.json";
    let desk = Desk::new();
    // The rows for machines that belong to those of the tables: all of these kinds, in this order.
    for (study, kinds) in [
        ("false-alarms --motors 2 --hours 0.01", &["total"][..]),
        ("delay --seeds 2 --sizes 1", &["loop", "white"]),
        ("ramp --seeds 2", &[""]),
        ("localization --motors 2 --sizes 2,16", &["size", "confusion", "isolable"]),
        ("robustness --motors 1 --healthy 10", &["disturbance", "stuck"]),
    ] {
        let text = String::from_utf8(stdout(&desk, &format!("study {study} --mode paper {quick}"))).unwrap();
        let report: Value = serde_json::from_str(&desk.read("rows.json")).unwrap();
        let rows = report["rows"].as_array().unwrap();
        let of = |kind: &'static str| rows.iter().filter(move |row| kind.is_empty() || row["row"] == kind);
        let told = kinds.iter().flat_map(|kind| of(kind));
        let (told, shown): (Vec<_>, _) = (told.collect(), table_rows(&text));
        assert_eq!(told.len(), shown.len(), "{study}\n{text}");
        for (row, cells) in told.into_iter().zip(shown) {
            assert!(["seed", "first_seed"].iter().any(|seed| row[seed].is_u64()), "{study}: no seed in {row}");
            let counts = ["motors", "flights"];
            assert!(counts.iter().any(|count| row[count].is_u64()), "{study}: of how many? {row}");
            let numbers =
                cells.iter().map(|cell| cell.trim_end_matches(" never")).filter(|cell| cell.parse::<f64>().is_ok());
            numbers.for_each(|cell| assert!(is_told(cell, row), "{study}: {cell} of {cells:?} is not in {row}"));
        }
    }
}

#[test]
fn an_interrupted_study_goes_on_to_the_same_result() {
    let desk = Desk::new();
    let whole = stdout(&desk, &format!("{SMALL} --json --resume units.jsonl --threads 1"));
    let lines = desk.read("units.jsonl");
    assert_eq!(lines.lines().count(), 5);
    // Two units were finished and a third was being written. The first is marked, to show that it is not flown again.
    let mut left: Vec<String> = lines.lines().take(4).map(str::to_owned).collect();
    left[3].truncate(20);
    desk.write("units.jsonl", left.join("\n"));
    assert_eq!(stdout(&desk, &format!("{SMALL} --json --resume units.jsonl")), whole);
    let marked = desk.read("units.jsonl").replacen("\"begun\":", "\"begun\":1000", 1);
    desk.write("units.jsonl", marked);
    let report = desk.json(&format!("{SMALL} --resume units.jsonl"), 0);
    assert!(report["rows"][0]["alarms"].as_u64().unwrap() >= 1000, "{}", report["rows"][0]);
}

/// The page that a study wrote: it stands alone, and holds these words.
fn assert_page(desk: &Desk, name: &str, words: &[&str]) {
    let page = desk.read(name);
    for outside in ["://", "<script ", "src=", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for word in words {
        assert!(page.contains(word), "no {word} in {name}");
    }
}

#[test]
fn a_page_pictures_what_a_study_found() {
    let desk = Desk::new();
    let told = String::from_utf8(stdout(&desk, &format!("{SMALL} --out result.json --page a.html"))).unwrap();
    assert!(told.contains("Written: result.json, a.html"), "{told}");
    assert_page(&desk, "a.html", &["hours of 4 motors", ">all motors</text>", "asked for", "calibration_runs"]);
    let few = "--seeds 1 --calibration-runs 2 --calibration-judged 20 --mode paper";
    stdout(&desk, &format!("study delay --sizes 1,2 {few} --page d.html"));
    assert_page(&desk, "d.html", &["Lorden's bound</li>", "F1 load torque: 1.000, ", "F3 current sensor: 2.000, "]);
    stdout(&desk, "study localization --motors 1 --sizes 8 --faults paper --mode paper --page l.html");
    assert_page(
        &desk,
        "l.html",
        &[
            "3 of 3 faults of 1 motors detected",
            "<title>F3 current sensor, 8: right name 100.0 %</title>",
            ">no name</text>",
        ],
    );
    stdout(&desk, "study robustness --motors 1 --healthy 10 --page b.html");
    assert_page(
        &desk,
        "b.html",
        &["0 false alarms in ", "undisturbed: 0, 0, 1328", ">0, up to 1328<", "ADC step 16 sigma, F1 load torque: "],
    );
    stdout(&desk, &format!("study ramp {few} --page r.html"));
    assert_page(
        &desk,
        "r.html",
        &["faults detected while they grew", "% of the value at the end", "F2 speed sensor: "],
    );
}

#[test]
fn the_result_is_written_to_a_file_as_it_is_printed() {
    let desk = Desk::new();
    let printed = stdout(&desk, &format!("{SMALL} --json --out result.json"));
    assert_eq!(desk.read("result.json").into_bytes(), printed);
    let told = String::from_utf8(stdout(&desk, &format!("{SMALL} --out result.json"))).unwrap();
    assert!(told.contains("Written: result.json") && told.contains("per hour"), "{told}");
}

#[test]
fn a_monitor_that_learns_in_two_seconds_judges_the_rest() {
    let desk = Desk::new();
    let total =
        |learn: &str| desk.json(&format!("study false-alarms --motors 1 --hours 0.02 {learn}"), 0)["rows"][0].clone();
    let (short, usual) = (total("--learn 2"), total(""));
    assert_eq!((&short["learn_s"], &usual["learn_s"]), (&2.0.into(), &Value::Null));
    // Half a second before the window, then the window, then 72 s.
    for (total, learn_s) in [(short, 2.0), (usual, 15.0)] {
        let judged = total["judged_share"].as_f64().unwrap();
        assert!((judged - 72.0 / (72.5 + learn_s)).abs() < 1e-3, "{total}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_a_sentence() {
    let desk = Desk::new();
    desk.refuses("study", &["false-alarms"]);
    desk.refuses("study false-alarms --learn 0", &["--learn", "above zero"]);
    desk.refuses("study false-alarms --learn 1", &["learning window", "24 middle time constants", "learn for longer"]);
    desk.refuses("study tides", &["tides"]);
    desk.refuses("study false-alarms --hours 0", &["--hours", "above zero"]);
    desk.refuses("study false-alarms --motors 0", &["--motors"]);
    desk.refuses("study false-alarms --asked nan", &["--asked", "above zero"]);
    desk.refuses("study false-alarms --threads 0", &["--threads"]);
    desk.refuses("study false-alarms --mode magic", &["--mode", "paper"]);
    desk.refuses(&format!("{SMALL} --out nowhere/result.json"), &["nowhere/result.json", "--out"]);
    desk.refuses(&format!("{SMALL} --out a.json --resume a.json"), &["--resume", "--out", "a.json"]);
    desk.refuses(
        "study false-alarms --mode paper --motors 2 --calibration-judged 0.5",
        &["nothing was judged", "--calibration-judged"],
    );
    desk.write("other.csv", "time,speed\n");
    desk.refuses(&format!("{SMALL} --resume other.csv"), &["other.csv", "not a file of finished units", "--resume"]);
    stdout(&desk, &format!("{SMALL} --resume units.jsonl"));
    desk.refuses(&format!("{SMALL} --resume units.jsonl --seed 9"), &["seed = 1 there and 9 now", "--resume"]);
}

#[test]
fn a_larger_fault_is_seen_sooner_and_white_noise_no_sooner_than_theory_allows() {
    let report = Desk::new()
        .json("study delay --mode paper --seeds 2 --sizes 0.25,2 --calibration-runs 2 --calibration-judged 30", 0);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 7 * 2 + 5);
    let of = |id: &str| rows.iter().filter(move |row| row["fault"] == id).collect::<Vec<_>>();
    for id in ["F1", "F2", "F3"] {
        let [small, large] = of(id)[..] else { panic!("two sizes of {id}") };
        assert_keys(small, &["size", "amplitude", "unit", "first_seed", "recovered_s", "cleared_behind_recovery_s"]);
        assert_eq!((&small["detected"], &large["detected"]), (&2.into(), &2.into()), "{id}");
        let median = |row: &serde_json::Value, key: &str| row[key]["median"].as_f64().unwrap();
        assert!(median(large, "delay_s") < median(small, "delay_s"), "{id}");
        assert!(median(large, "recovered_s") > median(small, "recovered_s"), "{id}");
        let shift = |row: &serde_json::Value| median(row, "settled_shift_sigmas");
        assert!((shift(large) / shift(small) - 8.0).abs() < 0.2, "{id}: the loop is linear");
    }
    let white = rows.iter().filter(|row| row["row"] == "white").collect::<Vec<_>>();
    let ratios: Vec<f64> = white.iter().filter_map(|row| row["lorden_ratio"].as_f64()).collect();
    assert!(!ratios.is_empty() && ratios.iter().all(|ratio| *ratio > 0.8), "{ratios:?}");
}

#[test]
fn the_smallest_ramp_of_a_scenarios_own_fault_is_found_and_half_of_it_is_not() {
    let desk = Desk::new();
    let fault = "[[fault]]\nid = \"A\"\nname = \"a\"\npoint = \"current_sensor\"\nkind = \"offset\"\nprofile = \"step\"\n\
                 amplitude = 0.5\nstart_s = 10.0\nend_s = 12.0\n";
    let motor = "name = \"mine\"\nduration_s = 20.0\n[learn]\nstart_s = 1.0\nend_s = 5.0\n";
    desk.write("own.toml", format!("{motor}{fault}"));
    let of = |options: &str| desk.json(&format!("study ramp --scenario own.toml --seeds 1 --ramp 5 {options}"), 0);
    let smallest = of("--smallest")["rows"][0]["smallest_ramp"]["median"].as_f64().unwrap();
    assert!(smallest > 0.0 && smallest < 0.1, "{smallest}");
    let words =
        ["Last value of the smallest ramp over 5 s that is detected: ", "of the smallest ramp, %", "those of mine."];
    stdout(&desk, "study ramp --scenario own.toml --seeds 1 --ramp 5 --smallest --page r.html");
    assert_page(&desk, "r.html", &words);
    // A ramp to that value, of a fault of 0.5 A, is detected before it ends; one to half of it is not.
    let found = |size: f64| of(&format!("--size {size}"))["rows"][0]["detected"] == 1;
    assert!(found(smallest / 0.5) && !found(smallest), "{smallest}");
    desk.write("none.toml", motor);
    desk.refuses("study ramp --scenario none.toml", &["none.toml", "no fault", "[[fault]]"]);
    desk.refuses("study ramp --scenario nowhere.toml", &["nowhere.toml"]);
}

#[test]
fn the_value_of_a_ramp_at_detection_lies_on_the_ramp() {
    let report = Desk::new().json("study ramp --mode paper --seeds 3 --calibration-runs 2 --calibration-judged 30", 0);
    let rows = report["rows"].as_array().unwrap();
    let ids: Vec<_> = rows.iter().map(|row| row["fault"].as_str().unwrap()).collect();
    assert_eq!(ids, ["F1", "F2", "F3", "R", "K", "U", "J"]);
    for row in &rows[..6] {
        assert_keys(row, &["unit", "flights", "first_seed", "values"]);
        assert_eq!(row["detected"], 3, "{row}");
        let [least, median, greatest] =
            ["min", "median", "max"].map(|key| row["value_at_detection"][key].as_f64().unwrap());
        assert!(0.0 < least && least <= median && median <= greatest, "{row}");
        assert!(greatest < 0.5 * row["amplitude"].as_f64().unwrap().abs(), "{row}");
    }
}

#[test]
fn every_flight_of_every_fault_is_counted_once_in_the_confusion_table() {
    let arguments =
        "study localization --mode paper --motors 3 --sizes 2,32 --calibration-runs 2 --calibration-judged 30";
    let report = Desk::new().json(arguments, 0);
    let rows = report["rows"].as_array().unwrap();
    let of = |kind: &str| rows.iter().filter(move |row| row["row"] == kind).collect::<Vec<_>>();
    assert_eq!((of("size").len(), of("confusion").len(), of("isolable").len()), (14, 7, 3));
    for row in of("confusion") {
        let named: u64 = row["named"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
        let rest = ["nameless", "missed", "early_alarms"].map(|key| row[key].as_u64().unwrap());
        assert_eq!(named + rest.iter().sum::<u64>(), 6, "{row}");
    }
    // A current sensor that is far off moves nothing but its own reading: the paper's table names it.
    let large = of("size").into_iter().find(|row| row["fault"] == "F3" && row["asked_sigmas"] == 32.0).unwrap();
    assert_eq!((&large["detected"], &large["named_right"]), (&3.into(), &3.into()), "{large}");
    // Without other candidates more of a shift is its own.
    let papers = Desk::new().json(&format!("{arguments} --faults paper"), 0);
    let papers = papers["rows"].as_array().unwrap();
    let papers_large = papers.iter().find(|row| row["fault"] == "F3" && row["asked_sigmas"] == 32.0).unwrap();
    let apart = |row: &serde_json::Value| row["apart_sigmas"]["median"].as_f64().unwrap();
    assert!(papers.len() == 3 * 2 + 3 + 3 && apart(papers_large) >= apart(large), "{papers_large}");
    assert_keys(large, &["seed", "flights", "sigmas", "apart_sigmas", "named_right_group", "right_name_stands"]);
}

#[test]
fn what_disturbs_a_monitor_is_counted_for_each_level_and_each_fault() {
    let arguments =
        "study robustness --mode paper --motors 1 --healthy 10 --size 32 --calibration-runs 2 --calibration-judged 30";
    let report = Desk::new().json(arguments, 0);
    let rows = report["rows"].as_array().unwrap();
    let of = |kind: &str| rows.iter().filter(move |row| row["row"] == kind).collect::<Vec<_>>();
    assert_eq!((of("disturbance").len(), of("stuck").len()), (15, 3));
    for row in of("disturbance") {
        assert_keys(row, &["level", "seed", "motors", "judged_share", "hours", "alarms_per_hour_high_95", "delay_s"]);
        for fault in row["faults"].as_array().unwrap() {
            assert_eq!(fault["flights"], 1, "{row}");
        }
    }
    let of_kind = |disturbance: &str, level: &str| {
        let mut rows = of("disturbance").into_iter();
        rows.find(|row| row["disturbance"] == disturbance && row["level"] == level).unwrap()
    };
    let undisturbed = of_kind("none", "");
    assert!(undisturbed["faults"].as_array().unwrap().iter().all(|fault| fault["detected"] == 1), "{undisturbed}");
    assert_eq!(undisturbed["judged_share"], 1.0);
    // Every second slot has no sample that could be judged: of 10,000 standard error 50; four of it.
    let lossy = of_kind("missing samples", "50.00 %");
    assert!((lossy["judged_share"].as_f64().unwrap() - 0.5).abs() < 0.02, "{lossy}");
}

#[test]
fn the_speed_of_plant_and_monitor_is_measured() {
    let report = Desk::new().json("study speed --steps 20000", 0);
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.len() >= 6, "{report}");
    for row in rows {
        assert_keys(row, &["motor", "what", "threads", "steps", "wall_s", "steps_per_s_and_thread", "monitor_share"]);
        // The learning window of 15.5 s at 1 kHz comes on top.
        assert_eq!(row["steps"].as_u64().unwrap(), 35_500 * row["threads"].as_u64().unwrap(), "{row}");
        assert!(row["steps_per_s_and_thread"].as_f64().unwrap() > 1e3, "{row}");
        assert_keys(row, &["seed", "repetitions"]);
    }
    let kernels = report["kernels"].as_array().unwrap();
    let channels: Vec<_> = kernels.iter().map(|row| row["channels"].as_u64().unwrap()).collect();
    assert_eq!(
        channels,
        [1, 2, 3, 1, 2, 3, 2, 3, 2, 3],
        "any number of channels is smoothed; two and three are decomposed"
    );
    for row in kernels {
        assert_keys(row, &["kernel", "seed", "repetitions", "calls"]);
        assert!((0.01..1e5).contains(&row["ns_each"].as_f64().unwrap()), "{row}");
    }
}

#[test]
fn the_ramp_table_of_the_readme_is_what_the_command_prints() {
    const README: &str = include_str!("../../../README.md");
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let readme: Vec<String> = README.lines().map(words).collect();
    let printed = String::from_utf8(stdout(&Desk::new(), "study ramp --mode paper")).unwrap();
    let rows: Vec<String> = printed.lines().filter(|line| line.contains(" 20 ")).map(words).collect();
    assert_eq!(rows.len(), 7, "{printed}");
    for row in rows {
        assert!(readme.contains(&row), "not in the README:\n{row}");
    }
}
