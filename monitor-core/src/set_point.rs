//! The set-point gate: the method is limited to regimes with a constant set point (the paper, II.C), so a change closes
//! the gate until the loop has settled.

/// Why a gate was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GateError {
    /// The tolerance must be finite and not negative.
    Tolerance,
}

/// What the gate says of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Gate {
    /// The set point has moved with this sample; the settling time starts.
    Changed,
    /// The loop is still settling.
    Settling,
    /// The set point has been constant for longer than the settling time.
    Open,
}

/// Decides from the set point alone whether a sample may be learned from or judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPointGate {
    tolerance: f32,
    settle_samples: u32,
}

/// The moving part of the gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateState {
    reference: f32,
    remaining: u32,
}

impl GateState {
    /// The set point that the gate stands at; infinite before the first.
    pub(crate) const fn reference(&self) -> f32 {
        self.reference
    }
}

impl SetPointGate {
    /// A gate that closes when the set point leaves its reference by more than `tolerance` (in the set point's unit)
    /// and opens again `settle_samples` after the last such change.
    ///
    /// # Errors
    /// [`GateError::Tolerance`] when the tolerance is negative or not finite.
    pub fn new(tolerance: f32, settle_samples: u32) -> Result<Self, GateError> {
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(GateError::Tolerance);
        }
        Ok(SetPointGate { tolerance, settle_samples })
    }

    /// The settling time, in samples.
    pub(crate) const fn settle_samples(&self) -> u32 {
        self.settle_samples
    }

    /// The state of a gate that has seen nothing: its first sample sets the reference and starts the settling time.
    #[must_use]
    pub const fn unknown(&self) -> GateState {
        // No set point is within the tolerance of an infinite reference.
        GateState { reference: f32::INFINITY, remaining: self.settle_samples }
    }

    /// The state of a gate that stands open at a known set point.
    #[must_use]
    pub const fn open_at(&self, set_point: f32) -> GateState {
        GateState { reference: set_point, remaining: 0 }
    }

    /// Whether a set point is the one the gate stands at; no number that is not finite is.
    #[inline(always)]
    #[must_use]
    pub fn holds(&self, state: &GateState, set_point: f32) -> bool {
        // A set point that creeps is compared with the reference it left, so a slow ramp cannot pass unseen.
        self.tolerates((set_point - state.reference).abs())
    }

    /// Whether a set point that is so far from another is not a different one.
    #[inline(always)]
    pub(crate) fn tolerates(&self, distance: f32) -> bool {
        distance <= self.tolerance
    }

    /// Takes the set point of one sample. The caller has checked that it is finite.
    pub fn step(&self, state: &mut GateState, set_point: f32) -> Gate {
        if !self.holds(state, set_point) {
            *state = GateState { reference: set_point, remaining: self.settle_samples };
            return Gate::Changed;
        }
        if state.remaining > 0 {
            state.remaining -= 1;
        }
        if state.remaining > 0 { Gate::Settling } else { Gate::Open }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gate_opens_exactly_the_settling_time_after_the_change() {
        let gate = SetPointGate::new(0.5, 3).unwrap();
        let mut state = gate.unknown();
        assert_eq!(gate.step(&mut state, 100.0), Gate::Changed);
        assert_eq!(gate.step(&mut state, 100.4), Gate::Settling);
        assert_eq!(gate.step(&mut state, 99.6), Gate::Settling);
        assert_eq!(gate.step(&mut state, 100.0), Gate::Open);
        assert_eq!(gate.step(&mut state, 101.0), Gate::Changed);
        assert_eq!(gate.step(&mut state, 101.0), Gate::Settling);
    }

    #[test]
    fn a_slow_ramp_closes_the_gate_once_it_has_crept_past_the_tolerance() {
        let gate = SetPointGate::new(0.5, 0).unwrap();
        let mut state = gate.open_at(0.0);
        let changes = (1..=20).filter(|k| gate.step(&mut state, 0.1 * *k as f32) == Gate::Changed).count();
        assert!(changes >= 3, "{changes} changes seen over a ramp of 2.0 with a tolerance of 0.5");
    }

    #[test]
    fn a_tolerance_that_is_negative_or_not_finite_is_refused() {
        for tolerance in [-1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(SetPointGate::new(tolerance, 1), Err(GateError::Tolerance));
        }
    }
}
