//! Flies some units of a record again, in this process.

use monitor_sim::guardian::Alarming;
use monitor_sim::mission::{Faults, guard, paper};
use monitor_sim::output::OutputDir;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use monitor_sim::study::Study;
use monitor_sim::study::delay::Delay;
use monitor_sim::study::false_alarms::FalseAlarms;
use monitor_sim::study::localization::Localization;
use monitor_sim::study::ramp::Ramp;
use monitor_sim::study::robustness::Robustness;
use monitor_sim::tune::Tune;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::fly;
use super::record::{Record, fingerprint};
use crate::toolchain::workspace;

/// Of each kind of run that `tune` makes: the fingerprint of a record of it is of so few.
const TUNE_RUNS: u64 = 1;

/// The units of a record that are flown again: the first one, and where a unit is one flight another one: a ramp of another
/// fault, a delay in white noise.
#[must_use]
pub fn chosen(record: &Record) -> Vec<usize> {
    let units = record.fingerprints.len();
    match record.command.split_whitespace().nth(1) {
        _ if units == 0 => vec![],
        Some("ramp") => vec![0, units / 3],
        Some("delay") => vec![0, units - 1],
        _ => vec![0],
    }
}

/// Flies the chosen units anew.
///
/// # Errors
/// Which unit is another than the recorded one; or why nothing could be flown.
pub fn check(record: &Record) -> Result<(), String> {
    let units = chosen(record);
    if units.is_empty() {
        return Ok(());
    }
    let flown = fingerprints(record, &units)?;
    for (unit, flown) in units.into_iter().zip(flown) {
        let recorded = &record.fingerprints[unit];
        if *recorded != flown {
            return Err(format!("`{}`: unit {unit} has the fingerprint {flown} now, not {recorded}", record.command));
        }
    }
    Ok(())
}

/// Fingerprints of units flown anew.
///
/// # Errors
/// The settings are of no study that is known, or a flight failed.
pub fn fingerprints(record: &Record, units: &[usize]) -> Result<Vec<String>, String> {
    match record.command.split_whitespace().take(2).collect::<Vec<_>>()[..] {
        ["study", "false-alarms"] => of_study::<FalseAlarms>(record, units),
        ["study", "delay"] => of_study::<Delay>(record, units),
        ["study", "ramp"] => of_study::<Ramp>(record, units),
        ["study", "localization"] => of_study::<Localization>(record, units),
        ["study", "robustness"] => of_study::<Robustness>(record, units),
        ["tune", _] => units.iter().map(|_| tuned()).collect(),
        [option, _] if option.starts_with("--") => units.iter().map(|unit| mission(record, *unit as u64 + 1)).collect(),
        _ => Err(format!("`{}` is nothing that can be flown in part", record.command)),
    }
}

fn of_study<S: Study + DeserializeOwned>(record: &Record, units: &[usize]) -> Result<Vec<String>, String> {
    let study: S = serde_json::from_value(record.settings.clone()).map_err(said)?;
    let shared = study.prepare().map_err(said)?;
    units.iter().map(|unit| of(&study.unit(&shared, *unit as u64).map_err(said)?)).collect()
}

/// A mission with the settings that it has if it is told no more than the command tells it.
fn mission(record: &Record, seed: u64) -> Result<String, String> {
    let scenario = match record.command.split_once("--scenario ") {
        None => Scenario::figure_1(),
        Some((_, rest)) => {
            let file = workspace().join(rest.split_whitespace().next().unwrap_or_default());
            Scenario::from_toml(&std::fs::read_to_string(file).map_err(said)?).map_err(said)?
        }
    };
    let directory = tempfile::tempdir().map_err(said)?;
    let out = OutputDir::prepare(directory.path()).map_err(said)?;
    let faults = Faults::Step;
    let report = if record.command.contains("--mode paper") {
        let mut settings = PaperSettings::default_motor().map_err(said)?;
        if !record.settings.is_null() {
            settings.thresholds = serde_json::from_value(record.settings.clone()).map_err(said)?;
        }
        let mission = paper::Mission { scenario, settings, seed, faults };
        serde_json::to_string(&mission.fly(&out, |_| {}).map_err(said)?.report(&mission))
    } else {
        let mission = guard::Mission { scenario, alarming: Alarming::default(), seed, faults, models: None };
        serde_json::to_string(&mission.fly(&out, |_| {}).map_err(said)?.report(&mission))
    };
    of(&fly::mission(&serde_json::from_str(&report.map_err(said)?).map_err(said)?))
}

/// A few runs with the settings that `tune` has if it is told nothing.
fn tuned() -> Result<String, String> {
    let settings = PaperSettings::default_motor().map_err(said)?;
    let scenario = Scenario::figure_1();
    let tune = Tune { scenario, settings, runs: TUNE_RUNS, first_seed: 1000, margin: 1.5, borderline_size: 0.25 };
    let report = tune.run(|_| {}).map_err(said)?;
    of(&(report.settings, report.sweep))
}

fn of(found: &impl Serialize) -> Result<String, String> {
    fingerprint(&serde_json::to_string(found).map_err(said)?)
}

fn said(error: impl std::fmt::Display) -> String {
    error.to_string()
}
