//! The stretches of samples over which a condition held.

/// A half-open stretch of samples: from `start` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// First sample at which the condition held.
    pub start: u64,
    /// First sample at which it no longer did.
    pub end: u64,
}

impl Interval {
    /// How many samples of `[start, end)` lie in this interval.
    #[must_use]
    pub fn overlap(&self, start: u64, end: u64) -> u64 {
        self.end.min(end).saturating_sub(self.start.max(start))
    }
}

/// Gathers intervals from one sample to the next. Memory grows with how often the condition changes, not with time.
#[derive(Clone, Debug, Default)]
pub struct Intervals {
    closed: Vec<Interval>,
    open: Option<u64>,
    next: u64,
}

impl Intervals {
    /// Takes the condition at sample `index`; indices ascend. Returns whether it is another than before.
    pub fn push(&mut self, index: u64, holds: bool) -> bool {
        let changes = holds != self.is_open();
        match (self.open, holds) {
            (None, true) => self.open = Some(index),
            (Some(start), false) => {
                self.closed.push(Interval { start, end: index });
                self.open = None;
            }
            _ => {}
        }
        self.next = index + 1;
        changes
    }

    /// All intervals, the last one closed where the record ends.
    #[must_use]
    pub fn all(&self) -> Vec<Interval> {
        let open = self.open.map(|start| Interval { start, end: self.next });
        self.closed.iter().copied().chain(open).collect()
    }

    /// Whether the condition still held at the end of the record.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_half_open_and_the_last_one_ends_with_the_record() {
        let mut intervals = Intervals::default();
        let changes = [false, true, true, false, true].into_iter().enumerate();
        let changes: Vec<bool> = changes.map(|(index, holds)| intervals.push(index as u64, holds)).collect();
        assert_eq!(changes, [false, true, false, true, true]);
        assert_eq!(intervals.all(), [Interval { start: 1, end: 3 }, Interval { start: 4, end: 5 }]);
        assert!(intervals.is_open());
    }

    #[test]
    fn overlap_counts_the_samples_two_stretches_share() {
        let interval = Interval { start: 10, end: 20 };
        assert_eq!(
            [(0, 5), (0, 12), (12, 15), (15, 40), (20, 30)].map(|(a, b)| interval.overlap(a, b)),
            [0, 2, 3, 5, 0]
        );
    }
}
