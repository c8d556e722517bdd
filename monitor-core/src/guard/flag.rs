//! Decisions of a slot that take no branch: a flag is the lowest bit of a word, and what it decides is masked.
//!
//! Numbers that are not negative are ordered as their bits are, so comparing them is a subtraction of words: a third of the
//! instructions of a comparison of `f32`, whose outcome has to be fetched from the floating-point unit first.

use core::ops::{BitAnd, BitOr, Not};

/// Yes or no.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Flag(u32);

impl Flag {
    pub(super) const fn new(set: bool) -> Self {
        Flag(set as u32)
    }

    /// a > b, of numbers that are neither negative nor NaN.
    #[inline(always)]
    pub(super) const fn above(a: f32, b: f32) -> Self {
        Flag(b.to_bits().wrapping_sub(a.to_bits()) >> 31)
    }

    /// a < b, of numbers that are neither negative nor NaN.
    #[inline(always)]
    pub(super) const fn below(a: f32, b: f32) -> Self {
        Flag::above(b, a)
    }

    /// Whether the sign of a number is minus.
    #[inline(always)]
    pub(super) const fn negative(x: f32) -> Self {
        Flag(x.to_bits() >> 31)
    }

    /// Whether a reading is no number.
    #[inline(always)]
    pub(super) const fn unfit(x: f32) -> Self {
        // Infinities and NaN have all bits of the exponent: one more carries over into the sign.
        Flag(((x.to_bits() & 0x7fff_ffff) + 0x0080_0000) >> 31)
    }

    /// count >= goal, both below 2^31.
    #[inline(always)]
    pub(super) const fn reached(count: u32, goal: u32) -> Self {
        Flag(count.wrapping_sub(goal) >> 31 ^ 1)
    }

    /// Whether any of the lower 31 bits of a word is set, whose highest is not.
    #[inline(always)]
    pub(super) const fn any(word: u32) -> Self {
        Flag(0_u32.wrapping_sub(word) >> 31)
    }

    /// A bit of a word.
    #[inline(always)]
    pub(super) const fn of(word: u32, place: u32) -> Self {
        Flag(word >> place & 1)
    }

    #[inline(always)]
    pub(super) const fn is_set(self) -> bool {
        self.0 != 0
    }

    /// The number, or zero if a bit of a word is not set.
    #[inline(always)]
    pub(super) const fn or_zero_by(word: u32, place: u32, x: f32) -> f32 {
        f32::from_bits(x.to_bits() & ((word << (31 - place)) as i32 >> 31) as u32) // one instruction sign-extends a bit
    }

    /// 0 or 1.
    #[inline(always)]
    pub(super) const fn bit(self) -> u32 {
        self.0
    }

    #[inline(always)]
    const fn mask(self) -> u32 {
        0_u32.wrapping_sub(self.0)
    }

    /// The number, or zero if the flag is not set.
    #[inline(always)]
    pub(super) const fn or_zero(self, x: f32) -> f32 {
        f32::from_bits(x.to_bits() & self.mask())
    }

    /// The first if the flag is set, else the second.
    #[inline(always)]
    pub(super) const fn choose(self, a: f32, b: f32) -> f32 {
        f32::from_bits(self.choose_word(a.to_bits(), b.to_bits()))
    }

    #[inline(always)]
    pub(super) const fn choose_word(self, a: u32, b: u32) -> u32 {
        b ^ ((a ^ b) & self.mask())
    }

    #[inline(always)]
    pub(super) const fn choose_long(self, a: u64, b: u64) -> u64 {
        let (lower, upper) =
            (self.choose_word(a as u32, b as u32), self.choose_word((a >> 32) as u32, (b >> 32) as u32));
        (upper as u64) << 32 | lower as u64
    }

    /// Counts on towards a goal below 2^31, or begins again if the flag is not set.
    #[inline(always)]
    pub(super) const fn count(self, count: u32, goal: u32) -> u32 {
        (count + (count.wrapping_sub(goal) >> 31)) & self.mask()
    }
}

impl BitAnd for Flag {
    type Output = Flag;
    #[inline(always)]
    fn bitand(self, other: Flag) -> Flag {
        Flag(self.0 & other.0)
    }
}

impl BitOr for Flag {
    type Output = Flag;
    #[inline(always)]
    fn bitor(self, other: Flag) -> Flag {
        Flag(self.0 | other.0)
    }
}

impl Not for Flag {
    type Output = Flag;
    #[inline(always)]
    fn not(self) -> Flag {
        Flag(self.0 ^ 1)
    }
}

/// The lesser of two numbers that are not negative.
#[inline(always)]
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    f32::from_bits(a.to_bits().min(b.to_bits()))
}

/// The greater of two numbers that are not negative.
#[inline(always)]
pub(super) fn greater(a: f32, b: f32) -> f32 {
    f32::from_bits(a.to_bits().max(b.to_bits()))
}

/// The number, or zero where it is negative.
#[inline(always)]
pub(super) const fn positive_part(x: f32) -> f32 {
    let bits = x.to_bits();
    f32::from_bits(bits & !((bits as i32 >> 31) as u32))
}

/// The number with its magnitude bounded. A NaN comes out as the bound.
#[inline(always)]
pub(super) fn within(x: f32, bound: f32) -> f32 {
    let (bits, sign) = (x.to_bits(), 1 << 31);
    f32::from_bits((bits & sign) | (bits & !sign).min(bound.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: [f32; 9] = [0.0, 1e-45, f32::MIN_POSITIVE, 0.5, 1.0, 1.000_000_1, 1e30, f32::MAX, f32::INFINITY];

    #[test]
    fn flags_of_numbers_are_the_comparisons_they_stand_for() {
        for a in NUMBERS {
            for b in NUMBERS {
                assert_eq!((Flag::above(a, b), Flag::below(a, b)), (Flag::new(a > b), Flag::new(a < b)), "{a} {b}");
                assert_eq!([lesser(a, b), greater(a, b)], [a.min(b), a.max(b)]);
                assert_eq!([within(a, b), within(-a, b)], [a.min(b), -a.min(b)]);
            }
            assert_eq!([positive_part(a), positive_part(-a)], [a, 0.0]);
            assert_eq!(Flag::unfit(a), Flag::new(a.is_infinite()));
            assert_eq!((Flag::negative(a), Flag::negative(-a)), (Flag::new(false), Flag::new(true)));
        }
        assert!(Flag::unfit(f32::NAN).bit() + Flag::unfit(-f32::NAN).bit() == 2);
        assert_eq!(within(f32::NAN, 3.0).abs(), 3.0);
    }

    #[test]
    fn flags_choose_and_count() {
        let (yes, no) = (Flag::new(true), Flag::new(false));
        assert_eq!(
            [yes.choose(1.0, -2.0), no.choose(1.0, -2.0), yes.or_zero(3.0), no.or_zero(3.0)],
            [1.0, -2.0, 3.0, 0.0]
        );
        assert_eq!([0, 1, 2].map(|place| Flag::or_zero_by(0b101, place, -7.0)), [-7.0, 0.0, -7.0]);
        assert_eq!([0, 1, 1 << 30, u32::MAX >> 1].map(|word| Flag::any(word).bit()), [0, 1, 1, 1]);
        let long = (1 << 40 | 7, 3 << 32 | 1 << 31);
        assert_eq!([yes.choose_long(long.0, long.1), no.choose_long(long.0, long.1)], [long.0, long.1]);
        let counts = [yes.count(0, 2), yes.count(1, 2), yes.count(2, 2), yes.count(0, 0), no.count(1, 2)];
        assert_eq!(counts, [1, 2, 2, 0, 0]);
        assert_eq!([(1, 2), (2, 2), (3, 2), (0, 0)].map(|(n, goal)| Flag::reached(n, goal).bit()), [0, 1, 1, 1]);
    }
}
