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
    off: f32,
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
        Ok(Relay { on: threshold, off: threshold * (1.0 - hysteresis) })
    }

    /// The level above which the relay goes up.
    #[must_use]
    pub const fn threshold(&self) -> f32 {
        self.on
    }

    /// Takes one residual; returns whether the relay is up.
    #[inline(always)]
    pub fn step(&self, up: &mut bool, residual: f32) -> bool {
        let level = if *up { self.off } else { self.on };
        *up = residual > level;
        *up
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_holds_between_its_two_levels_and_switches_outside_them() {
        let relay = Relay::new(2.0, 0.25).unwrap();
        let mut up = false;
        let seen: [bool; 7] = [1.9, 2.0, 2.1, 1.6, 1.5, 1.9, 2.1].map(|r| relay.step(&mut up, r));
        assert_eq!(seen, [false, false, true, true, false, false, true]);
    }

    #[test]
    fn a_residual_that_is_not_a_number_brings_the_relay_down_rather_than_holding_an_alarm() {
        let relay = Relay::new(2.0, 0.0).unwrap();
        let mut up = true;
        assert!(!relay.step(&mut up, f32::NAN));
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
}
