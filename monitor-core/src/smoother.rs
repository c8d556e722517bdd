//! What smooths a residual: one frozen design, one state for each residual.

/// A smoother with a DC gain of one. The design is shared by all residuals; each has a state of its own.
pub trait Smoother {
    /// The moving part.
    type State: Copy + core::fmt::Debug + PartialEq;

    /// The state that has seen `value` for ever: it starts a smoother without a transient.
    fn at_rest(&self, value: f32) -> Self::State;

    /// Takes one finite input, gives one output. Constant work.
    fn step(&self, state: &mut Self::State, input: f32) -> f32;

    /// As [`Smoother::step`] when `live`; otherwise the same work on a state that stays as it is, and the output means
    /// nothing.
    fn step_if(&self, live: bool, state: &mut Self::State, input: f32) -> f32;
}
