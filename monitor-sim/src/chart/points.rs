//! Results of many runs: lines through points, and ranges of values beside each other.

use std::fmt::Write as _;

use super::drawing::{BASE, Drawing, PLOT_HEIGHT, PLOT_WIDTH, px};
use super::scale::Scale;
use super::{Picture, Swatch, series_class};
use crate::page::escaped;
use crate::tables::significant;

/// Height of a row of a range.
const ROW: f64 = 30.0;

/// Room for a number behind a range.
const LABEL: f64 = 140.0;

/// An axis of results.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// Its name, with the unit.
    pub name: &'a str,
    /// Whether it is logarithmic; what is not above zero then lies at its lower end.
    pub log: bool,
}

/// A line through points.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// Whether it is a bound, which is dashed, or a series.
    pub bound: bool,
    /// Which of the points to ring.
    pub ringed: Option<usize>,
}

/// How some values are spread.
#[derive(Clone, Debug)]
pub struct Range {
    /// Of what.
    pub name: String,
    /// Least and greatest, or the ends of an interval.
    pub ends: (f64, f64),
    /// Half of them, if they are so many.
    pub half: Option<(f64, f64)>,
    /// The one in the middle.
    pub middle: f64,
}

impl Axis<'_> {
    fn scale(self, values: impl Iterator<Item = f64>) -> Scale {
        let finite = values.filter(|value| value.is_finite() && (*value > 0.0 || !self.log));
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        if self.log { Scale::decades(low, high) } else { Scale::around(low, high) }
    }
}

/// Draws lines through points.
#[must_use]
pub fn line_chart(lines: &[Line], x: Axis, y: Axis) -> Picture {
    let points = || lines.iter().flat_map(|line| &line.points);
    let (across, up) = (x.scale(points().map(|p| p.0)), y.scale(points().map(|p| p.1)));
    let mut drawing = Drawing::new(1.4 * PLOT_HEIGHT);
    drawing.ordinate(up, y.name);
    let series = lines.iter().filter(|line| !line.bound).zip(0..).map(|(line, k)| (line, Swatch::Series(k)));
    let bounds = lines.iter().filter(|line| line.bound).map(|line| (line, Swatch::Limit));
    let mut legend = Vec::new();
    for (line, swatch) in series.chain(bounds) {
        let place = |(x, y): (f64, f64)| (px(PLOT_WIDTH * across.share(x)), px(drawing.y(up, y)));
        let path: Vec<String> = line.points.iter().map(|p| place(*p)).map(|(x, y)| format!("{x} {y}")).collect();
        let class = match swatch {
            Swatch::Series(k) => format!("curve {}", series_class(k)),
            _ => "limit".to_owned(),
        };
        let mut drawn = match path.len() {
            0 => String::new(),
            _ => format!("<path class=\"{class}\" d=\"M{}\"/>", path.join("L")),
        };
        for (n, point) in line.points.iter().enumerate().filter(|_| !line.bound) {
            let ((x, y), class) = (place(*point), class.replace("curve", "solid"));
            let told = format!("{}: {}, {}", line.name, significant(point.0), significant(point.1));
            let told = escaped(&told);
            let _ =
                write!(drawn, "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"4\"><title>{told}</title></circle>");
            if line.ringed == Some(n) {
                let _ = write!(drawn, "<circle class=\"axis\" cx=\"{x}\" cy=\"{y}\" r=\"8\"/>");
            }
        }
        drawing.draw(&drawn);
        legend.push((swatch, line.name.clone()));
    }
    drawing.abscissa(across, Some(x.name));
    let names: Vec<&str> = legend.iter().map(|(_, name)| name.as_str()).collect();
    let alternative = format!("{} over {}: {}", y.name, x.name, names.join(", "));
    Picture { svg: drawing.finish(&alternative, "", ""), legend }
}

/// Draws ranges under each other, with a dashed line at `limit`.
#[must_use]
pub fn range_chart(ranges: &[Range], axis: Axis, limit: Option<(&str, f64)>) -> Picture {
    let ends = ranges.iter().flat_map(|range| [range.ends.0, range.middle, range.ends.1]);
    // A limit at the end of the axis would not be told from it.
    let scale = axis.scale(ends.chain(limit.map(|(_, value)| if axis.log { 0.5 * value } else { value })));
    let scale = scale.with_room(LABEL / PLOT_WIDTH);
    let mut drawing = Drawing::new(ROW * ranges.len().max(1) as f64);
    let x = |value: f64| px(PLOT_WIDTH * scale.share(value));
    for (range, k) in ranges.iter().zip(0..) {
        let middle = ROW * (f64::from(k) + 0.5);
        let Range { name, ends, half, middle: value } = range;
        let told = [ends.0, *value, ends.1].map(significant).join(", ");
        let told = escaped(&format!("{name}: {told}"));
        let mut drawn = format!(
            "<g class=\"s0\"><title>{told}</title><path class=\"curve\" d=\"M{} {middle}H{}\"/>",
            x(ends.0),
            x(ends.1)
        );
        if let Some((low, high)) = half {
            let (left, wide, top) = (x(*low), px(x(*high) - x(*low)).max(1.0), middle - 6.0);
            let _ =
                write!(drawn, "<rect class=\"solid half\" x=\"{left}\" y=\"{top}\" width=\"{wide}\" height=\"12\"/>");
        }
        // A logarithmic axis has no zero: nothing is a ring at its end.
        let none = axis.log && *value <= 0.0;
        let (class, at) = if none { ("curve", 6.0) } else { ("solid", x(*value)) };
        let _ = write!(drawn, "<circle class=\"{class}\" cx=\"{at}\" cy=\"{middle}\" r=\"5\"/>");
        let label = if none { format!("0, up to {}", significant(ends.1)) } else { significant(*value) };
        let behind = x(ends.1).max(at) + 12.0;
        let _ = write!(drawn, "<text x=\"{behind}\" y=\"{}\">{label}</text></g>", middle + BASE);
        drawing.draw(&drawn);
        drawing.name_before(middle, name);
    }
    if let Some((_, value)) = limit {
        drawing.draw(&format!("<path class=\"limit\" d=\"M{} 0V{}\"/>", x(value), ROW * ranges.len() as f64));
    }
    drawing.abscissa(scale, Some(axis.name));
    let names: Vec<&str> = ranges.iter().map(|range| range.name.as_str()).collect();
    let alternative = format!("{}: {}", axis.name, names.join(", "));
    let legend = limit.map(|(name, _)| (Swatch::Limit, name.to_owned())).into_iter().collect();
    Picture { svg: drawing.finish(&alternative, "", ""), legend }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Axis = Axis { name: "size, 1", log: true };
    const Y: Axis = Axis { name: "delay, s", log: true };

    #[test]
    fn points_lie_on_their_axes_and_say_their_values() {
        let points = vec![(1.0, 0.1), (10.0, 1.0), (100.0, 10.0)];
        let line = Line { name: "F1".to_owned(), points, bound: false, ringed: Some(1) };
        let bound = Line { name: "Lorden".to_owned(), bound: true, ringed: None, ..line.clone() };
        let Picture { svg, legend } = line_chart(&[bound, line], X, Y);
        assert!(svg.contains("<path class=\"curve s0\" d=\"M0 291.2L416 145.6L832 0\"/>"), "{svg}");
        assert!(svg.contains("<title>F1: 10.00, 1.000</title>") && svg.matches("<circle").count() == 4);
        assert!(svg.contains("class=\"limit\"") && svg.contains(">delay, s<") && svg.contains(">size, 1<"));
        assert_eq!(legend, [(Swatch::Series(0), "F1".to_owned()), (Swatch::Limit, "Lorden".to_owned())]);
    }

    #[test]
    fn a_range_has_its_ends_its_half_and_its_middle_beside_the_limit() {
        let range = Range { name: "F1".to_owned(), ends: (1.0, 100.0), half: Some((5.0, 20.0)), middle: 10.0 };
        let Picture { svg, legend } = range_chart(&[range], X, Some(("asked for", 10.0)));
        assert!(svg.contains("d=\"M0 15H692\"") && svg.contains("cx=\"346\" cy=\"15\""), "{svg}");
        assert!(
            svg.contains("<title>F1: 1.000, 10.00, 100.0</title>") && svg.contains("class=\"limit\" d=\"M346 0V30\"")
        );
        assert_eq!(legend.len(), 1);
    }

    #[test]
    fn on_a_logarithmic_axis_nothing_is_a_ring_at_its_end_and_reaches_to_what_it_may_be() {
        let of = |name: &str, ends, middle| Range { name: name.to_owned(), ends, half: None, middle };
        let ranges = [of("none", (0.0, 10.0), 0.0), of("some", (1.0, 100.0), 10.0)];
        let svg = range_chart(&ranges, X, None).svg;
        assert!(
            svg.contains("<path class=\"curve\" d=\"M0 15H346\"/><circle class=\"curve\" cx=\"6\" cy=\"15\""),
            "{svg}"
        );
        assert!(
            svg.contains("<circle class=\"solid\" cx=\"346\" cy=\"45\"") && svg.contains("none: 0, 0, 10.00"),
            "{svg}"
        );
    }

    #[test]
    fn without_results_there_are_still_axes() {
        let nothing = Line { name: "F1".to_owned(), points: vec![], bound: false, ringed: None };
        for svg in [line_chart(&[nothing], X, Y).svg, range_chart(&[], X, None).svg] {
            assert!(svg.contains(">size, 1<") && !svg.contains("NaN"), "{svg}");
        }
    }
}
