//! Finished units of a long study, one JSON line each, so that an interrupted study goes on where it was.
//!
//! The first line says which study with which settings; the file is refused for any other. A last line that was torn by
//! the interruption is dropped.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::StudyError;
use crate::output::OutputError;

/// The option that chooses the file.
const RESUME: &str = "--resume";

#[derive(Serialize, Deserialize, PartialEq)]
struct Header {
    study: String,
    version: String,
    settings: Value,
}

#[derive(Serialize, Deserialize)]
struct Line<T> {
    unit: u64,
    found: T,
}

/// The file and what it held when it was opened.
#[derive(Debug)]
pub struct Ledger {
    path: PathBuf,
    file: Mutex<File>,
    found: BTreeMap<u64, Value>,
}

impl Ledger {
    /// Opens the ledger of a study, or begins it.
    ///
    /// # Errors
    /// [`StudyError::Ledger`] when the file is of another study, other settings or another version, or is no ledger;
    /// [`StudyError::Output`] when it cannot be read or written.
    pub fn open(path: &Path, study: &str, settings: &Value) -> Result<Self, StudyError> {
        let failed = |source| OutputError::File { path: path.to_owned(), option: RESUME, source };
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        let (study, version) = (study.to_owned(), env!("CARGO_PKG_VERSION").to_owned());
        let header = Header { study, version, settings: settings.clone() };
        // A line that does not end was being written when the program was.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let (text, _torn) = text.split_at(whole);
        let found = if text.is_empty() { BTreeMap::new() } else { entries(path, text, &header)? };
        file.set_len(whole as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        if text.is_empty() {
            writeln!(file, "{}", serde_json::to_string(&header)?).map_err(failed)?;
        }
        Ok(Self { path: path.to_owned(), file: Mutex::new(file), found })
    }

    /// How many units it held when it was opened.
    #[must_use]
    pub fn finished(&self) -> u64 {
        self.found.len() as u64
    }

    /// What a unit found, if it was finished.
    #[must_use]
    pub fn get(&self, unit: u64) -> Option<&Value> {
        self.found.get(&unit)
    }

    /// Enters what a unit found.
    ///
    /// # Errors
    /// [`StudyError::Output`] when the system refuses.
    pub fn enter(&self, unit: u64, found: &impl Serialize) -> Result<(), StudyError> {
        let line = serde_json::to_string(&Line { unit, found })? + "\n";
        // A thread that panicked while writing has left a torn line at worst, which is dropped.
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // One write for the whole line.
        file.write_all(line.as_bytes()).map_err(|source| OutputError::File {
            path: self.path.clone(),
            option: RESUME,
            source,
        })?;
        Ok(())
    }
}

fn entries(path: &Path, text: &str, expected: &Header) -> Result<BTreeMap<u64, Value>, StudyError> {
    let refuse = |why: &str| {
        let remedy = "give another file to --resume, or the settings it was begun with";
        Err(StudyError::Ledger(format!("'{}' {why}; {remedy}", path.display())))
    };
    let mut lines = text.lines();
    let Some(Ok(header)) = lines.next().map(serde_json::from_str::<Header>) else {
        return refuse("is not a file of finished units");
    };
    if header.study != expected.study {
        return refuse(&format!("holds units of the study {}, not of {}", header.study, expected.study));
    }
    if header.version != expected.version {
        return refuse(&format!("was begun by version {}, and this is {}", header.version, expected.version));
    }
    if header.settings != expected.settings {
        return refuse(&format!("was begun with other settings: {}", changed(&header.settings, &expected.settings)));
    }
    let mut found = BTreeMap::new();
    for (n, line) in lines.enumerate() {
        let Ok(Line { unit, found: value }) = serde_json::from_str::<Line<Value>>(line) else {
            return refuse(&format!("is damaged in line {}", n + 2));
        };
        found.insert(unit, value);
    }
    Ok(found)
}

/// Which settings differ, from what to what.
fn changed(before: &Value, now: &Value) -> String {
    let (Some(before), Some(now)) = (before.as_object(), now.as_object()) else { return "of another form".to_owned() };
    let keys = now.keys().chain(before.keys().filter(|key| !now.contains_key(*key)));
    let differ = keys.filter(|key| before.get(*key) != now.get(*key)).map(|key| {
        let shown = |value: Option<&Value>| value.map_or_else(|| "nothing".to_owned(), Value::to_string);
        format!("{key} = {} there and {} now", shown(before.get(key)), shown(now.get(key)))
    });
    differ.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_was_entered_is_found_again_and_a_torn_last_line_is_dropped() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("units.jsonl");
        let settings = json!({"seed": 1});
        let ledger = Ledger::open(&path, "ramp", &settings).unwrap();
        ledger.enter(3, &json!({"x": 0.1})).unwrap();
        drop(ledger);
        let torn = std::fs::read_to_string(&path).unwrap() + "{\"unit\":4,\"fou";
        std::fs::write(&path, torn).unwrap();
        let ledger = Ledger::open(&path, "ramp", &settings).unwrap();
        assert_eq!((ledger.finished(), ledger.get(3), ledger.get(4)), (1, Some(&json!({"x": 0.1})), None));
        ledger.enter(4, &json!({"x": 0.2})).unwrap();
        assert_eq!(Ledger::open(&path, "ramp", &settings).unwrap().finished(), 2);
    }

    #[test]
    fn another_study_other_settings_and_other_files_are_refused_with_what_differs() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("units.jsonl");
        drop(Ledger::open(&path, "ramp", &json!({"seed": 1, "motors": 5})).unwrap());
        let refused = |study, settings| Ledger::open(&path, study, &settings).unwrap_err().to_string();
        let message = refused("ramp", json!({"seed": 2, "motors": 5}));
        assert!(message.contains("seed = 1 there and 2 now") && !message.contains("motors"), "{message}");
        assert!(refused("delay", json!({})).contains("of the study ramp"));
        std::fs::write(&path, "time,speed\n0,1\n").unwrap();
        assert!(refused("ramp", json!({})).contains("not a file of finished units"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "time,speed\n0,1\n", "a refused file is left as it was");
    }
}
