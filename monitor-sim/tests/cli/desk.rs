//! What the tests share: a directory, the program in it, and logs and scenarios to give it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use assert_cmd::Command;
use assert_cmd::assert::{Assert, OutputAssertExt};
use serde_json::Value;
use tempfile::TempDir;

/// The recorded sample: 3000 rows at 50 Hz, the speed sensor off from row 1750 (35 s) to row 2500 (50 s).
pub(crate) const SAMPLE: &str = include_str!("../../samples/thruster.csv");

/// How the sample is replayed in the paper's mode.
pub(crate) const MOTOR: &str =
    "--speed speed --current current --voltage voltage --rate-hz 50 --learn 5s..25s --mode paper";

/// How the sample is replayed in guard mode, which is the default.
pub(crate) const GUARD: &str = "--speed speed --current current --voltage voltage --rate-hz 50 --learn 5s..25s";

/// A mission of 30 s with one fault, which is flown in a moment.
pub(crate) const SHORT: &str = r#"
name = "short"
duration_s = 30.0
start = "steady"

[learn]
start_s = 2.0
end_s = 12.0

[[set_point]]
at_s = 0.0
rad_per_s = 300.0

[[fault]]
id = "F3"
name = "armature current sensor"
point = "current_sensor"
kind = "offset"
profile = "step"
amplitude = 0.5
start_s = 15.0
end_s = 25.0
"#;

/// The first `rows` rows of the sample, under its header.
pub(crate) fn first_rows(rows: usize) -> String {
    SAMPLE.split_inclusive('\n').take(1 + rows).collect()
}

/// The sample before its fault.
pub(crate) fn healthy() -> String {
    first_rows(1700)
}

/// The sample with some cells changed; `edit` gets the row (from 0) and its cells.
pub(crate) fn edited(mut edit: impl FnMut(usize, &mut Vec<String>)) -> String {
    let mut lines = SAMPLE.lines();
    let mut log = format!("{}\n", lines.next().unwrap());
    for (row, line) in lines.enumerate() {
        let mut cells = line.split(',').map(str::to_owned).collect();
        edit(row, &mut cells);
        log += &(cells.join(",") + "\n");
    }
    log
}

/// A directory with the program in it.
pub(crate) struct Desk(TempDir);

impl Desk {
    /// An empty directory.
    pub(crate) fn new() -> Self {
        Desk(tempfile::tempdir().unwrap())
    }

    /// A directory with one file.
    pub(crate) fn with(name: &str, text: &str) -> Self {
        let desk = Desk::new();
        desk.write(name, text);
        desk
    }

    /// A directory with the sample as `log.csv`.
    pub(crate) fn with_sample() -> Self {
        Desk::with("log.csv", SAMPLE)
    }

    /// A directory with the short mission as `short.toml`.
    pub(crate) fn with_short() -> Self {
        Desk::with("short.toml", SHORT)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// The program with arguments that are separated by spaces.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = assert_cmd::cargo::cargo_bin_cmd!("monitor-sim");
        command.current_dir(self.0.path()).args(arguments.split_whitespace()).timeout(Duration::from_secs(60));
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Assert {
        self.command(arguments).assert()
    }

    /// Runs to the end with `code`, and returns the one JSON document on standard output.
    pub(crate) fn json(&self, arguments: &str, code: i32) -> Value {
        let done = self.run(&format!("{arguments} --json")).code(code);
        serde_json::from_slice(&done.get_output().stdout).unwrap()
    }

    /// Replays `log` as the sample is replayed, with more `options`.
    pub(crate) fn replay(&self, log: &str, options: &str, code: i32) -> Value {
        self.write("replayed.csv", log);
        self.json(&format!("replay replayed.csv {MOTOR} {options}"), code)
    }

    /// The program refuses the arguments: a clear error with all the `words`, exit code 2, nothing on standard output,
    /// and every file of the directory as it was.
    pub(crate) fn refuses(&self, arguments: &str, words: &[&str]) {
        let before = self.files();
        let output = self.run(arguments).get_output().clone();
        self.refused(arguments, &output, words, &before);
    }

    pub(crate) fn refused(&self, what: &str, output: &Output, words: &[&str], before: &BTreeMap<PathBuf, Vec<u8>>) {
        let error = String::from_utf8(output.stderr.clone()).unwrap();
        assert!(error.starts_with("error: ") && !error.contains("panicked"), "{what}\n{error}");
        for word in words {
            assert!(error.contains(word), "{what}: no {word:?} in\n{error}");
        }
        output.clone().assert().code(2).stdout("");
        assert!(self.files() == *before, "{what} wrote: {:?}", self.files().keys());
    }

    /// Every file below the directory with its content.
    pub(crate) fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        fn gather(directory: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
            for entry in fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    gather(&path, files);
                } else {
                    let content = fs::read(&path).unwrap_or_default(); // one test makes a file nobody may read
                    files.insert(path, content);
                }
            }
        }
        let mut files = BTreeMap::new();
        gather(self.0.path(), &mut files);
        files
    }
}

/// The names of the keys of an object.
pub(crate) fn keys(object: &Value) -> Vec<&str> {
    object.as_object().unwrap().keys().map(String::as_str).collect()
}

/// Holds when the object has all the keys.
pub(crate) fn assert_keys(object: &Value, expected: &[&str]) {
    let missing: Vec<_> = expected.iter().filter(|key| !keys(object).contains(key)).collect();
    assert!(missing.is_empty(), "no {missing:?} in {:?}", keys(object));
}
