//! Rows called anomalous against rows that are: F1, false-alarm rate, missed-alarm rate.

use std::ops::AddAssign;

use serde::Serialize;

/// Counts of rows by what they are and what they were called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Confusion {
    /// Anomalous, and an alarm stood.
    pub true_alarms: u64,
    /// Normal, and an alarm stood.
    pub false_alarms: u64,
    /// Anomalous, and no alarm stood.
    pub missed: u64,
    /// Normal, and no alarm stood.
    pub quiet: u64,
}

impl Confusion {
    /// Counts the rows of one run.
    #[must_use]
    pub fn of(anomalous: &[bool], alarm: &[bool]) -> Self {
        let mut counts = Confusion::default();
        for (anomalous, alarm) in anomalous.iter().zip(alarm) {
            let count = match (anomalous, alarm) {
                (true, true) => &mut counts.true_alarms,
                (false, true) => &mut counts.false_alarms,
                (true, false) => &mut counts.missed,
                (false, false) => &mut counts.quiet,
            };
            *count += 1;
        }
        counts
    }

    /// F1, the harmonic mean of precision and recall; none where no row is anomalous and none was called so.
    #[must_use]
    pub fn f1(&self) -> Option<f64> {
        share(self.true_alarms as f64, self.true_alarms as f64 + (self.missed + self.false_alarms) as f64 / 2.0)
    }

    /// False-alarm rate: share of the normal rows over which an alarm stood, percent.
    #[must_use]
    pub fn far(&self) -> Option<f64> {
        share(100.0 * self.false_alarms as f64, (self.false_alarms + self.quiet) as f64)
    }

    /// Missed-alarm rate: share of the anomalous rows over which none stood, percent.
    #[must_use]
    pub fn mar(&self) -> Option<f64> {
        share(100.0 * self.missed as f64, (self.missed + self.true_alarms) as f64)
    }
}

fn share(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| part / whole)
}

impl AddAssign for Confusion {
    fn add_assign(&mut self, other: Self) {
        self.true_alarms += other.true_alarms;
        self.false_alarms += other.false_alarms;
        self.missed += other.missed;
        self.quiet += other.quiet;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const YES: bool = true;
    const NO: bool = false;

    #[test]
    fn ten_rows_counted_by_hand_have_the_rates_of_the_definitions() {
        let anomalous = [NO, NO, NO, NO, YES, YES, YES, YES, YES, YES];
        let alarm = [NO, YES, NO, NO, NO, NO, YES, YES, YES, NO];
        let counts = Confusion::of(&anomalous, &alarm);
        assert_eq!(counts, Confusion { true_alarms: 3, false_alarms: 1, missed: 3, quiet: 3 });
        // Precision 3/4, recall 3/6: F1 = 2 * 3/4 * 1/2 / (3/4 + 1/2) = 3/5.
        assert_eq!(counts.f1(), Some(0.6));
        assert_eq!(counts.far(), Some(25.0));
        assert_eq!(counts.mar(), Some(50.0));
    }

    #[test]
    fn runs_are_pooled_by_their_rows_and_not_by_their_rates() {
        // A short run that is all wrong and a long one that is all right: 10 of 100 anomalous rows are missed.
        let mut pooled = Confusion::of(&[YES; 10], &[NO; 10]);
        pooled += Confusion::of(&[YES; 90], &[YES; 90]);
        assert_eq!(pooled.mar(), Some(10.0));
    }

    #[test]
    fn whoever_always_alarms_has_a_good_f1_where_half_of_the_rows_are_anomalous() {
        let anomalous = [YES, NO];
        let counts = Confusion::of(&anomalous, &[YES; 2]);
        assert_eq!((counts.f1(), counts.far(), counts.mar()), (Some(2.0 / 3.0), Some(100.0), Some(0.0)));
        let counts = Confusion::of(&anomalous, &[NO; 2]);
        assert_eq!((counts.f1(), counts.far(), counts.mar()), (Some(0.0), Some(0.0), Some(100.0)));
    }

    #[test]
    fn a_rate_of_no_rows_is_none_and_not_a_number_that_looks_like_one() {
        let counts = Confusion::of(&[NO], &[NO]);
        assert_eq!((counts.f1(), counts.far(), counts.mar()), (None, Some(0.0), None));
        assert_eq!(Confusion::default().far(), None);
    }
}
