//! What is known of each set point, and what its neighbours make expect of one that is not known.

use super::design::Design;
use super::known::Known;
use crate::moments::LearnError;
use crate::sample::Channel;
use crate::set_point::SetPointGate;

/// Set points that are kept.
const BANK: usize = 4;

/// How far a mean may lie from the chord between its neighbours': a share of the chord's rise, and sigmas of single readings.
const BEND: f32 = 0.25;
const REACH_SIGMAS: f32 = 8.0;

/// Models of set points.
#[derive(Clone, Debug)]
pub(super) struct Bank {
    /// Set points, and what is known of them: nothing, where a place is free.
    entries: [(f32, Known); BANK],
    next: u8,
}

impl Bank {
    // All zeros: no board has to keep it in flash.
    pub(super) const EMPTY: Self = Bank { entries: [(0.0, Known::BLANK); BANK], next: 0 };

    /// The place of the model that is known nearest to a set point, within the tolerance.
    fn place(&self, gate: &SetPointGate, set_point: f32) -> Option<usize> {
        let taken = self.entries.iter().enumerate().filter(|(_, (_, known))| !known.is_blank());
        let far = taken.map(|(place, (at, _))| (place, (at - set_point).abs()));
        let near = far.filter(|(_, far)| gate.tolerates(*far)).min_by(|(_, a), (_, b)| a.total_cmp(b));
        near.map(|(place, _)| place)
    }

    pub(super) fn recall(&self, gate: &SetPointGate, set_point: f32) -> Option<&Known> {
        self.entries.get(self.place(gate, set_point)?).map(|(_, known)| known)
    }

    /// Keeps what is known of a set point. When there is no room for another one, what neighbours have lent can be had again, so it is
    /// not kept, or goes; else the one that was first kept goes.
    pub(super) fn keep(&mut self, design: &Design, set_point: f32, known: &Known) {
        let same = self.place(&design.gate, set_point);
        let free = || self.entries.iter().position(|(_, known)| known.is_blank());
        let lent = || self.entries.iter().position(|(_, known)| !known.is_own(design));
        let place = match same.or_else(free) {
            Some(place) => place,
            None if !known.is_own(design) => return,
            None => lent().unwrap_or_else(|| {
                let first = usize::from(self.next);
                self.next = (self.next + 1) % BANK as u8;
                first
            }),
        };
        if let Some((at, kept)) = self.entries.get_mut(place) {
            *at = if same.is_some() { *at } else { set_point };
            *kept = *known;
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &(f32, Known)> {
        self.entries.iter().filter(|(_, known)| !known.is_blank())
    }

    /// The nearest known set points on both sides of one that is not.
    pub(super) fn neighbours(&self, set_point: f32) -> Option<[&(f32, Known); 2]> {
        let nearest = |side: fn(f32) -> bool| {
            let there = self.iter().filter(move |(at, _)| side(at - set_point));
            there.min_by(|(a, _), (b, _)| (a - set_point).abs().total_cmp(&(b - set_point).abs()))
        };
        Some([nearest(|d| d < 0.0)?, nearest(|d| d > 0.0)?])
    }
}

/// Compares a mean at a set point between two known ones with what those make expect: the chord between theirs.
///
/// What a propeller takes grows with the square of the speed, and of a parabola that begins at rest the chord is off by no
/// more than a quarter of its rise.
pub(super) fn expected(
    [(a, below), (b, above)]: [&(f32, Known); 2],
    set_point: f32,
    mean: [f32; 3],
) -> Result<(), LearnError> {
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
