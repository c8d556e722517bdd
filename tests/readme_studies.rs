//! Promise: what the README states of studies, of benchmarks and of missions over many seeds is what was recorded, and what was
//! recorded is what is flown.

use tests::figures::command::REMEDY;
use tests::figures::list::FIGURES;
use tests::figures::{anew, claims};

const README: &str = include_str!("../README.md");

#[test]
fn what_the_readme_states_of_studies_and_benchmarks_is_what_was_recorded() {
    let (stale, wrong) = claims::stale(README);
    let lines: Vec<String> = stale.iter().map(|stale| claims::shown(README, stale)).chain(wrong).collect();
    assert!(lines.is_empty(), "{}\n`{REMEDY} -- --readme` corrects the numbers", lines.join("\n"));
}

#[test]
fn a_record_is_of_the_command_in_the_list() {
    for figure in FIGURES {
        let record = figure.record().unwrap().unwrap_or_else(|| panic!("no record; run `{REMEDY}`"));
        assert_eq!(record.command, figure.command, "{}; run `{REMEDY} -- --only {0}`", figure.name);
    }
}

#[test]
fn some_units_of_every_record_are_flown_again_as_they_were_recorded() {
    let changed = FIGURES.iter().filter_map(|figure| {
        let record = figure.record().unwrap()?;
        anew::check(&record).err().map(|error| format!("{}: {error}", figure.name))
    });
    let changed: Vec<String> = changed.collect();
    assert!(changed.is_empty(), "{}\nrun `{REMEDY}`", changed.join("\n"));
}
