//! Draws a run into a frame.

use ratatui::Frame;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::player::Player;

mod chart;
mod events;
mod help;
mod verdict;

/// The least frame in which everything has room.
pub const LEAST: (u16, u16) = (80, 24);

/// Width of the events: in a frame of the least width, and in a wide one.
const EVENTS: (u16, u16) = (27, 44);
const WIDE: u16 = 120;

/// What the frame is read by in a glance.
const DIM: Style = Style::new().fg(Color::DarkGray);

const KEYS: &str = "space pause  +/- pace  ←/→ PgUp/PgDn back  End now  [ ] span  ? help  q quit";

/// Fills a frame.
pub fn draw(player: &Player, frame: &mut Frame) {
    let area = frame.area();
    if area.width < LEAST.0 || area.height < LEAST.1 {
        too_small(player, frame, area);
        return;
    }
    let [head, body, foot] =
        Layout::vertical([Constraint::Length(3), Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    header(player, frame, head);
    let events = if area.width < WIDE { EVENTS.0 } else { EVENTS.1 };
    let [charts, list] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(events)]).areas(body);
    chart::draw(player, frame, charts);
    events::draw(player, frame, list);
    frame.render_widget(Line::styled(KEYS, DIM), foot);
    if player.helps() {
        help::draw(player, frame, body);
    }
}

/// A frame of `width` x `height` as text.
///
/// # Errors
/// A sentence if there can be no such frame.
pub fn as_text(player: &Player, width: u16, height: u16) -> Result<String, String> {
    let failed = |error| format!("no frame of {width}x{height} can be drawn: {error}");
    let mut terminal = Terminal::new(TestBackend::new(width, height)).map_err(|error| failed(format!("{error:?}")))?;
    let drawn = terminal.draw(|frame| draw(player, frame)).map_err(|error| failed(format!("{error:?}")))?;
    let mut text = String::new();
    for y in 0..height {
        let row: String = (0..width).filter_map(|x| drawn.buffer.cell((x, y))).map(|cell| cell.symbol()).collect();
        text += row.trim_end();
        text.push('\n');
    }
    Ok(text)
}

fn header(player: &Player, frame: &mut Frame, area: Rect) {
    let [title, verdict, standing] = Layout::vertical([Constraint::Length(1); 3]).areas(area);
    both_ends(frame, title, Line::from(player.subject().title.clone()), clock(player));
    let (style, words) = verdict::verdict(player);
    frame.render_widget(Paragraph::new(format!(" {words}")).style(style), verdict);
    frame.render_widget(Paragraph::new(verdict::standing(player)), standing);
}

/// Two texts in one line; the left one is cut where there is no room for both.
fn both_ends(frame: &mut Frame, area: Rect, left: Line, right: String) {
    let width = u16::try_from(right.chars().count()).unwrap_or(area.width).min(area.width);
    let [start, end] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(width)]).spacing(1).areas(area);
    frame.render_widget(left, start);
    frame.render_widget(Span::raw(right), end);
}

fn clock(player: &Player) -> String {
    let now = player.shown().map_or(0.0, |bin| bin.t_s);
    let of = player.subject().end_s.map_or_else(String::new, |end_s| format!(" of {end_s:.0} s"));
    format!("{now:.2} s{of}, {}", player.state())
}

fn too_small(player: &Player, frame: &mut Frame, area: Rect) {
    let (style, words) = verdict::verdict(player);
    let sentence = format!(
        "The window is {}x{} and the view needs {}x{}: enlarge it, or make its font smaller. q quits.",
        area.width, area.height, LEAST.0, LEAST.1
    );
    let lines = vec![Line::raw(clock(player)), Line::styled(words, style), Line::raw(sentence)];
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), area);
}

#[cfg(test)]
mod tests;
