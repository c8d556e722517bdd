//! What `watch` shows: single frames as text, and what it says where there is no terminal.

use crate::desk::{Desk, GUARD, MOTOR, SAMPLE};

const CONSTANTS: &str = "--resistance 0.33 --torque-constant 0.0275 --load-slope 0";

fn frames(desk: &Desk, arguments: &str) -> String {
    let done = desk.run(&format!("watch {arguments}")).code(0).stderr("");
    String::from_utf8(done.get_output().stdout.clone()).unwrap()
}

#[test]
fn frames_of_a_mission_are_printed_for_the_seconds_asked_for_and_nothing_is_written() {
    let desk = Desk::with_short();
    let text = frames(&desk, "--scenario short.toml --seed 3 --print-at 14 --print-at 24.5 --size 100x30");
    let (before, fault) = text.split_at(text.match_indices("short, seed 3, guard mode").nth(1).unwrap().0);
    assert_eq!((before.lines().count(), fault.lines().count()), (30, 30));
    assert!(before.contains("14.00 s of 30 s") && before.contains("\n healthy\n"), "{before}");
    assert!(fault.contains("ALARM  F3 current sensor") && fault.contains("15.000 F3 begins"), "{fault}");
    assert_eq!(desk.files().len(), 1);
    let paper = frames(&desk, "--scenario short.toml --mode paper --print-at 20");
    assert!(paper.contains("paper mode") && paper.contains("ALARM") && paper.contains(" r3 "), "{paper}");
}

#[test]
fn frames_of_a_log_show_the_fault_that_the_replay_reports() {
    let desk = Desk::with_sample();
    let text = frames(&desk, &format!("log.csv {GUARD} {CONSTANTS} --set-point set_point --print-at 3 --print-at 45"));
    for part in ["replay of log.csv", "the learning window has not begun", "ALARM  F2 speed sensor", "since 35.0"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    desk.refuses(&format!("watch log.csv {GUARD} --print-at 60"), &["59.98 s"]);
    desk.refuses(&format!("watch log.csv {GUARD} --learn 0..100 --print-at 9"), &["--learn"]);
}

#[test]
fn frames_of_a_log_in_paper_mode_show_what_the_replay_reports_too() {
    let desk = Desk::with_sample();
    let text = frames(&desk, &format!("log.csv {MOTOR} --print-at 3 --print-at 9 --print-at 30 --print-at 45"));
    let frames: Vec<_> = text.split("replay of log.csv, paper mode").skip(1).collect();
    for (frame, part) in frames.iter().zip(["has not begun", "learning what healthy means", " healthy", "ALARM"]) {
        assert!(frame.contains(part), "{part}\n{frame}");
    }
    let alarm = &desk.replay(SAMPLE, "", 1)["alarms"][0];
    assert_eq!(alarm["located"], "F2");
    let told = format!("ALARM  F2 speed sensor, since {:.3} s", alarm["start_s"].as_f64().unwrap());
    assert!(frames[3].contains(&told) && frames[3].contains(" r3 "), "{told}\n{}", frames[3]);
    let out_of_reach =
        include_str!("../../limits/figure-1.toml").replace(" = 1.7", " = 1e6 # 1.7").replace(" = 1.8", " = 1e6 # 1.8");
    desk.write("limits.toml", out_of_reach);
    let frame = self::frames(&desk, &format!("log.csv {MOTOR} --limits limits.toml --print-at 45"));
    assert!(frame.contains(" healthy") && !frame.contains("ALARM"), "{frame}");
}

#[test]
fn without_a_terminal_it_says_what_to_use_instead() {
    let desk = Desk::with_sample();
    desk.refuses("watch", &["no terminal", "`monitor-sim` without a command", "--print-at"]);
    desk.refuses(&format!("watch log.csv {GUARD}"), &["no terminal", "`monitor-sim replay`"]);
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let desk = Desk::with_sample();
    for (arguments, words) in [
        ("log.csv --print-at 1", ["--rate-hz", "--learn"]),
        ("--rate-hz 50 --print-at 1", ["--rate-hz", "<LOG>"]),
        ("--settle 3 --print-at 1", ["--settle", "<LOG>"]),
        ("log.csv --speed 1 --current 2 --voltage 3 --rate-hz 50 --learn 0..99 --seed 3", ["--seed", "LOG"]),
        ("--print-at 9 --print-at 3", ["--print-at", "ascending"]),
        ("--print-at 9 --size 80", ["--size", "80x24"]),
        ("--pace fast", ["--pace", "`max`"]),
        ("--limits log.csv --print-at 1", ["--limits", "--mode paper"]),
    ] {
        desk.refuses(&format!("watch {arguments}"), &words);
    }
    desk.refuses(&format!("watch log.csv {GUARD} --limits log.csv --print-at 1"), &["--limits", "--mode paper"]);
    desk.refuses(&format!("watch log.csv {MOTOR} {CONSTANTS} --print-at 1"), &["--resistance", "guard mode"]);
}

#[test]
fn the_frame_of_the_readme_is_what_the_command_prints() {
    let readme = include_str!("../../../README.md");
    let frame = frames(&Desk::new(), "--print-at 62");
    assert!(readme.contains(&format!("```text\n{frame}```")), "{frame}");
}
