//! Limits that sharpen: how far a time scale's limit lies above what theory gives for a motor that is known for ever.
//!
//! A window of some seconds holds few independent samples of a slow scale, so its variance and the mean are known roughly, and
//! limits must be wide. While the motor is healthy every sample adds to both: the mean follows, and each row of the metric is
//! brought to the length at which its share of the distance is one on average.

use super::design::Design;
use crate::moments::LearnError;
use crate::triangle::Triangle;

/// Slots from one update of a scale to the next. Updates take turns.
pub(super) const PERIOD: u32 = 64;

/// Fewest degrees of freedom at which a limit is calculated.
const DEGREES_FROM: f32 = 13.0;

/// What a time scale's limit is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    /// Limit for a covariance and a mean known exactly.
    base: f32,
    /// The exponent by which one degree of freedom would stretch it ([`stretched`]); of n it is an n-th of that.
    growth: f32,
    /// Independent samples in a slot.
    per_slot: f32,
    /// Degrees of freedom that the window gave beyond those of the scale itself.
    borrowed: f32,
}

impl Level {
    pub(super) const BLANK: Self = Level { base: 0.0, growth: 0.0, per_slot: 0.0, borrowed: 0.0 };

    pub(super) fn each_number(&mut self, f: &mut impl FnMut(&mut f32)) {
        [&mut self.base, &mut self.growth, &mut self.per_slot, &mut self.borrowed].into_iter().for_each(f);
    }

    /// Of the scale at this place, whose metric was learned from a window of so many slots with so many degrees of freedom, and
    /// which has so many independent samples in a slot.
    pub(super) fn new(
        design: &Design,
        place: usize,
        slots: f32,
        degrees_of_freedom: f32,
        per_slot: f32,
    ) -> Result<Self, LearnError> {
        let limit = |degrees| design.limit(place, degrees).map_err(|_| LearnError::TooShort { samples: slots as u32 });
        let base = limit(1e6)?;
        let degrees = degrees_of_freedom.max(DEGREES_FROM);
        let growth = degrees * exponent_of(limit(degrees)? / base);
        Ok(Level { base, growth, per_slot, borrowed: degrees - per_slot * slots })
    }

    /// The limit once the noise is known from so many slots, and the mean from so many.
    pub(super) fn limit(&self, slots: f32, mean_slots: f32) -> f32 {
        // The mean's own error is in every distance.
        let of_mean = 1.0 + 1.0 / (self.per_slot * mean_slots);
        self.base * stretched(self.growth / (self.per_slot * slots + self.borrowed)) * of_mean
    }

    /// Widens the limit for good: the tail is heavier than a normal one.
    pub(super) fn widen(&mut self, factor: f32) {
        self.base *= factor;
    }
}

/// (e^x - 1)/x, with (1 + x/16)^16 for the exponential: how far a limit that is b for a covariance known exactly moves out for
/// one of n degrees of freedom, at x = b/n, for the far tail of F falls as (1 + b/n)^(-n/2) where that of chi-square does as
/// e^(-b/2).
#[inline(always)]
fn stretched(x: f32) -> f32 {
    let power = (0..4).fold(1.0 + x / 16.0, |power, _| power * power);
    (power - 1.0) / x
}

/// The exponent that stretches a limit by so much, from 1/1000 to 16.
fn exponent_of(stretch: f32) -> f32 {
    let (mut exponent, mut step) = (1e-3, 8.0);
    for _ in 0..20 {
        if stretched(exponent + step) <= stretch {
            exponent += step;
        }
        step *= 0.5;
    }
    exponent
}

impl Triangle<3> {
    pub(super) const fn diagonal(&self) -> [f32; 3] {
        let [[a, ..], [_, b, _], [.., c]] = self.rows();
        [a, b, c]
    }

    /// Brings the metric a step nearer to where w = U y has the covariance I, by a smoothed deviation in control.
    ///
    /// U += g G U, with G the upper half of I - w w' and half its diagonal, comes to rest where the mean of w w' is I, and
    /// keeps U a triangle. With a gain g that is `PERIOD` slots in so many it is the mean over all of them
    /// (Robbins and Monro 1951; the relative gradient of Cardoso and Laheld 1996).
    pub(super) fn whiten(&mut self, y: [f32; 3], gain: f32) {
        let [w0, w1, w2] = self.times(y);
        let half = |w: f32| 1.0 + 0.5 * gain * (1.0 - w * w);
        let [first, second, third] = self.rows();
        let combined = |own: f32, a: [f32; 3], by: f32, b: [f32; 3], and: f32, c: [f32; 3]| {
            let [[a0, a1, a2], [b0, b1, b2], [c0, c1, c2]] = [a, b, c];
            [own * a0 + by * b0 + and * c0, own * a1 + by * b1 + and * c1, own * a2 + by * b2 + and * c2]
        };
        *self = Triangle::from_upper([
            combined(half(w0), first, -gain * w0 * w1, second, -gain * w0 * w2, third),
            combined(half(w1), second, -gain * w1 * w2, third, 0.0, third),
            third.map(|cell| half(w2) * cell),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantile::{upper_chi_square, upper_f};

    #[test]
    fn a_limit_comes_down_as_degrees_of_freedom_are_gained_and_never_below_what_they_make_of_it() {
        for tail in [1e-4, 1e-7, 1e-10_f32] {
            let base = upper_chi_square(tail, 3.0).unwrap();
            let exact = |degrees: f32| 3.0 * degrees / (degrees - 2.0) * upper_f(tail, 3.0, degrees - 2.0).unwrap();
            for from in [13.0, 30.0, 100.0] {
                let growth = from * exponent_of(exact(from) / base);
                assert!((base * stretched(growth / from) / exact(from) - 1.0).abs() < 1e-3, "{tail} from {from}");
                for more in [1.5, 3.0, 10.0, 100.0] {
                    let degrees = from * more;
                    let found = base * stretched(growth / degrees) / exact(degrees);
                    assert!((0.97..1.35).contains(&found), "{tail} from {from} to {degrees}: {found}");
                }
            }
        }
    }
}
