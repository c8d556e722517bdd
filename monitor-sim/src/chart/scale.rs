//! Axes, linear or logarithmic, with tick labels a person would write.

/// An axis. Its ends are places on it: of a logarithmic one, logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) log: bool,
}

impl Scale {
    pub(super) const fn linear(low: f64, high: f64) -> Self {
        Scale { low, high, log: false }
    }

    /// A linear axis with a little room around the values; a constant signal gets a little of its own size.
    pub(super) fn around(low: f64, high: f64) -> Self {
        let room = if high > low { 0.05 * (high - low) } else { 0.05 * high.abs().max(1.0) };
        Scale::linear(low - room, high + room)
    }

    /// A logarithmic axis of whole decades, one at least; of what is not above zero it knows nothing.
    pub(super) fn decades(low: f64, high: f64) -> Self {
        let high = if high > 0.0 { high.log10().ceil() } else { 0.0 };
        let low = if low > 0.0 { low.log10().floor() } else { high - 1.0 };
        Scale { low: low.min(high - 1.0), high, log: true }
    }

    /// The axis with this share of it left free at its upper end.
    pub(super) fn with_room(self, share: f64) -> Self {
        Scale { high: self.low + (self.high - self.low) / (1.0 - share), ..self }
    }

    /// Where a value lies on the axis.
    pub(super) fn place(self, value: f64) -> f64 {
        // What is not above zero has no logarithm, and NaN gives way to the floor.
        if self.log { value.log10().max(self.floor()) } else { value }
    }

    /// What lies deeper on a logarithmic axis, or has no place on it at all, is here: far below its lower end, but not so far
    /// that nothing is left to tell the other values apart by.
    pub(super) fn floor(self) -> f64 {
        self.low - 6.0
    }

    /// Where a value lies, from 0 at the lower end to 1 at the upper; what is beyond an end is at it.
    pub(super) fn share(self, value: f64) -> f64 {
        if self.is_point() { 0.0 } else { ((self.place(value) - self.low) / (self.high - self.low)).clamp(0.0, 1.0) }
    }

    /// Whether the axis has no length, as that of a log without rows.
    fn is_point(self) -> bool {
        self.low >= self.high
    }

    /// Values for about `most` ticks, with their labels.
    pub(super) fn ticks(self, most: u32) -> Vec<(f64, String)> {
        let values: Vec<f64> = if self.is_point() {
            vec![self.low]
        } else if self.log {
            let (first, last) = (self.low.round() as i32, (self.high + 1e-9).floor() as i32);
            let step = (last - first) / most as i32 + 1;
            // One or two decades alone would have next to no ticks.
            let within = if last - first > 2 { &[1.0][..] } else { &[1.0, 2.0, 5.0] };
            let of_decade = |exponent| within.iter().map(move |m| m * 10_f64.powi(exponent));
            let values = (first..=last).step_by(step as usize).flat_map(of_decade);
            values.filter(|value| *value <= 10_f64.powi(last)).collect()
        } else {
            let rough = (self.high - self.low) / f64::from(most);
            let decade = 10_f64.powf(rough.log10().floor());
            let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= rough).unwrap_or(rough);
            let first = (self.low / step).ceil();
            (0..=most).map(|k| (first + f64::from(k)) * step).take_while(|x| *x <= self.high).collect()
        };
        values.into_iter().map(|value| (value, tick(value, self.log))).collect()
    }
}

fn tick(value: f64, log: bool) -> String {
    let size = value.abs();
    // What rounding leaves of a zero between ticks that are numbers.
    if size < 1e-12 && !log {
        return "0".to_owned();
    }
    if (log && !(1e-2..1e4).contains(&size)) || !(1e-4..1e7).contains(&size) {
        return format!("{value:.0e}");
    }
    // What rounding has left behind the sixth digit is not shown.
    let shown = format!("{value:.6}");
    shown.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale) -> Vec<String> {
        scale.ticks(8).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers_as_a_person_writes_them() {
        assert_eq!(labels(Scale::linear(0.0, 140.0)), ["0", "20", "40", "60", "80", "100", "120", "140"]);
        assert_eq!(labels(Scale::linear(-0.1, 0.11)), ["-0.1", "-0.05", "0", "0.05", "0.1"]);
        assert_eq!(labels(Scale::decades(0.002, 7.0)), ["1e-3", "0.01", "0.1", "1", "10"]);
        assert_eq!(labels(Scale::decades(0.2, 7.0)), ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(labels(Scale::decades(1.0, 2e10)), ["1", "100", "1e4", "1e6", "1e8", "1e10"]);
    }

    #[test]
    fn room_at_the_upper_end_has_no_ticks() {
        let scale = Scale::decades(0.1, 1e4).with_room(0.1);
        assert!((scale.share(1e4) - 0.9).abs() < 1e-12);
        assert_eq!(labels(scale), ["0.1", "1", "10", "100", "1000", "1e4"]);
    }

    #[test]
    fn nothing_leaves_an_axis_whatever_its_values() {
        for scale in
            [Scale::around(3.0, 3.0), Scale::around(0.0, 0.0), Scale::decades(0.0, 0.0), Scale::decades(5.0, 5.0)]
        {
            assert!(scale.low < scale.high, "{scale:?}");
            for value in [f64::NEG_INFINITY, -1.0, 0.0, 1e-300, 4.0, f64::INFINITY] {
                assert!((0.0..=1.0).contains(&scale.share(value)), "{scale:?} {value}");
            }
        }
    }
}
