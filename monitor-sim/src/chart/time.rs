//! Pictures over time: signals, and logical outputs.

use std::fmt::Write as _;

use super::drawing::{Drawing, PLOT_HEIGHT, PLOT_WIDTH, px};
use super::scale::Scale;
use super::{LogicRow, Picture, Series, Swatch, TimeAxis, TimeChart, codes, series_class};
use crate::page::escaped;

/// Bins that are drawn of a signal: about one a pixel.
const DRAWN: usize = 900;

/// Height of a row of a logical output, and of the bar in it.
const ROW: f64 = 26.0;
const BAR: f64 = 18.0;

/// Intervals of a logical output that the script is told; more are joined where they lie closest together.
const SPANS: usize = 4000;

/// Logarithmic axes show nothing below this share of the lowest limit: what is further down is the filter's ringing.
const BELOW_LIMIT: f64 = 0.1;
/// Without a limit, nothing below this share of their top.
const BELOW_TOP: f64 = 1e-7;

/// Draws signals over time.
#[must_use]
pub fn time_chart(chart: &TimeChart, axis: &TimeAxis) -> Picture {
    let (time, scale) = (time_of(axis), ordinate(chart, axis));
    let label = if chart.unit.is_empty() { chart.name.to_owned() } else { format!("{}, {}", chart.name, chart.unit) };
    let mut drawing = Drawing::new(PLOT_HEIGHT);
    drawing.ordinate(scale, &label);
    bands(&mut drawing, axis);
    for (k, series) in chart.series.iter().enumerate() {
        let (path, codes) = (path(series, time, |y| drawing.y(scale, y)), codes::attributes(series.signal, scale));
        let (class, name) = (series_class(k), escaped(series.name));
        drawing.draw(&format!("<path class=\"curve {class}\" data-name=\"{name}\" {codes} d=\"{path}\"/>"));
    }
    chart.limits.iter().for_each(|(_, level)| drawing.limit(drawing.y(scale, *level)));
    drawing.abscissa(time, (!chart.stacked).then_some("time, s"));

    let series = chart.series.iter().enumerate().map(|(k, s)| (Swatch::Series(k), s.name.to_owned()));
    let limits = chart.limits.iter().map(|(name, _)| (Swatch::Limit, name.clone()));
    let bands = (!axis.bands.is_empty()).then(|| (Swatch::Band, axis.shaded.to_owned()));
    let legend: Vec<_> = series.chain(limits).chain(bands).collect();
    let words: Vec<&str> = legend.iter().map(|(_, name)| name.as_str()).collect();
    let of_plot = format!(
        " data-name=\"{}\" data-unit=\"{}\" data-low=\"{}\" data-high=\"{}\"{}",
        escaped(chart.name),
        escaped(chart.unit),
        scale.low,
        scale.high,
        if scale.log { format!(" data-floor=\"{}\"", scale.floor()) } else { String::new() }
    );
    let svg = drawing.finish(&format!("{label}, over time: {}", words.join(", ")), &over_time(axis), &of_plot);
    Picture { svg, legend }
}

/// Draws logical outputs under each other.
#[must_use]
pub fn logic_chart(rows: &[LogicRow], axis: &TimeAxis) -> Picture {
    let time = time_of(axis);
    let height = ROW * rows.len().max(1) as f64;
    let mut drawing = Drawing::new(height);
    bands(&mut drawing, axis);
    // One pixel of the picture: shorter intervals are widened to it, closer ones are drawn as one.
    let pixel = (axis.range.1 - axis.range.0) / PLOT_WIDTH;
    for (k, row) in rows.iter().enumerate() {
        let top = ROW * k as f64;
        let bar = top + (ROW - BAR) / 2.0;
        let mut path = String::new();
        for (start, end) in joined(&row.intervals, pixel) {
            let (x, wide) =
                (PLOT_WIDTH * time.share(start), (PLOT_WIDTH * (time.share(end) - time.share(start))).max(1.0));
            let _ = write!(path, "M{} {bar}h{}v{BAR}h-{1}z", px(x), px(wide));
        }
        let (class, name, spans) = (series_class(row.colour), escaped(&row.name), spans(&row.intervals));
        let told = format!("data-name=\"{name}\" data-spans=\"{spans}\" data-top=\"{bar}\" data-height=\"{BAR}\"");
        drawing.draw(&format!(
            "<path class=\"solid {class}\" {told} d=\"{path}\"/>\
             <path class=\"grid\" d=\"M0 {}h{PLOT_WIDTH}\"/>",
            top + ROW
        ));
        drawing.name_before(top + ROW / 2.0, &row.name);
    }
    drawing.abscissa(time, Some("time, s"));
    let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    let svg = drawing.finish(&format!("When each stood: {}", names.join(", ")), &over_time(axis), "");
    Picture { svg, legend: Vec::new() }
}

fn time_of(axis: &TimeAxis) -> Scale {
    Scale::linear(axis.range.0, axis.range.1)
}

/// Tells the page's script that a picture is over time, and over which stretch of it, s.
fn over_time(axis: &TimeAxis) -> String {
    let (from, to) = axis.range;
    format!(" class=\"time\" data-from=\"{from}\" data-to=\"{to}\"")
}

fn ordinate(chart: &TimeChart, axis: &TimeAxis) -> Scale {
    let limits = chart.limits.iter().map(|(_, level)| (*level, *level));
    let ranges = chart.series.iter().filter_map(|s| s.signal.range_from(axis.scaled_from)).chain(limits);
    let (low, high) = ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    if !chart.log_y {
        return Scale::around(low, high);
    }
    let lowest = chart.limits.iter().map(|(_, level)| level * BELOW_LIMIT).fold(f64::INFINITY, f64::min);
    Scale::decades(if lowest.is_finite() { lowest } else { low.max(high * BELOW_TOP) }, high)
}

fn path(series: &Series, time: Scale, y: impl Fn(f64) -> f64) -> String {
    let mut path = String::new();
    for line in series.signal.polylines(DRAWN) {
        for (k, (t_s, value)) in line.into_iter().enumerate() {
            let command = if k == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{} {}", px(PLOT_WIDTH * time.share(t_s)), px(y(value)));
        }
    }
    path
}

fn bands(drawing: &mut Drawing, axis: &TimeAxis) {
    let time = time_of(axis);
    let (from, to) = axis.range;
    for band in axis.bands.iter().filter(|b| b.to > from && b.from < to) {
        let (start, end) = (PLOT_WIDTH * time.share(band.from), PLOT_WIDTH * time.share(band.to));
        let interval = format!("data-from=\"{}\" data-to=\"{}\"", band.from.max(from), band.to.min(to));
        let (x, wide) = (px(start), px(end - start));
        let name = escaped(&band.label);
        drawing.draw(&format!(
            "<rect class=\"band\" data-name=\"{name}\" {interval} x=\"{x}\" width=\"{wide}\" height=\"100%\"/>"
        ));
        drawing.name_above((start, end), &interval, &band.label);
    }
}

/// Joins intervals that lie closer together than `gap`.
fn joined(intervals: &[(f64, f64)], gap: f64) -> Vec<(f64, f64)> {
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for &(start, end) in intervals {
        match merged.last_mut() {
            Some(last) if start - last.1 < gap => last.1 = last.1.max(end),
            _ => merged.push((start, end)),
        }
    }
    merged
}

/// The intervals for the script.
fn spans(intervals: &[(f64, f64)]) -> String {
    let mut told = intervals.to_vec();
    let mut gap = intervals.last().map_or(0.0, |last| (last.1 - intervals[0].0) / SPANS as f64);
    while told.len() > SPANS {
        told = joined(intervals, gap);
        gap *= 2.0;
    }
    told.iter().map(|(start, end)| format!("{start} {end}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_beyond_what_the_script_is_told_are_joined_and_none_is_lost() {
        let few: Vec<(f64, f64)> = (0..10).map(|k| (f64::from(k), f64::from(k) + 0.5)).collect();
        assert_eq!(spans(&few).split(' ').count(), 20);
        let many: Vec<(f64, f64)> = (0..50_000).map(|k| (f64::from(k), f64::from(k) + 0.5)).collect();
        let told: Vec<f64> = spans(&many).split(' ').map(|number| number.parse().unwrap()).collect();
        assert!(!told.is_empty() && told.len() <= 2 * SPANS, "{}", told.len());
        assert_eq!((told[0], told[told.len() - 1]), (0.0, 49_999.5));
    }
}
