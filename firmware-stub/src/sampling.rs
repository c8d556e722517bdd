//! The sampling interrupt's side: judge each slot, drive the fault output, queue what the main loop is to hear of.

use heapless::spsc::{self, Queue};
use monitor_core::Sample;
use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::event::{Event, EventKind, Watch};
use monitor_core::paper::verdict::Rejected;
use monitor_core::paper::{Baseline, Monitor, Verdict};
use monitor_core::sample::Absence;
use monitor_core::sample::ModelId;
use monitor_core::units::RadPerSec;

use crate::deadline::Slot;

/// What a board reads in one slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A sample, in time.
    Taken(Sample),
    /// None, or none of this slot.
    Absent(Absence),
}

/// Places of the queue to the main loop; one stays free. A verdict brings at most nine notes, seven of them events.
const PLACES: usize = 32;

/// The queue to the main loop.
pub type Notes = Queue<Note, PLACES>;
/// Its end in the interrupt.
pub type Producer<'q> = spsc::Producer<'q, Note, PLACES>;
/// Its end in the main loop.
pub type Consumer<'q> = spsc::Consumer<'q, Note, PLACES>;

/// What the main loop is told of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note {
    /// Something changed between two verdicts.
    Event {
        /// What, and when.
        event: Event,
        /// The smoothed T2 it is about: of the relay's model, else of the full one; zero when nothing was judged.
        residual: f32,
        /// The sample from which on some relay has been up.
        alarm_since: Option<u64>,
    },
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
#[derive(Clone, Copy, Debug)]
pub struct Snapshot {
    /// The last verdict.
    pub verdict: Verdict,
    /// The last sample that was not turned away; its channels in order.
    pub channels: [f32; 3],
    /// What samples are judged by.
    pub baseline: Option<Baseline>,
    /// What has gone wrong.
    pub counts: Counts,
}

/// The moving part of the sampling interrupt.
pub struct Sampling<'q> {
    monitor: Monitor,
    watch: Watch,
    notes: Producer<'q>,
    counts: Counts,
    /// Slots turned away in a row, and why the last of them was.
    run: (u32, Option<Rejected>),
    channels: [f32; 3],
}

impl<'q> Sampling<'q> {
    /// A monitor, and the queue to the main loop.
    #[must_use]
    pub fn new(monitor: Monitor, notes: Producer<'q>) -> Self {
        Sampling {
            monitor,
            watch: Watch::default(),
            notes,
            counts: Counts::default(),
            run: (0, None),
            channels: [0.0; 3],
        }
    }

    /// One sampling interrupt: lets lost slots go by, reads unless it is too late for that, judges, and drives the fault
    /// output (`true` while any relay is up).
    ///
    /// Slots that were lost are caught up with here; one costs far less than a slot lasts, so this ends.
    #[inline]
    pub fn on_interrupt(
        &mut self,
        slot: Slot,
        set_point: RadPerSec,
        read: impl FnOnce() -> Reading,
        drive_fault_output: impl FnOnce(bool),
    ) -> &Verdict {
        for _ in 0..slot.lost {
            self.judge(set_point, Reading::Absent(Absence::Missing));
        }
        let reading = if slot.late { Reading::Absent(Absence::Late) } else { read() };
        self.judge(set_point, reading);
        let verdict = self.monitor.verdict();
        drive_fault_output(verdict.alarm());
        verdict
    }

    /// Judges one slot, and queues what changed. Called from two places, and to be in flash once.
    #[inline(never)]
    fn judge(&mut self, set_point: RadPerSec, reading: Reading) {
        let Sampling { monitor, watch, notes, counts, run, channels } = self;
        let verdict = match reading {
            Reading::Taken(sample) => monitor.step(set_point, sample),
            Reading::Absent(why) => {
                counts.absent = counts.absent.saturating_add(1);
                monitor.skip(why)
            }
        };
        let rejected = verdict.rejected();
        if rejected.is_none() {
            *channels = verdict.readings();
        }
        if let Some(news) = rejection(run, counts, verdict.sample(), rejected) {
            push(notes, counts, news);
        }
        watch.observe(verdict, |event| push(notes, counts, note(event, verdict)));
    }

    /// To be called at the end of an interrupt that found the next slot begun
    /// ([`Deadline::overrun`](crate::deadline::Deadline::overrun)).
    pub fn overran(&mut self) {
        self.counts.overruns = self.counts.overruns.saturating_add(1);
        let sample = self.monitor.verdict().sample();
        push(&mut self.notes, &mut self.counts, Note::Overrun { sample });
    }

    /// What the main loop may ask for, by copy.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let Sampling { monitor, channels, counts, .. } = self;
        let (verdict, baseline) = (*monitor.verdict(), monitor.baseline().copied());
        Snapshot { verdict, channels: *channels, baseline, counts: *counts }
    }

    /// Slots so far: the count moves while the interrupt is alive.
    #[must_use]
    pub fn slots(&self) -> u64 {
        self.monitor.verdict().sample().wrapping_add(1)
    }

    /// The learning window, when it is complete and no model has been made of it.
    #[must_use]
    pub fn learned_window(&self) -> Option<Moments<3>> {
        self.monitor.learned_window().copied()
    }

    /// Hands in what was made of the learning window; returns whether it was still wanted.
    pub fn install(&mut self, learned: Result<Baseline, LearnError>) -> bool {
        let wanted = self.monitor.install(learned);
        if let (true, Err(error)) = (wanted, learned) {
            let event = Event { sample: self.monitor.verdict().sample(), kind: EventKind::LearningRefused(error) };
            push(&mut self.notes, &mut self.counts, note(event, self.monitor.verdict()));
        }
        wanted
    }
}

/// Tells once that slots are turned away, again when the reason changes, and when that is over. `run` counts them in a row,
/// and holds the last reason.
fn rejection(
    run: &mut (u32, Option<Rejected>),
    counts: &mut Counts,
    sample: u64,
    now: Option<Rejected>,
) -> Option<Note> {
    let (length, before) = *run;
    *run = (if now.is_some() { length.saturating_add(1) } else { 0 }, now);
    counts.rejected = counts.rejected.saturating_add(u32::from(now.is_some()));
    match now {
        _ if before == now => None,
        Some(why) => Some(Note::Rejecting { sample, why }),
        None => Some(Note::Accepting { sample, after: length }),
    }
}

/// What the main loop needs in order to tell of an event.
#[inline(never)]
fn note(event: Event, verdict: &Verdict) -> Note {
    let model = match event.kind {
        EventKind::RelayUp(model) | EventKind::RelayDown(model) => model,
        _ => ModelId::Full,
    };
    let residual = verdict.residuals().map_or(0.0, |residuals| *residuals.get(model));
    Note::Event { event, residual, alarm_since: verdict.alarm_since() }
}

#[inline(never)]
fn push(notes: &mut Producer<'_>, counts: &mut Counts, note: Note) {
    if notes.enqueue(note).is_err() {
        counts.dropped = counts.dropped.saturating_add(1);
    }
}
