//! Promise: the tables in the README are what the main job prints, in both modes.

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
        false_alarms_per_hour: 0.01,
        seed: 1,
        faults: Faults::Step,
        models: None,
    };
    let (path, out) = out("guard");
    let report = mission.fly(&out, |_| {}).unwrap().report(&mission);
    std::fs::remove_dir_all(path).unwrap();
    assert_in_readme(&tables::guard::of_mission(&report), report.monitor_bytes);
}
