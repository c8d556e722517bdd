//! What the keys do and what the lines mean.

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::text::Line;
use ratatui::widgets::{Block, Clear, Paragraph};

use crate::watch::player::Player;

pub(super) fn draw(player: &Player, frame: &mut Frame, area: Rect) {
    let mut lines: Vec<Line> = [
        "space       pause, go on",
        "+  -        faster, slower",
        "←  →        back and forth by a tenth of what is seen",
        "PgUp PgDn   back and forth by all that is seen",
        "Home End    as far back as it goes; now",
        "[  ]        see less, see more",
        "?           this help      q   quit",
        "",
    ]
    .into_iter()
    .map(Line::raw)
    .collect();
    lines.push(Line::raw(format!("It goes {:.0} s back; the run goes on meanwhile.", player.reach_s())));
    lines.push(Line::raw("Channels: readings, and ╌ the mean they are judged by."));
    lines.push(Line::raw("Distances over their limit, which is ▁ at 1:"));
    let distances = player.subject().distances.iter();
    lines.extend(distances.map(|distance| Line::raw(format!("  {:<6} {}", distance.name, distance.of))));
    lines.push(Line::raw("Judged: of the slots since the first that was."));
    lines.push(Line::raw("━ under the last chart: where an alarm stood."));
    let height = u16::try_from(lines.len()).unwrap_or(u16::MAX).saturating_add(2);
    let box_area = area.centered(Constraint::Length(60), Constraint::Length(height));
    frame.render_widget(Clear, box_area);
    frame.render_widget(Paragraph::new(lines).block(Block::bordered().title(" help ")), box_area);
}
