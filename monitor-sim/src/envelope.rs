//! A signal of any length, kept as a band of least and greatest values that is drawn in its place.

/// Buckets are merged in pairs when there are twice as many; a picture some 1,000 pixels wide shows no more.
const BUCKETS: usize = 800;

/// Least and greatest value over a stretch of the abscissa.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bucket {
    from: f64,
    to: f64,
    least: f64,
    greatest: f64,
    samples: u64,
    /// Whether a gap lies between this bucket and the one before.
    after_gap: bool,
}

/// Decimates a signal for drawing in constant memory: a spike of one sample in a billion is still seen.
#[derive(Clone, Debug, Default)]
pub struct Envelope {
    buckets: Vec<Bucket>,
    /// Samples a bucket takes before the next is begun; zero stands for one.
    bucket_samples: u64,
    gap: bool,
}

impl Envelope {
    /// Takes one point; abscissae ascend. A value that is not finite leaves a gap.
    pub fn push(&mut self, x: f64, y: f64) {
        if !y.is_finite() {
            self.gap = true;
            return;
        }
        let capacity = self.bucket_samples.max(1);
        match self.buckets.last_mut() {
            Some(last) if last.samples < capacity && !self.gap => {
                last.to = x;
                last.least = last.least.min(y);
                last.greatest = last.greatest.max(y);
                last.samples += 1;
            }
            last => {
                let after_gap = self.gap && last.is_some();
                self.buckets.push(Bucket { from: x, to: x, least: y, greatest: y, samples: 1, after_gap });
            }
        }
        self.gap = false;
        if self.buckets.len() >= 2 * BUCKETS {
            self.halve();
        }
    }

    /// Merges neighbours in pairs. Signals with more gaps than buckets lose gaps rather than memory.
    fn halve(&mut self) {
        self.bucket_samples = 2 * self.bucket_samples.max(1);
        let merged = self.buckets.chunks(2).map(|pair| match pair {
            [a, b] => Bucket {
                from: a.from,
                to: b.to,
                least: a.least.min(b.least),
                greatest: a.greatest.max(b.greatest),
                samples: a.samples + b.samples,
                after_gap: a.after_gap,
            },
            _ => pair[0],
        });
        self.buckets = merged.collect();
    }

    /// The band as polylines, one for each stretch without a gap: two points a bucket, least and greatest.
    #[must_use]
    pub fn polylines(&self) -> Vec<Vec<(f64, f64)>> {
        let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
        for bucket in &self.buckets {
            if bucket.after_gap || lines.is_empty() {
                lines.push(Vec::new());
            }
            let Some(line) = lines.last_mut() else { continue };
            // The nearer end first, so that the line does not cross the band twice a bucket.
            let down = line.last().is_some_and(|(_, y)| *y > 0.5 * (bucket.least + bucket.greatest));
            let (first, second) = if down { (bucket.greatest, bucket.least) } else { (bucket.least, bucket.greatest) };
            line.push((bucket.from, first));
            if bucket.samples > 1 {
                line.push((bucket.to, second));
            }
        }
        lines
    }

    /// Least and greatest value at and behind an abscissa; none when there is no point.
    #[must_use]
    pub fn range_from(&self, x: f64) -> Option<(f64, f64)> {
        let behind = self.buckets.iter().filter(|b| b.from >= x).map(|b| (b.least, b.greatest));
        behind.reduce(|(low, high), (least, greatest)| (low.min(least), high.max(greatest)))
    }

    /// First and last abscissa; none when the signal is empty.
    #[must_use]
    pub fn domain(&self) -> Option<(f64, f64)> {
        Some((self.buckets.first()?.from, self.buckets.last()?.to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_spike_of_one_sample_in_a_million_is_still_there() {
        let mut envelope = Envelope::default();
        (0..1_000_000).for_each(|k| envelope.push(f64::from(k), if k == 654_321 { 9.0 } else { 0.0 }));
        assert_eq!(envelope.range_from(0.0), Some((0.0, 9.0)));
        let drawn: Vec<(f64, f64)> = envelope.polylines().concat();
        assert!(drawn.len() <= 4 * BUCKETS);
        let spike = drawn.iter().find(|(_, y)| *y == 9.0).unwrap();
        assert!((spike.0 - 654_321.0).abs() < 2_000.0);
    }

    #[test]
    fn a_value_that_is_not_finite_leaves_a_gap() {
        let mut envelope = Envelope::default();
        [1.0, 2.0, f64::NAN, 3.0].iter().enumerate().for_each(|(k, y)| envelope.push(k as f64, *y));
        assert_eq!(envelope.polylines(), [vec![(0.0, 1.0), (1.0, 2.0)], vec![(3.0, 3.0)]]);
    }

    #[test]
    fn an_envelope_without_points_has_no_lines_and_no_range() {
        let mut envelope = Envelope::default();
        envelope.push(0.0, f64::INFINITY);
        assert_eq!((envelope.polylines().len(), envelope.range_from(0.0), envelope.domain()), (0, None, None));
    }

    proptest! {
        #[test]
        fn any_signal_keeps_its_extremes_its_ends_and_its_memory(
            values in prop::collection::vec(prop_oneof![9 => -1e3..1e3_f64, 1 => Just(f64::NAN)], 0..6000),
        ) {
            let mut envelope = Envelope::default();
            values.iter().enumerate().for_each(|(k, y)| envelope.push(k as f64, *y));
            let finite: Vec<f64> = values.iter().copied().filter(|y| y.is_finite()).collect();
            let least = finite.iter().copied().reduce(f64::min);
            let greatest = finite.iter().copied().reduce(f64::max);
            prop_assert_eq!(envelope.range_from(0.0), least.zip(greatest));
            prop_assert!(envelope.buckets.len() <= 2 * BUCKETS);
            let drawn = envelope.polylines().concat();
            prop_assert!(drawn.windows(2).all(|p| p[0].0 <= p[1].0));
        }
    }
}
