//! A picture of dots, two by four in a character, and its ordinate.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::widgets::canvas::{Canvas, Line};

use crate::tables::significant;
use crate::watch::slot::DISTANCES;

/// Dots in a character.
const DOTS_ACROSS: u64 = 2;
const DOTS_DOWN: u16 = 4;

/// An ordinate: a value for each row of dots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    rows: u16,
}

impl Axis {
    /// From `low` to `high` in so many rows of characters.
    pub(super) fn new(low: f64, high: f64, rows: u16) -> Self {
        Axis { low, high, rows }
    }

    /// With some room below and above; some ordinate where there is nothing to show.
    pub(super) fn around(low: f64, high: f64, rows: u16) -> Self {
        if !(low.is_finite() && high.is_finite()) {
            return Axis::new(0.0, 1.0, rows);
        }
        let least = 1e-6 * low.abs().max(high.abs()).max(1e-6);
        let room = (0.02 * (high - low)).max(least);
        Axis::new(low - room, high + room, rows)
    }

    /// The row of characters that a value falls into, from above.
    fn row(&self, y: f64) -> Option<u16> {
        let from_above = (self.high - y) / (self.high - self.low);
        (0.0..=1.0).contains(&from_above).then(|| {
            let row = (from_above * f64::from(self.rows)) as u16;
            row.min(self.rows.saturating_sub(1))
        })
    }

    /// Labels of both ends.
    pub(super) fn ends(&self) -> Vec<(f64, String, Style)> {
        [self.high, self.low].map(|end| (end, significant(end), super::DIM)).into()
    }

    /// Writes labels beside the picture, each in its row; of those that share a row the last, but for the first which stays.
    pub(super) fn label(&self, labels: Vec<(f64, String, Style)>, frame: &mut Frame, gutter: Rect) {
        let width = usize::from(gutter.width.saturating_sub(1));
        let mut taken = Vec::new();
        for (y, text, style) in labels {
            let Some(row) = self.row(y).filter(|row| !taken.contains(row)) else { continue };
            taken.push(row);
            frame.buffer_mut().set_stringn(gutter.x, gutter.y + row, format!("{text:>width$}"), width, style);
        }
    }
}

/// What is drawn, gathered by columns of dots.
#[derive(Debug)]
pub(super) struct Plot {
    bins: u64,
    cells: u16,
    /// Least and greatest value of each column, for each line.
    columns: [Vec<Option<(f64, f64)>>; DISTANCES],
}

impl Plot {
    /// An empty picture of so many bins in so many characters across.
    pub(super) fn new(bins: u64, cells: u16) -> Self {
        let dots = usize::from(cells) * DOTS_ACROSS as usize;
        Plot { bins: bins.max(1), cells, columns: core::array::from_fn(|_| vec![None; dots]) }
    }

    /// The column of dots of a bin.
    fn dot(&self, place: u64) -> usize {
        (place * DOTS_ACROSS * u64::from(self.cells) / self.bins) as usize
    }

    /// The column of characters of a bin.
    pub(super) fn cell(&self, place: u64) -> usize {
        self.dot(place) / DOTS_ACROSS as usize
    }

    /// Adds a bin to a line; one without a number leaves a gap.
    pub(super) fn push(&mut self, series: usize, place: u64, least: f64, greatest: f64) {
        let dot = self.dot(place);
        let column = self.columns.get_mut(series).and_then(|columns| columns.get_mut(dot));
        if let Some(column) = column.filter(|_| least.is_finite() && greatest.is_finite()) {
            let (low, high) = column.unwrap_or((least, greatest));
            *column = Some((low.min(least), high.max(greatest)));
        }
    }

    /// Draws the lines.
    pub(super) fn render(&self, axis: &Axis, colors: &[Color], frame: &mut Frame, area: Rect) {
        // The middle of a row of dots has a whole number.
        let (dots_across, dots_down) = (self.columns[0].len() as f64, f64::from(area.height * DOTS_DOWN));
        // Where there are fewer bins than columns, the empty columns between two bins are no gap.
        let reach = self.columns[0].len().div_ceil(usize::try_from(self.bins).unwrap_or(usize::MAX));
        let dots_per_unit = (dots_down - 1.0) / (axis.high - axis.low);
        let down = |y: f64| (y - axis.low) * dots_per_unit;
        let canvas = Canvas::default()
            .marker(Marker::Braille)
            .x_bounds([0.0, dots_across - 1.0])
            .y_bounds([0.0, dots_down - 1.0])
            .paint(|context| {
                for (columns, color) in self.columns.iter().zip(colors) {
                    for line in lines(columns, reach) {
                        let [(x1, y1), (x2, y2)] = line;
                        context.draw(&Line::new(x1, down(y1), x2, down(y2), *color));
                    }
                }
            });
        frame.render_widget(canvas, area);
    }

    /// Writes a character at a value, where the picture is empty.
    pub(super) fn mark(
        &self,
        axis: &Axis,
        place: u64,
        y: f64,
        (symbol, style): (&str, Style),
        frame: &mut Frame,
        area: Rect,
    ) {
        let Some(row) = axis.row(y).filter(|_| y.is_finite()) else { return };
        let x = area.x + u16::try_from(self.cell(place)).unwrap_or(u16::MAX).min(area.width.saturating_sub(1));
        if let Some(cell) = frame.buffer_mut().cell_mut((x, area.y + row)).filter(|cell| is_empty(cell.symbol())) {
            cell.set_symbol(symbol).set_style(style);
        }
    }
}

/// Nothing, or a pattern of no dots.
fn is_empty(symbol: &str) -> bool {
    matches!(symbol, " " | "\u{2800}")
}

/// The band of each column, and how it joins the one before if that is not further off than `reach` columns.
fn lines(columns: &[Option<(f64, f64)>], reach: usize) -> Vec<[(f64, f64); 2]> {
    let mut lines = Vec::new();
    let mut before: Option<(usize, (f64, f64))> = None;
    for (dot, column) in columns.iter().enumerate() {
        let Some((low, high)) = *column else { continue };
        let x = dot as f64;
        lines.push([(x, low), (x, high)]);
        if let Some((at, (low_before, high_before))) = before.filter(|(at, _)| dot - at <= reach) {
            let (from, to) = if low > high_before { (high_before, low) } else { (low_before, high) };
            if low > high_before || high < low_before || dot - at > 1 {
                lines.push([(at as f64, from), (x, to)]);
            }
        }
        before = Some((dot, (low, high)));
    }
    lines
}
