//! The sampling deadline: which slot of the sampling clock an interrupt belongs to, and whether it came in time.

use core::num::NonZeroU32;

/// What the clock says when the sampling interrupt begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slot {
    /// Slots that went by without an interrupt of their own since the last one.
    pub lost: u32,
    /// The interrupt began too long after its slot: a reading taken now is not one of the slot.
    pub late: bool,
}

/// Slots of equal length on a free-running counter of 32 bits.
///
/// The counter may wrap between two interrupts, but not go round: at 1 MHz that leaves 35 minutes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadline {
    period: NonZeroU32,
    tolerance: u32,
    due: Option<u32>,
}

impl Deadline {
    /// Slots of `period` ticks, begun at the first interrupt, that count as late beyond `tolerance` ticks. A period of
    /// zero is taken as one.
    #[must_use]
    pub const fn new(period: u32, tolerance: u32) -> Self {
        let period = match NonZeroU32::new(period) {
            Some(period) => period,
            None => NonZeroU32::MIN,
        };
        Deadline { period, tolerance, due: None }
    }

    /// To be called as the interrupt begins, with the counter.
    pub fn enter(&mut self, now: u32) -> Slot {
        let due = self.due.unwrap_or(now);
        let behind = self.behind(due, now);
        let lost = behind / self.period;
        let late = behind % self.period > self.tolerance;
        self.due = Some(due.wrapping_add(lost.wrapping_add(1).wrapping_mul(self.period.get())));
        Slot { lost, late }
    }

    /// To be called as the interrupt ends: whether the next slot has begun meanwhile, so that the work of one slot did
    /// not fit into it.
    #[must_use]
    pub fn overrun(&self, now: u32) -> bool {
        self.due.is_some_and(|due| now.wrapping_sub(due) <= i32::MAX as u32)
    }

    /// How many ticks `now` is behind `due`; zero when it is ahead, which jitter of the first interrupt allows.
    const fn behind(self, due: u32, now: u32) -> u32 {
        let behind = now.wrapping_sub(due);
        if behind <= i32::MAX as u32 { behind } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IN_TIME: Slot = Slot { lost: 0, late: false };

    /// A deadline of 1,000 ticks that has seen its first interrupt at `start`.
    fn begun(start: u32) -> Deadline {
        let mut deadline = Deadline::new(1000, 500);
        assert_eq!(deadline.enter(start), IN_TIME);
        deadline
    }

    #[test]
    fn interrupts_in_their_slots_are_in_time_also_where_the_counter_wraps() {
        let start = u32::MAX - 1500;
        let mut deadline = begun(start);
        for (slot, jitter) in [(1, 0), (2, 500), (3, 20), (4, 499)] {
            assert_eq!(deadline.enter(start.wrapping_add(slot * 1000 + jitter)), IN_TIME, "slot {slot}");
        }
    }

    #[test]
    fn an_interrupt_beyond_the_tolerance_is_late_and_the_next_slot_keeps_its_place() {
        let mut deadline = begun(0);
        assert_eq!(deadline.enter(1501), Slot { lost: 0, late: true });
        assert_eq!(deadline.enter(2000), IN_TIME);
    }

    #[test]
    fn slots_without_an_interrupt_are_counted() {
        let mut deadline = begun(0);
        assert_eq!(deadline.enter(4100), Slot { lost: 3, late: false });
        assert_eq!(deadline.enter(7600), Slot { lost: 2, late: true });
        assert_eq!(deadline.enter(8000), IN_TIME);
    }

    #[test]
    fn an_interrupt_that_ends_in_the_next_slot_is_an_overrun() {
        let mut deadline = Deadline::new(1000, 500);
        assert!(!deadline.overrun(5), "nothing has begun");
        deadline.enter(0);
        assert!(!deadline.overrun(999));
        assert!(deadline.overrun(1000));
        assert!(deadline.overrun(2400));
    }

    #[test]
    fn a_first_interrupt_that_was_delayed_does_not_make_the_next_one_lost() {
        let mut deadline = begun(300);
        assert_eq!(deadline.enter(1000), IN_TIME);
        assert_eq!(deadline.enter(2000), IN_TIME);
    }
}
