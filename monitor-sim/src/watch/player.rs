//! Moves a run on at its pace, and lets its viewer stop it and go back.

use std::time::{Duration, Instant};

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::chronicle::{Chronicle, Event};
use super::feed::{Feed, Subject, WatchError};
use super::history::{Bin, History};
use super::pace::Pace;

/// What can be seen at once, s; slow logs, in which it would hold too few slots, show so many times as much.
const SPANS_S: [f64; 8] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 60.0, 120.0];
const USUAL_SPAN: usize = 5;

/// Fewest slots of the usual span.
const LEAST_SLOTS: f64 = 200.0;

/// Slots between two looks at the clock: some tens of microseconds.
const SLOTS_PER_LOOK: u32 = 32;

/// How far a run that is shown may fall behind its pace before it is let off, s of real time.
const MOST_BEHIND_S: f64 = 0.25;

/// A run that is shown.
#[derive(Debug)]
pub struct Player {
    feed: Feed,
    history: History,
    chronicle: Chronicle,
    pace: Pace,
    paused: bool,
    ended: bool,
    help: bool,
    /// The bin at the right edge, while the viewer looks back.
    back_at: Option<u64>,
    span: usize,
    /// Real time that is still to be shown, s.
    owed_s: f64,
}

impl Player {
    /// A run before its first slot.
    #[must_use]
    pub fn new(feed: Feed, pace: Pace) -> Self {
        Player {
            history: History::new(feed.subject().rate_hz),
            feed,
            chronicle: Chronicle::default(),
            pace,
            paused: false,
            ended: false,
            help: false,
            back_at: None,
            span: USUAL_SPAN,
            owed_s: 0.0,
        }
    }

    /// Shows what a stretch of real time has brought, for as long as `budget` at most, so that keys are answered.
    ///
    /// # Errors
    /// [`WatchError`] when the run cannot go on.
    pub fn advance(&mut self, real_time: Duration, budget: Duration) -> Result<(), WatchError> {
        if self.paused || self.ended {
            self.owed_s = 0.0;
            return Ok(());
        }
        let slot_s = match self.pace {
            Pace::Times(times) => 1.0 / (times * self.feed.subject().rate_hz),
            Pace::Max => 0.0,
        };
        self.owed_s += real_time.as_secs_f64();
        let begun = Instant::now();
        let mut slots = 0_u32;
        while self.owed_s >= slot_s && !self.ended {
            self.owed_s -= slot_s;
            self.step()?;
            slots += 1;
            if slots.is_multiple_of(SLOTS_PER_LOOK) && begun.elapsed() >= budget {
                break;
            }
        }
        self.owed_s = self.owed_s.min(slot_s + MOST_BEHIND_S);
        Ok(())
    }

    /// Goes on to the slot at `t_s`, as fast as it can. Returns whether the run is as long as that.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn advance_to(&mut self, t_s: f64) -> Result<bool, WatchError> {
        // A slot this close to the instant is the one that is meant; a slot's time is rounded.
        let near_s = 1e-6 / self.feed.subject().rate_hz;
        while self.latest().is_none_or(|bin| bin.t_s < t_s - near_s) {
            if self.ended {
                return Ok(false);
            }
            self.step()?;
        }
        Ok(true)
    }

    fn step(&mut self) -> Result<(), WatchError> {
        match self.feed.next_slot()? {
            Some(slot) => {
                let tally = self.chronicle.take(&slot, self.feed.subject());
                self.history.push(&slot, tally);
            }
            None => self.ended = true,
        }
        Ok(())
    }

    /// Answers a key. Returns whether the viewer stays.
    pub fn press(&mut self, key: KeyEvent) -> bool {
        if key.kind == KeyEventKind::Release {
            return true;
        }
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        let page = i64::try_from(self.bins_shown()).unwrap_or(i64::MAX);
        match key.code {
            KeyCode::Esc if self.help => self.help = false,
            KeyCode::Char('q') | KeyCode::Esc => return false,
            KeyCode::Char('c') if control => return false,
            KeyCode::Char('?' | 'h') => self.help = !self.help,
            KeyCode::Char(' ') => self.paused = !self.paused,
            KeyCode::Char('+' | '=') => self.pace = self.pace.faster(),
            KeyCode::Char('-' | '_') => self.pace = self.pace.slower(),
            KeyCode::Char('[') => self.span = self.span.saturating_sub(1),
            KeyCode::Char(']') => self.span = (self.span + 1).min(SPANS_S.len() - 1),
            KeyCode::Left => self.scroll(-(page / 10).max(1)),
            KeyCode::Right => self.scroll((page / 10).max(1)),
            KeyCode::PageUp => self.scroll(-page),
            KeyCode::PageDown => self.scroll(page),
            KeyCode::Home => self.scroll(i64::MIN),
            KeyCode::End => self.back_at = None,
            _ => {}
        }
        true
    }

    /// Moves the right edge by some bins; at the latest bin it follows the run again.
    fn scroll(&mut self, bins: i64) {
        let Some((first, last)) = self.history.ends() else { return };
        let at = self.edge().unwrap_or(last).saturating_add_signed(bins).max(first);
        self.back_at = (at < last).then_some(at);
    }

    /// The bin at the right edge; none before the first slot.
    fn edge(&self) -> Option<u64> {
        let (first, last) = self.history.ends()?;
        Some(self.back_at.map_or(last, |at| at.clamp(first, last)))
    }

    fn latest(&self) -> Option<&Bin> {
        self.history.get(self.history.ends()?.1)
    }

    /// The bin that the words are about.
    #[must_use]
    pub fn shown(&self) -> Option<&Bin> {
        self.history.get(self.edge()?)
    }

    /// How many bins are seen at once.
    #[must_use]
    pub fn bins_shown(&self) -> u64 {
        ((self.span_s() / self.history.bin_s()).round() as u64).max(2)
    }

    /// What is seen at once, s.
    #[must_use]
    pub fn span_s(&self) -> f64 {
        let usual = SPANS_S.get(USUAL_SPAN).copied().unwrap_or(1.0);
        let stretch = (LEAST_SLOTS / self.feed.subject().rate_hz / usual).max(1.0);
        SPANS_S.get(self.span).copied().unwrap_or(usual) * stretch
    }

    /// The bins that are seen, each with its place from the left, 0 to [`bins_shown`](Self::bins_shown) - 1.
    pub fn seen(&self) -> impl Iterator<Item = (u64, &Bin)> {
        let edge = self.edge().unwrap_or(0);
        // Where the left edge lies before the run, the run begins inside the picture.
        let shift = self.bins_shown().saturating_sub(1);
        let bins = self.history.bins(edge.saturating_sub(shift)..=edge);
        bins.map(move |(number, bin)| (number + shift - edge, bin))
    }

    /// What has happened up to what is seen, the latest first.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        self.chronicle.up_to(self.shown().map_or(0.0, |bin| bin.t_s))
    }

    /// What is looked at.
    #[must_use]
    pub const fn subject(&self) -> &Subject {
        self.feed.subject()
    }

    /// How far back one can go, s.
    #[must_use]
    pub fn reach_s(&self) -> f64 {
        self.history.reach_s()
    }

    /// Whether the help is shown.
    #[must_use]
    pub const fn helps(&self) -> bool {
        self.help
    }

    /// How the run is shown, in words.
    #[must_use]
    pub fn state(&self) -> String {
        let state = match (self.ended, self.paused) {
            (true, _) => "ended".to_owned(),
            (false, true) => format!("{}, paused", self.pace),
            (false, false) => self.pace.to_string(),
        };
        match (self.back_at, self.latest()) {
            (Some(_), Some(latest)) => format!("looking back from {:.2} s, {state}", latest.t_s),
            _ => state,
        }
    }
}

#[cfg(test)]
pub(in crate::watch) mod tests;
