//! Closed-form eigen-decomposition of symmetric 2x2 and 3x3 matrices.
//!
//! No loop, no iteration, no trigonometry: the work does not depend on the data. Errors are relative to the norm of
//! the matrix; an eigenvalue that is tiny beside the largest has no relative accuracy of its own, in any closed form.
//!
//! # The 3x3 method, and why it keeps its digits when eigenvalues meet
//! 1. Subtract the mean eigenvalue q = trace/3. The deviator's diagonal is formed from *differences* of diagonal
//!    entries, so nothing cancels when the matrix is nearly a multiple of the identity (Harari and Albocher 2023).
//! 2. With p = sqrt(J2/3) and r = det/(2 p^3), the eigenvalue that lies furthest from the other two is
//!    sign(r) 2p g(|r|), g(u) = cos(acos(u)/3), which is smooth on [0, 1] where acos alone is not: a polynomial of degree
//!    three does. It takes the constants between J2 and p in, so that neither is multiplied by them. The root is simple and
//!    far from the others, so one step of Newton's on the characteristic polynomial brings it to rounding.
//! 3. That eigenvalue is at least sqrt(3) p away from the others, so its eigenvector is well conditioned whatever the
//!    others do. It is the adjugate's column with the largest diagonal entry (Scherzinger and Dohrmann 2008).
//! 4. A Householder reflection makes that eigenvector an axis; the other two eigenvectors are a rotation in the plane
//!    across it, where Mohr's circle settles a 2x2 problem. If they are equal, any rotation is right. The trace of the
//!    deviator is zero, so the centre of the circle is known.
//!
//! What error step 3 leaves turns the three vectors together: a reflection and a rotation keep them orthonormal, and the
//! eigenvalues of the plane feel its square alone.
//!
//! Square roots enter only as reciprocals, so Newton's iteration gives them in a fixed number of products; choices are
//! selects, and sums of squares have a summand far below rounding in place of a case for zero. So every matrix takes the same
//! instructions: an audit of the linked firmware proves it. `NUMERICS.md` says what takes how many.

use nalgebra::{SMatrix, SVector};

use crate::root::{reciprocal_sqrt_of_twice, reciprocal_sqrt_of_twice_rough};

mod traceless;
use traceless::{Below, Deviator, Traceless};

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
pub struct Decomposition<const N: usize>(Eigen<N>);

impl Eigen<3> {
    /// The same with right-handed vectors: where the determinant of `vectors` is negative, the last column is turned about,
    /// and the entry of largest magnitude in it is then negative.
    #[must_use]
    pub fn right_handed(mut self) -> Self {
        let [first, middle, last] = self.vectors.data.0;
        let hand = 1.0_f32.copysign(dot(cross(first, middle), last));
        self.vectors.set_column(2, &SVector::from(last.map(|x| hand * x)));
        self
    }
}

impl<const N: usize> Decomposition<N> {
    /// The decomposition.
    ///
    /// # Errors
    /// [`EigenError::NonFinite`] when an entry of the matrix was not finite.
    pub const fn checked(self) -> Result<Eigen<N>, EigenError> {
        let [values] = &self.0.values.data.0;
        match values.as_slice() {
            // One entry that is not finite leaves no number in the result.
            [first, ..] if first.is_nan() => Err(EigenError::NonFinite),
            _ => Ok(self.0),
        }
    }
}

/// A symmetric matrix whose size has a closed form: 2x2 and 3x3. Only the lower triangle is read.
///
/// The decompositions take the same instructions in the same order whatever the entries are.
pub trait ClosedFormEigen<const N: usize> {
    /// Decomposes the matrix.
    fn decompose(&self) -> Decomposition<N>;

    /// Decomposes a correlation matrix at about five sixths of the cost: its diagonal is taken for ones and not read, and
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
        let scale = Scale::of([a00, a10, a11]);
        let (a, b, c) = (a00 * scale.down, a10 * scale.down, a11 * scale.down);
        let pair = diagonalize(0.5 * (a - c), b, 0.5 * (a + c), LARGER_FIRST);
        Decomposition(Eigen {
            values: SVector::from([pair.first, pair.second].map(|v| v * scale.up)),
            vectors: SMatrix::from(rotation_with_signs([pair.cos, pair.sin])),
        })
    }

    #[inline]
    fn decompose_correlation(&self) -> Decomposition<2> {
        // No solver: 1 + |rho| belongs to (1, sign(rho))/sqrt(2), and 1 - |rho| to (1, -sign(rho))/sqrt(2), with the first
        // entry positive because magnitudes tie.
        const H: f32 = core::f32::consts::FRAC_1_SQRT_2;
        let [[_, rho], _] = self.data.0;
        let h = H.copysign(rho);
        let no_number_unless_finite = 0.0 * rho;
        Decomposition(Eigen {
            values: SVector::from([1.0 + rho.abs() + no_number_unless_finite, 1.0 - rho.abs()]),
            vectors: SMatrix::from([[H, h], [H, -h]]),
        })
    }
}

impl ClosedFormEigen<3> for SMatrix<f32, 3, 3> {
    #[inline]
    fn decompose(&self) -> Decomposition<3> {
        let [[a00, a10, a20], [_, a11, a21], [_, _, a22]] = self.data.0;
        let scale = Scale::of([a00, a10, a20, a11, a21, a22]);
        // Step 1. Three times the deviator needs no division: 3 (a00 - trace/3) = (a00 - a11) - (a22 - a00).
        let (t00, t11, t22) = (a00 * scale.down, a11 * scale.down, a22 * scale.down);
        let (d01, d12, d20) = (t00 - t11, t11 - t22, t22 - t00);
        let down = 3.0 * scale.down;
        let below = Below { s10: a10 * down, s20: a20 * down, s21: a21 * down };
        let (trace, up) = (t00 + t11 + t22, scale.up * (1.0 / 3.0));
        decompose_deviator(&Deviator { diagonal: [d01 - d20, d12 - d01, d20 - d12], below }, |v| (trace + v) * up)
    }

    #[inline]
    fn decompose_correlation(&self) -> Decomposition<3> {
        let [[_, s10, s20], [_, _, s21], _] = self.data.0;
        decompose_deviator(&Below { s10, s20, s21 }, |v| 1.0 + v)
    }
}

/// Steps 2 to 4, for a symmetric matrix S of trace zero with entries of about one; `value` turns its eigenvalues into those
/// of the whole matrix, in the same order.
#[inline(always)]
fn decompose_deviator(deviator: &impl Traceless, value: impl Fn(f32) -> f32) -> Decomposition<3> {
    // Step 2. The most isolated eigenvalue, from |S| = sqrt(2 J2).
    let (j2, determinant) = (deviator.half_square() + SMALL, deviator.determinant());
    let per_norm = reciprocal_sqrt_of_twice_rough(j2);
    let r = determinant * per_norm * (per_norm * per_norm);
    let order = r.to_bits() & SIGN; // set if the isolated eigenvalue is the smallest of the three, else it is the largest
    let v1 = with_bit(j2 * per_norm * isolation(r.abs()), order);
    let v1 = newton(v1, j2, determinant);

    // Step 3. Its eigenvector: the column of adj(S - isolated I) with the largest diagonal entry. The other two
    // eigenvalues of (S - isolated I) are both above or both below zero, so its adjugate is positive semidefinite and the
    // diagonal needs no magnitude.
    let [[j00, j10, j20], [_, j11, j21], [_, _, j22]] = deviator.adjugate_less(v1);
    let (column, largest) = (select3(j11 > j00, [j10, j11, j21], [j00, j10, j20]), select(j11 > j00, j11, j00));
    let column = select3(j22 > largest, [j20, j21, j22], column);
    let mirror = Reflection::of(column);

    // Step 4. The other two, in the frame where that vector is the third axis.
    let (half_difference, off_diagonal) = mirror.across(deviator);
    let pair = diagonalize(half_difference, off_diagonal, -0.5 * v1, order); // the trace of S is zero
    let (c, s, v2, v3) = (pair.cos, pair.sin, pair.first, pair.second);
    let (first, middle, last) = (mirror.v, mirror.reflect([c, s]), mirror.reflect([-s, c]));

    let lowest = order != 0;
    let (highest_value, lowest_value) = (select(lowest, v3, v1), select(lowest, v1, v3));
    let (highest, lowest) = (select3(lowest, last, first), select3(lowest, first, last));
    Decomposition(Eigen {
        values: SVector::from([highest_value, v2, lowest_value].map(value)),
        vectors: SMatrix::from([highest, middle, lowest].map(with_sign)),
    })
}

/// Newton's step for the isolated root of v^3 - j2 v - determinant: of an error of 1e-4 it leaves 1e-8.
#[inline(always)]
fn newton(v: f32, j2: f32, determinant: f32) -> f32 {
    let square = v * v;
    let difference = square - j2;
    v - (v * difference - determinant) / (difference + (square + square))
}

/// The reflection I - w2 w w' that takes the third axis to minus the unit vector v, with w = (v + (0, 0, 1))/w2: its third
/// entry is one.
struct Reflection {
    v: [f32; 3],
    w: [f32; 2],
    w2: f32,
}

impl Reflection {
    /// That of the unit vector along `column`, turned about if need be so that nothing cancels in w2.
    #[inline(always)]
    fn of(column: [f32; 3]) -> Reflection {
        let per_norm = reciprocal_sqrt_of_twice(0.5 * dot(column, column), column[2].to_bits() & SIGN);
        let v @ [x, y, z] = column.map(|entry| entry * per_norm);
        let w2 = 1.0 + z;
        let per_w2 = 1.0 / w2;
        Reflection { v, w: [x * per_w2, y * per_w2], w2 }
    }

    /// Half the difference of the diagonal and the entry below it, of the block that S leaves across v: it is the leading one
    /// of S - v q' - q v', where q = S w - v (w' S w)/2 (as LAPACK's `ssytd2` updates it).
    #[inline(always)]
    fn across(&self, matrix: &impl Traceless) -> (f32, f32) {
        let ([s00, s11, _], [v0, v1, _], [w0, w1]) = (matrix.diagonal(), self.v, self.w);
        let [p0, p1, p2] = matrix.times([w0, w1, 1.0]);
        let half = 0.5 * (w0 * p0 + w1 * p1 + p2);
        let (q0, q1) = (p0 - v0 * half, p1 - v1 * half);
        ((v1 * q1 - v0 * q0) - 0.5 * (s11 - s00), matrix.below().s10 - (v0 * q1 + v1 * q0))
    }

    /// The image of a vector across the third axis.
    #[inline(always)]
    fn reflect(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let ([v0, v1, _], [w0, w1]) = (self.v, self.w);
        let along = w0 * x + w1 * y;
        [x - along * v0, y - along * v1, -(along * self.w2)]
    }
}

/// Added to what is divided by, so that a multiple of the identity, of which every vector is an eigenvector, needs no case
/// of its own. Beside a matrix of size one, a deviator of the size of its root (1e-9) is far below rounding.
const SMALL: f32 = 1e-18;

/// A choice that the compiler is asked not to make a branch of.
#[inline(always)]
fn select(condition: bool, yes: f32, no: f32) -> f32 {
    core::hint::select_unpredictable(condition, yes, no)
}

#[inline(always)]
fn select3(condition: bool, [a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [select(condition, a, x), select(condition, b, y), select(condition, c, z)]
}

/// The isolated eigenvalue of a traceless matrix in units of |S|/2, for u = |det S|/|S|^3 in [0, 54^-0.5]: that is
/// 4/sqrt(6) cos(acos(54^0.5 u)/3). Polynomial of degree 3, error 8e-5, by `tests/references/fit_cosine_third.py`; Newton's
/// step leaves the square of it, some 1e-8.
#[inline(always)]
fn isolation(u: f32) -> f32 {
    1.414_280_4 + u * (1.983_964_2 + u * (-3.588_216 + u * 6.039_155))
}

/// Eigenvalues of a 2x2 matrix, and the rotation that diagonalizes it: (cos, sin) belongs to `first`, (-sin, cos) to
/// `second`.
struct Pair {
    first: f32,
    second: f32,
    cos: f32,
    sin: f32,
}

/// What [`diagonalize`] puts first; [`SIGN`] stands for the smaller one.
const LARGER_FIRST: u32 = 0;

/// Diagonalizes [[centre + d, b], [b, centre - d]], entries scaled to about one.
#[inline(always)]
fn diagonalize(d: f32, b: f32, centre: f32, order: u32) -> Pair {
    // Mohr's circle: eigenvalues are its centre plus and minus its radius, and (d, b)/radius is (cos, sin) of the angle it
    // shows, twice that of the eigenvectors. With a radius below zero the smaller eigenvalue comes first.
    let along = d.abs() + SMALL; // where both are zero, the axes themselves will do
    let radius2 = along * along + b * b;
    let per_radius = reciprocal_sqrt_of_twice(0.5 * radius2, order);
    let radius = radius2 * per_radius;
    let (cos2, sin2) = ((along * per_radius).abs(), b * per_radius);
    // Half the angle, between the eigenvector and the axis that is nearer to it, so that nothing cancels.
    let per_norm = reciprocal_sqrt_of_twice(1.0 + cos2, 0);
    let (major, minor) = ((1.0 + cos2) * per_norm, sin2 * per_norm);
    let second_axis = (d.to_bits() ^ order) & SIGN != 0;
    Pair {
        first: centre + radius,
        second: centre - radius,
        cos: select(second_axis, minor, major),
        sin: select(second_axis, major, minor),
    }
}

#[inline(always)]
fn dot([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> f32 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// The bit that holds the sign of an `f32`.
const SIGN: u32 = 1 << 31;

/// `x` with the bit of its sign, which is not set yet, from `sign`.
#[inline(always)]
fn with_bit(x: f32, sign: u32) -> f32 {
    f32::from_bits(x.to_bits() | sign)
}

/// The sign convention: the entry of largest magnitude is positive, the first of them when magnitudes tie.
#[inline(always)]
fn with_sign<const N: usize>(v: [f32; N]) -> [f32; N] {
    let larger = |best: u32, bits: u32| core::hint::select_unpredictable(bits << 1 > best << 1, bits, best);
    let bits = v.map(f32::to_bits);
    let sign = bits.into_iter().reduce(larger).unwrap_or(0) & SIGN;
    bits.map(|bits| f32::from_bits(bits ^ sign))
}

/// The columns (cos, sin) and (-sin, cos) with the same convention: one comparison settles both.
#[inline(always)]
fn rotation_with_signs(column: [f32; 2]) -> [[f32; 2]; 2] {
    let first @ [c, s] = with_sign(column);
    let (c, s) = (c.to_bits(), s.to_bits());
    // The larger of c and s is positive by now. Across, either s comes to stand first and leads, or c leads.
    let turn = core::hint::select_unpredictable(s << 1 >= c << 1, s & SIGN, SIGN);
    [first, [s ^ turn, c ^ turn ^ SIGN].map(f32::from_bits)]
}

/// A power of two that brings the sum of magnitudes to between four and eight, and back, without rounding.
struct Scale {
    down: f32,
    up: f32,
}

impl Scale {
    #[inline(always)]
    fn of<const K: usize>(entries: [f32; K]) -> Scale {
        const ONE: u32 = 1 << 23; // added to the bits of a number, doubles it
        const EXPONENT: u32 = 255 * ONE;
        let sum = entries.map(f32::abs).iter().fold(-0.0, |sum, a| sum + a);
        // Not below four, for `up` to be normal. A sum that overflows counts as twice the largest f32.
        let exponent = (sum.to_bits() & EXPONENT).max(4 * ONE);
        // The exponents of both add up to 254, twice that of one.
        Scale { down: f32::from_bits((256 * ONE).wrapping_sub(exponent)), up: f32::from_bits(exponent - 2 * ONE) }
    }
}

#[cfg(test)]
mod tests;
