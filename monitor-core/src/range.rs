//! What a channel can credibly read.
//!
//! Whoever takes a reading knows the converter and the sensor behind it, so this check stands where readings are made,
//! before [`Monitor::step`](crate::paper::Monitor::step): a reading at or beyond an end becomes infinite, and an infinite
//! reading is reported as out of range. A reading that is no number stays none, and is reported as that.

use crate::sample::Sample;
use crate::units::{Amperes, RadPerSec, Volts};

/// Why a range was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RangeError {
    /// The ends must be numbers, the lower below the higher.
    Ends,
}

/// Ends of what a channel can read, in its unit, both excluded: an analog-to-digital converter at one of its rails is
/// saturated, and says nothing of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range {
    low: f32,
    high: f32,
}

impl Range {
    /// Readings between `low` and `high`, in the channel's unit.
    ///
    /// # Errors
    /// [`RangeError::Ends`] unless `low` < `high`.
    pub fn new(low: f32, high: f32) -> Result<Self, RangeError> {
        if low < high { Ok(Range { low, high }) } else { Err(RangeError::Ends) }
    }

    /// The reading itself within the range, an infinity of its side at or beyond an end.
    #[must_use]
    pub fn admit(&self, x: f32) -> f32 {
        // In this order NaN, which compares with nothing, stays what it is.
        if x <= self.low {
            f32::NEG_INFINITY
        } else if x >= self.high {
            f32::INFINITY
        } else {
            x
        }
    }
}

/// The ranges of the three channels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ranges {
    /// Of the shaft speed, rad/s.
    pub speed: Range,
    /// Of the armature current, A.
    pub armature_current: Range,
    /// Of the armature voltage, V.
    pub armature_voltage: Range,
}

impl Ranges {
    /// The sample with each reading admitted by the range of its channel.
    #[must_use]
    pub fn admit(&self, sample: Sample) -> Sample {
        Sample {
            speed: RadPerSec(self.speed.admit(sample.speed.0)),
            armature_current: Amperes(self.armature_current.admit(sample.armature_current.0)),
            armature_voltage: Volts(self.armature_voltage.admit(sample.armature_voltage.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_within_the_range_pass_and_readings_at_a_rail_or_beyond_become_infinite() {
        let adc = Range::new(-40.0, 60.0).unwrap();
        for x in [-39.999, 0.0, 59.999] {
            assert_eq!(adc.admit(x), x);
        }
        for x in [-40.0, -1e38, f32::NEG_INFINITY] {
            assert_eq!(adc.admit(x), f32::NEG_INFINITY);
        }
        for x in [60.0, 1e38, f32::INFINITY] {
            assert_eq!(adc.admit(x), f32::INFINITY);
        }
        assert!(adc.admit(f32::NAN).is_nan());
    }

    #[test]
    fn each_channel_of_a_sample_has_its_own_range() {
        let range = |high| Range::new(0.0, high).unwrap();
        let ranges = Ranges { speed: range(600.0), armature_current: range(40.0), armature_voltage: range(60.0) };
        let sample = Sample { speed: RadPerSec(50.0), armature_current: Amperes(50.0), armature_voltage: Volts(50.0) };
        let admitted: [f32; 3] = ranges.admit(sample).into();
        assert_eq!(admitted, [50.0, f32::INFINITY, 50.0]);
    }

    #[test]
    fn ends_that_do_not_ascend_are_refused() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f32::NAN, 1.0), (0.0, f32::NAN)] {
            assert_eq!(Range::new(low, high), Err(RangeError::Ends));
        }
    }
}
