//! How recordings are scored, as data: a description in TOML. The built-in benchmarks are such descriptions too.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::BenchError;
use super::condition::Condition;

/// Names of the built-in protocols, and what they are.
const BUILT_IN: [(&str, &str); 2] = [
    ("skab", include_str!("../../protocols/skab.toml")),
    ("cnc-spindle", include_str!("../../protocols/cnc-spindle.toml")),
];

/// A description to start from.
pub const EXAMPLE: &str = include_str!("../../protocols/example.toml");

/// Settling time after a change of the set point, s; that of a replay.
const SETTLE_S: f64 = 5.0;

/// How recordings are scored.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Names the result.
    pub name: String,
    /// What it is, in words.
    pub title: String,
    /// Where the recordings can be had.
    #[serde(default)]
    pub get_it: Option<String>,
    /// Why these channels.
    #[serde(default)]
    pub channels_because: Option<String>,
    /// What a reader of the result must know.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Where the published scores come from.
    #[serde(default)]
    pub published_because: Option<String>,
    /// How the files are written.
    pub data: Data,
    /// Three channels.
    pub channel: Vec<Channel>,
    /// What is learned from.
    pub learn: Learn,
    /// What the rows are, where somebody has said so.
    #[serde(default)]
    pub labels: Option<Labels>,
    /// Drifts to add, where nobody has.
    #[serde(default)]
    pub drifts: Option<Drifts>,
    /// Scores of others.
    #[serde(default)]
    pub published: Vec<Published>,
}

/// How the files are written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Data {
    /// Rows per second.
    pub rate_hz: f64,
    /// What separates the columns; found from the first rows if none.
    #[serde(default)]
    pub delimiter: Option<String>,
    /// Column of the time; by row and rate if none.
    #[serde(default)]
    pub time: Option<String>,
    /// Column of the set point; constant if none.
    #[serde(default)]
    pub set_point: Option<String>,
    /// Largest movement of the set point that is not a change.
    #[serde(default)]
    pub set_point_tolerance: f64,
    /// Settling time after a change of the set point, s.
    #[serde(default = "settle_s")]
    pub settle_s: f64,
    /// Files whose path below the directory holds one of these are no runs.
    #[serde(default)]
    pub skip: Vec<String>,
    /// Rows that count: those for which all of these hold.
    #[serde(default, rename = "where")]
    pub conditions: Vec<Condition>,
}

const fn settle_s() -> f64 {
    SETTLE_S
}

/// A channel of the monitor.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its column.
    pub column: String,
}

/// What is learned from: one of the two.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Learn {
    /// The first rows of each run, which is then judged itself.
    #[serde(default)]
    pub rows: Option<usize>,
    /// The longest stretch of rows for which all of these hold, of a run by which others are judged.
    #[serde(default)]
    pub longest_where: Vec<Condition>,
}

/// Columns that say what a row is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Labels {
    /// Whether the row is anomalous.
    pub anomaly: String,
    /// Whether something changes at the row.
    #[serde(default)]
    pub change_point: Option<String>,
    /// How long behind a change point its detection counts, s.
    #[serde(default = "window_s")]
    pub window_s: f64,
}

/// The window of SKAB's leaderboard, s.
const fn window_s() -> f64 {
    60.0
}

/// Drifts that are added to healthy runs.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drifts {
    /// The healthy runs are those whose first row fulfils this.
    pub healthy: Condition,
    /// Their sizes, in sigmas of the channel as learned.
    pub sigmas: Vec<f64>,
}

/// The score of another detector.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// The detector.
    pub name: String,
    /// F1.
    #[serde(default)]
    pub f1: Option<f64>,
    /// False-alarm rate, percent.
    #[serde(default)]
    pub far: Option<f64>,
    /// Missed-alarm rate, percent.
    #[serde(default)]
    pub mar: Option<f64>,
    /// NAB score in the standard profile, in that with few false positives, and in that with few missed.
    #[serde(default)]
    pub nab: Option<[f64; 3]>,
}

/// What there is to do; parts of a protocol that go together.
#[derive(Clone, Copy, Debug)]
pub enum Task<'a> {
    /// The first rows of each run are learned, the others are scored by their labels.
    Labelled {
        /// How many rows are learned.
        learn_rows: usize,
        /// What the rows are.
        labels: &'a Labels,
    },
    /// Healthy runs are learned, the other runs are judged by them, with drifts and without.
    Drifts(&'a Drifts),
}

impl Protocol {
    /// The built-in protocol of that name, or the one in that file.
    ///
    /// # Errors
    /// [`BenchError::UnknownBenchmark`] if it is neither, [`BenchError::Protocol`] if the file makes no sense.
    pub fn find(name: &str) -> Result<Self, BenchError> {
        if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
            return Self::from_toml(name, text);
        }
        let path = PathBuf::from(name);
        if path.extension().is_none_or(|extension| extension != "toml") {
            return Err(BenchError::UnknownBenchmark(name.to_owned()));
        }
        match std::fs::read_to_string(&path) {
            Ok(text) => Self::from_toml(name, &text),
            Err(error) => Err(BenchError::Protocol {
                name: name.to_owned(),
                why: format!("it cannot be read ({error}); check the path, or begin with `bench --example > {name}`"),
            }),
        }
    }

    /// Reads a description; `name` stands for it in messages.
    ///
    /// # Errors
    /// [`BenchError::Protocol`] says what is wrong with it.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, BenchError> {
        let wrong = |why: String| BenchError::Protocol { name: name.to_owned(), why };
        let protocol: Protocol = toml::from_str(text).map_err(|error| wrong(error.to_string()))?;
        protocol.check().map_err(wrong)?;
        Ok(protocol)
    }

    fn check(&self) -> Result<(), String> {
        let Data { rate_hz, settle_s, set_point_tolerance, .. } = self.data;
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            return Err(format!("`rate_hz` is {rate_hz}; give the rows per second, above zero"));
        }
        if !(settle_s >= 0.0 && settle_s.is_finite() && set_point_tolerance >= 0.0) {
            return Err("`settle_s` and `set_point_tolerance` must not be negative".to_owned());
        }
        let names: Vec<&str> = self.channel.iter().map(|channel| channel.name.as_str()).collect();
        match names.as_slice() {
            [a, b, c] if a != b && b != c && a != c => {}
            [_, _, _] => return Err("two channels have the same name; give each its own".to_owned()),
            _ => return Err(format!("it has {} channels and three are needed; write [[channel]] thrice", names.len())),
        }
        let conditions = self.data.conditions.iter().chain(&self.learn.longest_where);
        conditions.chain(self.drifts.iter().map(|drifts| &drifts.healthy)).try_for_each(Condition::check)?;
        self.task().map(|_| ())
    }

    /// What there is to do.
    ///
    /// # Errors
    /// What is missing, in a sentence; never of a protocol that was read.
    pub(super) fn task(&self) -> Result<Task<'_>, String> {
        match (&self.labels, &self.drifts, self.learn.rows) {
            (Some(labels), None, Some(learn_rows)) if labels.window_s > 0.0 && labels.window_s.is_finite() => {
                Ok(Task::Labelled { learn_rows, labels })
            }
            (Some(labels), None, Some(_)) => Err(format!("`window_s` is {}; it must be above zero", labels.window_s)),
            (Some(_), None, None) => {
                Err("it does not say how many rows are learned from; write `rows = N` under [learn]".to_owned())
            }
            (None, Some(drifts), None) if !self.learn.longest_where.is_empty() => Ok(Task::Drifts(drifts)),
            (None, Some(_), _) => {
                Err("drifts are judged by another run; write `longest_where = [..]` alone under [learn]".to_owned())
            }
            _ => Err("it must have either [labels] or [drifts]; `bench --example` shows one with labels".to_owned()),
        }
    }

    /// Names of the channels, in their order.
    #[must_use]
    pub fn names(&self) -> [String; 3] {
        core::array::from_fn(|k| self.channel.get(k).map(|channel| channel.name.clone()).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(from: &str, to: &str) -> String {
        assert!(EXAMPLE.contains(from), "{from}");
        Protocol::from_toml("my.toml", &EXAMPLE.replacen(from, to, 1)).unwrap_err().to_string()
    }

    #[test]
    fn the_example_and_the_built_in_protocols_are_descriptions_that_are_taken() {
        assert_eq!(Protocol::from_toml("example", EXAMPLE).unwrap().names(), ["speed", "current", "voltage"]);
        assert!(matches!(Protocol::find("skab").unwrap().task(), Ok(Task::Labelled { learn_rows: 400, .. })));
        assert!(matches!(Protocol::find("cnc-spindle").unwrap().task(), Ok(Task::Drifts(_))));
    }

    #[test]
    fn a_description_that_makes_no_sense_is_refused_with_what_to_write() {
        let cases = [
            ("rate_hz = 50.0", "rate_hz = 0.0", "above zero"),
            ("rate_hz = 50.0", "rate_hz = nan", "above zero"),
            ("rows = 3000", "", "`rows = N` under [learn]"),
            ("name = \"current\"", "name = \"speed\"", "same name"),
            ("[[channel]]\nname = \"voltage\"\ncolumn = \"volts\"", "", "three are needed"),
            ("column = \"rpm\"", "colum = \"rpm\"", "colum"),
            ("window_s = 60.0", "window_s = -1.0", "above zero"),
            ("starts_with = \"run\"", "above = 1.0, is = \"run\"", "number or text"),
            ("{ column = \"supply\", above = 20.0 }", "{ column = \"supply\" }", "`supply`"),
        ];
        for (from, to, word) in cases {
            let message = refused(from, to);
            assert!(message.contains(word) && message.contains("my.toml"), "{from} -> {to}\n{message}");
        }
    }

    #[test]
    fn a_name_that_is_no_benchmark_is_told_those_there_are() {
        let message = Protocol::find("scab").unwrap_err().to_string();
        assert!(message.contains("skab") && message.contains("cnc-spindle") && message.contains(".toml"), "{message}");
    }
}
