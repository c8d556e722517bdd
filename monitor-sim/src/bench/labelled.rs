//! Recordings with labels: the first rows of each run are learned, the others are scored.

use rayon::prelude::*;
use serde::Serialize;

use super::confusion::Confusion;
use super::judge::{Judge, Refusal};
use super::nab::{self, Nab, Tally};
use super::protocol::{Labels, Published};
use super::recorded::Recorded;
use super::report::{About, Decided};
use super::{Bench, BenchError};
use crate::guardian::summary::Settings;

/// What came out.
#[derive(Clone, Debug, Serialize)]
pub struct LabelledReport {
    /// What was run.
    #[serde(flatten)]
    pub about: About,
    /// Rows of each run that were learned from.
    pub learn_rows: usize,
    /// How long behind a change point its detection counts, s.
    pub window_s: f64,
    /// Rows that were scored.
    pub scored_rows: usize,
    /// Rows of them that are anomalous.
    pub anomalous_rows: usize,
    /// Runs in which nothing was learned: no alarm at any row.
    pub refused_runs: usize,
    /// The monitor's score.
    #[serde(flatten)]
    pub score: Score,
    /// The monitor's settings, as the core takes them; of `guard` mode.
    pub config: Option<Settings>,
    /// The same score of whoever does not look.
    pub baselines: Vec<Baseline>,
    /// Scores of others, as published.
    pub published: Vec<Published>,
    /// The runs, in the order of their paths.
    pub per_run: Vec<RunReport>,
}

/// The score of a detector over all runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// F1.
    pub f1: Option<f64>,
    /// False-alarm rate, percent.
    pub far: Option<f64>,
    /// Missed-alarm rate, percent.
    pub mar: Option<f64>,
    /// Rows by what they are and what they were called.
    pub counts: Confusion,
    /// Score of change points.
    pub nab: Option<Nab>,
}

/// A detector that does not look at the readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// What it does.
    pub name: &'static str,
    /// What that is worth.
    #[serde(flatten)]
    pub score: Score,
}

/// What came out of one run.
#[derive(Clone, Debug, Serialize)]
pub struct RunReport {
    /// Path of the file below the directory.
    pub run: String,
    /// Rows that were scored.
    pub scored_rows: usize,
    /// Why nothing was learned, if it was not.
    pub refused: Option<String>,
    /// Its score by itself.
    #[serde(flatten)]
    pub score: Score,
    /// Labels and alarms over time.
    #[serde(skip)]
    pub timeline: Timeline,
}

/// What is drawn of a run.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// Where scoring begins, s.
    pub scored_from_s: f64,
    /// Where the run ends, s.
    pub end_s: f64,
    /// Where it is anomalous, s.
    pub anomalous: Vec<(f64, f64)>,
    /// When it changes, s.
    pub change_points: Vec<f64>,
    /// Where an alarm stood, s.
    pub alarm: Vec<(f64, f64)>,
}

/// A run with its decisions.
struct Scored<'a> {
    recorded: &'a Recorded,
    /// Rows that were learned.
    learned: usize,
    decided: Decided,
    config: Option<Settings>,
}

pub(super) fn run(
    bench: &Bench,
    judge: &Judge,
    runs: &[Recorded],
    (learn_rows, labels): (usize, &Labels),
    tick: &(impl Fn() + Sync),
) -> Result<LabelledReport, BenchError> {
    let scored = |recorded| {
        let scored = Scored::of(bench, judge, recorded, learn_rows);
        tick();
        scored
    };
    let runs: Vec<Scored> = runs.par_iter().map(scored).collect::<Vec<_>>().into_iter().collect::<Result<_, _>>()?;
    let window_ns = (labels.window_s * 1e9).round() as i64;
    let by = |decide: fn(&Scored) -> Vec<bool>| Score::of(&runs, window_ns, decide);
    let score = by(|run| run.decided.alarm.clone());
    let baselines = vec![
        Baseline { name: "always alarm", score: by(|run| vec![true; run.decided.alarm.len()]) },
        Baseline { name: "never alarm", score: by(|run| vec![false; run.decided.alarm.len()]) },
    ];
    Ok(LabelledReport {
        about: About::of(bench, judge, runs.len()),
        learn_rows,
        window_s: labels.window_s,
        scored_rows: runs.iter().map(|run| run.decided.alarm.len()).sum(),
        anomalous_rows: runs.iter().map(|run| run.anomaly().iter().filter(|anomalous| **anomalous).count()).sum(),
        refused_runs: runs.iter().filter(|run| run.decided.refused.is_some()).count(),
        score,
        config: runs.iter().find_map(|run| run.config),
        baselines,
        published: bench.protocol.published.clone(),
        per_run: runs.iter().map(|run| run.report(window_ns)).collect(),
    })
}

impl<'a> Scored<'a> {
    fn of(bench: &Bench, judge: &Judge, recorded: &'a Recorded, learned: usize) -> Result<Self, BenchError> {
        let Some((learn, rest)) = recorded.samples.split_at_checked(learned).filter(|(_, rest)| !rest.is_empty())
        else {
            return Err(BenchError::Run {
                path: bench.directory.join(&recorded.name),
                why: format!(
                    "it has {} rows, none behind the {learned} that are learned from; name it under `skip`, or learn fewer",
                    recorded.samples.len()
                ),
            });
        };
        // Nothing learned, nothing said: every row counts as one without an alarm.
        let (decided, config) = match judge.judge(learn, rest) {
            Ok(judged) => (Decided { alarm: judged.alarm, refused: None }, judged.learned.settings),
            Err(Refusal::Learning(why)) => (Decided { alarm: vec![false; rest.len()], refused: Some(why) }, None),
            Err(Refusal::Settings(why)) => return Err(BenchError::Settings(why)),
        };
        Ok(Scored { recorded, learned, decided, config })
    }

    fn anomaly(&self) -> &[bool] {
        self.recorded.anomaly.get(self.learned..).unwrap_or_default()
    }

    fn tally(&self, alarm: &[bool], window_ns: i64) -> Tally {
        let at_ns = self.recorded.at_ns.get(self.learned..).unwrap_or_default();
        let changing = self.recorded.change_point.get(self.learned..).unwrap_or_default();
        let change_points: Vec<i64> = at_ns.iter().zip(changing).filter(|(_, cp)| **cp).map(|(at, _)| *at).collect();
        let detections: Vec<i64> = nab::changes(alarm).iter().filter_map(|row| at_ns.get(*row).copied()).collect();
        nab::tally(&change_points, &detections, window_ns)
    }

    fn report(&self, window_ns: i64) -> RunReport {
        let Decided { alarm, refused } = &self.decided;
        let counts = Confusion::of(self.anomaly(), alarm);
        RunReport {
            run: self.recorded.name.clone(),
            scored_rows: alarm.len(),
            refused: refused.clone(),
            score: Score::from_sums(counts, &self.tally(alarm, window_ns)),
            timeline: self.timeline(),
        }
    }

    fn timeline(&self) -> Timeline {
        let run = self.recorded;
        let changing = run.change_point.iter().enumerate().filter(|(_, changing)| **changing);
        Timeline {
            scored_from_s: run.seconds(self.learned),
            end_s: run.seconds(run.samples.len()),
            anomalous: run.stretches(&run.anomaly, 0),
            change_points: changing.map(|(row, _)| run.seconds(row)).collect(),
            alarm: run.stretches(&self.decided.alarm, self.learned),
        }
    }
}

impl Score {
    fn of(runs: &[Scored], window_ns: i64, decide: impl Fn(&Scored) -> Vec<bool>) -> Self {
        let (mut counts, mut tally) = (Confusion::default(), Tally::default());
        for run in runs {
            let alarm = decide(run);
            counts += Confusion::of(run.anomaly(), &alarm);
            tally += run.tally(&alarm, window_ns);
        }
        Score::from_sums(counts, &tally)
    }

    fn from_sums(counts: Confusion, tally: &Tally) -> Self {
        Score { f1: counts.f1(), far: counts.far(), mar: counts.mar(), counts, nab: tally.score() }
    }
}
