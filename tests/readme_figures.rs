//! Promise: the tables in the README are what the main job prints.

use monitor_sim::mission::Faults;
use monitor_sim::mission::paper::Mission;
use monitor_sim::output::OutputDir;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use monitor_sim::tables;

const README: &str = include_str!("../README.md");

#[test]
fn every_row_of_the_missions_tables_stands_in_the_readme() {
    let mission = Mission {
        scenario: Scenario::figure_1(),
        settings: PaperSettings::default_motor().unwrap(),
        seed: 1,
        faults: Faults::Step,
    };
    let out = OutputDir::prepare(&std::env::temp_dir().join(format!("monitor-readme-{}", std::process::id()))).unwrap();
    let flights = mission.fly(&out, |_| {}).unwrap();
    let report = flights.report(&mission);
    for file in &report.files {
        std::fs::remove_file(file).unwrap();
    }
    let readme: Vec<String> =
        README.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    for table in tables::of_mission(&report) {
        for row in &table.rows {
            let shown = row.join(" ").split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(readme.contains(&shown), "not in the README, under \"{}\":\n{shown}", table.caption);
        }
    }
    let size = format!("{} bytes", report.monitor_bytes);
    assert!(README.contains(&size), "the size of the monitor, {size}");
}
