//! Pictures as SVG: signals over time, logical outputs over time, bars of explained variance.
//!
//! `plotters` draws in marker colours; the page's style sheet gives each its colour in the light and the dark theme
//! ([`STYLE`]). Legends are made of HTML above a picture, so that they never cover data.

use std::fmt::Write as _;

use plotters::coord::ranged1d::{NoDefaultFormatting, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::envelope::Envelope;
use crate::intervals::Interval;

/// Size of a picture's coordinate system; it is scaled to the page.
const WIDTH: u32 = 1000;
const TIME_HEIGHT: u32 = 280;
const BAR_HEIGHT: u32 = 280;
/// The same for every picture over time, so that they stand exactly under each other.
const LEFT: u32 = 130;
const RIGHT: u32 = 18;
const TOP: u32 = 24;
const BOTTOM: u32 = 48;
/// A picture with another under it names its ticks, but not the axis.
const BOTTOM_STACKED: u32 = 26;
const ROW_HEIGHT: u32 = 26;
const FONT: (&str, u32) = ("sans-serif", 14);
/// Logarithmic axes show nothing below this share of the lowest limit: what is further down is the filter's ringing.
const BELOW_LIMIT: f64 = 0.1;
/// Without a limit, nothing below this share of their top.
const BELOW_TOP: f64 = 1e-7;

/// Marker colours: never seen, but replaced by the style sheet.
const INK: RGBColor = RGBColor(1, 1, 1);
const GRID: RGBColor = RGBColor(2, 2, 2);
const BAND: RGBColor = RGBColor(3, 3, 3);
const LIMIT: RGBColor = RGBColor(4, 4, 4);
const SERIES: [RGBColor; 4] = [RGBColor(11, 11, 11), RGBColor(12, 12, 12), RGBColor(13, 13, 13), RGBColor(14, 14, 14)];

/// The colours of the pictures in both themes: Okabe and Ito's palette, which colour-blind readers tell apart,
/// brightened for the dark one.
pub const STYLE: &str = r##"
:root{--ink:#1c2733;--grid:#d9dfe5;--band:#7a8794;--limit:#c0392b;--s0:#0072b2;--s1:#c65a00;--s2:#008a63;--s3:#8a4f9e}
@media(prefers-color-scheme:dark){:root{--ink:#dfe6ee;--grid:#33404d;--band:#93a4b5;--limit:#ff8a75;--s0:#5cb8f2;--s1:#f0a04b;--s2:#3fd0a0;--s3:#d79be8}}
@media print{:root{--ink:#000;--grid:#ccc;--band:#888;--limit:#b00;--s0:#0072b2;--s1:#c65a00;--s2:#008a63;--s3:#8a4f9e}}
svg [fill="#010101"]{fill:var(--ink)}svg [stroke="#010101"]{stroke:var(--ink)}
svg [stroke="#020202"]{stroke:var(--grid)}svg [fill="#030303"]{fill:var(--band)}
svg [stroke="#040404"]{stroke:var(--limit)}svg [fill="#040404"]{fill:var(--limit)}
svg [stroke="#0B0B0B"]{stroke:var(--s0)}svg [fill="#0B0B0B"]{fill:var(--s0)}
svg [stroke="#0C0C0C"]{stroke:var(--s1)}svg [fill="#0C0C0C"]{fill:var(--s1)}
svg [stroke="#0D0D0D"]{stroke:var(--s2)}svg [fill="#0D0D0D"]{fill:var(--s2)}
svg [stroke="#0E0E0E"]{stroke:var(--s3)}svg [fill="#0E0E0E"]{fill:var(--s3)}
"##;

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("a picture could not be drawn: {0}")]
pub struct ChartError(String);

type Drawn<T> = Result<T, ChartError>;

fn failed(error: impl std::fmt::Display) -> ChartError {
    ChartError(error.to_string())
}

/// A shaded stretch of time, such as the true interval of a fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Beginning, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
    /// What it is.
    pub label: String,
}

/// A signal to draw.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// Its name in the legend.
    pub name: &'a str,
    /// The signal.
    pub signal: &'a Envelope,
}

/// The stretch of time a picture shows, and what is shaded in it.
#[derive(Clone, Debug)]
pub struct TimeAxis {
    /// First and last instant, s.
    pub range: (f64, f64),
    /// Ordinates are scaled to what comes from this instant on, s, so that a start-up does not dwarf the rest.
    pub scaled_from: f64,
    /// Shaded stretches.
    pub bands: Vec<Band>,
}

/// Signals over time.
#[derive(Clone, Debug)]
pub struct TimeChart<'a> {
    /// Name and unit of the ordinate.
    pub y_label: &'a str,
    /// Whether the ordinate is logarithmic.
    pub log_y: bool,
    /// At most four signals.
    pub series: Vec<Series<'a>>,
    /// Dashed level lines with their names.
    pub limits: Vec<(String, f64)>,
    /// Whether another picture over the same time stands under this one.
    pub stacked: bool,
}

/// A logical output over time.
#[derive(Clone, Debug)]
pub struct LogicRow {
    /// Its name.
    pub name: String,
    /// Its colour: that of the series of this index.
    pub colour: usize,
    /// Where it was true, s.
    pub intervals: Vec<(f64, f64)>,
}

/// Bars in groups: the share of the variance that each component explains.
#[derive(Clone, Debug)]
pub struct BarGroup {
    /// What the group stands for.
    pub name: String,
    /// One value for each bar, percent.
    pub values: Vec<f64>,
}

/// A picture and the legend that stands above it.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The SVG element.
    pub svg: String,
    /// Entries of the legend: a class of [`STYLE`] and a name.
    pub legend: Vec<(Swatch, String)>,
}

/// How an entry of a legend is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Swatch {
    /// A line or area in the colour of a series.
    Series(usize),
    /// A dashed limit.
    Limit,
    /// A shaded band.
    Band,
}

impl Swatch {
    /// The colour, as a variable of [`STYLE`].
    #[must_use]
    pub fn colour(self) -> String {
        match self {
            Swatch::Series(k) => format!("var(--s{})", k % SERIES.len()),
            Swatch::Limit => "var(--limit)".to_owned(),
            Swatch::Band => "var(--band)".to_owned(),
        }
    }
}

/// Intervals of samples as intervals of time.
#[must_use]
pub fn in_seconds(intervals: &[Interval], rate_hz: f64) -> Vec<(f64, f64)> {
    intervals.iter().map(|i| (i.start as f64 / rate_hz, i.end as f64 / rate_hz)).collect()
}

/// An ordinate from low to high, linear or logarithmic, with tick labels a person would write.
#[derive(Clone)]
struct Ordinate {
    low: f64,
    high: f64,
    log: bool,
}

impl Ordinate {
    fn of(chart: &TimeChart, axis: &TimeAxis) -> Ordinate {
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

    fn key_points<Hint: plotters::coord::ranged1d::KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
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

fn tick(value: f64, log: bool) -> String {
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

/// Draws signals over time.
///
/// # Errors
/// [`ChartError`] when the drawing library fails.
pub fn time_chart(chart: &TimeChart, axis: &TimeAxis) -> Drawn<Picture> {
    let mut svg = String::new();
    {
        let bottom = if chart.stacked { BOTTOM_STACKED } else { BOTTOM };
        let height = TIME_HEIGHT - (BOTTOM - bottom);
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        let ordinate = Ordinate::of(chart, axis);
        let (from, to) = axis.range;
        let mut drawing = ChartBuilder::on(&root)
            .margin_right(RIGHT)
            .margin_top(TOP)
            .x_label_area_size(bottom)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(from..to, ordinate.clone())
            .map_err(failed)?;
        draw_bands(&mut drawing, axis, ordinate.range())?;
        drawing
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .label_style(FONT.into_font().color(&INK))
            .x_desc(if chart.stacked { "" } else { "time, s" })
            .y_desc(chart.y_label)
            .x_labels(8)
            .x_label_formatter(&|x| tick(*x, false))
            .draw()
            .map_err(failed)?;
        for (series, colour) in chart.series.iter().zip(SERIES) {
            for line in series.signal.polylines() {
                drawing.draw_series(LineSeries::new(line, colour.stroke_width(1))).map_err(failed)?;
            }
        }
        for (_, level) in &chart.limits {
            let dashed = DashedLineSeries::new([(from, *level), (to, *level)], 9, 5, LIMIT.stroke_width(2));
            drawing.draw_series(dashed).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    let series = chart.series.iter().enumerate().map(|(k, s)| (Swatch::Series(k), s.name.to_owned()));
    let limits = chart.limits.iter().map(|(name, _)| (Swatch::Limit, name.clone()));
    let bands = (!axis.bands.is_empty()).then(|| (Swatch::Band, "true fault".to_owned()));
    Ok(Picture { svg: scalable(&svg), legend: series.chain(limits).chain(bands).collect() })
}

/// Draws logical outputs under each other.
///
/// # Errors
/// [`ChartError`] when the drawing library fails.
pub fn logic_chart(rows: &[LogicRow], axis: &TimeAxis) -> Drawn<Picture> {
    let height = TOP + BOTTOM + ROW_HEIGHT * rows.len().max(1) as u32;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        let (from, to) = axis.range;
        let top = rows.len().max(1) as f64;
        let mut drawing = ChartBuilder::on(&root)
            .margin_right(RIGHT)
            .margin_top(TOP)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(from..to, 0.0..top)
            .map_err(failed)?;
        draw_bands(&mut drawing, axis, 0.0..top)?;
        drawing
            .configure_mesh()
            .disable_mesh()
            .axis_style(INK)
            .label_style(FONT.into_font().color(&INK))
            .x_desc("time, s")
            .x_labels(8)
            .y_labels(0)
            .x_label_formatter(&|x| tick(*x, false))
            .draw()
            .map_err(failed)?;
        // One pixel of the picture: shorter intervals are widened to it, closer ones are drawn as one.
        let pixel = (to - from) / f64::from(WIDTH - LEFT - RIGHT);
        for (k, row) in rows.iter().enumerate() {
            let low = top - k as f64 - 1.0;
            let colour = SERIES.get(row.colour % SERIES.len()).unwrap_or(&INK);
            for (start, end) in joined(&row.intervals, pixel) {
                let corners = [(start, low + 0.15), (end.max(start + pixel), low + 0.85)];
                drawing.draw_series([Rectangle::new(corners, colour.filled())]).map_err(failed)?;
            }
            drawing.draw_series(LineSeries::new([(from, low), (to, low)], GRID)).map_err(failed)?;
            let name = FONT.into_font().color(&INK).pos(Pos::new(HPos::Right, VPos::Center));
            let y = (TOP + ROW_HEIGHT * k as u32 + ROW_HEIGHT / 2) as i32;
            root.draw_text(&row.name, &name, (LEFT as i32 - 10, y)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(Picture { svg: scalable(&svg), legend: Vec::new() })
}

/// Draws groups of bars in percent, with a dashed line at `criterion`.
///
/// # Errors
/// [`ChartError`] when the drawing library fails.
pub fn bar_chart(groups: &[BarGroup], y_label: &str, criterion: (&str, f64)) -> Drawn<Picture> {
    let bars = groups.iter().map(|g| g.values.len()).max().unwrap_or(0);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, BAR_HEIGHT)).into_drawing_area();
        let right = groups.len().max(1) as f64;
        let mut drawing = ChartBuilder::on(&root)
            .margin_right(RIGHT)
            .margin_top(TOP)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(0.0..right, 0.0..100.0)
            .map_err(failed)?;
        drawing
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .label_style(FONT.into_font().color(&INK))
            .y_desc(y_label)
            .y_labels(6)
            .x_labels(0)
            .draw()
            .map_err(failed)?;
        let centred = FONT.into_font().color(&INK).pos(Pos::new(HPos::Center, VPos::Bottom));
        for (g, group) in groups.iter().enumerate() {
            // Bars share four fifths of the group's room.
            let width = 0.8 / bars.max(1) as f64;
            for ((k, value), colour) in group.values.iter().enumerate().zip(SERIES) {
                let left = g as f64 + 0.1 + width * k as f64;
                let corners = [(left + 0.05 * width, 0.0), (left + 0.95 * width, *value)];
                drawing.draw_series([Rectangle::new(corners, colour.filled())]).map_err(failed)?;
                let label = Text::new(format!("{value:.1}"), (left + 0.5 * width, value + 1.0), centred.clone());
                drawing.draw_series([label]).map_err(failed)?;
            }
            let plot = f64::from(WIDTH - LEFT - RIGHT);
            let x = f64::from(LEFT) + plot * (g as f64 + 0.5) / right;
            root.draw_text(&group.name, &centred, (x as i32, (BAR_HEIGHT - BOTTOM + 26) as i32)).map_err(failed)?;
        }
        let dashed = DashedLineSeries::new([(0.0, criterion.1), (right, criterion.1)], 9, 5, LIMIT.stroke_width(2));
        drawing.draw_series(dashed).map_err(failed)?;
        root.present().map_err(failed)?;
    }
    let components = (0..bars).map(|k| (Swatch::Series(k), format!("component {}", k + 1)));
    Ok(Picture { svg: scalable(&svg), legend: components.chain([(Swatch::Limit, criterion.0.to_owned())]).collect() })
}

fn draw_bands<DB: DrawingBackend, Y: Ranged<ValueType = f64>>(
    drawing: &mut ChartContext<DB, Cartesian2d<plotters::coord::types::RangedCoordf64, Y>>,
    axis: &TimeAxis,
    ordinate: std::ops::Range<f64>,
) -> Drawn<()> {
    let (from, to) = axis.range;
    for band in axis.bands.iter().filter(|b| b.to > from && b.from < to) {
        let (start, end) = (band.from.max(from), band.to.min(to));
        let corners = [(start, ordinate.start), (end, ordinate.end)];
        drawing.draw_series([Rectangle::new(corners, BAND.mix(0.18).filled())]).map_err(failed)?;
        let style = FONT.into_font().color(&INK).pos(Pos::new(HPos::Center, VPos::Bottom));
        let label = Text::new(band.label.clone(), (0.5 * (start + end), ordinate.end), style);
        drawing.draw_series([label]).map_err(failed)?;
    }
    Ok(())
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

/// Gives the SVG a view box instead of a fixed size, so that it fits the page.
fn scalable(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len());
    let start = svg.find("<svg").unwrap_or(0);
    let body = svg.get(start..).unwrap_or_default();
    let open = body.find('>').map_or(0, |end| end + 1);
    let (head, rest) = body.split_at(open);
    let view_box = head.split("viewBox=\"").nth(1).and_then(|tail| tail.split('"').next());
    let height = view_box.and_then(|v| v.rsplit(' ').next()).unwrap_or("300");
    let _ = write!(out, "<svg viewBox=\"0 0 {WIDTH} {height}\" aria-hidden=\"true\" focusable=\"false\">{rest}");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(n: u32) -> Envelope {
        let mut envelope = Envelope::default();
        (0..n).for_each(|k| envelope.push(f64::from(k) * 0.001, f64::from(k % 1000)));
        envelope
    }

    fn axis() -> TimeAxis {
        let band = Band { from: 20.0, to: 40.0, label: "F1 <cord>".to_owned() };
        TimeAxis { range: (0.0, 140.0), scaled_from: 0.0, bands: vec![band] }
    }

    #[test]
    fn a_chart_shows_its_series_its_limit_its_bands_and_its_units() {
        let signal = ramp(140_000);
        let series = vec![Series { name: "speed", signal: &signal }];
        let limits = vec![("threshold".to_owned(), 500.0)];
        let chart = TimeChart { y_label: "T², 1", log_y: false, series, limits, stacked: false };
        let Picture { svg, legend } = time_chart(&chart, &axis()).unwrap();
        assert_eq!(svg.matches("stroke=\"#0B0B0B\"").count(), 1, "one line for the series");
        assert!(svg.contains("stroke=\"#040404\""), "the limit");
        assert!(svg.contains("fill=\"#030303\""), "the band");
        assert!(svg.contains("time, s") && svg.contains("T², 1"));
        assert!(svg.contains("F1 &lt;cord&gt;") && !svg.contains("<cord>"));
        assert_eq!(legend.len(), 3);
        assert!(svg.starts_with("<svg viewBox=\"0 0 1000 280\""));
    }

    #[test]
    fn a_gap_breaks_a_line_in_two() {
        let mut signal = Envelope::default();
        [1.0, 2.0, f64::NAN, 3.0, 4.0].iter().enumerate().for_each(|(k, y)| signal.push(k as f64, *y));
        let chart = TimeChart {
            y_label: "y",
            log_y: true,
            series: vec![Series { name: "s", signal: &signal }],
            limits: vec![],
            stacked: false,
        };
        let svg = time_chart(&chart, &TimeAxis { range: (0.0, 5.0), scaled_from: 0.0, bands: vec![] }).unwrap().svg;
        assert_eq!(svg.matches("stroke=\"#0B0B0B\"").count(), 2);
    }

    #[test]
    fn nothing_to_draw_is_drawn_without_failing() {
        let empty = Envelope::default();
        for log_y in [false, true] {
            let chart = TimeChart {
                y_label: "y",
                log_y,
                series: vec![Series { name: "s", signal: &empty }],
                limits: vec![],
                stacked: false,
            };
            assert!(time_chart(&chart, &axis()).is_ok());
        }
        assert!(logic_chart(&[], &axis()).is_ok());
        assert!(bar_chart(&[], "share, %", ("80 %", 80.0)).is_ok());
    }

    #[test]
    fn every_interval_is_drawn_and_those_closer_than_a_pixel_as_one() {
        let rows = vec![LogicRow {
            name: "r1".to_owned(),
            colour: 0,
            intervals: vec![(1.0, 2.0), (2.001, 3.0), (50.0, 60.0)],
        }];
        let svg = logic_chart(&rows, &axis()).unwrap().svg;
        assert_eq!(svg.matches("fill=\"#0B0B0B\"").count(), 2);
        assert!(svg.contains("r1"));
    }

    #[test]
    fn bars_carry_their_values_and_the_criterion_is_drawn() {
        let groups = vec![BarGroup { name: "all".to_owned(), values: vec![60.0, 30.0, 10.0] }];
        let Picture { svg, legend } = bar_chart(&groups, "share, %", ("80 % criterion", 80.0)).unwrap();
        assert!(svg.contains("60.0") && svg.contains("10.0"));
        assert_eq!(legend.last().map(|(s, n)| (*s, n.as_str())), Some((Swatch::Limit, "80 % criterion")));
    }

    #[test]
    fn every_marker_colour_has_a_rule_in_the_style_sheet() {
        for colour in SERIES.iter().chain([&INK, &LIMIT]) {
            let hex = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
            assert!(
                STYLE.contains(&format!("stroke=\"{hex}\"")) && STYLE.contains(&format!("fill=\"{hex}\"")),
                "{hex}"
            );
        }
        for variable in ["--ink", "--grid", "--band", "--limit", "--s0", "--s1", "--s2", "--s3"] {
            assert_eq!(STYLE.matches(&format!("{variable}:")).count(), 3, "{variable} in light, dark and print");
        }
    }

    #[test]
    fn ticks_read_as_a_person_writes_them() {
        assert_eq!([0.0, 0.1 + 0.2, 300.0, -0.05].map(|v| tick(v, false)), ["0", "0.3", "300", "-0.05"]);
        assert_eq!([1e-3, 0.01, 10.0, 1e6].map(|v| tick(v, true)), ["1e-3", "0.01", "10", "1e6"]);
    }
}
