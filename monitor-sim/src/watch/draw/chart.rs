//! The charts: three channels with the mean they are judged by, and the distances against their limit.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::DIM;
use crate::tables::significant;
use crate::watch::history::Bin;
use crate::watch::player::Player;
use plot::{Axis, Plot};

mod plot;

/// Width of the numbers beside a chart.
const GUTTER: u16 = 9;

const READINGS: Color = Color::Cyan;
const MEAN: Color = Color::Yellow;
const LIMIT: Color = Color::Red;
const DISTANCES: [Color; 4] = [Color::Cyan, Color::Magenta, Color::Yellow, Color::Green];

/// How many sigmas around the mean a chart shows at least.
const LEAST_SIGMAS: f64 = 5.0;

/// Decades above the limit that the distances show at least.
const LEAST_DECADES: f64 = 1.0;

/// The limit, as a logarithm: just above the edge between two rows.
const LIMIT_AT: f64 = 1e-6;

pub(super) fn draw(player: &Player, frame: &mut Frame, area: Rect) {
    let [a, b, c, distances, strip] = Layout::vertical([
        Constraint::Fill(1),
        Constraint::Fill(1),
        Constraint::Fill(1),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(area);
    for (channel, area) in [a, b, c].into_iter().enumerate() {
        self::channel(player, channel, frame, area);
    }
    self::distances(player, frame, distances);
    alarms(player, frame, strip);
}

/// Title, numbers and picture of a chart.
fn parts(area: Rect) -> [Rect; 3] {
    let [title, below] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    let [gutter, picture] = Layout::horizontal([Constraint::Length(GUTTER), Constraint::Fill(1)]).areas(below);
    [title, gutter, picture]
}

fn channel(player: &Player, channel: usize, frame: &mut Frame, area: Rect) {
    let [title, gutter, picture] = parts(area);
    frame.render_widget(channel_title(player, channel), title);
    let mut plot = Plot::new(player.bins_shown(), picture.width);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut latest = None;
    for (place, bin) in player.seen() {
        let [least, greatest] = [bin.least[channel], bin.greatest[channel]].map(f64::from);
        plot.push(0, place, least, greatest);
        let [mean, sigma] = [bin.says.mean[channel], bin.says.sigma[channel]].map(f64::from);
        if mean.is_finite() {
            latest = Some(mean);
            let around = LEAST_SIGMAS * sigma;
            (low, high) = (low.min(mean - around), high.max(mean + around));
        }
        (low, high) = (low.min(least), high.max(greatest));
    }
    let axis = Axis::around(low, high, picture.height);
    plot.render(&axis, &[READINGS], frame, picture);
    // A mean per column: it is another one behind a change of the set point.
    for (place, bin) in player.seen() {
        let mean = f64::from(bin.says.mean[channel]);
        plot.mark(&axis, place, mean, ("╌", Style::new().fg(MEAN)), frame, picture);
    }
    let mut labels = axis.ends();
    if let Some(mean) = latest {
        labels.push((mean, significant(mean), Style::new().fg(MEAN)));
    }
    axis.label(labels, frame, gutter);
}

fn channel_title(player: &Player, channel: usize) -> Line<'static> {
    let subject = player.subject();
    let (name, unit) = (&subject.names.0[channel], subject.units[channel]);
    let comma = if unit.is_empty() { "" } else { ", " };
    let mut spans = vec![Span::raw(format!(" {name}{comma}{unit}  "))];
    let Some(bin) = player.shown() else { return Line::from(spans) };
    let reading = bin.reading(channel);
    let shown = if reading.is_finite() { significant(reading) } else { "no reading".to_owned() };
    spans.push(Span::styled(shown, Style::new().fg(READINGS)));
    let [mean, sigma] = [bin.says.mean[channel], bin.says.sigma[channel]].map(f64::from);
    if mean.is_finite() {
        spans.push(Span::styled(format!("  mean {}", significant(mean)), Style::new().fg(MEAN)));
        let off = (reading - mean) / sigma;
        if off.is_finite() {
            spans.push(Span::raw(format!("  {off:+.1} sigma")));
        }
    }
    Line::from(spans)
}

fn distances(player: &Player, frame: &mut Frame, area: Rect) {
    let [title, gutter, picture] = parts(area);
    let count = player.subject().distances.len();
    let log = |ratio: f32| f64::from(ratio).log10();
    frame.render_widget(distance_title(player), title);
    let mut plot = Plot::new(player.bins_shown(), picture.width);
    let ratios = player.seen().flat_map(|(_, bin)| bin.ratios);
    let high = ratios.map(|ratio| log(ratio).ceil()).filter(|y| y.is_finite()).fold(LEAST_DECADES, f64::max);
    let low = below_the_limit(high, picture.height);
    for (place, bin) in player.seen() {
        for (series, ratio) in bin.ratios.into_iter().take(count).enumerate() {
            // Far below the limit there is nothing to see.
            let y = log(ratio).max(low);
            plot.push(series, place, y, y);
        }
    }
    let axis = Axis::new(low, high, picture.height);
    plot.render(&axis, &DISTANCES, frame, picture);
    for (place, _) in player.seen() {
        plot.mark(&axis, place, LIMIT_AT, ("▁", Style::new().fg(LIMIT)), frame, picture);
    }
    let decade = |decade: i32| (f64::from(decade), decade_label(decade), DIM);
    let decades = (low.ceil() as i32..=high as i32).filter(|at| *at != 0).map(decade);
    let limit = (LIMIT_AT, "limit 1".to_owned(), Style::new().fg(LIMIT));
    axis.label([limit].into_iter().chain(decades).collect(), frame, gutter);
}

/// The lower end of an ordinate that shows a decade below the limit if it can, and has the limit on the edge of a row: what
/// is within the limit leaves its line free.
fn below_the_limit(high: f64, rows: u16) -> f64 {
    let below = (f64::from(rows) / (high + 1.0)).floor().max(1.0);
    if rows < 2 { -1.0 } else { -high * below / (f64::from(rows) - below) }
}

fn decade_label(decade: i32) -> String {
    if (-3..=5).contains(&decade) { format!("{}", 10_f64.powi(decade)) } else { format!("1e{decade}") }
}

fn distance_title(player: &Player) -> Line<'static> {
    let mut spans = vec![Span::raw(format!(" {}", player.subject().ratio))];
    let ratios = player.shown().map_or([f32::NAN; 4], |bin: &Bin| bin.says.ratios);
    for ((distance, ratio), color) in player.subject().distances.iter().zip(ratios).zip(DISTANCES) {
        let shown = if ratio.is_finite() { short(f64::from(ratio)) } else { "-".to_owned() };
        spans.push(Span::styled(format!(" {} {shown}", distance.name), Style::new().fg(color)));
    }
    Line::from(spans)
}

/// Three or four digits are enough of a distance, and of one that is far beyond its limit one.
fn short(ratio: f64) -> String {
    match ratio {
        _ if ratio >= 9999.5 => format!("{ratio:.0e}"),
        _ if ratio >= 99.95 => format!("{ratio:.0}"),
        _ if ratio >= 9.995 => format!("{ratio:.1}"),
        _ => format!("{ratio:.2}"),
    }
}

/// Where an alarm stood, under the last chart, with the time of its left edge.
fn alarms(player: &Player, frame: &mut Frame, area: Rect) {
    let [gutter, picture] = Layout::horizontal([Constraint::Length(GUTTER), Constraint::Fill(1)]).areas(area);
    let Some(now) = player.shown() else { return };
    let left = now.t_s - player.span_s();
    let label = format!("{left:>width$.2} s ", width = usize::from(GUTTER) - 3);
    frame.render_widget(Paragraph::new(Span::styled(label, DIM)), gutter);
    let columns = Plot::new(player.bins_shown(), picture.width);
    let mut wrong = vec![None; usize::from(picture.width)];
    for (place, bin) in player.seen() {
        if let Some(wrong) = wrong.get_mut(columns.cell(place)) {
            *wrong = Some(*wrong == Some(true) || bin.alarm);
        }
    }
    let spans = wrong.into_iter().map(|wrong| match wrong {
        Some(true) => Span::styled("━", Style::new().fg(LIMIT)),
        Some(false) => Span::styled("─", DIM),
        None => Span::raw(" "),
    });
    frame.render_widget(Line::from(spans.collect::<Vec<_>>()), picture);
}
