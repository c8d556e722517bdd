//! What every benchmark's result has.

use serde::Serialize;

use super::Bench;
use super::drifts::DriftReport;
use super::judge::Judge;
use super::labelled::LabelledReport;
use super::protocol::Channel;
use crate::tables::TextTable;

/// The result of a benchmark, as machines read it.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum BenchReport {
    /// Of recordings with labels.
    Labelled(Box<LabelledReport>),
    /// Of healthy recordings, with drifts and without.
    Drifts(Box<DriftReport>),
}

/// What was run.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// Name of the benchmark.
    pub benchmark: String,
    /// What it is.
    #[serde(skip)]
    pub title: String,
    /// Version of the program.
    pub version: &'static str,
    /// How many recordings there are.
    pub runs: usize,
    /// The three channels and their columns.
    pub channels: Vec<Channel>,
    /// Why these.
    pub channels_because: Option<String>,
    /// What the monitor was told.
    pub settings: Judge,
    /// Where published scores come from.
    pub published_because: Option<String>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

/// What was decided of the rows of a run.
#[derive(Clone, Debug)]
pub(super) struct Decided {
    pub(super) alarm: Vec<bool>,
    /// Why nothing was learned, if it was not.
    pub(super) refused: Option<String>,
}

impl About {
    pub(super) fn of(bench: &Bench, judge: &Judge, runs: usize) -> Self {
        let protocol = &bench.protocol;
        About {
            benchmark: protocol.name.clone(),
            title: protocol.title.clone(),
            version: env!("CARGO_PKG_VERSION"),
            runs,
            channels: protocol.channel.clone(),
            channels_because: protocol.channels_because.clone(),
            settings: judge.clone(),
            published_because: protocol.published_because.clone(),
            notes: protocol.notes.clone(),
        }
    }
}

impl BenchReport {
    /// What was run.
    #[must_use]
    pub const fn about(&self) -> &About {
        match self {
            BenchReport::Labelled(report) => &report.about,
            BenchReport::Drifts(report) => &report.about,
        }
    }

    /// What came out, in a sentence or two.
    #[must_use]
    pub fn summary(&self) -> String {
        match self {
            BenchReport::Labelled(report) => super::tables::summary_of_labelled(report),
            BenchReport::Drifts(report) => super::tables::summary_of_drifts(report),
        }
    }

    /// The result in tables: the first is the score, and the last one lists the runs.
    #[must_use]
    pub fn tables(&self) -> Vec<TextTable> {
        match self {
            BenchReport::Labelled(report) => super::tables::of_labelled(report),
            BenchReport::Drifts(report) => super::tables::of_drifts(report),
        }
    }

    /// What a person must know to read the tables, a sentence each.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        super::tables::remarks(self)
    }
}
