//! Runs the command of a figure and makes its record.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use super::anew;
use super::list::{Figure, Kind, Printed};
use super::record::{Record, fingerprint, hash};
use crate::toolchain::workspace;

/// The program that is run, and where it keeps finished units.
#[derive(Clone, Debug)]
pub struct Program {
    path: PathBuf,
    units: PathBuf,
}

impl Program {
    /// Builds it as a user does. Units of another build are never taken for those of this one.
    ///
    /// # Errors
    /// It does not compile, or there is no place for its files.
    pub fn build() -> Result<Self, String> {
        let target = workspace().join("target");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut build = Command::new(cargo);
        build.current_dir(workspace()).args(["build", "--release", "--locked", "--quiet", "-p", "monitor-sim"]);
        let status = build.arg("--target-dir").arg(&target).status().map_err(|error| format!("cargo: {error}"))?;
        if !status.success() {
            return Err("monitor-sim does not compile".to_owned());
        }
        let path = target.join("release/monitor-sim").with_extension(std::env::consts::EXE_EXTENSION);
        let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let units = target.join("figures").join(format!("{:016x}", hash(&bytes)));
        fs::create_dir_all(&units).map_err(|error| format!("{}: {error}", units.display()))?;
        Ok(Self { path, units })
    }

    /// What it prints.
    fn printed<'a>(&self, arguments: impl IntoIterator<Item = &'a str>) -> Result<String, String> {
        let mut command = Command::new(&self.path);
        command.current_dir(workspace()).args(arguments).stderr(Stdio::inherit());
        let output = command.output().map_err(|error| format!("{}: {error}", self.path.display()))?;
        if !output.status.success() {
            return Err(format!("failed: {command:?}"));
        }
        String::from_utf8(output.stdout).map_err(|error| error.to_string())
    }

    fn json<'a>(&self, arguments: impl IntoIterator<Item = &'a str>) -> Result<Value, String> {
        parsed(&self.printed(arguments.into_iter().chain(["--json"]))?)
    }
}

fn parsed(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| error.to_string())
}

fn words(command: &str) -> impl Iterator<Item = &str> {
    command.split_whitespace()
}

/// The rows of a result.
fn rows_of(report: &Value) -> impl Iterator<Item = Value> {
    report["rows"].as_array().cloned().unwrap_or_default().into_iter()
}

impl Figure {
    /// Runs the command; none where it needs recordings and `data` is not given.
    ///
    /// # Errors
    /// What went wrong.
    pub fn fly(&self, program: &Program, data: Option<&Path>) -> Result<Option<Record>, String> {
        match self.kind {
            Kind::Study(kinds, printed) => self.study(program, kinds, printed).map(Some),
            Kind::Tune => self.tune(program).map(Some),
            Kind::Missions(seeds) => self.missions(program, seeds).map(Some),
            Kind::Tuned(tune) => self.tuned(program, tune).map(Some),
            Kind::Bench(directory) => data.map(|data| self.bench(program, &data.join(directory))).transpose(),
        }
    }

    fn found(&self, settings: Value, rows: Vec<Value>) -> Record {
        Record { command: self.command.to_owned(), settings, rows, printed: Vec::new(), fingerprints: Vec::new() }
    }

    fn study(&self, program: &Program, kinds: &[&str], printed: Printed) -> Result<Record, String> {
        let units = program.units.join(self.name).with_extension("jsonl");
        let units = units.to_str().ok_or("a path that is no text")?;
        let resumed = || words(self.command).chain(["--resume", units]);
        let report = program.json(resumed())?;
        let is_kept = |row: &Value| kinds.is_empty() || row["row"].as_str().is_some_and(|kind| kinds.contains(&kind));
        let rows = rows_of(&report).filter(is_kept).map(short).collect();
        Ok(Record {
            // All units are there now.
            printed: if printed == Printed::Yes { lines(&program.printed(resumed())?) } else { Vec::new() },
            fingerprints: finished(Path::new(units), report["units"].as_u64().unwrap_or_default())?,
            ..self.found(report["settings"].clone(), rows)
        })
    }

    fn tune(&self, program: &Program) -> Result<Record, String> {
        let printed = lines(&program.printed(words(self.command))?);
        let record = Record { printed, ..self.found(Value::Null, Vec::new()) };
        Ok(Record { fingerprints: anew::fingerprints(&record, &[0])?, ..record })
    }

    fn missions(&self, program: &Program, seeds: u64) -> Result<Record, String> {
        let reports = (1..=seeds).map(|seed| {
            let seed = seed.to_string();
            self.mission(program, &[("N", &seed)])
        });
        let rows: Vec<Value> = reports.map(|report| Ok(mission(&report?))).collect::<Result<_, String>>()?;
        self.of_missions(Value::Null, rows)
    }

    /// A mission with thresholds of its own.
    fn tuned(&self, program: &Program, tune: &str) -> Result<Record, String> {
        let limits = program.units.join("limits.toml");
        let limits = limits.to_str().ok_or("a path that is no text")?;
        program.printed(words(tune).map(|word| if word == "limits.toml" { limits } else { word }))?;
        let report = self.mission(program, &[("limits.toml", limits)])?;
        self.of_missions(report["limits"].clone(), vec![mission(&report)])
    }

    /// The result of a mission; words of the command stand for others.
    fn mission(&self, program: &Program, others: &[(&str, &str)]) -> Result<Value, String> {
        let out = program.units.join("mission");
        let out = out.to_str().ok_or("a path that is no text")?;
        let other =
            |word: &'static str| others.iter().find(|(place, _)| *place == word).map_or(word, |(_, other)| *other);
        parsed(&program.printed(words(self.command).map(other).chain(["--out", out]))?)
    }

    fn of_missions(&self, settings: Value, rows: Vec<Value>) -> Result<Record, String> {
        let fingerprints = rows.iter().map(|row| fingerprint(&row.to_string())).collect::<Result<_, _>>()?;
        Ok(Record { fingerprints, ..self.found(settings, rows) })
    }

    fn bench(&self, program: &Program, directory: &Path) -> Result<Record, String> {
        let directory = directory.to_str().ok_or("a path that is no text")?;
        let arguments = words(self.command).map(|word| if word == "DIR" { directory } else { word });
        let mut report = program.json(arguments)?;
        let settings = report["settings"].take();
        for bulk in ["per_run", "learned", "config", "notes", "channels", "channels_because", "published_because"] {
            report.as_object_mut().map(|report| report.remove(bulk));
        }
        Ok(self.found(settings, vec![report]))
    }
}

/// What the README needs of a mission's result.
#[must_use]
pub fn mission(report: &Value) -> Value {
    let keys =
        ["start_s", "end_s", "detected_s", "recovered_s", "cleared_s", "id", "located", "located_s", "located_share"];
    let score = |score: &Value| keys.iter().map(|key| ((*key).to_owned(), score[*key].clone())).collect::<Value>();
    let scores = |key: &str, method: &str| {
        let of_method = report[key].as_array().into_iter().flatten().filter(|score| score["method"] == method);
        of_method.map(score).collect::<Value>()
    };
    let [seed, false_alarms] = ["seed", "false_alarms"].map(|key| &report[key]);
    if report["mode"] == "paper" {
        let [explained, retained, ramp] = ["explained", "retained", "ramp"].map(|key| &report[key]);
        return json!({
            "seed": seed, "false_alarms": false_alarms, "faults": scores("faults", "ppca"), "explained": explained,
            "retained": retained, "ramp": ramp,
        });
    }
    let [faults, speed_dependent] = ["faults", "speed_dependent_load"].map(|key| scores(key, "guard"));
    json!({"seed": seed, "false_alarms": false_alarms, "faults": faults, "speed_dependent_load": speed_dependent})
}

/// A row without the values of single flights.
fn short(mut row: Value) -> Value {
    row.as_object_mut().map(|row| row.remove("values"));
    row
}

/// Lines of a printed text that do not depend on the clock: the tables.
fn lines(text: &str) -> Vec<String> {
    text.lines().filter(|line| line.starts_with([' ', '─'])).map(|line| line.trim_end().to_owned()).collect()
}

/// Fingerprints from the file of finished units.
fn finished(path: &Path, units: u64) -> Result<Vec<String>, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut found = vec![String::new(); usize::try_from(units).unwrap_or_default()];
    for line in text.lines().skip(1) {
        let line = parsed(line)?;
        let unit = line["unit"].as_u64().and_then(|unit| found.get_mut(usize::try_from(unit).ok()?));
        *unit.ok_or("a unit without a number")? = fingerprint(&line["found"].to_string())?;
    }
    if found.iter().any(String::is_empty) {
        Err(format!("{}: not all units are there", path.display()))
    } else {
        Ok(found)
    }
}
