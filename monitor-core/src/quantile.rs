//! Upper quantiles of the normal, chi-square and F distributions: what control limits are made of.
//!
//! For design and start-up, not for `step`: a quantile takes some thousand operations, among them `logf`. Their number
//! is fixed. All of them are single precision, so a target without double precision links none of its emulation.
//!
//! # Method
//! The logarithm of the tail comes from a continued fraction (`tail.rs`), and Newton's iteration solves
//! ln(tail) = ln(p) for it. In the logarithm the tail is nearly a straight line in the variable chosen, so a few
//! steps from the Wilson-Hilferty approximation reach the rounding of `f32`, for p = 1e-12 as for p = 0.1; and the
//! slope falls out of the same continued fraction, without another function. Rounding is small because a logarithm known
//! to 1e-6 is a quantile known to 1e-6 over the logarithm's size. `NUMERICS.md` ([`crate::numerics`]) has the errors measured.

mod tail;

use tail::Tail;

/// Why a quantile was refused: an argument out of the range in which it is known to be accurate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum QuantileError {
    /// The tail probability must lie in [1e-12, 0.1].
    TailProbability,
    /// The degrees of freedom, of an F distribution those of the numerator, must lie in [1, 50].
    DegreesOfFreedom,
    /// The denominator's degrees of freedom must be finite and at least 10.
    DenominatorDegreesOfFreedom,
}

/// Smallest and largest tail probability.
const PROBABILITIES: [f32; 2] = [1e-12, 0.1];

/// Smallest and largest degrees of freedom of a chi-square, or of the numerator of an F.
const DEGREES: [f32; 2] = [1.0, 50.0];

/// Smallest degrees of freedom of the denominator: five samples for each of the two that Stirling's series wants.
const DENOMINATOR_FROM: f32 = 10.0;

/// z with P(Z > z) = `tail_probability`, for a standard normal Z. Relative error below 2e-6.
///
/// # Errors
/// [`QuantileError::TailProbability`] unless the tail probability lies in [1e-12, 0.1].
pub fn upper_normal(tail_probability: f32) -> Result<f32, QuantileError> {
    check_probability(tail_probability)?;
    // Z^2 has the chi-square distribution with one degree of freedom, and |Z| > z has both tails.
    Ok(libm::sqrtf(2.0 * Tail::chi_square(1.0).quantile(2.0 * tail_probability)))
}

/// x with P(X > x) = `tail_probability`, for X chi-square with the given degrees of freedom, which need not be whole.
/// Relative error below 2e-6.
///
/// # Errors
/// [`QuantileError::TailProbability`] unless the tail probability lies in [1e-12, 0.1];
/// [`QuantileError::DegreesOfFreedom`] unless they lie in [1, 50].
pub fn upper_chi_square(tail_probability: f32, degrees_of_freedom: f32) -> Result<f32, QuantileError> {
    check_probability(tail_probability)?;
    check_degrees(degrees_of_freedom)?;
    Ok(2.0 * Tail::chi_square(degrees_of_freedom).quantile(tail_probability))
}

/// x with P(X > x) = `tail_probability`, for X distributed as F(`numerator`, `denominator`), degrees of freedom which need
/// not be whole. Relative error below 1e-5.
///
/// # Errors
/// [`QuantileError::TailProbability`] unless the tail probability lies in [1e-12, 0.1];
/// [`QuantileError::DegreesOfFreedom`] unless the numerator's lie in [1, 50];
/// [`QuantileError::DenominatorDegreesOfFreedom`] unless the denominator's are finite and at least 10.
pub fn upper_f(tail_probability: f32, numerator: f32, denominator: f32) -> Result<f32, QuantileError> {
    check_probability(tail_probability)?;
    check_degrees(numerator)?;
    if !(denominator >= DENOMINATOR_FROM && denominator.is_finite()) {
        return Err(QuantileError::DenominatorDegreesOfFreedom);
    }
    Ok(2.0 * Tail::f(numerator, denominator).quantile(tail_probability) / numerator)
}

fn check_probability(p: f32) -> Result<(), QuantileError> {
    let [smallest, largest] = PROBABILITIES;
    if p >= smallest && p <= largest { Ok(()) } else { Err(QuantileError::TailProbability) }
}

fn check_degrees(degrees: f32) -> Result<(), QuantileError> {
    let [smallest, largest] = DEGREES;
    if degrees >= smallest && degrees <= largest { Ok(()) } else { Err(QuantileError::DegreesOfFreedom) }
}

#[cfg(test)]
mod tests;
