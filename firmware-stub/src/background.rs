//! The main loop's side: everything that may take its time. It ends learning, answers requests, and tells whether the
//! sampling interrupt is alive.

use monitor_core::moments::LearnError;
use monitor_core::units::RadPerSec;

use crate::mode::Mode;
use crate::request::Request;
use crate::sampling::{Consumer, NoteOf, Sampling, Snapshot};

/// Access to what the sampling interrupt owns, with that interrupt held off meanwhile: RTIC's lock, embassy's blocking
/// mutex, or a critical section. Whoever calls keeps it short.
pub trait Shared<'q, M: Mode> {
    /// Calls `f` with the sampling interrupt held off.
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'q, M>) -> R) -> R;
}

/// How a learning window ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Learned {
    /// A model was made and judges from the next sample on.
    Installed,
    /// The window cannot be learned from; a new one has begun.
    Refused(LearnError),
    /// The set point changed while the model was made, so it was thrown away.
    InVain,
}

/// What is wrong, by a name that was not said before.
#[derive(Clone, Copy, Debug)]
pub struct Named<Finding> {
    /// The slot by which it was found.
    pub sample: u64,
    /// The sample from which on something has been wrong.
    pub since: Option<u64>,
    /// What is wrong.
    pub finding: Finding,
}

/// What a request brings.
#[derive(Clone, Debug)]
pub enum Answer<M: Mode> {
    /// What of the last verdict is due to each channel; none while nothing is judged.
    ByChannel(Option<[f32; 3]>),
    /// The state that statistics are read from.
    Statistics(Snapshot<M>),
    /// The state that the last verdict is read from, and what is wrong.
    Verdict(Snapshot<M>, M::Finding),
    /// The set point from now on.
    SetPoint(RadPerSec),
    /// The motor was taken for healthy.
    Acknowledged,
}

/// The main loop's part of the monitor.
pub struct Background<'q, M: Mode> {
    notes: Consumer<'q, M>,
    named: M::Named,
    in_vain: u32,
    /// The slot that was current when the watchdog was last fed.
    fed_at: Option<u64>,
}

impl<'q, M: Mode> Background<'q, M> {
    /// The other end of the queue.
    #[must_use]
    pub fn new(notes: Consumer<'q, M>) -> Self {
        Background { notes, named: M::Named::default(), in_vain: 0, fed_at: None }
    }

    /// The oldest note that waits.
    pub fn next_note(&mut self) -> Option<NoteOf<M>> {
        self.notes.dequeue()
    }

    /// Makes a model of a complete learning window, if there is one: copies the window in one critical section, runs the
    /// eigen-solver outside, hands the model in in another.
    pub fn learn(&mut self, shared: &mut impl Shared<'q, M>) -> Option<Learned> {
        let window = shared.with(|sampling| sampling.mode().learned_window())?;
        let learned = M::learn(&window);
        let refused = learned.as_ref().err().copied();
        let wanted = shared.with(|sampling| sampling.install(learned));
        Some(match (wanted, refused) {
            (false, _) => {
                self.in_vain = self.in_vain.saturating_add(1);
                Learned::InVain
            }
            (true, None) => Learned::Installed,
            (true, Some(error)) => Learned::Refused(error),
        })
    }

    /// Asks a copy of the monitor for the name of what is wrong, where that is not in the verdicts, from time to time while
    /// something is. Returns a name that was not said yet.
    pub fn name(&mut self, shared: &mut impl Shared<'q, M>) -> Option<Named<M::Finding>> {
        let named = &mut self.named;
        let due = |sampling: &mut Sampling<'q, M>| sampling.mode().is_to_be_named(named).then(|| sampling.snapshot());
        let Snapshot { mode, .. } = shared.with(due)?;
        let finding = mode.name(named)?;
        Some(Named { sample: mode.slot(), since: mode.since(), finding })
    }

    /// Works out what a request asks for. Whoever has the set point in hand acts on [`Answer::SetPoint`].
    pub fn answer(&self, request: Request, shared: &mut impl Shared<'q, M>) -> Answer<M> {
        let mut snapshot = || shared.with(|sampling| sampling.snapshot());
        match request {
            Request::ByChannel => Answer::ByChannel(snapshot().mode.by_channel()),
            Request::Statistics => Answer::Statistics(snapshot()),
            Request::Verdict => {
                let snapshot = snapshot();
                let finding = snapshot.mode.finding();
                Answer::Verdict(snapshot, finding)
            }
            Request::SetPoint(set_point) => Answer::SetPoint(set_point),
            Request::Acknowledge => {
                shared.with(Sampling::acknowledge);
                Answer::Acknowledged
            }
        }
    }

    /// Models that were thrown away because the set point had changed.
    #[must_use]
    pub const fn in_vain(&self) -> u32 {
        self.in_vain
    }

    /// Whether the sampling interrupt has judged a slot since this was last asked. Only then may the watchdog be fed:
    /// fed by a main loop alone, it would not see an interrupt that has stopped.
    pub fn sampling_is_alive(&mut self, shared: &mut impl Shared<'q, M>) -> bool {
        let slot = shared.with(|sampling| sampling.slots());
        let alive = self.fed_at != Some(slot);
        self.fed_at = Some(slot);
        alive
    }
}

#[cfg(test)]
mod tests;
