//! The sampling interrupt's side: judge each slot, drive the fault output, queue what the main loop is to hear of.

use heapless::spsc::{self, Queue};
use monitor_core::Sample;
use monitor_core::moments::LearnError;
use monitor_core::sample::Absence;
use monitor_core::units::RadPerSec;

use crate::deadline::Slot;
use crate::mode::Mode;

/// What a board reads in one slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A sample, in time.
    Taken(Sample),
    /// None, or none of this slot.
    Absent(Absence),
}

/// Places of the queue to the main loop; one stays free. A verdict brings at most nine notes, eight of them news.
const PLACES: usize = 32;

/// The queue to the main loop.
pub type Notes<M> = Queue<NoteOf<M>, PLACES>;
/// Its end in the interrupt.
pub type Producer<'q, M> = spsc::Producer<'q, NoteOf<M>, PLACES>;
/// Its end in the main loop.
pub type Consumer<'q, M> = spsc::Consumer<'q, NoteOf<M>, PLACES>;

/// What the main loop is told of by a monitor in a mode.
pub type NoteOf<M> = Note<<M as Mode>::News, <M as Mode>::Rejected>;

/// What the main loop is told of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note<News, Rejected> {
    /// Something changed between two verdicts.
    News(News),
    /// Slots are turned away from this one on.
    Rejecting {
        /// The first such slot.
        sample: u64,
        /// Why.
        why: Rejected,
    },
    /// A sample was judged again.
    Accepting {
        /// The first such slot.
        sample: u64,
        /// How many slots had been turned away in a row.
        after: u32,
    },
    /// The work of this slot did not end before the next one began.
    Overrun {
        /// The slot.
        sample: u64,
    },
}

/// What has gone wrong since the start. Every count stays at its largest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Slots turned away, for whatever reason.
    pub rejected: u32,
    /// Slots among them that had no sample, or not in time.
    pub absent: u32,
    /// Slots whose work did not end before the next one began.
    pub overruns: u32,
    /// Notes that found the queue full.
    pub dropped: u32,
}

/// What the main loop works on at leisure, copied in a short critical section.
#[derive(Clone, Debug)]
pub struct Snapshot<M> {
    /// The monitor behind its last verdict.
    pub mode: M,
    /// What has gone wrong.
    pub counts: Counts,
}

/// The moving part of the sampling interrupt.
pub struct Sampling<'q, M: Mode> {
    mode: M,
    notes: Producer<'q, M>,
    counts: Counts,
    /// Slots turned away in a row, and why the last of them was.
    run: (u32, Option<M::Rejected>),
}

impl<'q, M: Mode> Sampling<'q, M> {
    /// A monitor, and the queue to the main loop.
    #[must_use]
    pub fn new(mode: M, notes: Producer<'q, M>) -> Self {
        Sampling { mode, notes, counts: Counts::default(), run: (0, None) }
    }

    /// One sampling interrupt: lets lost slots go by, reads unless it is too late for that, judges, and drives the fault
    /// output (`true` while something is wrong).
    ///
    /// Slots that were lost are caught up with here; one costs far less than a slot lasts, so this ends.
    #[inline]
    pub fn on_interrupt(
        &mut self,
        slot: Slot,
        set_point: RadPerSec,
        read: impl FnOnce() -> Reading,
        drive_fault_output: impl FnOnce(bool),
    ) -> &M::Verdict {
        for _ in 0..slot.lost {
            self.judge(set_point, Reading::Absent(Absence::Missing));
        }
        let reading = if slot.late { Reading::Absent(Absence::Late) } else { read() };
        self.judge(set_point, reading);
        drive_fault_output(self.mode.alarm());
        self.mode.verdict()
    }

    /// Judges one slot, and queues what changed. Called from two places, and to be in flash once.
    #[inline(never)]
    fn judge(&mut self, set_point: RadPerSec, reading: Reading) {
        let Sampling { mode, notes, counts, run } = self;
        counts.absent = counts.absent.saturating_add(u32::from(matches!(reading, Reading::Absent(_))));
        let rejected = mode.step(set_point, reading, |news| push::<M>(notes, counts, Note::News(news)));
        if let Some(note) = rejection(run, counts, mode.slot(), rejected) {
            push::<M>(notes, counts, note);
        }
    }

    /// To be called at the end of an interrupt that found the next slot begun
    /// ([`Deadline::overrun`](crate::deadline::Deadline::overrun)).
    pub fn overran(&mut self) {
        self.counts.overruns = self.counts.overruns.saturating_add(1);
        push::<M>(&mut self.notes, &mut self.counts, Note::Overrun { sample: self.mode.slot() });
    }

    /// The monitor.
    #[must_use]
    pub const fn mode(&self) -> &M {
        &self.mode
    }

    /// What the main loop may ask for, by copy. Asked for in several places, and to be in flash once.
    #[must_use]
    #[inline(never)]
    pub fn snapshot(&self) -> Snapshot<M> {
        Snapshot { mode: self.mode.clone(), counts: self.counts }
    }

    /// Slots so far: the count moves while the interrupt is alive.
    #[must_use]
    pub fn slots(&self) -> u64 {
        self.mode.slot().wrapping_add(1)
    }

    /// Hands in what was made of the learning window; returns whether it was still wanted.
    pub fn install(&mut self, learned: Result<M::Model, LearnError>) -> bool {
        let Sampling { mode, notes, counts, .. } = self;
        mode.install(learned, |news| push::<M>(notes, counts, Note::News(news)))
    }

    /// Takes the motor for healthy as it runs now.
    pub fn acknowledge(&mut self) {
        self.mode.acknowledge();
    }
}

/// Tells once that slots are turned away, again when the reason changes, and when that is over. `run` counts them in a row,
/// and holds the last reason.
fn rejection<News, Rejected: Copy + PartialEq>(
    run: &mut (u32, Option<Rejected>),
    counts: &mut Counts,
    sample: u64,
    now: Option<Rejected>,
) -> Option<Note<News, Rejected>> {
    let (length, before) = *run;
    *run = (if now.is_some() { length.saturating_add(1) } else { 0 }, now);
    counts.rejected = counts.rejected.saturating_add(u32::from(now.is_some()));
    match now {
        _ if before == now => None,
        Some(why) => Some(Note::Rejecting { sample, why }),
        None => Some(Note::Accepting { sample, after: length }),
    }
}

#[inline(never)]
fn push<M: Mode>(notes: &mut Producer<'_, M>, counts: &mut Counts, note: NoteOf<M>) {
    if notes.enqueue(note).is_err() {
        counts.dropped = counts.dropped.saturating_add(1);
    }
}
