//! The change-point score of SKAB: the Numenta Anomaly Benchmark's (NAB) idea with SKAB's windows and weights.
//!
//! Every change of the decision from row to row is a detected change point, a first row that is an alarm as well. Each true
//! change point opens a window of 60 s **behind** it, its ends included; where it would begin before the window in front
//! has ended, it begins there. The first detection in a window scores 1 at its beginning, falling to A_FP at its end,
//!
//! > score(p) = (1 - A_FP)/2 · (1 - tanh(π (p - 1/2)) / tanh(π/2)) + A_FP,   p the share of the window that has passed;
//!
//! later ones in the same window count nothing; a window without one scores A_FN; each detection in no window scores A_FP.
//! Scores are summed over all runs and stated on the scale on which detecting nothing is 0 and detecting every change
//! point at once, and nothing else, is 100. The three profiles are the rows of [`PROFILES`].
//!
//! Sources: the leaderboard "on the test set, to the right of the change point, 60 s" and `core/metrics.py` of the SKAB
//! repository (github.com/waico/SKAB; from github.com/waico/tsad), understood and written anew: `chp_score` with
//! `window_width="60s"`, `anomaly_window_destination="righter"`, `intersection_mode="cut right window"`. There p is rounded to
//! a thousandth, which moves the score of a window by less than 0.002. I. Katser, V. Kozitsin: Skoltech Anomaly Benchmark
//! (SKAB), Kaggle 2020, doi 10.34740/KAGGLE/DSV/1693952. The idea: A. Lavin, S. Ahmad: Evaluating Real-time Anomaly
//! Detection Algorithms - the Numenta Anomaly Benchmark, ICMLA 2015.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::AddAssign;

use serde::Serialize;

/// Weights of a profile; a detection at once is worth 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Of a detection in no window, A_FP.
    pub false_positive: f64,
    /// Of a change point that was not detected, A_FN.
    pub missed: f64,
}

/// Standard, few false positives, few missed (SKAB's table of coefficients).
pub const PROFILES: [Profile; 3] = [
    Profile { false_positive: -0.11, missed: -1.0 },
    Profile { false_positive: -0.22, missed: -1.0 },
    Profile { false_positive: -0.11, missed: -2.0 },
];

/// What the runs add up to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// True change points.
    pub change_points: u64,
    /// Those that no detection lies behind in their window.
    pub missed: u64,
    /// Detections that lie in no window.
    pub false_positives: u64,
    /// Score of the detections in windows, by profile.
    detected: [f64; 3],
}

/// The score, 0 for detecting nothing and 100 for a perfect detector; it may be below 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nab {
    /// Standard profile.
    pub standard: f64,
    /// False positives weigh twice as much.
    pub low_fp: f64,
    /// Missed change points weigh twice as much.
    pub low_fn: f64,
    /// True change points.
    pub change_points: u64,
    /// How many of them were missed.
    pub missed: u64,
    /// Detections in no window.
    pub false_positives: u64,
}

/// Where a decision changes from row to row; a first row that is an alarm is a change.
#[must_use]
pub fn changes(alarm: &[bool]) -> Vec<usize> {
    let before = std::iter::once(&false).chain(alarm);
    alarm.iter().zip(before).enumerate().filter(|(_, (now, before))| now != before).map(|(row, _)| row).collect()
}

/// Scores one run: when change points were, when they were detected, and how long windows are, all in nanoseconds; instants
/// ascend.
#[must_use]
pub fn tally(change_points: &[i64], detections: &[i64], window_ns: i64) -> Tally {
    let windows = windows(change_points, window_ns);
    let mut tally = Tally { change_points: windows.len() as u64, ..Tally::default() };
    for &(from, to) in &windows {
        // The end of a window may be the beginning of the next: a detection there counts in both.
        match detections.iter().find(|at| (from..=to).contains(*at)) {
            Some(at) => {
                let passed = if to > from { (at - from) as f64 / (to - from) as f64 } else { 0.0 };
                for (sum, profile) in tally.detected.iter_mut().zip(PROFILES) {
                    *sum += worth(passed, profile.false_positive);
                }
            }
            None => tally.missed += 1,
        }
    }
    let inside = |at: &i64| windows.iter().any(|(from, to)| (from..=to).contains(&at));
    tally.false_positives = detections.iter().filter(|at| !inside(at)).count() as u64;
    tally
}

/// The window behind each change point; one that would overlap the window in front begins where that ends.
fn windows(change_points: &[i64], window_ns: i64) -> Vec<(i64, i64)> {
    let mut windows: Vec<(i64, i64)> = Vec::with_capacity(change_points.len());
    for &at in change_points {
        let from = windows.last().map_or(at, |(_, end)| at.max(*end));
        windows.push((from, at.saturating_add(window_ns).max(from)));
    }
    windows
}

/// What a detection is worth when this share of its window has passed.
fn worth(passed: f64, false_positive: f64) -> f64 {
    let falling = 0.5 * (1.0 - (PI * (passed - 0.5)).tanh() / FRAC_PI_2.tanh());
    (1.0 - false_positive) * falling + false_positive
}

impl Tally {
    /// The score; none where there is no change point.
    #[must_use]
    pub fn score(&self) -> Option<Nab> {
        if self.change_points == 0 {
            return None;
        }
        let n = self.change_points as f64;
        let mut scores = [0.0; 3];
        for ((score, profile), detected) in scores.iter_mut().zip(PROFILES).zip(self.detected) {
            let sum =
                detected + profile.missed * self.missed as f64 + profile.false_positive * self.false_positives as f64;
            let (nothing, perfect) = (profile.missed * n, n);
            *score = 100.0 * (sum - nothing) / (perfect - nothing);
        }
        let [standard, low_fp, low_fn] = scores;
        let Tally { change_points, missed, false_positives, .. } = *self;
        Some(Nab { standard, low_fp, low_fn, change_points, missed, false_positives })
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.change_points += other.change_points;
        self.missed += other.missed;
        self.false_positives += other.false_positives;
        for (sum, more) in self.detected.iter_mut().zip(other.detected) {
            *sum += more;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const MINUTE: i64 = 60;

    fn scored(change_points: &[i64], detections: &[i64]) -> [f64; 3] {
        let Nab { standard, low_fp, low_fn, .. } = tally(change_points, detections, MINUTE).score().unwrap();
        [standard, low_fp, low_fn]
    }

    /// Holds when all three profiles are as expected to a hundred-millionth.
    fn assert_scores(found: [f64; 3], expected: [f64; 3]) {
        for (found, expected) in found.into_iter().zip(expected) {
            assert_abs_diff_eq!(found, expected, epsilon = 1e-8);
        }
    }

    #[test]
    fn detecting_nothing_is_zero_and_every_change_point_at_once_is_a_hundred() {
        assert_scores(scored(&[100, 400, 700], &[]), [0.0; 3]);
        assert_scores(scored(&[100, 400, 700], &[100, 400, 700]), [100.0; 3]);
    }

    #[test]
    fn a_published_row_follows_from_its_missed_change_points_and_false_positives() {
        // SKAB's leaderboard, ArimaFD: 127 missed and 2 false positives are printed with -0.09, -0.17, -0.06.
        let change_points: Vec<i64> = (0..127).map(|k| 1000 * k + 500).collect();
        let found = scored(&change_points, &[0, 400]);
        assert_eq!(found.map(|score| format!("{score:.2}")), ["-0.09", "-0.17", "-0.06"]);
    }

    #[test]
    fn a_detection_falls_from_one_to_the_weight_of_a_false_positive_over_its_window() {
        // Half of the window: (1 - 0.11)/2 = 0.445, on the scale from -1 to 1: 100 (0.445 + 1)/2 = 72.25; (1 - 0.22)/2 = 0.39.
        assert_scores(scored(&[100], &[130]), [72.25, 69.5, 100.0 * 2.445 / 3.0]);
        // At its last instant a detection is worth -0.11: 100 (1 - 0.11)/2.
        assert_scores(scored(&[100], &[160]), [44.5, 39.0, 100.0 * 1.89 / 3.0]);
        // A quarter: tanh(-pi/4)/tanh(pi/2) = -0.655794202632672/0.917152335667274 = -0.715033043...
        let quarter = 0.555 * (1.0 + 0.655_794_202_632_672 / 0.917_152_335_667_274) - 0.11;
        assert_abs_diff_eq!(scored(&[100], &[115])[0], 50.0 * (quarter + 1.0), epsilon = 1e-8);
    }

    #[test]
    fn a_window_holds_both_its_ends_and_not_an_instant_more() {
        let counts = |at| {
            let Tally { missed, false_positives, .. } = tally(&[100], &[at], MINUTE);
            (missed, false_positives)
        };
        assert_eq!([99, 100, 160, 161].map(counts), [(1, 1), (0, 0), (0, 0), (1, 1)]);
        // A miss and a false positive: 100 (-1 - 0.11 + 1)/2.
        assert_scores(scored(&[100], &[99]), [-5.5, -11.0, 100.0 * -0.11 / 3.0]);
    }

    #[test]
    fn only_the_first_detection_in_a_window_counts_and_the_others_cost_nothing() {
        assert_eq!(scored(&[100], &[110, 120, 160]), scored(&[100], &[110]));
    }

    #[test]
    fn windows_that_overlap_are_parted_where_the_first_ends() {
        // Change points 40 s apart: the second window is 160 to 200. A detection at 150 is the first's alone.
        let parted = tally(&[100, 140], &[150], MINUTE);
        assert_eq!((parted.missed, parted.false_positives), (1, 0));
        // A detection at 160 is the last of the first window and the first of the second: -0.11 + 1 of 2 at most.
        assert_scores(scored(&[100, 140], &[160]), [100.0 * 2.89 / 4.0, 100.0 * 2.78 / 4.0, 100.0 * 4.89 / 6.0]);
        // Half of what is left of the second window.
        let second = tally(&[100, 140], &[180], MINUTE);
        assert_abs_diff_eq!(second.detected[0], 0.445, epsilon = 1e-12);
    }

    #[test]
    fn both_the_rise_and_the_fall_of_an_alarm_are_detections() {
        assert_eq!(changes(&[false, true, true, false, true]), [1, 3, 4]);
        assert_eq!(changes(&[true, true]), [0]);
        assert!(changes(&[false, false]).is_empty());
    }

    #[test]
    fn runs_add_up_before_the_score_is_formed() {
        let mut sum = tally(&[100], &[100], MINUTE);
        sum += tally(&[100], &[], MINUTE);
        assert_abs_diff_eq!(sum.score().unwrap().standard, 50.0, epsilon = 1e-12);
        assert_eq!(tally(&[], &[5], MINUTE).score(), None);
    }
}
