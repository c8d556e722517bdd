use super::*;
use crate::scenario::Scenario;
use crate::watch::chronicle::{Kind, Tally};
use crate::watch::slot::{Says, Slot};

/// 30 s at 1 kHz: learning from 2 s to 12 s, the current sensor off by 0.5 A from 15 s to 25 s.
const SHORT: &str = r#"
name = "short"
duration_s = 30.0
start = "steady"
learn = { start_s = 2.0, end_s = 12.0 }
[[fault]]
id = "F3"
name = "armature current sensor"
point = "current_sensor"
kind = "offset"
profile = "step"
amplitude = 0.5
start_s = 15.0
end_s = 25.0
"#;

const LONG: Duration = Duration::from_secs(60);

pub(in crate::watch) fn short() -> Player {
    let scenario = Scenario::from_toml(SHORT).unwrap();
    Player::new(Feed::mission(&scenario, &crate::guardian::Alarming::default(), 1, None).unwrap(), Pace::Times(1.0))
}

fn press(player: &mut Player, keys: &[KeyCode]) {
    for key in keys {
        assert!(player.press(KeyEvent::from(*key)), "{key:?}");
    }
}

fn now(player: &Player) -> f64 {
    player.shown().unwrap().t_s
}

#[test]
fn a_run_keeps_its_pace_and_a_pause_costs_nothing_afterwards() {
    let mut player = short();
    let tenths = |player: &mut Player, count: usize| {
        for _ in 0..count {
            player.advance(Duration::from_millis(100), LONG).unwrap();
        }
    };
    tenths(&mut player, 10);
    assert!((now(&player) - 1.0).abs() < 0.005, "{}", now(&player));
    press(&mut player, &[KeyCode::Char(' ')]);
    tenths(&mut player, 50);
    press(&mut player, &[KeyCode::Char(' '), KeyCode::Char('+'), KeyCode::Char('+')]);
    tenths(&mut player, 10);
    assert!((now(&player) - 6.0).abs() < 0.01, "one second, and five in the next: {}", now(&player));
    press(&mut player, &[KeyCode::Char('-')]);
    assert_eq!(player.state(), "x2");
}

#[test]
fn what_cannot_be_kept_up_with_is_let_off_and_the_viewer_is_not_kept_waiting() {
    let mut player = short();
    for key in ["+"; 30] {
        press(&mut player, &[KeyCode::Char(key.chars().next().unwrap())]);
    }
    assert_eq!(player.state(), "max");
    let begun = Instant::now();
    player.advance(LONG, Duration::from_millis(5)).unwrap();
    assert!(now(&player) < 29.0 && begun.elapsed() < Duration::from_secs(2), "{} {:?}", now(&player), begun.elapsed());
    assert!(player.owed_s <= MOST_BEHIND_S);
    assert!(player.advance_to(29.999).unwrap() && !player.advance_to(30.0).unwrap());
    assert_eq!(player.state(), "ended");
}

#[test]
fn going_back_shows_what_was_said_then_while_the_run_goes_on() {
    let mut player = short();
    assert!(player.advance_to(20.0).unwrap());
    assert!(player.shown().unwrap().says.alarm);
    press(&mut player, &[KeyCode::Char('['), KeyCode::PageUp]);
    let back = player.shown().unwrap();
    assert!((back.t_s - 10.0).abs() < 0.02 && !back.says.alarm, "{back:?}");
    assert!(player.events().all(|event| event.t_s <= 10.01 && event.kind != Kind::Wrong));
    assert!(player.advance_to(21.0).unwrap());
    assert!((now(&player) - 10.0).abs() < 0.02 && player.state().starts_with("looking back from 21.00 s"));
    press(&mut player, &[KeyCode::Right]);
    assert!((now(&player) - 11.0).abs() < 0.02);
    press(&mut player, &[KeyCode::Home]);
    assert!(now(&player) < 0.02);
    press(&mut player, &[KeyCode::End]);
    assert!((now(&player) - 21.0).abs() < 0.02);
}

#[test]
fn events_tell_what_was_injected_found_and_withdrawn_in_order() {
    let mut player = short();
    assert!(player.advance_to(29.0).unwrap());
    let events: Vec<_> = player.events().map(|event| event.text.as_str()).collect();
    let after = |earlier: &str, later: &str| {
        let at = |text: &str| events.iter().position(|event| event.starts_with(text)).ok_or_else(|| text.to_owned());
        at(later).unwrap() < at(earlier).unwrap()
    };
    for (earlier, later) in [
        ("settling", "learning"),
        ("learning", "monitoring"),
        ("monitoring", "F3 begins"),
        ("F3 begins", "alarm raised"),
        ("alarm raised", "named F3 current sensor"),
        ("named F3 current sensor", "F3 ends"),
        ("F3 ends", "alarm withdrawn after 10."),
    ] {
        assert!(after(earlier, later), "{earlier}, {later}: {events:?}");
    }
    assert_eq!(player.shown().unwrap().tally.alarms, 1);
    // All but single readings that are far off, where the fault begins and ends.
    assert!(player.shown().unwrap().tally.covered().is_some_and(|share| share > 0.999));
}

#[test]
fn memory_does_not_grow_with_the_run() {
    let mut history = History::new(10.0);
    for k in 0..20_000 {
        let slot = Slot { t_s: f64::from(k) / 10.0, set_point: 0.0, x: [f64::from(k); 3], says: Says::NOTHING };
        history.push(&slot, Tally::default());
    }
    assert_eq!(history.ends(), Some((3616, 19_999)), "16,384 bins of a slot each");
    assert_eq!(history.get(3616).map(|bin| bin.reading(0)), Some(3616.0));
    assert!(history.get(3615).is_none() && history.get(20_000).is_none());
    let seen: Vec<_> = history.bins(3000..=3618).map(|(number, bin)| (number, bin.least[0])).collect();
    assert_eq!(seen, [(3616, 3616.0), (3617, 3617.0), (3618, 3618.0)]);
}

#[test]
fn the_viewer_leaves_by_q_escape_or_control_c_and_escape_closes_the_help_first() {
    let mut player = short();
    press(&mut player, &[KeyCode::Char('?'), KeyCode::Esc, KeyCode::Char('x')]);
    assert!(!player.helps());
    for key in [KeyCode::Char('q'), KeyCode::Esc] {
        assert!(!player.press(KeyEvent::from(key)));
    }
    assert!(!player.press(KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)));
    let mut released = KeyEvent::from(KeyCode::Char('q'));
    released.kind = KeyEventKind::Release;
    assert!(player.press(released));
}
