//! Promise: the tables in the README are what the main job prints, in both modes, and what the audit accepted.

use monitor_sim::guardian::Alarming;
use monitor_sim::mission::{Faults, guard, paper};
use monitor_sim::output::OutputDir;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use monitor_sim::tables::{self, TextTable};

const README: &str = include_str!("../README.md");

/// A directory of this process for one mode's traces.
fn out(mode: &str) -> (std::path::PathBuf, OutputDir) {
    let path = std::env::temp_dir().join(format!("monitor-readme-{mode}-{}", std::process::id()));
    let out = OutputDir::prepare(&path).unwrap();
    (path, out)
}

fn assert_in_readme(tables: &[TextTable], monitor_bytes: usize) {
    let readme: Vec<String> =
        README.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    for table in tables {
        for row in &table.rows {
            let shown = row.join(" ").split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(readme.contains(&shown), "not in the README, under \"{}\":\n{shown}", table.caption);
        }
    }
    let size = format!("{monitor_bytes} bytes");
    assert!(README.contains(&size), "the size of the monitor, {size}");
}

#[test]
fn every_row_of_the_papers_tables_stands_in_the_readme() {
    let mission = paper::Mission {
        scenario: Scenario::figure_1(),
        settings: PaperSettings::default_motor().unwrap(),
        seed: 1,
        faults: Faults::Step,
    };
    let (path, out) = out("paper");
    let report = mission.fly(&out, |_| {}).unwrap().report(&mission);
    std::fs::remove_dir_all(path).unwrap();
    assert_in_readme(&tables::of_mission(&report), report.monitor_bytes);
}

#[test]
fn every_row_of_guard_modes_tables_stands_in_the_readme() {
    let mission = guard::Mission {
        scenario: Scenario::figure_1(),
        alarming: Alarming::default(),
        seed: 1,
        faults: Faults::Step,
        models: None,
    };
    let (path, out) = out("guard");
    let report = mission.fly(&out, |_| {}).unwrap().report(&mission);
    std::fs::remove_dir_all(path).unwrap();
    assert_in_readme(&tables::guard::of_mission(&report), report.monitor_bytes);
}

/// What the README's rows on memory and time say, by how each row begins: figures, then limits.
const COSTS: &[(&str, &[&str], &[&str])] = &[
    ("| a slot that is judged, alarms", &["time.step_monitoring.instructions", "time.step_monitoring.worst"], &[]),
    ("| a slot of the learning window (12", &["time.step_learning.instructions", "time.step_learning_join.worst"], &[]),
    ("| 3x3 eigen-decomposition of a corr", &["time.eigen_3x3_correlation.instructions", "time.eigen_3x3.worst"], &[]),
    ("| T² of three channels", &["time.t2_of_three.instructions", "time.t2_of_three.worst"], &[]),
    ("| `guard` mode: a slot that is ju", &["time.guard_monitoring.instructions", "time.guard_monitoring.worst"], &[]),
    ("| the same in the 10 slots of 64", &["time.guard_turn.instructions", "time.guard_turn.worst"], &[]),
    ("| `guard` mode: a slot of the lea", &["time.guard_learning.instructions", "time.guard_learning.worst"], &[]),
    (
        "| while the sampling interrupt is",
        &["time.guard_copy.instructions", "time.guard_copy.worst", "time.guard_install.worst"],
        &[],
    ),
    ("| second-order low-pass", &["time.low_pass.instructions", "time.low_pass_compensated.worst"], &[]),
    ("| first-order low-pass", &["time.first_order.instructions", "time.first_order_compensated.worst"], &[]),
    ("| moving average", &["time.moving_average.instructions", "time.ewma_of_three.worst"], &[]),
    ("| a quantile, once", &["time.upper_normal.instructions", "time.upper_f.worst"], &[]),
    ("| `t2_limit`, an F", &["time.t2_limit.instructions", "time.filtered_limit.worst"], &[]),
    ("| `smoothed_t2_limit`", &["time.smoothed_t2_limit.instructions", "time.smoothed_t2_limit.worst"], &[]),
    ("| code of the monitor in flash", &["flash.core"], &["flash.core"]),
    (
        "| flash of the STM32F405 image",
        &["flash.thruster", "flash.thruster-paper"],
        &["flash.thruster", "flash.thruster-paper"],
    ),
    ("| its static RAM", &["ram.thruster", "ram.thruster-paper"], &["ram.thruster", "ram.thruster-paper"]),
    ("| its deepest stack", &["stack.thruster", "stack.thruster-paper"], &["stack.thruster", "stack.thruster-paper"]),
    ("| deepest stack of a slot |", &["stack.footprint.core_step"], &["stack.footprint.core_step"]),
    ("| code of `guard` mode in flash", &["flash.guard"], &["flash.guard"]),
    (
        "| deepest stack of a slot of `guard`",
        &["stack.footprint-guard.guard_step"],
        &["stack.footprint-guard.guard_step"],
    ),
    ("  3,690 where all judged ones", &["time.guard_transition.worst", "time.guard_window_end.worst"], &[]),
];

/// A number as the README writes it.
fn grouped(number: i64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).unwrap()).collect();
    groups.join(",")
}

#[test]
fn what_the_readme_says_of_memory_and_time_is_what_the_audit_accepted() {
    let budgets: toml_edit::DocumentMut = include_str!("budgets.toml").parse().unwrap();
    let budget = |key: &str, column: &str| {
        let number = budgets["figures"].get(key).and_then(|budget| budget.get(column)?.as_integer());
        grouped(number.unwrap_or_else(|| panic!("no {column} of {key} in the budgets")))
    };
    for (begins, figures, limits) in COSTS {
        let row = README.lines().find(|line| line.starts_with(begins));
        let row = row.unwrap_or_else(|| panic!("no row of the README begins with {begins:?}"));
        let said: Vec<&str> = row.split(|c: char| !c.is_ascii_digit() && c != ',').collect();
        let told = |number: String, key: &str| assert!(said.contains(&number.as_str()), "{key} is {number}:\n{row}");
        figures.iter().for_each(|key| told(budget(key, "figure"), key));
        limits.iter().for_each(|key| told(budget(key, "limit"), key));
    }
}
