//! Healthy recordings: each is learned and every other one judged by it, as it is and with a drift of a known size.

use rayon::prelude::*;
use serde::Serialize;

use super::judge::{Alarm, Judge, Judged, Learned, Refusal, Sample};
use super::protocol::Drifts;
use super::recorded::Recorded;
use super::report::About;
use super::{Bench, BenchError};
use crate::guardian::summary::Settings;
use crate::study::summary::Spread;

/// What came out.
#[derive(Clone, Debug, Serialize)]
pub struct DriftReport {
    /// What was run.
    #[serde(flatten)]
    pub about: About,
    /// All pairs and cases together.
    #[serde(flatten)]
    pub totals: Totals,
    /// The healthy runs, and what was learned of each.
    pub learned: Vec<LearnedRun>,
    /// Every run, judged as it is by every other one that is healthy.
    pub judged: Vec<JudgedRun>,
    /// Healthy runs with a drift.
    pub drifts: Vec<DriftCase>,
}

/// All pairs and cases together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Totals {
    /// Ordered pairs of healthy runs.
    pub healthy_pairs: usize,
    /// Of them, those in which nothing was learned.
    pub refused_pairs: usize,
    /// Alarms in healthy runs: all of them false.
    pub false_alarms: usize,
    /// Hours of healthy runs that were judged.
    pub healthy_hours: f64,
    /// Drifts that were added.
    pub injected: usize,
    /// Of them, those that were found.
    pub found: usize,
    /// Of those, the ones in whose alarm the channel that drifts has the largest share.
    pub named_right: usize,
    /// Median of the time from the beginning of a drift until it was found, s; none if none was.
    pub median_delay_s: Option<f64>,
}

/// What was learned of a healthy run.
#[derive(Clone, Debug, Serialize)]
pub struct LearnedRun {
    /// Path of the file below the directory.
    pub run: String,
    /// First row, of those that count, of the stretch.
    pub first_row: usize,
    /// Rows of the stretch.
    pub rows: usize,
    /// Standard deviation of each channel, in its unit; none if it was refused.
    pub sigma: Option<[f64; 3]>,
    /// Why it was refused, if it was.
    pub refused: Option<String>,
    /// The monitor's settings, as the core takes them; of `guard` mode.
    pub config: Option<Settings>,
}

/// A run, judged by another.
#[derive(Clone, Debug, Serialize)]
pub struct JudgedRun {
    /// The run that was learned.
    pub learned: String,
    /// The run that was judged.
    pub judged: String,
    /// Whether it is healthy, so that each alarm is a false one.
    pub healthy: bool,
    /// Rows of its file.
    pub recorded_rows: usize,
    /// Those of them that count.
    pub rows: usize,
    /// Those of them that were judged: neither settling nor learning anew after a change of the set point.
    pub judged_rows: Option<usize>,
    /// Share of the rows that count which were judged; none where nothing was learned.
    pub judged_share: Option<f64>,
    /// Alarms; none where nothing was learned.
    pub alarms: Option<usize>,
    /// Rows over which they stood.
    pub alarm_rows: Option<usize>,
    /// Where they stood, s.
    #[serde(skip)]
    pub alarm: Vec<(f64, f64)>,
    /// Where the run ends, s.
    #[serde(skip)]
    pub end_s: f64,
}

/// A drift that was added to a healthy run.
#[derive(Clone, Debug, Serialize)]
pub struct DriftCase {
    /// The run that was learned.
    pub learned: String,
    /// The run that was judged.
    pub judged: String,
    /// The channel.
    pub channel: String,
    /// Its size, in sigmas as learned.
    pub sigmas: f64,
    /// The same in the unit of the channel; none where nothing was learned.
    pub amount: Option<f64>,
    /// When it begins, s.
    pub begins_s: f64,
    /// Whether it was found: an alarm where there is none without it.
    pub found: bool,
    /// How long that took, s.
    pub delay_s: Option<f64>,
    /// The channel with the largest share in that alarm.
    pub named: Option<String>,
    /// That share.
    pub share: Option<f64>,
    /// Where an alarm stood, s.
    #[serde(skip)]
    pub alarm: Vec<(f64, f64)>,
}

/// A healthy run with the stretch of it that is learned.
struct Learner<'a> {
    recorded: &'a Recorded,
    window: (usize, usize),
}

impl<'a> Learner<'a> {
    fn of(recorded: &'a Recorded, judge: &Judge) -> Self {
        Learner { recorded, window: recorded.longest_stretch(judge.set_point_tolerance) }
    }

    fn samples(&self) -> &'a [Sample] {
        self.recorded.samples.get(self.window.0..self.window.1).unwrap_or_default()
    }

    /// Learns and judges no more than what was learned, to say what that was.
    fn learned(&self, judge: &Judge) -> Result<LearnedRun, BenchError> {
        let learned = accepted(judge.judge(self.samples(), &[]))?;
        let (learned, refused) = match learned {
            Ok(judged) => (Some(judged.learned), None),
            Err(why) => (None, Some(why)),
        };
        Ok(LearnedRun {
            run: self.recorded.name.clone(),
            first_row: self.window.0,
            rows: self.window.1 - self.window.0,
            sigma: learned.map(|learned| learned.sigma),
            refused,
            config: learned.and_then(|learned| learned.settings),
        })
    }
}

/// What a pair gave.
struct Pair {
    judged: JudgedRun,
    drifts: Vec<DriftCase>,
}

pub(super) fn run(
    bench: &Bench,
    judge: &Judge,
    runs: &[Recorded],
    asked: &Drifts,
    tick: &(impl Fn() + Sync),
) -> Result<DriftReport, BenchError> {
    let learners: Vec<Learner> = runs.iter().filter(|run| run.healthy).map(|run| Learner::of(run, judge)).collect();
    if learners.is_empty() || runs.len() < 2 {
        return Err(BenchError::Runs(format!(
            "{} of {} runs are healthy, and one is needed to learn and another to be judged: give a directory with more, or \
             correct `healthy` of the description",
            learners.len(),
            runs.len()
        )));
    }
    let of_target = |target: &Recorded| {
        let others = learners.iter().filter(|learner| !std::ptr::eq(learner.recorded, target));
        let pairs: Result<Vec<Pair>, BenchError> =
            others.map(|learner| Meeting { judge, asked, learner, target }.pair()).collect();
        tick();
        pairs
    };
    let pairs: Vec<Vec<Pair>> =
        runs.par_iter().map(of_target).collect::<Vec<_>>().into_iter().collect::<Result<_, _>>()?;
    let mut pairs: Vec<Pair> = pairs.into_iter().flatten().collect();
    pairs.sort_by(|a, b| a.judged.learned.cmp(&b.judged.learned)); // stable: the judged runs stay in order
    let learned = learners.iter().map(|learner| learner.learned(judge)).collect::<Result<_, _>>()?;
    let totals = totals(&pairs, judge.rate_hz);
    let (judged, drifts): (Vec<_>, Vec<_>) = pairs.into_iter().map(|pair| (pair.judged, pair.drifts)).unzip();
    let drifts = drifts.into_iter().flatten().collect();
    Ok(DriftReport { about: About::of(bench, judge, runs.len()), totals, learned, judged, drifts })
}

/// One run judged by what was learned of another.
struct Meeting<'a> {
    judge: &'a Judge,
    asked: &'a Drifts,
    learner: &'a Learner<'a>,
    target: &'a Recorded,
}

impl Meeting<'_> {
    fn pair(&self) -> Result<Pair, BenchError> {
        let plain = accepted(self.judge.judge(self.learner.samples(), &self.target.samples))?.ok();
        let judged = JudgedRun {
            learned: self.learner.recorded.name.clone(),
            judged: self.target.name.clone(),
            healthy: self.target.healthy,
            recorded_rows: self.target.rows,
            rows: self.target.samples.len(),
            judged_rows: plain.as_ref().map(|plain| plain.watched),
            judged_share: plain.as_ref().map(|plain| plain.watched as f64 / self.target.samples.len().max(1) as f64),
            alarms: plain.as_ref().map(|plain| plain.alarms.len()),
            alarm_rows: plain.as_ref().map(|plain| plain.alarm.iter().filter(|stands| **stands).count()),
            alarm: plain.as_ref().map(|plain| self.target.stretches(&plain.alarm, 0)).unwrap_or_default(),
            end_s: self.target.seconds(self.target.samples.len()),
        };
        let mut drifts = Vec::new();
        if self.target.healthy {
            for (channel, name) in self.judge.names().iter().enumerate() {
                for &sigmas in &self.asked.sigmas {
                    drifts.push(self.drift((channel, name), sigmas, plain.as_ref())?);
                }
            }
        }
        Ok(Pair { judged, drifts })
    }

    /// Adds a drift to a channel of the target from its middle on, and looks when that is found.
    fn drift(
        &self,
        (channel, name): (usize, &String),
        sigmas: f64,
        plain: Option<&Judged>,
    ) -> Result<DriftCase, BenchError> {
        let begins = self.target.samples.len() / 2;
        let missed = DriftCase {
            learned: self.learner.recorded.name.clone(),
            judged: self.target.name.clone(),
            channel: name.clone(),
            sigmas,
            amount: None,
            begins_s: self.target.seconds(begins),
            found: false,
            delay_s: None,
            named: None,
            share: None,
            alarm: Vec::new(),
        };
        let Some(Judged { learned: Learned { sigma, .. }, alarm: without, .. }) = plain else { return Ok(missed) };
        let amount = sigmas * sigma.get(channel).copied().unwrap_or_default();
        let drifting = drifting(&self.target.samples, channel, amount, begins);
        let Ok(judged) = accepted(self.judge.judge(self.learner.samples(), &drifting))? else { return Ok(missed) };
        let found = (begins..drifting.len()).find(|row| stands(&judged.alarm, *row) && !stands(without, *row));
        let named = found.and_then(|row| largest_share(&judged.alarms, row));
        Ok(DriftCase {
            amount: Some(amount),
            found: found.is_some(),
            delay_s: found.map(|row| self.target.seconds(row) - self.target.seconds(begins)),
            named: named.and_then(|(position, _)| self.judge.names().get(position).cloned()),
            share: named.map(|(_, share)| share),
            alarm: self.target.stretches(&judged.alarm, 0),
            ..missed
        })
    }
}

/// Tells a refused learning window, which is a result, from refused settings, which are a mistake.
fn accepted(judged: Result<Judged, Refusal>) -> Result<Result<Judged, String>, BenchError> {
    match judged {
        Ok(judged) => Ok(Ok(judged)),
        Err(Refusal::Learning(why)) => Ok(Err(why)),
        Err(Refusal::Settings(why)) => Err(BenchError::Settings(why)),
    }
}

fn drifting(samples: &[Sample], channel: usize, amount: f64, begins: usize) -> Vec<Sample> {
    let mut drifting = samples.to_vec();
    for sample in drifting.iter_mut().skip(begins) {
        if let Some(x) = sample.x.get_mut(channel) {
            *x += amount;
        }
    }
    drifting
}

fn stands(alarm: &[bool], row: usize) -> bool {
    alarm.get(row).copied().unwrap_or_default()
}

/// The position of the channel with the largest share in the alarm that stood at a row, and that share.
fn largest_share(alarms: &[Alarm], row: usize) -> Option<(usize, f64)> {
    let shares = alarms.iter().find(|alarm| (alarm.start..alarm.end).contains(&row))?.shares?;
    shares.into_iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b))
}

fn totals(pairs: &[Pair], rate_hz: f64) -> Totals {
    let healthy: Vec<&JudgedRun> = pairs.iter().map(|pair| &pair.judged).filter(|judged| judged.healthy).collect();
    let judged = || healthy.iter().filter(|judged| judged.alarms.is_some());
    let drifts: Vec<&DriftCase> = pairs.iter().flat_map(|pair| &pair.drifts).collect();
    let right = |case: &&&DriftCase| case.named.as_ref() == Some(&case.channel);
    let delays = Spread::of(drifts.iter().filter_map(|case| case.delay_s));
    Totals {
        healthy_pairs: healthy.len(),
        refused_pairs: healthy.len() - judged().count(),
        false_alarms: judged().filter_map(|judged| judged.alarms).sum(),
        healthy_hours: judged().filter_map(|judged| judged.judged_rows).sum::<usize>() as f64 / rate_hz / 3600.0,
        injected: drifts.len(),
        found: drifts.iter().filter(|case| case.found).count(),
        named_right: drifts.iter().filter(right).count(),
        median_delay_s: delays.map(|delays| delays.median),
    }
}
