use ratatui::crossterm::event::{KeyCode, KeyEvent};

use super::as_text;
use crate::watch::feed::Feed;
use crate::watch::pace::Pace;
use crate::watch::player::Player;
use crate::watch::player::tests::short;

fn at(t_s: f64) -> Player {
    let mut player = short();
    assert!(player.advance_to(t_s).unwrap());
    player
}

/// The dots of the rows of a text between two columns.
fn dots(row: &str) -> u32 {
    row.chars().filter_map(|c| u32::from(c).checked_sub(0x2800).filter(|bits| *bits < 256)).map(u32::count_ones).sum()
}

#[test]
fn each_phase_has_its_verdict_and_a_fault_its_name_size_and_time() {
    for (t_s, verdict) in [
        (0.0, "not judged: the loop is given time to settle"),
        (5.0, "not judged: learning what healthy means"),
        (14.0, "healthy"),
        (24.9, "ALARM  F3 current sensor 0.4998 ± 0.0058 A"),
    ] {
        let text = as_text(&at(t_s), 80, 24).unwrap();
        let line = text.lines().nth(1).unwrap();
        assert!(line.trim_start().starts_with(verdict), "{t_s}\n{text}");
    }
    let text = as_text(&at(24.9), 80, 24).unwrap();
    for part in [" A, since 15.00", "± 0.0", "24.90 s of 30 s, x1", "100.0 % judged", "1 alarm ", "alarm raised", "━"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn every_chart_shows_its_readings_and_the_mean_and_limit_they_are_held_against() {
    for (width, height) in [(80, 24), (160, 48)] {
        let text = as_text(&at(20.0), width, height).unwrap();
        assert_eq!(text.lines().count(), usize::from(height));
        assert!(text.lines().all(|line| line.chars().count() <= usize::from(width)));
        let rows: Vec<_> = text.lines().collect();
        let starts: Vec<_> = [" speed, rad/s", " current, A", " voltage, V", " T²/limit"]
            .into_iter()
            .map(|title| rows.iter().position(|row| row.starts_with(title)).ok_or(title).unwrap())
            .collect();
        for (start, end) in starts.iter().zip(starts.iter().skip(1).chain([&(rows.len() - 2)])) {
            let seen: u32 = rows[*start..*end].iter().map(|row| dots(row)).sum();
            assert!(seen > u32::from(width) / 2, "{seen} dots\n{text}");
        }
        assert!(text.contains("╌╌") && text.contains("limit 1 ▁▁▁") && text.contains("mean 300.0"), "{text}");
    }
}

#[test]
fn readings_that_do_not_come_leave_a_gap_in_the_chart_and_are_told() {
    let silent = r#"
        name = "silent"
        duration_s = 30.0
        start = "steady"
        learn = { start_s = 2.0, end_s = 12.0 }
        [[fault]]
        id = "gap"
        name = "no samples"
        point = "sampling"
        kind = "missing"
        profile = "step"
        amplitude = 1.0
        start_s = 18.0
        end_s = 24.0
    "#;
    let scenario = crate::scenario::Scenario::from_toml(silent).unwrap();
    let mut player =
        Player::new(Feed::mission(&scenario, &crate::guardian::Alarming::default(), 1, None).unwrap(), Pace::Max);
    assert!(player.advance_to(22.0).unwrap());
    let text = as_text(&player, 80, 24).unwrap();
    assert!(text.contains("ALARM  sensor loss") && text.contains("speed, rad/s  no reading"), "{text}");
    assert!(player.advance_to(29.0).unwrap());
    let text = as_text(&player, 80, 24).unwrap();
    // From 9 s to 29 s in 42 columns behind the numbers: 18 s is column 19 of them, 24 s column 31.
    let columns = |skip: usize, take: usize| {
        let rows = text.lines().skip(4).take(4);
        rows.map(|row| dots(&row.chars().skip(9 + skip).take(take).collect::<String>())).sum::<u32>()
    };
    assert!(columns(20, 10) == 0 && columns(8, 10) > 10 && columns(32, 10) > 10, "{text}");
}

#[test]
fn a_window_that_is_too_small_keeps_the_verdict_and_says_what_helps() {
    let player = at(20.0);
    for (width, height) in [(79, 24), (80, 23), (40, 10)] {
        let text = as_text(&player, width, height).unwrap();
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("ALARM F3 current sensor") && words.contains("enlarge it"), "{text}");
    }
    // Whatever has no room is left out.
    for (width, height) in [(1, 1), (3, 24), (80, 1), (500, 24), (80, 300)] {
        assert!(as_text(&player, width, height).is_ok());
    }
}

#[test]
fn the_help_lies_over_the_charts_and_explains_each_distance() {
    let mut player = at(1.0);
    player.press(KeyEvent::from(KeyCode::Char('?')));
    let text = as_text(&player, 80, 24).unwrap();
    for part in [" help ", "pause, go on", "fast   over some", "It goes 164 s back"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}
