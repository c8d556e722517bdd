//! Scores a flight against what was injected: Tables 1 and 2 of the paper.

use serde::Serialize;

use crate::intervals::Interval;

pub mod guard;

/// Which of the paper's two detectors a row speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The full model: Table 1. Detects, cannot locate.
    Pca,
    /// The three pairs: Table 2.
    Ppca,
}

/// One injected fault, in samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Identifier, such as `F1`.
    pub id: String,
    /// First sample with the fault.
    pub start: u64,
    /// First sample without it.
    pub end: u64,
}

/// What a flight recorded, as far as scoring needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observed {
    /// Where the relay of the full model was up.
    pub full: Vec<Interval>,
    /// Where any pair relay was up.
    pub any_pair: Vec<Interval>,
    /// Where each diagnosis stood, by its identifier.
    pub located: Vec<(String, Vec<Interval>)>,
}

/// One row of Table 1 or Table 2. Times in seconds since the start of the mission.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultScore {
    /// Which table.
    pub method: Method,
    /// Identifier of the injected fault.
    pub id: String,
    /// When the fault began.
    pub start_s: f64,
    /// When it ended.
    pub end_s: f64,
    /// First sample inside the interval at which a relay of this method was up.
    pub detected_s: Option<f64>,
    /// When the relays of this method came down for good after the fault; none if they had not before the next fault
    /// or the end of the record, or if nothing was detected.
    pub cleared_s: Option<f64>,
    /// The name that stood longest inside the interval (none for PCA, which cannot locate).
    pub located: Option<String>,
    /// When the right name first stood inside the interval.
    pub located_s: Option<f64>,
    /// Share of the interval over which the right name stood.
    pub located_share: Option<f64>,
}

/// The tables of a flight and what it got wrong outside of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Table 1, then Table 2, each in the order of the faults.
    pub faults: Vec<FaultScore>,
    /// Alarms (full or pair) that began where there was no fault: neither inside a fault nor within the recovery time
    /// behind it, while the loop itself still moves.
    pub false_alarms: usize,
}

/// Scores a flight. `recovery` is how many samples the loop is given to come back after a fault has ended.
#[must_use]
pub fn score(truth: &[Truth], observed: &Observed, rate_hz: f64, recovery: u64, samples: u64) -> Score {
    let seconds = |sample: u64| sample as f64 / rate_hz;
    let row = |method: Method, fault: &Truth| {
        let up = match method {
            Method::Pca => &observed.full,
            Method::Ppca => &observed.any_pair,
        };
        let detected = first_overlap(up, fault.start, fault.end);
        let cleared = detected.and_then(|_| cleared(up, truth, fault, recovery, samples));
        let mut scored = FaultScore {
            method,
            id: fault.id.clone(),
            start_s: seconds(fault.start),
            end_s: seconds(fault.end),
            detected_s: detected.map(seconds),
            cleared_s: cleared.map(seconds),
            located: None,
            located_s: None,
            located_share: None,
        };
        if method == Method::Ppca {
            let stood =
                |intervals: &[Interval]| intervals.iter().map(|i| i.overlap(fault.start, fault.end)).sum::<u64>();
            let longest = observed.located.iter().max_by_key(|(_, intervals)| stood(intervals));
            scored.located = longest.filter(|(_, intervals)| stood(intervals) > 0).map(|(id, _)| id.clone());
            let right = observed.located.iter().find(|(id, _)| *id == fault.id).map(|(_, intervals)| intervals);
            scored.located_s = right.and_then(|i| first_overlap(i, fault.start, fault.end)).map(seconds);
            let share = stood(right.map_or(&[], Vec::as_slice)) as f64 / (fault.end - fault.start).max(1) as f64;
            scored.located_share = Some(share);
        }
        scored
    };
    let faults = [Method::Pca, Method::Ppca].iter().flat_map(|method| truth.iter().map(|f| row(*method, f))).collect();
    let false_alarms = false_alarms(&union(&observed.full, &observed.any_pair), truth, recovery);
    Score { faults, false_alarms }
}

/// Alarms that began where there was no fault: neither inside a fault nor within the recovery time behind it.
fn false_alarms(alarms: &[Interval], truth: &[Truth], recovery: u64) -> usize {
    let explained = |alarm: &Interval| truth.iter().any(|f| (f.start..f.end + recovery).contains(&alarm.start));
    alarms.iter().filter(|alarm| !explained(alarm)).count()
}

/// The first sample of `[start, end)` that lies in an interval.
fn first_overlap(intervals: &[Interval], start: u64, end: u64) -> Option<u64> {
    intervals.iter().find(|i| i.overlap(start, end) > 0).map(|i| i.start.max(start))
}

/// The end of the last interval that stood at the fault's end or began within the recovery time behind it; none if the next
/// fault to begin hides it.
fn cleared(intervals: &[Interval], truth: &[Truth], fault: &Truth, recovery: u64, samples: u64) -> Option<u64> {
    let behind = intervals.iter().filter(|i| i.start < fault.end + recovery && i.end > fault.end);
    let cleared = behind.map(|i| i.end).max().unwrap_or(fault.end);
    let next = truth.iter().map(|t| t.start).filter(|start| *start >= fault.end).min().unwrap_or(samples);
    (cleared < next).then_some(cleared)
}

/// Intervals in which at least one of two conditions held.
#[must_use]
pub fn union(a: &[Interval], b: &[Interval]) -> Vec<Interval> {
    let mut all: Vec<Interval> = a.iter().chain(b).copied().collect();
    all.sort_by_key(|i| i.start);
    let mut merged: Vec<Interval> = Vec::with_capacity(all.len());
    for interval in all {
        match merged.last_mut() {
            Some(last) if interval.start <= last.end => last.end = last.end.max(interval.end),
            _ => merged.push(interval),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(spans: &[(u64, u64)]) -> Vec<Interval> {
        spans.iter().map(|(start, end)| Interval { start: *start, end: *end }).collect()
    }

    fn truth() -> Vec<Truth> {
        [("F1", 100, 200), ("F2", 300, 400)].map(|(id, start, end)| Truth { id: id.to_owned(), start, end }).into()
    }

    #[test]
    fn a_fault_is_detected_cleared_and_located_at_the_samples_the_relays_say() {
        let observed = Observed {
            full: at(&[(110, 230), (305, 420)]),
            any_pair: at(&[(105, 215), (301, 410)]),
            located: vec![("F1".to_owned(), at(&[(108, 215), (301, 310)])), ("F2".to_owned(), at(&[(310, 410)]))],
        };
        let Score { faults, false_alarms } = score(&truth(), &observed, 10.0, 20, 500);
        let [pca, _, ppca1, ppca2] = &faults[..] else { panic!("four rows") };
        assert_eq!((pca.detected_s, pca.cleared_s, pca.located.as_deref()), (Some(11.0), Some(23.0), None));
        assert_eq!((ppca1.detected_s, ppca1.cleared_s, ppca1.located.as_deref()), (Some(10.5), Some(21.5), Some("F1")));
        assert_eq!((ppca1.located_s, ppca1.located_share), (Some(10.8), Some(0.92)));
        assert_eq!(
            (ppca2.located.as_deref(), ppca2.located_s, ppca2.located_share),
            (Some("F2"), Some(31.0), Some(0.9))
        );
        assert_eq!(false_alarms, 0);
    }

    #[test]
    fn the_wrong_name_is_reported_as_wrong_and_a_missed_fault_as_missed() {
        let observed = Observed {
            located: vec![("F2".to_owned(), at(&[(120, 200)]))],
            any_pair: at(&[(120, 200)]),
            ..Observed::default()
        };
        let rows = score(&truth(), &observed, 10.0, 20, 500).faults;
        assert_eq!(
            (rows[2].located.as_deref(), rows[2].located_s, rows[2].located_share),
            (Some("F2"), None, Some(0.0))
        );
        assert_eq!((rows[3].detected_s, rows[3].cleared_s, rows[3].located.as_deref()), (None, None, None));
    }

    #[test]
    fn an_alarm_that_never_clears_before_the_next_fault_has_no_clear_time() {
        let observed = Observed { full: at(&[(110, 350)]), ..Observed::default() };
        assert_eq!(score(&truth(), &observed, 10.0, 20, 500).faults[0].cleared_s, None);
    }

    #[test]
    fn chatter_while_the_loop_recovers_delays_the_clear_time_and_is_no_false_alarm_but_later_alarms_are() {
        let observed = Observed {
            full: at(&[(110, 205), (210, 215), (250, 255)]),
            any_pair: at(&[(252, 260), (50, 60)]),
            ..Observed::default()
        };
        let scored = score(&truth(), &observed, 10.0, 20, 500);
        assert_eq!(scored.faults[0].cleared_s, Some(21.5));
        assert_eq!(scored.false_alarms, 2); // 50..60 and the union 250..260
    }
}
