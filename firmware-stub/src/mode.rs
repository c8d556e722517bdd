//! What the wiring asks of a monitor, so that it is the same whichever mode it is in: [`Guarded`] or [`Paper`].
//!
//! A mode is what lives in the sampling interrupt. What takes its time is asked of a copy, in the main loop.

use monitor_core::moments::LearnError;
use monitor_core::units::RadPerSec;

use crate::sampling::Reading;

pub mod guarded;
pub mod paper;

pub use guarded::Guarded;
pub use paper::Paper;

/// A monitor in one of its modes.
pub trait Mode: Clone {
    /// What is said of a slot.
    type Verdict;
    /// What has changed with a slot.
    type News: Copy;
    /// Why a slot is turned away.
    type Rejected: Copy + PartialEq;
    /// All that a model is made of.
    type Window;
    /// What is made of it.
    type Model;
    /// What is wrong.
    type Finding;
    /// Of names that are asked for, when that was last and what was said.
    type Named: Default;

    /// Judges one slot and tells what has changed with it. Returns why it was turned away, if it was.
    fn step(&mut self, set_point: RadPerSec, reading: Reading, tell: impl FnMut(Self::News)) -> Option<Self::Rejected>;

    /// The verdict on the last slot.
    fn verdict(&self) -> &Self::Verdict;

    /// The last slot, counted from zero; before the first one the largest number.
    fn slot(&self) -> u64;

    /// Whether something is wrong: what drives a fault output.
    fn alarm(&self) -> bool;

    /// The sample from which on the motor has not been what it was learned to be.
    fn since(&self) -> Option<u64>;

    /// The learning window, when it is complete and no model has been made of it.
    fn learned_window(&self) -> Option<Self::Window>;

    /// Makes a model of it. This takes its time.
    ///
    /// # Errors
    /// [`LearnError`] when the window cannot be learned from.
    fn learn(window: &Self::Window) -> Result<Self::Model, LearnError>;

    /// Hands in what was made of it, and tells how that went; returns whether it was still wanted.
    fn install(&mut self, learned: Result<Self::Model, LearnError>, tell: impl FnMut(Self::News)) -> bool;

    /// Takes the motor for healthy as it runs now, where the mode can be told so.
    fn acknowledge(&mut self) {}

    /// What of the last verdict is due to each channel.
    fn by_channel(&self) -> Option<[f32; 3]>;

    /// What is wrong. This may take its time.
    fn finding(&self) -> Self::Finding;

    /// Whether it is time to ask for a name; never where verdicts bring the name with them.
    fn is_to_be_named(&self, _: &Self::Named) -> bool {
        false
    }

    /// Asks for the name; returns what is wrong if its name is not the one that was said last.
    fn name(&self, _: &mut Self::Named) -> Option<Self::Finding> {
        None
    }
}
