//! Options and files of settings that make no sense are refused by name, and nothing is written.

use std::fs;

use crate::desk::{Desk, MOTOR, SAMPLE, SHORT};

const LIMITS: &str = include_str!("../../limits/figure-1.toml");

/// The sample with its channels chosen; what follows is up to the test.
const CHANNELS: &str = "replay log.csv --speed speed --current current --voltage voltage";

/// Refuses each of `values` for `option` of a replay.
fn refuses_values(option: &str, values: &[&str], words: &[&str]) {
    let desk = Desk::with_sample();
    for value in values {
        desk.refuses(&format!("replay log.csv {MOTOR} {option} {value}"), words);
    }
}

/// Refuses the short mission with `from` replaced by `to`, in flight and in tuning.
fn refuses_mission(from: &str, to: &str, words: &[&str]) {
    assert!(SHORT.contains(from), "{from}");
    let desk = Desk::with("my.toml", &SHORT.replace(from, to));
    desk.refuses("--scenario my.toml", words);
    desk.refuses("tune --scenario my.toml --runs 1 --out limits.toml", words);
}

/// Refuses the default thresholds with `from` replaced by `to`, in flight and in replay.
fn refuses_limits(from: &str, to: &str, words: &[&str]) {
    assert!(LIMITS.contains(from), "{from}");
    let desk = Desk::with_sample();
    desk.write("limits.toml", LIMITS.replacen(from, to, 1));
    desk.refuses("--mode paper --limits limits.toml", words);
    desk.refuses(&format!("replay log.csv {MOTOR} --limits limits.toml"), words);
}

#[test]
fn a_learning_window_that_holds_no_samples_to_learn_from_is_refused() {
    let desk = Desk::with_sample();
    let cases: [(&str, &[&str]); 10] = [
        ("50s..70s", &["2500 to 3500", "3000 rows"]),
        ("4000..5000", &["4000 to 5000", "3000 rows"]),
        ("100..129", &["at least 30 samples"]),
        ("0.101s..0.11s", &["no row", "0.101s..0.11s"]),
        ("25s..5s", &["`25s..5s`", "empty"]),
        ("500..500", &["`500..500`", "empty"]),
        ("5s..25", &["mixes rows and seconds"]),
        ("-5..20", &["negative"]),
        ("later", &["`later` is not a window"]),
        ("0..x", &["`x`", "not a number"]),
    ];
    for (window, words) in cases {
        desk.refuses(&format!("{CHANNELS} --rate-hz 50 --learn {window} --mode paper"), words);
        let words = if window == "100..129" { &["29 rows", "at least 180", "--learn"] } else { words };
        desk.refuses(&format!("{CHANNELS} --rate-hz 50 --learn {window}"), words);
    }
}

#[test]
fn a_rate_that_is_no_positive_number_is_refused_whatever_the_window_counts_in() {
    let desk = Desk::with_sample();
    for window in ["5s..25s", "250..1250"] {
        for rate in ["0", "-50", "nan", "inf"] {
            desk.refuses(&format!("{CHANNELS} --rate-hz {rate} --learn {window}"), &["sampling rate", "--rate-hz"]);
        }
        desk.refuses(&format!("{CHANNELS} --rate-hz fast --learn {window}"), &["--rate-hz", "fast"]);
    }
}

#[test]
fn a_cutoff_at_or_above_half_the_rate_is_refused() {
    refuses_values("--cutoff-hz", &["25", "25.1", "1e9", "0", "-1", "nan"], &["cutoff", "half the sampling rate"]);
    refuses_limits("cutoff_hz = 1.0", "cutoff_hz = 500.0", &["cutoff", "half the sampling rate"]);
}

#[test]
fn a_time_or_tolerance_that_is_negative_or_no_number_is_refused() {
    refuses_values("--settle", &["-1", "nan", "inf", "1e30"], &["settling time"]);
    refuses_values("--relearn", &["-1", "0", "nan"], &["learning window", "30 samples"]);
    refuses_values("--set-point-tolerance", &["-1", "nan", "inf"], &["tolerance"]);
}

#[test]
fn a_margin_that_is_not_above_zero_is_refused_by_the_name_of_its_option() {
    refuses_values("--margin", &["0", "-1", "nan", "inf", "much"], &["--margin", "above zero"]);
    let desk = Desk::with_short();
    for value in ["0", "-1", "nan"] {
        for option in ["--margin", "--borderline"] {
            desk.refuses(&format!("tune --scenario short.toml {option} {value}"), &[option, "above zero"]);
        }
    }
}

#[test]
fn an_injection_that_cannot_be_read_is_refused_with_the_way_to_write_it() {
    let injections = [
        "current+0.3@1400",
        "current:0.3@1400",
        "current:+0.3",
        ":+0.3@1400",
        "current:+much@1400",
        "current:+nan@1400",
        "current:ramp+0.3@1400",
        "current:+0.3@1400..1300",
        "current:+0.3@-5",
    ];
    refuses_values("--inject", &injections, &["CHANNEL:CHANGE@FROM"]);
    refuses_values("--inject", &["curent:+0.3@1400"], &["did you mean `current`?", "speed, current, voltage"]);
}

#[test]
fn channels_that_are_not_three_different_ones_are_refused() {
    let desk = Desk::with_sample();
    let cases: [(&str, &[&str]); 7] = [
        ("--channel a=speed --channel b=current", &["three channels", "2 given"]),
        ("--channel a=3 --channel b=4 --channel c=5 --channel d=1", &["three channels", "4 given"]),
        ("--channel a=speed --channel b=current --channel a=voltage", &["the same name"]),
        ("--channel a=speed --channel b=current --channel c=current", &["b and the c", "`current`"]),
        ("--channel a=speed --channel b=current --channel c=voltage --speed speed", &["--channel", "--speed"]),
        ("--channel a --channel b=current --channel c=voltage", &["NAME=COL"]),
        ("--speed speed --current current", &["--voltage"]),
    ];
    for (channels, words) in cases {
        desk.refuses(&format!("replay log.csv {channels} --rate-hz 50 --learn 5s..25s"), words);
    }
}

#[test]
fn a_scenario_that_cannot_be_read_is_named() {
    let desk = Desk::with("table.csv", SAMPLE);
    desk.write("picture.toml", b"\xff\xd8\xff\xe0");
    fs::create_dir(desk.path("missions")).unwrap();
    for command in ["", "tune --runs 1 --out limits.toml"] {
        desk.refuses(&format!("{command} --scenario my.toml"), &["scenario", "'my.toml'"]);
        desk.refuses(&format!("{command} --scenario missions"), &["scenario", "'missions'"]);
        desk.refuses(&format!("{command} --scenario picture.toml"), &["scenario", "'picture.toml'", "UTF-8"]);
        desk.refuses(&format!("{command} --scenario table.csv"), &["scenario 'table.csv'", "TOML", "line 1"]);
    }
}

#[test]
fn an_unknown_key_of_a_scenario_is_refused_with_its_line_and_the_keys_there_are() {
    refuses_mission("duration_s", "durations", &["'my.toml'", "line 3", "`durations`", "`duration_s`"]);
    refuses_mission("profile =", "profil =", &["'my.toml'", "`profil`", "`profile`"]);
}

#[test]
fn a_value_no_mission_can_have_is_refused_with_its_line_key_and_remedy() {
    refuses_mission("end_s = 25.0", "end_s = 10.0", &["line 22", "`fault[0].end_s`", "after it starts"]);
    refuses_mission("end_s = 25.0", "end_s = 30.1", &["line 22", "`fault[0].end_s`", "duration_s = 30"]);
    refuses_mission("end_s = 12.0", "end_s = 31.0", &["line 8", "`learn.end_s`", "duration_s = 30"]);
    refuses_mission("end_s = 12.0", "end_s = 2.0", &["line 8", "`learn.end_s`", "learning window"]);
    refuses_mission("duration_s = 30.0", "duration_s = nan", &["line 3", "`duration_s`", "above 0"]);
    refuses_mission("duration_s = 30.0", "duration_s = 1e15", &["line 3", "`duration_s`", "shorten"]);
    refuses_mission("duration_s = 30.0", "duration_s = 1e300", &["line 3", "`duration_s`", "shorten"]);
}

#[test]
fn a_mission_of_which_only_some_flights_fail_leaves_no_trace_either() {
    // Without noise the step is constant over the learning window and cannot be learned from; the ramp can.
    let silent = SHORT.replace(
        "end_s = 25.0",
        "end_s = 25.0\n[noise]\nspeed_sigma_rad_per_s = 0.0\ncurrent_sigma_a = 0.0\nvoltage_sigma_v = 0.0",
    );
    let loaded = silent.replace("current_sensor", "load_torque").replace("0.5", "0.01");
    let desk = Desk::with("my.toml", &loaded.replace("start_s = 15.0", "start_s = 0.0"));
    desk.refuses("--scenario my.toml --mode paper", &["learning failed", "constant"]);
}

#[test]
fn thresholds_that_cannot_be_read_are_named() {
    let desk = Desk::with_sample();
    for command in ["--mode paper".to_owned(), format!("replay log.csv {MOTOR}")] {
        desk.refuses(&format!("{command} --limits limits.toml"), &["thresholds", "'limits.toml'"]);
        desk.refuses(&format!("{command} --limits log.csv"), &["thresholds", "'log.csv'", "TOML"]);
    }
}

#[test]
fn thresholds_with_an_unknown_key_or_no_positive_number_are_refused_by_key() {
    refuses_limits("full = 1.753", "ful = 1.753", &["'limits.toml'", "line 7", "`ful`", "`full`"]);
    refuses_limits("hysteresis", "hysteresys", &["'limits.toml'", "`hysteresys`"]);
    refuses_limits("full = 1.753", "full = -1.753", &["'full'", "above zero"]);
    refuses_limits("full = 1.753", "full = nan", &["'full'", "above zero"]);
    refuses_limits("speed_current = 1.896", "speed_current = 0.0", &["'speed_current'", "above zero"]);
}

#[test]
fn a_place_that_takes_no_files_is_refused_before_anything_is_flown() {
    let desk = Desk::with_sample();
    desk.write("short.toml", SHORT);
    fs::create_dir(desk.path("limits")).unwrap();
    for out in ["log.csv", "log.csv/below"] {
        desk.refuses(&format!("--scenario short.toml --out {out}"), &[out, "--out"]);
        desk.refuses(&format!("replay log.csv {MOTOR} --out {out}"), &[out, "--out"]);
    }
    // So many runs would take minutes: the refusal comes before the first.
    for out in ["log.csv/below", "missing/below", "limits"] {
        desk.refuses(&format!("tune --scenario short.toml --runs 100000 --out {out}"), &[out, "--out"]);
    }
}

#[test]
fn a_command_or_option_that_does_not_exist_is_refused_with_the_nearest() {
    let desk = Desk::with_sample();
    let cases: [(&str, &[&str]); 8] = [
        ("reply log.csv", &["'reply'", "'replay'"]),
        ("--sede 7", &["'--sede'", "'--seed'"]),
        ("--seed -1", &["--seed"]),
        ("--faults gone", &["step, ramp"]),
        ("--mode other", &["guard", "paper"]),
        ("replay", &["LOG.csv", "--rate-hz", "--learn"]),
        ("replay log.csv --out there", &["--rate-hz", "--learn"]),
        ("--json replay log.csv", &["'--json'"]),
    ];
    for (command, words) in cases {
        desk.refuses(command, words);
    }
    refuses_values("--limits limits.toml --margin", &["2"], &["--limits", "--margin"]);
}

#[test]
fn tuning_without_a_run_is_refused() {
    let desk = Desk::with_short();
    for runs in ["0", "-1", "100001", "many"] {
        desk.refuses(&format!("tune --scenario short.toml --runs {runs}"), &["--runs"]);
    }
}

#[test]
fn a_refused_run_leaves_the_results_of_an_earlier_one_as_they_were() {
    let desk = Desk::with_sample();
    desk.run(&format!("replay log.csv {MOTOR}")).code(1);
    assert_eq!(desk.files().len(), 4, "the log, the page, the trace and the baseline");
    let cut = SAMPLE.replacen("\n59.98", "\nnoon,300,299,abc,9\n59.98", 1);
    desk.write("bad.csv", cut);
    desk.refuses(&format!("replay bad.csv {MOTOR}"), &["row 2999", "`abc`"]);
}

#[test]
fn a_stored_baseline_that_does_not_fit_is_refused_with_what_does_not() {
    let desk = Desk::with_sample();
    desk.run(&format!("replay log.csv {MOTOR} --out first")).code(1);
    let stored = desk.read("first/baseline.toml");
    let columns = "--speed speed --current current --voltage voltage --rate-hz 50 --mode paper";
    let refused = |text: &str, options: &str, words: &[&str]| {
        desk.write("other.toml", text);
        desk.refuses(&format!("replay log.csv {options} --baseline other.toml"), words);
    };
    refused(&stored, &columns.replace("50", "100"), &["learned at 50 Hz", "100 Hz"]);
    refused(&stored.replace("\"current\"", "\"amps\""), columns, &["speed, amps, voltage"]);
    refused(&stored.replace("samples = 1000", "samples = 3"), columns, &["at least 30 samples"]);
    refused(&stored.replace("sigma = [", "sigma = [-"), columns, &["sigma of 'speed'"]);
    refused(&stored.replace("rate_hz", "rate"), columns, &["other.toml", "rate"]);
    desk.refuses(&format!("replay log.csv {columns} --baseline none.toml"), &["none.toml"]);
    desk.refuses(&format!("replay log.csv {MOTOR} --baseline first/baseline.toml"), &["--learn", "--baseline"]);
    desk.refuses(&format!("replay log.csv {columns}"), &["--learn"]);
}

#[test]
fn a_file_that_is_read_is_never_overwritten() {
    let desk = Desk::with("replay.csv", SAMPLE);
    desk.refuses(&format!("replay replay.csv {MOTOR} --out ."), &["replay.csv", "--out"]);
    desk.refuses(&format!("replay ./replay.csv {MOTOR} --out ."), &["replay.csv", "--out"]);
    desk.write("short.toml", SHORT);
    desk.refuses("tune --scenario short.toml --runs 1 --out ./short.toml", &["short.toml", "--out"]);
}
