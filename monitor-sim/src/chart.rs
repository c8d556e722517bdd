//! Pictures as SVG: signals over time, logical outputs over time, bars of explained variance.
//!
//! `plotters` draws in marker colours; the page's style sheet gives each its colour in the light and the dark theme
//! ([`STYLE`]). Legends are made of HTML above a picture, so that they never cover data.

mod ordinate;

use std::fmt::Write as _;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use self::ordinate::{Ordinate, tick};
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
    let bottom = if chart.stacked { BOTTOM_STACKED } else { BOTTOM };
    Ok(Picture { svg: over_time(&scalable(&svg), axis, bottom), legend: series.chain(limits).chain(bands).collect() })
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
    Ok(Picture { svg: over_time(&scalable(&svg), axis, BOTTOM), legend: Vec::new() })
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

/// Tells the page's script which stretch of time a picture shows, s, and how much room its labels take below.
fn over_time(svg: &str, axis: &TimeAxis, bottom: u32) -> String {
    let (from, to) = axis.range;
    svg.replacen(" aria-hidden", &format!(" data-time=\"{from} {to}\" data-bottom=\"{bottom}\" aria-hidden"), 1)
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
mod tests;
