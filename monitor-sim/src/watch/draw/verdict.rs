//! The verdict on what is shown, in a line, and how the monitor stands, in another.

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};

use super::DIM;
use crate::tables::significant;
use crate::watch::chronicle::how;
use crate::watch::history::Bin;
use crate::watch::player::Player;
use crate::watch::slot::Phase;

const ALARM: Style = Style::new().fg(Color::White).bg(Color::Red).add_modifier(Modifier::BOLD);
const HEALTHY: Style = Style::new().fg(Color::Black).bg(Color::Green);
const UNJUDGED: Style = Style::new().fg(Color::Black).bg(Color::Yellow);

/// Whether something is wrong, what, how large it is, and since when.
pub(super) fn verdict(player: &Player) -> (Style, String) {
    let Some(bin) = player.shown() else { return (UNJUDGED, "nothing has been read yet".to_owned()) };
    let says = &bin.says;
    if says.alarm {
        return (ALARM, format!("ALARM  {}{}", what(player, bin), since(bin)));
    }
    match says.phase {
        Phase::Waiting => (UNJUDGED, "not judged: the learning window has not begun".to_owned()),
        Phase::Settling => (UNJUDGED, "not judged: the loop is given time to settle".to_owned()),
        Phase::Learning => (UNJUDGED, "not judged: learning what healthy means".to_owned()),
        Phase::Withheld => {
            (UNJUDGED, "not judged: an unknown set point, reached while a fault was suspected".to_owned())
        }
        Phase::Monitoring if !says.judged => (UNJUDGED, "not judged: no sample in this slot".to_owned()),
        Phase::Monitoring if says.recovering => (HEALTHY, "no alarm; the loop recovers".to_owned()),
        Phase::Monitoring => (HEALTHY, "healthy".to_owned()),
    }
}

/// The name and the size of what is wrong.
fn what(player: &Player, bin: &Bin) -> String {
    let names = player.subject().names.0.iter().zip(bin.says.lost);
    let lost: Vec<_> = names.filter_map(|(name, lost)| lost.map(|loss| format!("{name} {}", how(loss)))).collect();
    let lost = if lost.is_empty() { String::new() } else { format!(" ({})", lost.join(", ")) };
    let name = bin.says.name.map_or_else(|| "no name yet".to_owned(), |name| name.shown());
    let size =
        bin.says.size.map_or_else(String::new, |size| format!(" {} {}", with_sigma(size.value, size.sigma), size.unit));
    format!("{name}{size}{lost}")
}

fn since(bin: &Bin) -> String {
    let since = bin.tally.since_s;
    since.map_or_else(String::new, |since_s| format!(", since {since_s:.3} s ({:.2} s)", bin.t_s - since_s))
}

/// A value to the second digit of its sigma.
fn with_sigma(value: f64, sigma: f64) -> String {
    if !(sigma > 0.0 && sigma.is_finite()) {
        return significant(value);
    }
    let decimals = (1.0 - sigma.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$} ± {sigma:.decimals$}")
}

/// Phase, set point, and what is counted.
pub(super) fn standing(player: &Player) -> Line<'static> {
    let Some(bin) = player.shown() else { return Line::default() };
    let mut parts = vec![bin.says.phase.words().to_owned()];
    if bin.set_point.is_finite() {
        parts.push(
            format!("set point {} {}", significant(bin.set_point), player.subject().units[0]).trim_end().to_owned(),
        );
    }
    if let Some(share) = bin.tally.covered() {
        parts.push(format!("{:.1} % judged", 100.0 * share));
    }
    parts.push(match bin.tally.alarms {
        1 => "1 alarm".to_owned(),
        alarms => format!("{alarms} alarms"),
    });
    parts.push(format!("{} s seen", significant(player.span_s())));
    let separator = || Span::styled(" · ", DIM);
    let mut spans = Vec::new();
    for part in parts {
        spans.push(if spans.is_empty() { Span::raw(" ") } else { separator() });
        spans.push(Span::raw(part));
    }
    Line::from(spans)
}

#[cfg(test)]
mod tests {
    use super::with_sigma;

    #[test]
    fn a_size_has_the_digits_that_its_sigma_leaves() {
        for (value, sigma, shown) in [
            (0.029_897_3, 0.000_123_4, "0.02990 ± 0.00012"),
            (8.0123, 0.0456, "8.012 ± 0.046"),
            (1234.6, 56.7, "1235 ± 57"),
            (0.5, 0.0, "0.5000"),
            (0.5, f64::NAN, "0.5000"),
        ] {
            assert_eq!(with_sigma(value, sigma), shown);
        }
    }
}
