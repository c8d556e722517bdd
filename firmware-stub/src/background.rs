//! The main loop's side: everything that may take its time. It ends learning, answers requests, and tells whether the
//! sampling interrupt is alive.

use monitor_core::moments::LearnError;
use monitor_core::paper::Baseline;
use monitor_core::pca::ExplainedShare;
use monitor_core::units::RadPerSec;

use crate::request::Request;
use crate::sampling::{Consumer, Note, Sampling, Snapshot};

/// Access to what the sampling interrupt owns, with that interrupt held off meanwhile: RTIC's lock, embassy's blocking
/// mutex, or a critical section. Whoever calls keeps it short.
pub trait Shared<'q> {
    /// Calls `f` with the sampling interrupt held off.
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'q>) -> R) -> R;
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

/// What a request brings.
#[derive(Clone, Copy, Debug)]
pub enum Answer {
    /// What each channel contributes to the T2 of the last sample; none while nothing is judged.
    Contributions(Option<[f32; 3]>),
    /// The state that statistics are read from.
    Statistics(Snapshot),
    /// The state that the last verdict is read from.
    Verdict(Snapshot),
    /// The set point from now on.
    SetPoint(RadPerSec),
}

/// The main loop's part of the monitor.
pub struct Background<'q> {
    notes: Consumer<'q>,
    share: ExplainedShare,
    in_vain: u32,
    /// The slot that was current when the watchdog was last fed.
    fed_at: Option<u64>,
}

impl<'q> Background<'q> {
    /// The other end of the queue, and the share of variance that a model must explain, as in the monitor's settings. A
    /// share that the monitor refuses gives the paper's.
    #[must_use]
    pub fn new(notes: Consumer<'q>, explained_share: f32) -> Self {
        let share = ExplainedShare::new(explained_share).unwrap_or(ExplainedShare::PAPER);
        Background { notes, share, in_vain: 0, fed_at: None }
    }

    /// The oldest note that waits.
    pub fn next_note(&mut self) -> Option<Note> {
        self.notes.dequeue()
    }

    /// Makes a model of a complete learning window, if there is one: copies the window in one critical section, runs the
    /// eigen-solver outside, hands the model in in another.
    pub fn learn(&mut self, shared: &mut impl Shared<'q>) -> Option<Learned> {
        let window = shared.with(|sampling| sampling.learned_window())?;
        let learned = Baseline::learn(&window, self.share);
        let wanted = shared.with(|sampling| sampling.install(learned));
        Some(match (wanted, learned) {
            (false, _) => {
                self.in_vain = self.in_vain.saturating_add(1);
                Learned::InVain
            }
            (true, Ok(_)) => Learned::Installed,
            (true, Err(error)) => Learned::Refused(error),
        })
    }

    /// Works out what a request asks for. Whoever has the set point in hand acts on [`Answer::SetPoint`].
    pub fn answer(&self, request: Request, shared: &mut impl Shared<'q>) -> Answer {
        let mut snapshot = || shared.with(|sampling| sampling.snapshot());
        match request {
            Request::Contributions => {
                let Snapshot { channels, baseline, .. } = snapshot();
                Answer::Contributions(baseline.map(|baseline| baseline.contributions(channels)))
            }
            Request::Statistics => Answer::Statistics(snapshot()),
            Request::Verdict => Answer::Verdict(snapshot()),
            Request::SetPoint(set_point) => Answer::SetPoint(set_point),
        }
    }

    /// Models that were thrown away because the set point had changed.
    #[must_use]
    pub const fn in_vain(&self) -> u32 {
        self.in_vain
    }

    /// Whether the sampling interrupt has judged a slot since this was last asked. Only then may the watchdog be fed:
    /// fed by a main loop alone, it would not see an interrupt that has stopped.
    pub fn sampling_is_alive(&mut self, shared: &mut impl Shared<'q>) -> bool {
        let slot = shared.with(|sampling| sampling.slots());
        let alive = self.fed_at != Some(slot);
        self.fed_at = Some(slot);
        alive
    }
}

#[cfg(test)]
mod tests;
