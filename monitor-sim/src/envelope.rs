//! A signal of any length in memory that does not grow with it: least and greatest value of each of thousands of bins, and
//! every sample around the first events.

use std::collections::VecDeque;

/// Bins are merged in pairs when there are twice as many: a stretch of a hundredth still has as many as a narrow screen has
/// columns.
const BINS: usize = 8192;

/// Samples kept one by one before an event and behind it, and in all: those of twelve events far apart.
const BEFORE: usize = 400;
const BEHIND: usize = 1200;
const KEPT: usize = 12 * (BEFORE + BEHIND);

/// Least and greatest value of a bin's samples; both NaN in a gap.
type Bin = (f64, f64);

/// Every sample of a stretch.
#[derive(Clone, Debug)]
struct CloseUp {
    first: u64,
    values: Vec<f64>,
}

/// Decimates a signal in constant memory: a spike of one sample in a billion is still seen. Samples are evenly spaced.
#[derive(Clone, Debug)]
pub struct Envelope {
    /// First and last abscissa.
    domain: (f64, f64),
    samples: u64,
    bins: Vec<Bin>,
    bin_samples: u64,
    /// The last samples, should an event follow them.
    recent: VecDeque<f64>,
    close_ups: Vec<CloseUp>,
    /// Samples that the last close-up still takes, and all of them may.
    wanted: usize,
    room: usize,
}

/// A stretch of a signal: its first abscissa, and values evenly spaced from there.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// First abscissa.
    pub from: f64,
    /// Distance of the values.
    pub step: f64,
    /// Least and greatest value each; the same where it is of one sample, NaN in a gap.
    pub values: Vec<(f64, f64)>,
}

impl Default for Envelope {
    fn default() -> Self {
        Envelope {
            domain: (0.0, 0.0),
            samples: 0,
            bins: Vec::new(),
            bin_samples: 1,
            recent: VecDeque::with_capacity(BEFORE),
            close_ups: Vec::new(),
            wanted: 0,
            room: KEPT,
        }
    }
}

impl Envelope {
    /// Takes one sample; abscissae ascend evenly. A value that is not finite leaves a gap.
    pub fn push(&mut self, x: f64, y: f64) {
        let y = if y.is_finite() { y } else { f64::NAN };
        let from = if self.samples == 0 { x } else { self.domain.0 };
        self.domain = (from, x);
        match self.bins.last_mut() {
            Some(bin) if !self.samples.is_multiple_of(self.bin_samples) => *bin = union(*bin, (y, y)),
            _ => self.bins.push((y, y)),
        }
        self.samples += 1;
        if self.bins.len() >= 2 * BINS {
            self.bins = merged(&self.bins, 2);
            self.bin_samples *= 2;
        }
        self.keep(y);
    }

    fn keep(&mut self, y: f64) {
        if self.wanted > 0 && self.room > 0 {
            self.close_ups.last_mut().into_iter().for_each(|last| last.values.push(y));
            self.wanted -= 1;
            self.room -= 1;
        } else {
            if self.recent.len() == BEFORE {
                self.recent.pop_front();
            }
            self.recent.push_back(y);
        }
    }

    /// Keeps the samples around the last one, which is an event's, if it is among the first events.
    pub fn mark(&mut self) {
        if self.wanted == 0 && self.room > 0 {
            // What the close-up before this one has taken is not among the recent samples.
            let newest = self.recent.len().min(self.room);
            let values: Vec<f64> = self.recent.drain(..).rev().take(newest).collect();
            self.room -= values.len();
            let first = self.samples - values.len() as u64;
            self.close_ups.push(CloseUp { first, values: values.into_iter().rev().collect() });
        }
        self.wanted = BEHIND;
    }

    fn step(&self) -> f64 {
        let (from, to) = self.domain;
        if self.samples > 1 { (to - from) / (self.samples - 1) as f64 } else { 0.0 }
    }

    fn at(&self, sample: u64) -> f64 {
        self.domain.0 + self.step() * sample as f64
    }

    /// The whole signal in bins, and behind it, where bins are of several samples, the stretches whose samples were kept.
    #[must_use]
    pub fn pieces(&self) -> Vec<Piece> {
        let step = self.step();
        let whole = Piece { from: self.domain.0, step: step * self.bin_samples as f64, values: self.bins.clone() };
        let close_up = |kept: &CloseUp| {
            let values = kept.values.iter().map(|y| (*y, *y)).collect();
            Piece { from: self.at(kept.first), step, values }
        };
        let close_ups = self.close_ups.iter().filter(|_| self.bin_samples > 1).map(close_up);
        std::iter::once(whole).chain(close_ups).collect()
    }

    /// The band of at most `most` bins as polylines, one for each stretch without a gap: least and greatest of each.
    #[must_use]
    pub fn polylines(&self, most: usize) -> Vec<Vec<(f64, f64)>> {
        let together = self.bins.len().div_ceil(most.max(1)).max(1);
        let samples = self.bin_samples * together as u64;
        let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut gap = true;
        for (k, (least, greatest)) in (0..).zip(merged(&self.bins, together)) {
            if least.is_nan() {
                gap = true;
                continue;
            }
            if gap {
                lines.push(Vec::new());
                gap = false;
            }
            let Some(line) = lines.last_mut() else { continue };
            let first = k * samples;
            let last = (first + samples).min(self.samples) - 1;
            // The nearer end first, so that the line does not cross the band twice a bin.
            let down = line.last().is_some_and(|(_, y)| *y > 0.5 * (least + greatest));
            let (one, other) = if down { (greatest, least) } else { (least, greatest) };
            line.push((self.at(first), one));
            if last > first {
                line.push((self.at(last), other));
            }
        }
        lines
    }

    /// Least and greatest value at and behind an abscissa; none when there is no point.
    #[must_use]
    pub fn range_from(&self, x: f64) -> Option<(f64, f64)> {
        let from = |k: u64| self.at(k * self.bin_samples);
        let behind = (0..).zip(&self.bins).filter(|(k, _)| from(*k) >= x).map(|(_, bin)| *bin);
        behind.reduce(union).filter(|(least, _)| !least.is_nan())
    }
}

/// Of both; a NaN, which stands for none, gives way to a number.
fn union((a, b): Bin, (c, d): Bin) -> Bin {
    (a.min(c), b.max(d))
}

fn merged(bins: &[Bin], together: usize) -> Vec<Bin> {
    bins.chunks(together).map(|few| few.iter().copied().fold((f64::NAN, f64::NAN), union)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn filled(values: impl IntoIterator<Item = f64>) -> Envelope {
        let mut envelope = Envelope::default();
        values.into_iter().enumerate().for_each(|(k, y)| envelope.push(k as f64, y));
        envelope
    }

    #[test]
    fn a_spike_of_one_sample_in_a_million_is_still_there() {
        let envelope = filled((0..1_000_000).map(|k| if k == 654_321 { 9.0 } else { 0.0 }));
        assert_eq!(envelope.range_from(0.0), Some((0.0, 9.0)));
        let drawn: Vec<(f64, f64)> = envelope.polylines(1000).concat();
        assert!(drawn.len() <= 2000);
        let spike = drawn.iter().find(|(_, y)| *y == 9.0).unwrap();
        assert!((spike.0 - 654_321.0).abs() < 2_000.0);
    }

    #[test]
    fn a_value_that_is_not_finite_leaves_a_gap() {
        let envelope = filled([1.0, 2.0, f64::NAN, 3.0]);
        assert_eq!(envelope.polylines(1000), [vec![(0.0, 1.0), (1.0, 2.0)], vec![(3.0, 3.0)]]);
    }

    #[test]
    fn an_envelope_without_points_has_no_lines_and_no_range() {
        let envelope = filled([f64::INFINITY]);
        assert_eq!((envelope.polylines(1000).len(), envelope.range_from(0.0)), (0, None));
        assert_eq!((Envelope::default().polylines(1000).len(), Envelope::default().range_from(0.0)), (0, None));
    }

    #[test]
    fn around_an_event_every_sample_is_kept_and_elsewhere_bins_of_a_few() {
        let mut envelope = Envelope::default();
        for k in 0..100_000 {
            envelope.push(f64::from(k) * 0.001, f64::from(k));
            // The second falls into what is kept behind the first, the third follows it closely.
            if [50_000, 50_100, 51_400].contains(&k) {
                envelope.mark();
            }
        }
        let pieces = envelope.pieces();
        assert_eq!(pieces[0].values.len(), 12_500, "{}", pieces[0].step);
        let kept: Vec<f64> = pieces[1..].iter().flat_map(|piece| &piece.values).map(|(y, _)| *y).collect();
        let expected: Vec<f64> = (50_001 - BEFORE..=51_400 + BEHIND).map(|k| k as f64).collect();
        assert_eq!(kept, expected);
        for piece in &pieces[1..] {
            assert!((piece.from - 0.001 * piece.values[0].0).abs() < 1e-9 && (piece.step - 0.001).abs() < 1e-12);
        }
    }

    #[test]
    fn a_signal_that_is_an_event_at_every_sample_takes_no_more_memory() {
        let mut envelope = Envelope::default();
        for k in 0..1_000_000 {
            envelope.push(f64::from(k), 0.0);
            envelope.mark();
        }
        let kept: usize = envelope.close_ups.iter().map(|close_up| close_up.values.len()).sum();
        assert!(kept == KEPT && envelope.recent.len() <= BEFORE, "{kept}");
    }

    proptest! {
        #[test]
        fn any_signal_keeps_its_extremes_its_ends_and_its_memory(
            values in prop::collection::vec(prop_oneof![9 => -1e3..1e3_f64, 1 => Just(f64::NAN)], 0..40_000),
        ) {
            let envelope = filled(values.iter().copied());
            let finite: Vec<f64> = values.iter().copied().filter(|y| y.is_finite()).collect();
            let least = finite.iter().copied().reduce(f64::min);
            let greatest = finite.iter().copied().reduce(f64::max);
            prop_assert_eq!(envelope.range_from(0.0), least.zip(greatest));
            prop_assert!(envelope.bins.len() < 2 * BINS);
            let drawn = envelope.polylines(1000).concat();
            prop_assert!(drawn.len() <= 2000 && drawn.windows(2).all(|p| p[0].0 <= p[1].0));
            prop_assert!(drawn.iter().all(|(x, _)| *x <= values.len() as f64 - 1.0));
        }
    }
}
