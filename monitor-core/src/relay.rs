//! The relay that "squares off" a residual (the paper, figs. 7 and 9): threshold with hysteresis.

/// Why a relay was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RelayError {
    /// The threshold must be finite and greater than zero.
    Threshold,
    /// The hysteresis is a share of the threshold in [0, 1).
    Hysteresis,
}

/// Goes up above `on`, comes down below `off`, and stays as it is in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relay {
    on: f32,
    /// The bits in which the level that brings the relay down differs from `on`.
    ///
    /// The level is then chosen by a mask. A choice between two numbers in memory, the compiler turns into a load from
    /// an address that depends on the relay, and the path of a sample must not depend on what was measured.
    to_off: u32,
}

impl Relay {
    /// A relay that goes up above `threshold` and comes down below `threshold * (1 - hysteresis)`.
    ///
    /// # Errors
    /// [`RelayError`] names the parameter that is out of range.
    pub fn new(threshold: f32, hysteresis: f32) -> Result<Self, RelayError> {
        if !(threshold > 0.0 && threshold.is_finite()) {
            return Err(RelayError::Threshold);
        }
        if !(0.0..1.0).contains(&hysteresis) {
            return Err(RelayError::Hysteresis);
        }
        let off = threshold * (1.0 - hysteresis);
        Ok(Relay { on: threshold, to_off: threshold.to_bits() ^ off.to_bits() })
    }

    /// The level above which the relay goes up.
    #[must_use]
    pub const fn threshold(&self) -> f32 {
        self.on
    }

    /// Takes one residual, which must be a number; returns whether the relay is up.
    #[inline(always)]
    pub fn step(&self, up: &mut bool, residual: f32) -> bool {
        let level = self.on.to_bits() ^ if *up { self.to_off } else { 0 };
        // Bits of numbers above zero are ordered as the numbers are, and those of numbers below are below all of them.
        *up = residual.to_bits().cast_signed() > level.cast_signed();
        *up
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_relay_holds_between_its_two_levels_and_switches_outside_them() {
        let relay = Relay::new(2.0, 0.25).unwrap();
        let mut up = false;
        let seen: [bool; 7] = [1.9, 2.0, 2.1, 1.6, 1.5, 1.9, 2.1].map(|r| relay.step(&mut up, r));
        assert_eq!(seen, [false, false, true, true, false, false, true]);
    }

    #[test]
    fn levels_that_make_no_sense_are_refused_by_name() {
        for threshold in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Relay::new(threshold, 0.1), Err(RelayError::Threshold));
        }
        for hysteresis in [-0.1, 1.0, f32::NAN] {
            assert_eq!(Relay::new(1.0, hysteresis), Err(RelayError::Hysteresis));
        }
    }

    proptest! {
        #[test]
        fn a_relay_compares_numbers_of_any_size_and_sign_by_their_bits_as_it_would_by_their_value(
            threshold in any::<f32>(), residual in any::<f32>(), hysteresis in 0.0_f32..0.99, before in any::<bool>(),
        ) {
            let threshold = threshold.abs();
            prop_assume!(threshold > 0.0 && threshold.is_finite() && residual.is_finite());
            let relay = Relay::new(threshold, hysteresis).unwrap();
            for residual in [residual, threshold, threshold * (1.0 - hysteresis), threshold.next_up(), -0.0, 0.0] {
                let level = if before { threshold * (1.0 - hysteresis) } else { threshold };
                let mut up = before;
                prop_assert_eq!(relay.step(&mut up, residual), residual > level, "{} at {}", residual, level);
            }
        }
    }
}
