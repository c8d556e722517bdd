//! Closed-form eigen-decomposition of symmetric 2x2 and 3x3 matrices.
//!
//! No loop, no iteration, no trigonometry: the work does not depend on the data. Errors are relative to the norm of
//! the matrix; an eigenvalue that is tiny beside the largest has no relative accuracy of its own, in any closed form.
//!
//! # The 3x3 method, and why it keeps its digits when eigenvalues meet
//! 1. Subtract the mean eigenvalue q = trace/3. The deviator's diagonal is formed from *differences* of diagonal
//!    entries, so nothing cancels when the matrix is nearly a multiple of the identity (Harari and Albocher 2023).
//! 2. With p = sqrt(J2/3) and r = det/(2 p^3), the eigenvalue that lies furthest from the other two is
//!    sign(r) 2p g(|r|), g(u) = cos(acos(u)/3), which is smooth on [0, 1] where acos alone is not: a polynomial does.
//! 3. That eigenvalue is at least sqrt(3) p away from the others, so its eigenvector is well conditioned whatever the
//!    others do. It is the adjugate's column with the largest diagonal entry (Scherzinger and Dohrmann 2008).
//! 4. The other two live in its orthogonal complement, where a 2x2 problem settles them; if they are equal, any pair of
//!    orthonormal vectors is right and the 2x2 solver returns one.
//! 5. One first-order correction between the first vector and the other two removes what the polynomial and the
//!    adjugate left (the error after it is the square of the error before).
//!
//! Square roots enter only as reciprocals, so Newton's iteration gives them in a fixed number of products; choices are
//! selects, and sums of squares have a summand far below rounding in place of a case for zero. So every matrix takes the same
//! instructions: an audit of the linked firmware proves it.

use nalgebra::{SMatrix, SVector};

use crate::root::{reciprocal_sqrt, reciprocal_sqrt_rough};

/// Why a matrix has no decomposition here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EigenError {
    /// An entry is not finite.
    NonFinite,
}

/// Eigenvalues and eigenvectors of a symmetric matrix.
///
/// An eigenvalue that an `f32` cannot hold (entries near its largest) is infinite; the vectors are right all the same.
///
/// `values` descend. Column k of `vectors` belongs to `values[k]`; columns are orthonormal, and the entry of largest
/// magnitude in each is positive (the first of them when magnitudes tie).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigen<const N: usize> {
    /// Eigenvalues, descending.
    pub values: SVector<f32, N>,
    /// Eigenvectors, one a column.
    pub vectors: SMatrix<f32, N, N>,
}

/// A decomposition that has not been asked yet whether its matrix was finite: for that, [`Decomposition::checked`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decomposition<const N: usize> {
    eigen: Eigen<N>,
    finite: bool,
}

impl<const N: usize> Decomposition<N> {
    /// The decomposition.
    ///
    /// # Errors
    /// [`EigenError::NonFinite`] when an entry of the matrix was not finite.
    pub const fn checked(self) -> Result<Eigen<N>, EigenError> {
        if self.finite { Ok(self.eigen) } else { Err(EigenError::NonFinite) }
    }
}

/// A symmetric matrix whose size has a closed form: 2x2 and 3x3. Only the lower triangle is read.
///
/// The decompositions take the same instructions in the same order whatever the entries are.
pub trait ClosedFormEigen<const N: usize> {
    /// Decomposes the matrix.
    fn decompose(&self) -> Decomposition<N>;

    /// Decomposes a correlation matrix at about two thirds of the cost: its diagonal is taken for ones and not read, and
    /// no entry is larger, so nothing needs to be scaled.
    fn decompose_correlation(&self) -> Decomposition<N>;

    /// Decomposes the matrix.
    ///
    /// # Errors
    /// [`EigenError::NonFinite`] when an entry is not finite.
    fn closed_form_eigen(&self) -> Result<Eigen<N>, EigenError> {
        self.decompose().checked()
    }
}

impl ClosedFormEigen<2> for SMatrix<f32, 2, 2> {
    #[inline]
    fn decompose(&self) -> Decomposition<2> {
        let [[a00, a10], [_, a11]] = self.data.0;
        // Quarters, so that the sum of magnitudes does not overflow.
        let (a, b, c) = (0.25 * a00, 0.25 * a10, 0.25 * a11);
        let scale = Scale::of([a, b, c]);
        let pair = diagonalize(scale.down(a), scale.down(b), scale.down(c), false);
        let (c, s) = (pair.cos, pair.sin);
        let eigen = Eigen {
            values: SVector::from([pair.first, pair.second].map(|v| 4.0 * scale.up(v))),
            vectors: SMatrix::from([[c, s], [-s, c]].map(with_sign)),
        };
        Decomposition { eigen, finite: scale.finite }
    }

    #[inline]
    fn decompose_correlation(&self) -> Decomposition<2> {
        // No solver: 1 + |rho| belongs to (1, sign(rho))/sqrt(2), and 1 - |rho| to (1, -sign(rho))/sqrt(2), with the first
        // entry positive because magnitudes tie.
        const H: f32 = core::f32::consts::FRAC_1_SQRT_2;
        let [[_, rho], _] = self.data.0;
        let h = H.copysign(rho);
        let eigen = Eigen {
            values: SVector::from([1.0 + rho.abs(), 1.0 - rho.abs()]),
            vectors: SMatrix::from([[H, h], [H, -h]]),
        };
        Decomposition { eigen, finite: rho.is_finite() }
    }
}

impl ClosedFormEigen<3> for SMatrix<f32, 3, 3> {
    #[inline]
    fn decompose(&self) -> Decomposition<3> {
        let [[a00, a10, a20], [_, a11, a21], [_, _, a22]] = self.data.0;
        // Step 1. An eighth of the deviator, by differences of sixteenths of the diagonal: these factors are exact, and an
        // entry of the deviator, up to 4/3 of the largest of the matrix, may be more than an f32 holds.
        const THIRD: f32 = 1.0 / 3.0;
        const TWO_THIRDS: f32 = 2.0 / 3.0;
        let mean = a00 * THIRD + a11 * THIRD + a22 * THIRD;
        let (e00, e11, e22) = (0.0625 * a00, 0.0625 * a11, 0.0625 * a22);
        let (d01, d12, d20) = (e00 - e11, e11 - e22, e22 - e00);
        let diagonal = [(d01 - d20) * TWO_THIRDS, (d12 - d01) * TWO_THIRDS, (d20 - d12) * TWO_THIRDS];
        let [d00, d11, d22] = diagonal;
        let raw = [d00, 0.125 * a10, 0.125 * a20, d11, 0.125 * a21, d22];
        let scale = Scale::of(raw);
        let [s00, s10, s20, s11, s21, s22] = raw.map(|a| scale.down(a));
        let deviator = Deviator { diagonal: [s00, s11, s22], below: Below { s10, s20, s21 } };
        let eigen = decompose_deviator(&deviator, |v| mean + 8.0 * scale.up(v));
        Decomposition { eigen, finite: scale.finite }
    }

    #[inline]
    fn decompose_correlation(&self) -> Decomposition<3> {
        let [[_, s10, s20], [_, _, s21], _] = self.data.0;
        let eigen = decompose_deviator(&Below { s10, s20, s21 }, |v| 1.0 + v);
        // One entry that is not finite leaves no number in the result.
        Decomposition { eigen, finite: !eigen.values.x.is_nan() }
    }
}

/// Steps 2 to 5, for a symmetric matrix of trace zero with entries of about one at most; `value` turns its eigenvalues into
/// those of the whole matrix, in the same order.
#[inline(always)]
fn decompose_deviator(deviator: &impl Traceless, value: impl Fn(f32) -> f32) -> Eigen<3> {
    // Step 2. The most isolated eigenvalue.
    let p2 = deviator.half_square() * (1.0 / 3.0) + SMALL;
    let per_p = reciprocal_sqrt_rough(p2);
    let per_p2 = per_p * per_p;
    let r = deviator.half_determinant() * per_p * per_p2;
    let lowest = r.is_sign_negative(); // the isolated eigenvalue is the smallest of the three, else the largest
    let isolated = (2.0 * (p2 * per_p) * cosine_of_third(r.abs())).copysign(r);

    // Step 3. Its eigenvector: the column of adj(S - isolated I) with the largest diagonal entry. The other two
    // eigenvalues of (S - isolated I) are both above or both below zero, so its adjugate is positive semidefinite and the
    // diagonal needs no magnitude.
    let [[j00, j10, j20], [_, j11, j21], [_, _, j22]] = deviator.adjugate_less(isolated);
    let (column, largest) = (select3(j11 > j00, [j10, j11, j21], [j00, j10, j20]), select(j11 > j00, j11, j00));
    let column = select3(j22 > largest, [j20, j21, j22], column);
    let first = normalize(column.map(|x| x * per_p2));

    // Step 4. The rest, in the orthogonal complement.
    let (e, f) = complement(first);
    let (se, sf) = (deviator.times(e), deviator.times(f));
    let pair = diagonalize(dot(e, se), dot(e, sf), dot(f, sf), lowest);
    let (c, s) = (pair.cos, pair.sin);
    let middle = combine(c, e, s, f);
    let last = combine(c, f, -s, e);

    // Step 5. First-order correction; the trace of a deviator is zero, which gives the isolated eigenvalue better.
    let (v2, v3) = (pair.first, pair.second);
    let v1 = -(v2 + v3);
    let (g_e, g_f) = (dot(first, se), dot(first, sf));
    let (to_middle, to_last) = (c * g_e + s * g_f, c * g_f - s * g_e);
    let (gap2, gap3) = (v1 - v2, v1 - v3);
    let per_gaps = 1.0 / (gap2 * gap3 + SMALL_GAPS);
    let tilt2 = to_middle * gap3 * per_gaps;
    let tilt3 = to_last * gap2 * per_gaps;
    let corrected = combine(1.0, first, 1.0, combine(tilt2, middle, tilt3, last));
    let middle = combine(1.0, middle, -tilt2, first);
    let last = combine(1.0, last, -tilt3, first);

    let (highest_value, lowest_value) = (select(lowest, v3, v1), select(lowest, v1, v3));
    let (highest, lowest) = (select3(lowest, last, corrected), select3(lowest, corrected, last));
    Eigen {
        values: SVector::from([highest_value, v2, lowest_value].map(value)),
        vectors: SMatrix::from([highest, middle, lowest].map(with_sign)),
    }
}

/// What the method asks of a symmetric 3x3 matrix S of trace zero.
trait Traceless {
    /// Half the sum of squares of all entries: J2 of the literature.
    fn half_square(&self) -> f32;
    fn half_determinant(&self) -> f32;
    /// adj(S - shift I); the entries above the diagonal are not filled in.
    fn adjugate_less(&self, shift: f32) -> [[f32; 3]; 3];
    fn times(&self, v: [f32; 3]) -> [f32; 3];
}

/// The entries below the diagonal; alone, a matrix whose diagonal is zero.
#[derive(Clone, Copy)]
struct Below {
    s10: f32,
    s20: f32,
    s21: f32,
}

struct Deviator {
    diagonal: [f32; 3],
    below: Below,
}

impl Traceless for Below {
    #[inline(always)]
    fn half_square(&self) -> f32 {
        self.s10 * self.s10 + self.s20 * self.s20 + self.s21 * self.s21
    }

    #[inline(always)]
    fn half_determinant(&self) -> f32 {
        self.s10 * (self.s20 * self.s21)
    }

    #[inline(always)]
    fn adjugate_less(&self, shift: f32) -> [[f32; 3]; 3] {
        let Below { s10, s20, s21 } = *self;
        let shift2 = shift * shift;
        [
            [shift2 - s21 * s21, s20 * s21 + s10 * shift, s10 * s21 + s20 * shift],
            [0.0, shift2 - s20 * s20, s10 * s20 + s21 * shift],
            [0.0, 0.0, shift2 - s10 * s10],
        ]
    }

    #[inline(always)]
    fn times(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let Below { s10, s20, s21 } = *self;
        [s10 * y + s20 * z, s10 * x + s21 * z, s20 * x + s21 * y]
    }
}

impl Traceless for Deviator {
    #[inline(always)]
    fn half_square(&self) -> f32 {
        let [s00, s11, s22] = self.diagonal;
        0.5 * (s00 * s00 + s11 * s11 + s22 * s22) + self.below.half_square()
    }

    #[inline(always)]
    fn half_determinant(&self) -> f32 {
        let ([s00, s11, s22], Below { s10, s20, s21 }) = (self.diagonal, self.below);
        0.5 * (s00 * (s11 * s22 - s21 * s21) - s10 * (s10 * s22 - s20 * s21) + s20 * (s10 * s21 - s20 * s11))
    }

    #[inline(always)]
    fn adjugate_less(&self, shift: f32) -> [[f32; 3]; 3] {
        let Below { s10, s20, s21 } = self.below;
        let [m00, m11, m22] = self.diagonal.map(|s| s - shift);
        [
            [m11 * m22 - s21 * s21, s20 * s21 - s10 * m22, s10 * s21 - s20 * m11],
            [0.0, m00 * m22 - s20 * s20, s10 * s20 - s21 * m00],
            [0.0, 0.0, m00 * m11 - s10 * s10],
        ]
    }

    #[inline(always)]
    fn times(&self, v: [f32; 3]) -> [f32; 3] {
        let ([s00, s11, s22], [x, y, z], [a, b, c]) = (self.diagonal, v, self.below.times(v));
        [s00 * x + a, s11 * y + b, s22 * z + c]
    }
}

/// Added to what is divided by, so that a multiple of the identity, of which every vector is an eigenvector, needs no case
/// of its own. Beside a matrix of size one, a deviator of the size of its root (1e-9) is far below rounding.
const SMALL: f32 = 1e-18;

/// The same for the correction of step 5. Where `SMALL` makes the isolated eigenvector wrong, deviators below 1e-7, this
/// keeps the correction, and with it the deviation from orthonormal, below 3 SMALL/SMALL_GAPS = 3e-4 (of which the square
/// remains); there any orthonormal vectors are right to within rounding.
const SMALL_GAPS: f32 = 1e-14;

/// A choice that the compiler is asked not to make a branch of.
#[inline(always)]
fn select(condition: bool, yes: f32, no: f32) -> f32 {
    core::hint::select_unpredictable(condition, yes, no)
}

#[inline(always)]
fn select3(condition: bool, [a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [select(condition, a, x), select(condition, b, y), select(condition, c, z)]
}

/// cos(acos(u)/3) for u in [0, 1]: polynomial of degree 3, error 4e-5, by `tests/references/fit_cosine_third.py`. The
/// correction of step 5 leaves the square of it, 2e-9.
#[inline(always)]
fn cosine_of_third(u: f32) -> f32 {
    0.866_066_34 + u * (0.165_330_35 + u * (-0.040_691_197 + u * 0.009_319_684))
}

/// Eigenvalues of a 2x2 matrix, and the rotation that diagonalizes it: (cos, sin) belongs to `first`, (-sin, cos) to
/// `second`.
struct Pair {
    first: f32,
    second: f32,
    cos: f32,
    sin: f32,
}

/// Diagonalizes [[a, b], [b, c]], entries scaled to about one; the larger eigenvalue comes first, or the smaller.
#[inline(always)]
fn diagonalize(a: f32, b: f32, c: f32, smaller_first: bool) -> Pair {
    let (d, x) = (a - c, 2.0 * b);
    let gap2 = d * d + x * x;
    let gap = gap2 * reciprocal_sqrt(gap2);
    // Half-angle from the larger of the two candidates, |d| + gap, so that nothing cancels.
    // Where both are zero, eigenvalues are equal and the axes themselves will do.
    let u = d.abs() + gap + SMALL;
    let per_norm = reciprocal_sqrt(u * u + x * x);
    let (major, minor) = (u * per_norm, x * per_norm);
    let shift = (gap * (minor * minor)).copysign(d);
    let minor = f32::from_bits(minor.to_bits() ^ (d.to_bits() & SIGN));
    // (major, minor) is the eigenvector near the first axis, of the eigenvalue a + shift: the larger one if d is above zero.
    let (near_first, near_second) = (a + shift, c - shift);
    let in_order = d.is_sign_positive() != smaller_first;
    Pair {
        first: select(in_order, near_first, near_second),
        second: select(in_order, near_second, near_first),
        cos: select(in_order, major, -minor),
        sin: select(in_order, minor, major),
    }
}

/// Two unit vectors orthogonal to the unit vector `v` and to each other, without a branch (Duff et al. 2017).
#[inline(always)]
fn complement([x, y, z]: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let sign = 1.0_f32.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    ([1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y])
}

#[inline(always)]
fn dot([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> f32 {
    a * x + b * y + c * z
}

#[inline(always)]
fn combine(s: f32, [a, b, c]: [f32; 3], t: f32, [x, y, z]: [f32; 3]) -> [f32; 3] {
    [s * a + t * x, s * b + t * y, s * c + t * z]
}

#[inline(always)]
fn normalize(v: [f32; 3]) -> [f32; 3] {
    let per_norm = reciprocal_sqrt(dot(v, v));
    v.map(|x| x * per_norm)
}

/// The bit that holds the sign of an `f32`.
const SIGN: u32 = 1 << 31;

/// The sign convention: the entry of largest magnitude is positive, the first of them when magnitudes tie.
#[inline(always)]
fn with_sign<const N: usize>(v: [f32; N]) -> [f32; N] {
    let larger = |best: u32, bits: u32| core::hint::select_unpredictable(bits << 1 > best << 1, bits, best);
    let bits = v.map(f32::to_bits);
    let sign = bits.into_iter().reduce(larger).unwrap_or(0) & SIGN;
    bits.map(|bits| f32::from_bits(bits ^ sign))
}

/// A power of two that brings the sum of magnitudes to between one and two, and back, without rounding.
struct Scale {
    down: f32,
    up: f32,
    /// Whether every entry is.
    finite: bool,
}

impl Scale {
    /// The sum of the entries' magnitudes must not overflow.
    #[inline(always)]
    fn of<const K: usize>(entries: [f32; K]) -> Scale {
        const MANTISSA_BITS: u32 = 23;
        const NOT_FINITE: u32 = 255;
        let sum = entries.map(f32::abs).iter().fold(-0.0, |sum, a| sum + a);
        let exponent = sum.to_bits() >> MANTISSA_BITS & NOT_FINITE;
        let finite = exponent != NOT_FINITE;
        // 254 - exponent must itself be the exponent of a normal number.
        let exponent = exponent.clamp(1, 253);
        Scale {
            down: f32::from_bits((254 - exponent) << MANTISSA_BITS),
            up: f32::from_bits(exponent << MANTISSA_BITS),
            finite,
        }
    }

    #[inline(always)]
    fn down(&self, a: f32) -> f32 {
        a * self.down
    }

    #[inline(always)]
    fn up(&self, a: f32) -> f32 {
        a * self.up
    }
}

#[cfg(test)]
mod tests;
