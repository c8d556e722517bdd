//! What has happened, the latest below.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Paragraph};

use super::DIM;
use crate::watch::chronicle::{Event, Kind};
use crate::watch::player::Player;

/// Width of an event's time.
const TIME: usize = 8;

pub(super) fn draw(player: &Player, frame: &mut Frame, area: Rect) {
    let block = Block::new().borders(Borders::LEFT).border_style(DIM);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let [title, list] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(inner);
    frame.render_widget(Span::styled(" events, the latest below", DIM), title);
    let (width, height) = (usize::from(list.width), usize::from(list.height));
    let mut lines: Vec<Line> = Vec::new();
    for event in player.events() {
        // Wrapped lines are gathered from below.
        lines.extend(shown(event, width).into_iter().rev());
        if lines.len() >= height {
            break;
        }
    }
    lines.truncate(height);
    lines.reverse();
    frame.render_widget(Paragraph::new(lines), list);
}

/// An event in as many lines as it takes.
fn shown(event: &Event, width: usize) -> Vec<Line<'static>> {
    let style = match event.kind {
        Kind::Plain => Style::new(),
        Kind::Wrong => Style::new().fg(Color::Red),
        Kind::Right => Style::new().fg(Color::Green),
        Kind::Injected => DIM,
    };
    let rows = wrapped(&event.text, width.saturating_sub(TIME + 1));
    let row = |(position, row): (usize, String)| {
        let time = if position == 0 { format!("{:>TIME$.3}", event.t_s) } else { " ".repeat(TIME) };
        Line::from(vec![Span::styled(time, DIM), Span::styled(format!(" {row}"), style)])
    };
    rows.into_iter().enumerate().map(row).collect()
}

/// A text in rows of at most `width` characters, broken between words.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut rows: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match rows.last_mut() {
            Some(row) if row.chars().count() + 1 + word.chars().count() <= width => {
                row.push(' ');
                row.push_str(word);
            }
            _ => rows.push(word.to_owned()),
        }
    }
    rows
}
