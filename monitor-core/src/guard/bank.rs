//! What is known of each set point, and what its neighbours make expect of one that is not known.

use super::known::Known;
use crate::moments::LearnError;
use crate::sample::Channel;
use crate::set_point::SetPointGate;

/// Set points that are kept.
const BANK: usize = 4;

/// How far a mean may lie from the chord between its neighbours': a share of the chord's rise, and sigmas of single readings.
const BEND: f32 = 0.25;
const REACH_SIGMAS: f32 = 8.0;

/// Models of set points that were learned.
#[derive(Clone, Debug, Default)]
pub(super) struct Bank {
    entries: [Option<(f32, Known)>; BANK],
    next: u8,
}

impl Bank {
    /// The place of the model that was learned nearest to a set point, within the tolerance.
    fn place(&self, gate: &SetPointGate, set_point: f32) -> Option<usize> {
        let far = |place: usize| self.entries.get(place).copied().flatten().map(|(at, _)| (at - set_point).abs());
        let holds = |place: &usize| far(*place).is_some_and(|far| gate.tolerates(far));
        (0..BANK).filter(holds).min_by(|a, b| far(*a).unwrap_or(f32::MAX).total_cmp(&far(*b).unwrap_or(f32::MAX)))
    }

    pub(super) fn recall(&self, gate: &SetPointGate, set_point: f32) -> Option<&Known> {
        let entry = self.entries.get(self.place(gate, set_point)?)?;
        entry.as_ref().map(|(_, known)| known)
    }

    /// Keeps what is known of a set point; of another one when there is no room, the one that was first kept goes.
    pub(super) fn keep(&mut self, gate: &SetPointGate, set_point: f32, known: &Known) {
        if let Some(Some((_, kept))) = self.place(gate, set_point).and_then(|place| self.entries.get_mut(place)) {
            *kept = *known;
            return;
        }
        if let Some(entry) = self.entries.get_mut(usize::from(self.next)) {
            *entry = Some((set_point, *known));
        }
        self.next = (self.next + 1) % BANK as u8;
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &(f32, Known)> {
        self.entries.iter().flatten()
    }

    /// Compares a mean at an unknown set point with what its neighbours make expect: the chord between theirs.
    ///
    /// What a propeller takes grows with the square of the speed, and of a parabola that begins at rest the chord is off by no
    /// more than a quarter of its rise. Where there are no known set points on both sides, anything may be.
    pub(super) fn expects(&self, set_point: f32, mean: [f32; 3]) -> Result<(), LearnError> {
        let nearest = |side: fn(f32) -> bool| {
            let there = self.iter().filter(move |(at, _)| side(at - set_point));
            there.min_by(|(a, _), (b, _)| (a - set_point).abs().total_cmp(&(b - set_point).abs()))
        };
        let Some(((a, below), (b, above))) = nearest(|d| d < 0.0).zip(nearest(|d| d > 0.0)) else { return Ok(()) };
        let share = (set_point - a) / (b - a);
        let sigmas = below.model.sigma().into_iter().zip(above.model.sigma());
        let ends = below.centre().into_iter().zip(above.centre()).zip(sigmas);
        for (position, (((from, to), (s, t)), mean)) in ends.zip(mean).enumerate() {
            let reach = BEND * (to - from).abs() + REACH_SIGMAS * s.max(t);
            if (mean - (from + share * (to - from))).abs() > reach {
                return Err(LearnError::Unexpected(Channel::at(position)));
            }
        }
        Ok(())
    }
}
