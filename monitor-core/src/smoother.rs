//! What smooths a residual: one frozen design, one state for each residual.

use crate::sample::Bank;

/// A smoother with a DC gain of one. The design is shared by all residuals; each has a state of its own.
pub trait Smoother {
    /// The moving part.
    type State: Copy + core::fmt::Debug + PartialEq;

    /// The state that has seen `value` for ever: it starts a smoother without a transient.
    fn at_rest(&self, value: f32) -> Self::State;

    /// Takes one finite input, gives one output. Constant work.
    fn step(&self, state: &mut Self::State, input: f32) -> f32;

    /// Takes one input for each of four states, gives four outputs. When `held` the states stay as they are, for the
    /// same work, and the outputs mean nothing.
    fn step_bank(&self, held: bool, states: &mut Bank<Self::State>, inputs: Bank<f32>) -> Bank<f32>;
}
