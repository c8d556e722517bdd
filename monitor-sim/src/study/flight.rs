//! One run of samples through one monitor, and what studies keep of it.

use serde::{Deserialize, Serialize};

use super::watch::{Name, Said, Watch, give};
use crate::plant::PlantSample;

/// Flies samples through a monitor; returns how many. `seen` gets the index of each with what was said of it.
pub fn fly(
    samples: impl Iterator<Item = PlantSample>,
    watch: &mut dyn Watch,
    mut seen: impl FnMut(u64, &PlantSample, Said),
) -> u64 {
    let mut index = 0;
    for measured in samples {
        let said = give(watch, &measured);
        seen(index, &measured, said);
        index += 1;
    }
    index
}

/// Flies samples with one fault of the right name over `fault_s` (first and last second) through a monitor, and says what
/// became of it and how many samples there were.
pub fn outcome(
    samples: impl Iterator<Item = PlantSample>,
    watch: &mut dyn Watch,
    right: Name,
    [start_s, end_s]: [f64; 2],
    rate_hz: f64,
) -> (Outcome, u64) {
    let mut episode = Episode::new(right, start_s, end_s, rate_hz);
    let steps = fly(samples, watch, |index, _, said| episode.push(index, said));
    (episode.outcome(), steps)
}

/// Alarms of a run that has no fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alarms {
    /// Samples judged.
    pub judged: u64,
    /// How often an alarm began.
    pub begun: u64,
    /// Samples under an alarm.
    pub stood: u64,
    #[serde(skip)]
    up: bool,
}

impl Alarms {
    /// Takes what was said of the next sample.
    #[inline]
    pub fn push(&mut self, said: Said) {
        self.judged += u64::from(said.judged);
        self.begun += u64::from(said.alarm && !self.up);
        self.stood += u64::from(said.alarm);
        self.up = said.alarm;
    }
}

/// What became of one fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// An alarm stood already when the fault began: nothing after it counts as detection.
    pub early: bool,
    /// From the onset to the alarm, s.
    pub detected_s: Option<f64>,
    /// From the end of the fault to the end of the last alarm, s; none if it never cleared.
    pub cleared_s: Option<f64>,
    /// The name that stood longest, from [`NAMED_AFTER_S`] after detection until the fault's end.
    pub named: Option<Name>,
    /// Share of that time over which the right name stood; none where there was no such time.
    pub right_share: Option<f64>,
}

/// The right name stands if it does so for this share of the time after [`NAMED_AFTER_S`].
pub const STANDS_SHARE: f64 = 0.99;

/// A name given while the loop still moves is a guess: the right one has to stand from one second after detection on.
pub const NAMED_AFTER_S: f64 = 1.0;

impl Outcome {
    /// Whether the right name stood from one second after detection on, but for a hundredth of the time.
    #[must_use]
    pub fn right_stands(&self) -> bool {
        self.right_share.is_some_and(|share| share >= STANDS_SHARE)
    }
}

/// Follows one fault through a run.
#[derive(Clone, Debug)]
pub struct Episode {
    right: Name,
    start: u64,
    end: u64,
    named_after: u64,
    rate_hz: f64,
    early: bool,
    detected: Option<u64>,
    last_alarm: Option<u64>,
    last_seen: u64,
    stood: [u64; Name::ALL.len()],
}

impl Episode {
    /// A fault of the right name from `start_s` to `end_s` (seconds) in samples of `rate_hz`.
    #[must_use]
    pub fn new(right: Name, start_s: f64, end_s: f64, rate_hz: f64) -> Self {
        let index = |t_s: f64| (t_s * rate_hz).round() as u64;
        Self {
            right,
            start: index(start_s),
            end: index(end_s),
            named_after: index(NAMED_AFTER_S),
            rate_hz,
            early: false,
            detected: None,
            last_alarm: None,
            last_seen: 0,
            stood: [0; Name::ALL.len()],
        }
    }

    /// Takes what was said of sample `index`; indices ascend.
    #[inline]
    pub fn push(&mut self, index: u64, said: Said) {
        self.last_seen = index;
        if index + 1 == self.start {
            self.early = said.alarm;
        }
        if !said.alarm || index < self.start {
            return;
        }
        self.last_alarm = Some(index);
        if index >= self.end || self.early {
            return;
        }
        let detected = *self.detected.get_or_insert(index);
        if index >= detected + self.named_after
            && let Some(name) = said.name
        {
            self.stood[name as usize] += 1;
        }
    }

    /// What became of it.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        let seconds = |samples: u64| samples as f64 / self.rate_hz;
        let clear = self.last_alarm.map_or(self.end, |last| (last + 1).max(self.end));
        let named = Name::ALL.into_iter().filter(|n| self.stood[*n as usize] > 0);
        let time = self.detected.map_or(0, |detected| self.end.saturating_sub(detected + self.named_after));
        Outcome {
            early: self.early,
            detected_s: self.detected.map(|detected| seconds(detected - self.start)),
            cleared_s: (clear <= self.last_seen).then(|| seconds(clear - self.end)),
            named: named.max_by_key(|n| self.stood[*n as usize]),
            right_share: (time > 0).then(|| self.stood[self.right as usize] as f64 / time as f64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(alarm: bool, name: Option<Name>) -> Said {
        Said { judged: true, alarm, name, size: None }
    }

    /// A fault of the speed sensor over samples 10 to 29 at 1 Hz, of 50 samples.
    fn outcome(of: impl Fn(u64) -> Said) -> Outcome {
        let mut episode = Episode::new(Name::SpeedSensor, 10.0, 30.0, 1.0);
        (0..50).for_each(|index| episode.push(index, of(index)));
        episode.outcome()
    }

    #[test]
    fn delay_clear_time_and_name_are_those_of_the_samples() {
        // Right at once, by luck, then wrong while the loop moves.
        let right = |index| index == 12 || index >= 16;
        let name = |index| Some(if right(index) { Name::SpeedSensor } else { Name::LoadTorque });
        let found = outcome(|index| said((12..34).contains(&index), name(index)));
        // Named from one second after 12 on: 13 to 29, of which 16 to 29 are right.
        let expected = Outcome {
            early: false,
            detected_s: Some(2.0),
            cleared_s: Some(4.0),
            named: Some(Name::SpeedSensor),
            right_share: Some(14.0 / 17.0),
        };
        assert_eq!(found, expected);
    }

    #[test]
    fn a_missed_fault_an_early_alarm_and_one_that_stays_are_told_apart() {
        let missed = outcome(|_| said(false, None));
        assert_eq!((missed.detected_s, missed.cleared_s, missed.right_share), (None, Some(0.0), None));
        let early = outcome(|index| said(index >= 5, None));
        assert!(early.early && early.detected_s.is_none());
        let stays = outcome(|index| said(index >= 15, None));
        assert_eq!((stays.detected_s, stays.cleared_s), (Some(5.0), None));
    }

    #[test]
    fn an_alarm_that_chatters_has_begun_as_often_as_it_rose() {
        let mut alarms = Alarms::default();
        [false, true, true, false, true].into_iter().for_each(|up| alarms.push(said(up, None)));
        assert_eq!((alarms.judged, alarms.begun, alarms.stood), (5, 2, 3));
    }
}
