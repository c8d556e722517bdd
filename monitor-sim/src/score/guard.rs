//! Scores a flight in `guard` mode against what was injected.

use serde::Serialize;

use super::{Truth, cleared, false_alarms, first_overlap};
use crate::fault::{Fault, FaultKind};
use crate::guardian::Size;
use crate::intervals::Interval;
use crate::names::name::Name;
use crate::record::guard::Outputs;

/// A name given while the loop still moves is a guess: the right one has to stand from one second after detection on.
pub const NAMED_AFTER_S: f64 = 1.0;

/// One injected fault. Times in seconds since the start of the mission.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultScore {
    /// By which detector: `guard`, where the tables of the paper have `pca` and `ppca`.
    pub method: &'static str,
    /// Identifier of the injected fault.
    pub id: String,
    /// What was injected, in words.
    pub fault: &'static str,
    /// When the fault began.
    pub start_s: f64,
    /// When it ended.
    pub end_s: f64,
    /// First sample inside the interval at which an alarm stood.
    pub detected_s: Option<f64>,
    /// When raw samples came back behind the fault: the last of them beyond the one-sample limit has gone by.
    pub recovered_s: f64,
    /// When the alarm was withdrawn for good after the fault; none if it was not before the next fault or the end of the
    /// record, or if nothing was detected.
    pub cleared_s: Option<f64>,
    /// The name that stood longest inside the interval: the fault's own identifier if it is the right one.
    pub located: Option<String>,
    /// The same in words.
    pub located_as: Option<&'static str>,
    /// When the right name first stood inside the interval.
    pub located_s: Option<f64>,
    /// Share of the time from [`NAMED_AFTER_S`] after detection to the end of the fault for which the right name stood; none
    /// where there was no such time.
    pub located_share: Option<f64>,
    /// Size of the fault as it was last given inside the interval by the name that stood longest.
    pub size: Option<f64>,
    /// Standard deviation of the size, by noise.
    pub size_sigma: Option<f64>,
    /// Unit of both.
    pub size_unit: Option<&'static str>,
}

impl FaultScore {
    /// Whether the name that stood longest is the right one.
    #[must_use]
    pub fn is_located_right(&self) -> bool {
        self.located.as_ref() == Some(&self.id)
    }
}

/// The scores of a flight and what it got wrong outside of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// In the order of the faults.
    pub faults: Vec<FaultScore>,
    /// Alarms that began where there was no fault.
    pub false_alarms: usize,
}

/// What was seen of one fault apart from the outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Sample behind the last one after the fault's end that was beyond the one-sample limit; none if none was.
    pub recovered: Option<u64>,
    /// The last size that each name gave inside the interval.
    pub sizes: Vec<(Name, Size)>,
}

impl Seen {
    /// Takes a size.
    pub fn push_size(&mut self, name: Name, size: Size) {
        match self.sizes.iter_mut().find(|(known, _)| *known == name) {
            Some((_, last)) => *last = size,
            None => self.sizes.push((name, size)),
        }
    }
}

/// The right name for a fault.
#[must_use]
pub const fn right_name(fault: &Fault) -> Name {
    match fault.kind {
        FaultKind::Stuck | FaultKind::Missing => Name::SensorLoss,
        _ => Name::of(fault.point),
    }
}

/// A flight, as far as scoring needs it.
#[derive(Clone, Copy, Debug)]
pub struct Flown<'a> {
    /// What was injected.
    pub faults: &'a [Fault],
    /// The same in samples.
    pub truth: &'a [Truth],
    /// What the monitor said.
    pub outputs: &'a Outputs,
    /// What was seen of each fault besides.
    pub seen: &'a [Seen],
    /// Samples per second.
    pub rate_hz: f64,
    /// Samples that the loop is given to come back after a fault has ended.
    pub recovery: u64,
    /// Samples of the flight.
    pub samples: u64,
}

impl Flown<'_> {
    /// Scores the flight.
    #[must_use]
    pub fn score(&self) -> Score {
        let alarms = self.outputs.alarm.all();
        let faults = self.faults.iter().zip(self.truth).zip(self.seen);
        Score {
            faults: faults.map(|((fault, truth), seen)| self.row(fault, truth, seen, &alarms)).collect(),
            false_alarms: false_alarms(&alarms, self.truth, self.recovery),
        }
    }

    fn row(&self, fault: &Fault, truth: &Truth, seen: &Seen, alarms: &[Interval]) -> FaultScore {
        let seconds = |sample: u64| sample as f64 / self.rate_hz;
        let (start, end) = (truth.start, truth.end);
        let stood = |name, from| self.outputs.of(name).iter().map(|i| i.overlap(from, end)).sum::<u64>();
        let right = right_name(fault);
        let detected = first_overlap(alarms, start, end);
        let named_from = detected.map(|at| at + (NAMED_AFTER_S * self.rate_hz).round() as u64).filter(|at| *at < end);
        let name = Name::ALL.into_iter().filter(|name| stood(*name, start) > 0).max_by_key(|name| stood(*name, start));
        let size = seen.sizes.iter().find(|(sized, _)| Some(*sized) == name).map(|(_, size)| *size);
        FaultScore {
            method: "guard",
            id: truth.id.clone(),
            fault: right.words(),
            start_s: seconds(start),
            end_s: seconds(end),
            detected_s: detected.map(seconds),
            recovered_s: seconds(seen.recovered.unwrap_or(end)),
            cleared_s: detected
                .and_then(|_| cleared(alarms, self.truth, truth, self.recovery, self.samples))
                .map(seconds),
            located: name.map(|name| if name == right { truth.id.clone() } else { name.id().to_owned() }),
            located_as: name.map(Name::words),
            located_s: first_overlap(&self.outputs.of(right), start, end).map(seconds),
            located_share: named_from.map(|from| stood(right, from) as f64 / (end - from) as f64),
            size: size.map(|size| size.value),
            size_sigma: size.map(|size| size.sigma),
            size_unit: size.map(|size| size.unit),
        }
    }
}
