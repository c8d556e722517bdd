//! The ordinate of a picture over time, linear or logarithmic.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::{TimeAxis, TimeChart};

/// Logarithmic axes show nothing below this share of the lowest limit: what is further down is the filter's ringing.
const BELOW_LIMIT: f64 = 0.1;
/// Without a limit, nothing below this share of their top.
const BELOW_TOP: f64 = 1e-7;

/// An ordinate from low to high, linear or logarithmic, with tick labels a person would write.
#[derive(Clone)]
pub(super) struct Ordinate {
    low: f64,
    high: f64,
    log: bool,
}

impl Ordinate {
    pub(super) fn of(chart: &TimeChart, axis: &TimeAxis) -> Ordinate {
        let limits = chart.limits.iter().map(|(_, level)| (*level, *level));
        let ranges = chart.series.iter().filter_map(|s| s.signal.range_from(axis.scaled_from)).chain(limits);
        let (low, high) = ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        if chart.log_y {
            let high = if high > 0.0 { 10_f64.powf(high.log10().ceil()) } else { 1.0 };
            let lowest = chart.limits.iter().map(|(_, level)| level * BELOW_LIMIT).fold(f64::INFINITY, f64::min);
            let low = if lowest.is_finite() { lowest } else { low.max(high * BELOW_TOP) };
            let low = 10_f64.powf(low.log10().floor());
            return Ordinate { low: low.min(high / 10.0), high, log: true };
        }
        // A little room above and below; a constant signal gets a little of its own size.
        let room = if high > low { 0.05 * (high - low) } else { 0.05 * high.abs().max(1.0) };
        Ordinate { low: low - room, high: high + room, log: false }
    }
}

impl Ranged for Ordinate {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let position = if self.log {
            (value.max(self.low) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        limit.0 + (position.clamp(0.0, 1.0) * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if !self.log {
            return (self.low..self.high).key_points_of(hint.max_num_points());
        }
        let (first, last) = (self.low.log10().round() as i32, self.high.log10().round() as i32);
        let step = ((last - first) / 6 + 1).max(1);
        (first..=last).step_by(step as usize).map(|exponent| 10_f64.powi(exponent)).collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }
}

/// Round numbers between two values.
trait RoundNumbers {
    fn key_points_of(&self, most: usize) -> Vec<f64>;
}

impl RoundNumbers for std::ops::Range<f64> {
    fn key_points_of(&self, most: usize) -> Vec<f64> {
        let rough = (self.end - self.start) / most.clamp(2, 6) as f64;
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= rough).unwrap_or(rough);
        let first = (self.start / step).ceil();
        (0..).map(|k| (first + f64::from(k)) * step).take_while(|x| *x <= self.end).take(50).collect()
    }
}

impl ValueFormatter<f64> for Ordinate {
    fn format_ext(&self, value: &f64) -> String {
        tick(*value, self.log)
    }
}

pub(super) fn tick(value: f64, log: bool) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if (log && !(1e-2..1e4).contains(&size)) || !(1e-4..1e7).contains(&size) {
        return format!("{value:.0e}");
    }
    // What rounding has left behind the sixth digit is not shown.
    let shown = format!("{value:.6}");
    shown.trim_end_matches('0').trim_end_matches('.').to_owned()
}
