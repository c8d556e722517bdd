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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guardian::{Found, Said};
    use crate::scenario::Scenario;

    /// At 1 Hz: the speed sensor is off from 20 to 39, and a name stands from 22 to 44 with the alarm.
    fn scored(name: impl Fn(u64) -> Option<Name>, recovered: Option<u64>) -> Score {
        let fault =
            Fault { start_s: 20.0, end_s: 40.0, id: "mine".to_owned(), ..Scenario::figure_1().faults[1].clone() };
        let truth = [Truth { id: "mine".to_owned(), start: 20, end: 40 }];
        let mut outputs = Outputs::default();
        for index in 0..80 {
            let found = name(index).map(|name| Found { name, size: None });
            outputs.push(index, &Said { verdict: Default::default(), found, learned: None });
        }
        // A verdict cannot be made up: the alarm stands where a name does, and once more.
        let named = outputs.names().flat_map(|(_, stood)| stood).collect::<Vec<_>>();
        outputs.alarm = Default::default();
        for index in 0..80 {
            outputs.alarm.push(index, index == 70 || named.iter().any(|i| (i.start..i.end).contains(&index)));
        }
        let size = Size { value: 5.0, sigma: 0.5, unit: "rad/s" };
        let seen = [Seen { recovered, sizes: vec![(Name::SpeedSensor, size)] }];
        let flown = Flown {
            faults: &[fault],
            truth: &truth,
            outputs: &outputs,
            seen: &seen,
            rate_hz: 1.0,
            recovery: 10,
            samples: 80,
        };
        flown.score()
    }

    #[test]
    fn times_names_and_sizes_are_those_of_the_samples() {
        let name = |index: u64| match index {
            22..25 => Some(Name::LoadTorque),
            25..45 => Some(Name::SpeedSensor),
            _ => None,
        };
        let Score { faults, false_alarms } = scored(name, Some(43));
        let [row] = &faults[..] else { panic!("one row") };
        assert_eq!((row.detected_s, row.recovered_s, row.cleared_s), (Some(22.0), 43.0, Some(45.0)));
        assert_eq!(
            (row.located.as_deref(), row.located_as, row.located_s),
            (Some("mine"), Some("speed sensor"), Some(25.0))
        );
        assert_eq!(row.located_share, Some(15.0 / 17.0), "25 to 39 of 23 to 39");
        assert_eq!((row.size, row.size_sigma, row.size_unit), (Some(5.0), Some(0.5), Some("rad/s")));
        assert!(row.is_located_right());
        assert_eq!(false_alarms, 1, "at 70");
    }

    #[test]
    fn a_wrong_name_has_its_own_identifier_and_no_size_of_another() {
        let row = &scored(|index| (22..45).contains(&index).then_some(Name::LoadTorque), None).faults[0];
        assert_eq!((row.located.as_deref(), row.located_s, row.located_share), (Some("F1"), None, Some(0.0)));
        assert_eq!((row.size, row.recovered_s, row.is_located_right()), (None, 40.0, false));
        let missed = &scored(|_| None, None).faults[0];
        assert_eq!((missed.detected_s, missed.cleared_s, missed.located_share), (None, None, None));
    }
}
