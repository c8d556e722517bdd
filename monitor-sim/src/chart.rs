//! Pictures as SVG: signals over time, logical outputs over time, bars, results of many runs.
//!
//! A picture stands as it is drawn, on paper and without script. Elements say by class what they are and by `data-`
//! attributes what they show, so that the page's style sheet gives them the colours of each theme ([`STYLE`]) and its script
//! can draw them anew for a shorter stretch of time. Legends are made of HTML above a picture, so that they never cover data.

mod scale;
mod drawing;
mod codes;
mod time;
mod bars;
mod grid;
mod points;

use crate::envelope::Envelope;
use crate::intervals::Interval;

pub use bars::bar_chart;
pub use grid::{Grid, GridRow, Share, bar_grid, shade_grid};
pub use points::{Axis, Line, Range, line_chart, range_chart};
pub use time::{logic_chart, time_chart};

/// Colours of series.
const SERIES: usize = 4;

/// The colours of the pictures in both themes: Okabe and Ito's palette, which colour-blind readers tell apart,
/// brightened for the dark one.
pub const STYLE: &str = r##"
:root{--ink:#1c2733;--on:#fff;--grid:#d9dfe5;--band:#7a8794;--limit:#c0392b;--s0:#0072b2;--s1:#c65a00;--s2:#008a63;--s3:#8a4f9e}
@media(prefers-color-scheme:dark){:root{--ink:#dfe6ee;--on:#12181f;--grid:#33404d;--band:#93a4b5;--limit:#ff8a75;--s0:#5cb8f2;--s1:#f0a04b;--s2:#3fd0a0;--s3:#d79be8}}
@media print{:root{--ink:#000;--on:#fff;--grid:#ccc;--band:#888;--limit:#b00;--s0:#0072b2;--s1:#c65a00;--s2:#008a63;--s3:#8a4f9e}}
svg text{font-size:14px;fill:var(--ink)}.mid{text-anchor:middle}.end{text-anchor:end}svg .on{fill:var(--on);font-weight:600}
.field{fill:transparent}.empty{fill:none;stroke:var(--grid)}.axis{fill:none;stroke:var(--ink)}.grid{fill:none;stroke:var(--grid)}
.s0{color:var(--s0)}.s1{color:var(--s1)}.s2{color:var(--s2)}.s3{color:var(--s3)}
.half{opacity:.45}.curve{fill:none;stroke:currentColor;stroke-linejoin:bevel}.solid{fill:currentColor}
.band{fill:var(--band);fill-opacity:.18}.limit{fill:none;stroke:var(--limit);stroke-width:2;stroke-dasharray:9 5}
"##;

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
    /// What they are, for the legend.
    pub shaded: &'static str,
}

/// Signals over time.
#[derive(Clone, Debug)]
pub struct TimeChart<'a> {
    /// Name of the ordinate.
    pub name: &'a str,
    /// Its unit; empty if it has none.
    pub unit: &'a str,
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

/// Bars side by side.
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
    /// Entries of the legend: how they are marked, and a name.
    pub legend: Vec<(Swatch, String)>,
}

impl Picture {
    /// The picture without its series in the legend, where the axis names its only one already.
    #[must_use]
    pub fn without_series(mut self) -> Self {
        self.legend.retain(|(swatch, _)| !matches!(swatch, Swatch::Series(_)));
        self
    }
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
            Swatch::Series(k) => format!("var(--{})", series_class(k)),
            Swatch::Limit => "var(--limit)".to_owned(),
            Swatch::Band => "var(--band)".to_owned(),
        }
    }

    /// The class of an area of its kind.
    fn class(self) -> String {
        match self {
            Swatch::Series(k) => format!("solid {}", series_class(k)),
            Swatch::Limit => "limit".to_owned(),
            Swatch::Band => "band".to_owned(),
        }
    }
}

fn series_class(k: usize) -> String {
    format!("s{}", k % SERIES)
}

/// Intervals of samples as intervals of time.
#[must_use]
pub fn in_seconds(intervals: &[Interval], rate_hz: f64) -> Vec<(f64, f64)> {
    intervals.iter().map(|i| (i.start as f64 / rate_hz, i.end as f64 / rate_hz)).collect()
}

#[cfg(test)]
mod tests;
