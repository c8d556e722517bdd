//! What a channel can credibly read: a reading outside, or one that is not a number, is turned away at the door.
//!
//! The check decides for all three channels without a branch, so that a broken sensor costs the interrupt the same
//! cycles as a good one. It is also what keeps every later stage finite: no filter ever sees an infinity or a NaN, which
//! it would keep for ever.

use crate::sample::Channel;

/// Ends of what a channel can read, in its unit, both excluded: an analog-to-digital converter at one of its rails is
/// saturated, and says nothing of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range {
    /// Readings lie above this.
    pub low: f32,
    /// Readings lie below this.
    pub high: f32,
}

/// Largest magnitude of an end: far above anything measured, and low enough that no later stage can overflow.
const LARGEST_END: f32 = 1e9;

impl Range {
    /// No converter known: anything a sensor could sensibly give, in any unit.
    pub const WIDE: Range = Range { low: -LARGEST_END, high: LARGEST_END };

    /// Half its width.
    pub(crate) const fn reach(&self) -> f32 {
        0.5 * (self.high - self.low)
    }
}

impl Default for Range {
    fn default() -> Self {
        Range::WIDE
    }
}

/// The check of one channel: |x - middle| times scale is below two exactly when `x` lies in the range.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Door {
    middle: f32,
    scale: f32,
}

/// The checks of the three channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Doors([Door; 3]);

impl Doors {
    /// # Errors
    /// The first channel whose ends do not ascend or are larger than 1e9.
    pub(crate) fn new(ranges: &[Range; 3]) -> Result<Self, Channel> {
        let mut doors = [Door { middle: 0.0, scale: 0.0 }; 3];
        for ((position, range), door) in ranges.iter().enumerate().zip(&mut doors) {
            let Range { low, high } = *range;
            let scale = 2.0 / range.reach();
            if !(low < high && -LARGEST_END <= low && high <= LARGEST_END && scale.is_finite()) {
                return Err(Channel::at(position));
            }
            *door = Door { middle: 0.5 * (low + high), scale };
        }
        Ok(Doors(doors))
    }

    /// Looks at the three readings.
    #[inline(always)]
    pub(crate) fn look(&self, x: [f32; 3]) -> Look {
        let [a, b, c] = &self.0;
        let [x0, x1, x2] = x;
        let exponent = |door: &Door, x: f32| ((x - door.middle) * door.scale).to_bits() >> 23 & 0xff;
        Look(exponent(a, x0) | exponent(b, x1) << 8 | exponent(c, x2) << 16)
    }
}

/// What the doors saw: for each channel, in eight bits, the exponent of its distance from the middle of its range.
///
/// An `f32` is below two in magnitude exactly when the top bit of its exponent is clear, and it is no finite number
/// exactly when all bits are set. One reading so large that its distance overflows counts as not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Look(u32);

/// Why a channel was turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unfit {
    NonFinite(Channel),
    OutOfRange(Channel),
}

impl Look {
    /// Of a slot without a sample: no channel is fit.
    pub(crate) const NOTHING: Look = Look(0xff_ff_ff);

    const TOP_BITS: u32 = 0x80_80_80;

    /// Whether all three readings are finite and in range.
    #[inline(always)]
    pub(crate) const fn fit(self) -> bool {
        self.0 & Self::TOP_BITS == 0
    }

    /// The first channel that is not, and why.
    pub(crate) fn unfit(self) -> Option<Unfit> {
        let exponents = [self.0, self.0 >> 8, self.0 >> 16].map(|word| word & 0xff);
        let (position, exponent) = exponents.into_iter().enumerate().find(|(_, exponent)| *exponent >= 0x80)?;
        let channel = Channel::at(position);
        Some(if exponent == 0xff { Unfit::NonFinite(channel) } else { Unfit::OutOfRange(channel) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ADC: Range = Range { low: -40.0, high: 60.0 };

    fn look(x: [f32; 3]) -> Look {
        Doors::new(&[ADC, Range::WIDE, ADC]).unwrap().look(x)
    }

    #[test]
    fn readings_in_range_are_fit_and_readings_at_a_rail_or_beyond_are_not() {
        assert!(look([-39.999, 1e8, 59.999]).fit());
        for rail in [-40.0, 60.0, 60.001, -1e6, 3e38] {
            assert_eq!(look([0.0, 0.0, rail]).unfit(), Some(Unfit::OutOfRange(Channel::ArmatureVoltage)), "{rail}");
        }
        assert_eq!(look([0.0, -1e9, 0.0]).unfit(), Some(Unfit::OutOfRange(Channel::ArmatureCurrent)));
    }

    #[test]
    fn a_reading_that_is_no_number_is_told_from_one_that_is_too_large_and_the_first_channel_is_named() {
        for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(look([0.0, bad, 1e30]).unfit(), Some(Unfit::NonFinite(Channel::ArmatureCurrent)));
        }
        assert_eq!(look([1e30, f32::NAN, 0.0]).unfit(), Some(Unfit::OutOfRange(Channel::Speed)));
    }

    #[test]
    fn ranges_that_make_no_sense_are_refused_by_channel() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f32::NAN, 1.0), (0.0, f32::INFINITY), (-2e9, 0.0), (0.0, 1e-45)] {
            let refused = Doors::new(&[ADC, Range { low, high }, ADC]);
            assert_eq!(refused, Err(Channel::ArmatureCurrent), "{low}..{high}");
        }
    }

    proptest! {
        #[test]
        fn any_bits_are_fit_exactly_when_they_lie_in_the_range(bits in any::<u32>(), x in -100.0_f32..100.0) {
            for x in [f32::from_bits(bits), x] {
                // Within rounding of an end either answer is right.
                let near = (x - ADC.low).abs() < 1e-4 || (x - ADC.high).abs() < 1e-4;
                prop_assert!(near || look([x, 0.0, 0.0]).fit() == (ADC.low < x && x < ADC.high), "{x}");
            }
        }
    }
}
