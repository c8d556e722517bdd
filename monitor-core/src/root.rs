//! The reciprocal square root, in the same few operations for every number.
//!
//! Why not [`libm::sqrtf`]: on a Cortex-M4F it is software that branches on its argument, so its time depends on the data.
//! Why not the processor's own instruction: stable Rust reaches it by inline assembly alone, which would be the one unsafe
//! block of this crate, and cores without a floating-point unit do not have it. The solver wants the reciprocal anyway, and
//! Newton's iteration for it needs no division: about as many cycles as `VSQRT` and `VDIV` together, and bit for bit the
//! same on every platform.

/// 1/sqrt(2h) for a normal `half` h above zero, to within 1.5 units in the last place, with `sign` for its sign bit;
/// something finite for other finite h. Half, because Newton's iteration asks for half the argument.
#[inline(always)]
pub(crate) fn reciprocal_sqrt_of_twice(half: f32, sign: u32) -> f32 {
    // The iteration is odd in y: the sign of its start stays.
    let y = newton(half, f32::from_bits(start(half) | sign));
    // The last step takes Newton's next term along, 3/8 e^2, and adds its correction, so that its rounding weighs nothing:
    // it brings 1.8e-3 to 1.4e-8.
    let e = 0.5 - half * y * y;
    y + y * (e + 1.5 * (e * e))
}

/// 1/sqrt(2h) to within 5e-6.
#[inline(always)]
pub(crate) fn reciprocal_sqrt_of_twice_rough(half: f32) -> f32 {
    newton(half, newton(half, f32::from_bits(start(half))))
}

/// The bits of 1/sqrt(2h) to within 3.4 %, by halving the exponent and changing its sign (Lomont, "Fast inverse square
/// root", 2003, whose constant is for h and its root: half an exponent more).
#[inline(always)]
const fn start(half: f32) -> u32 {
    (0x5f37_5a86_u32 - (1 << 22)).wrapping_sub(half.to_bits() >> 1)
}

/// Newton's step for 1/sqrt(2h): it brings 3.4 % to 1.8e-3, and that to 4.7e-6.
#[inline(always)]
fn newton(half: f32, y: f32) -> f32 {
    y * (1.5 - half * y * y)
}

/// 1/sqrt(x) for an `x` from twice the smallest normal number on.
#[inline(always)]
pub(crate) fn reciprocal_sqrt(x: f32) -> f32 {
    reciprocal_sqrt_of_twice(0.5 * x, 0)
}

/// The square root of zero, or of a number from twice the smallest normal one on, to within two units in the last place.
#[inline(never)] // for the end of a learning window, where flash is dearer than time
pub(crate) fn square_root(x: f32) -> f32 {
    x * reciprocal_sqrt(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reciprocal_root_is_within_one_and_a_half_units_in_the_last_place_over_all_mantissas() {
        // One number in 61 of two binades, which hold every mantissa and both parities of the exponent, and their ends.
        let (first, last) = (1.0_f32.to_bits(), 4.0_f32.to_bits());
        let mut worst = 0.0_f64;
        for bits in (first..=last).step_by(61) {
            for scale in [1.0_f32, f32::from_bits(0x0100_0000), f32::from_bits(0x7c00_0000)] {
                let x = f32::from_bits(bits) * scale;
                let exact = 1.0 / libm::sqrt(f64::from(x));
                let unit = f64::from((exact as f32).next_up()) - f64::from(exact as f32);
                worst = worst.max((f64::from(reciprocal_sqrt(x)) - exact).abs() / unit);
            }
        }
        assert!(worst <= 1.5, "{worst} units");
    }

    #[test]
    fn the_root_of_zero_is_zero_and_others_are_within_two_units_in_the_last_place() {
        assert_eq!(square_root(0.0), 0.0);
        for k in 1..100_000 {
            for scale in [1e-37, 1e-4, 1e4, 1e33] {
                let x = k as f32 * scale;
                let exact = libm::sqrt(f64::from(x));
                assert!((f64::from(square_root(x)) / exact - 1.0).abs() < 2.4e-7, "{x:e}");
            }
        }
    }

    #[test]
    fn numbers_without_a_reciprocal_root_give_something_finite() {
        for x in [0.0, 1e-45, 1e-39, f32::MIN_POSITIVE, f32::MAX] {
            assert!(reciprocal_sqrt(x).is_finite() && reciprocal_sqrt(x) > 0.0, "{x:e}");
        }
    }
}
