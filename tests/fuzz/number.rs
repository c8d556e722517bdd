//! Numbers as the worst sensor would send them.

use bolero::TypeGenerator;

/// Where arithmetic changes its ways.
const AWKWARD: [f32; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    1e15,
    1.9e19, // its square is not finite
    -1e30,
];

/// A number of any bits, of awkward ones, or of everyday size. The last kind gets past validation.
#[derive(Clone, Copy, Debug, TypeGenerator)]
pub(super) enum Number {
    Bits(u32),
    Awkward(#[generator(0..AWKWARD.len())] usize),
    /// In 64ths, so that some are equal.
    Everyday(i16),
}

impl Number {
    pub(super) fn value(self) -> f32 {
        match self {
            Number::Bits(bits) => f32::from_bits(bits),
            Number::Awkward(index) => AWKWARD[index],
            Number::Everyday(count) => f32::from(count) / 64.0,
        }
    }
}
