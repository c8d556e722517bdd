//! What the README says that a command prints is what it prints.

use std::path::Path;

use crate::desk::Desk;

const README: &str = include_str!("../../../README.md");

fn words(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn the_alarms_of_the_recorded_log_are_what_the_command_of_the_readme_prints() {
    let desk = Desk::new();
    let command =
        README.split("```sh\ncargo run --release -- ").find(|text| text.starts_with("replay monitor-sim/samples"));
    let (command, _) = command.unwrap().split_once("```").unwrap();
    let command = command.replace("\\\n", " ");
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let command = command.replace("monitor-sim/samples", samples.to_str().unwrap());
    let (alike, _) = command.split_once("--resistance").unwrap();
    let readme: Vec<String> = README.lines().map(words).collect();
    for command in [&command, &format!("{alike} --mode paper")] {
        let printed = desk.run(command).code(1).get_output().stdout.clone();
        let printed = String::from_utf8(printed).unwrap();
        let table: Vec<&str> = printed.lines().skip_while(|line| !line.starts_with("Alarms: ")).take(4).collect();
        assert_eq!(table.len(), 4, "{printed}");
        for line in table {
            assert!(readme.contains(&words(line)), "not in the README:\n{line}");
        }
    }
}
