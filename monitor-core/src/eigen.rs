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

use nalgebra::{SMatrix, SVector};

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

/// A symmetric matrix whose size has a closed form: 2x2 and 3x3. Only the lower triangle is read.
pub trait ClosedFormEigen<const N: usize> {
    /// Decomposes the matrix.
    ///
    /// # Errors
    /// [`EigenError::NonFinite`] when an entry is not finite.
    fn closed_form_eigen(&self) -> Result<Eigen<N>, EigenError>;
}

impl ClosedFormEigen<2> for SMatrix<f32, 2, 2> {
    fn closed_form_eigen(&self) -> Result<Eigen<2>, EigenError> {
        let [[a00, a10], [_, a11]] = self.data.0;
        if !(a00.is_finite() && a10.is_finite() && a11.is_finite()) {
            return Err(EigenError::NonFinite);
        }
        let scale = Scale::of([a00, a10, a11]);
        let rotation = diagonalize(scale.down(a00), scale.down(a10), scale.down(a11));
        let (c, s) = (rotation.cos, rotation.sin);
        Ok(Eigen {
            values: SVector::from([scale.up(rotation.larger), scale.up(rotation.smaller)]),
            vectors: SMatrix::from([[c, s], [-s, c]].map(with_sign)),
        })
    }
}

impl ClosedFormEigen<3> for SMatrix<f32, 3, 3> {
    fn closed_form_eigen(&self) -> Result<Eigen<3>, EigenError> {
        let [[a00, a10, a20], [_, a11, a21], [_, _, a22]] = self.data.0;
        if ![a00, a10, a20, a11, a21, a22].iter().all(|a| a.is_finite()) {
            return Err(EigenError::NonFinite);
        }
        // Step 1. A quarter of the deviator, by differences of eighths of the diagonal: these factors are exact, and an
        // entry of the deviator, up to 4/3 of the largest of the matrix, may be more than an f32 holds.
        const THIRD: f32 = 1.0 / 3.0;
        const TWO_THIRDS: f32 = 2.0 / 3.0;
        let mean = a00 * THIRD + a11 * THIRD + a22 * THIRD;
        let (e00, e11, e22) = (0.125 * a00, 0.125 * a11, 0.125 * a22);
        let (d01, d12, d20) = (e00 - e11, e11 - e22, e22 - e00);
        let diagonal = [(d01 - d20) * TWO_THIRDS, (d12 - d01) * TWO_THIRDS, (d20 - d12) * TWO_THIRDS];
        let [d00, d11, d22] = diagonal;
        let raw = [d00, 0.25 * a10, 0.25 * a20, d11, 0.25 * a21, d22];
        let scale = Scale::of(raw);
        let [s00, s10, s20, s11, s21, s22] = raw.map(|a| scale.down(a));

        // Step 2. The most isolated eigenvalue.
        let p2 = (0.5 * (s00 * s00 + s11 * s11 + s22 * s22) + (s10 * s10 + s20 * s20 + s21 * s21)) * THIRD;
        let p = libm::sqrtf(p2);
        let determinant = s00 * (s11 * s22 - s21 * s21) - s10 * (s10 * s22 - s20 * s21) + s20 * (s10 * s21 - s20 * s11);
        let two_p3 = 2.0 * p2 * p;
        let spherical = !(two_p3 > 0.0); // a multiple of the identity: every vector is an eigenvector
        let r = determinant / if spherical { 1.0 } else { two_p3 };
        let isolated = (2.0 * p * cosine_of_third(f32::min(r.abs(), 1.0))).copysign(r);

        // Step 3. Its eigenvector: the column of adj(S - isolated I) with the largest diagonal entry.
        let (m00, m11, m22) = (s00 - isolated, s11 - isolated, s22 - isolated);
        let adjugate = [
            [m11 * m22 - s21 * s21, s20 * s21 - s10 * m22, s10 * s21 - s20 * m11],
            [s20 * s21 - s10 * m22, m00 * m22 - s20 * s20, s10 * s20 - s21 * m00],
            [s10 * s21 - s20 * m11, s10 * s20 - s21 * m00, m00 * m11 - s10 * s10],
        ];
        let [c0, c1, c2] = adjugate;
        // (S - isolated I) has the other two eigenvalues both below or both above zero, so its adjugate is positive
        // semidefinite and the diagonal needs no magnitude.
        let (column, largest) = if c1[1] > c0[0] { (c1, c1[1]) } else { (c0, c0[0]) };
        let column = if c2[2] > largest { c2 } else { column };
        let first = normalize(if spherical { [0.0, 0.0, 1.0] } else { column });

        // Step 4. The rest, in the orthogonal complement.
        let (e, f) = complement(first);
        let (se, sf) = (apply([s00, s10, s20, s11, s21, s22], e), apply([s00, s10, s20, s11, s21, s22], f));
        let rotation = diagonalize(dot(e, se), dot(e, sf), dot(f, sf));
        let (c, s) = (rotation.cos, rotation.sin);
        let second = combine(c, e, s, f);
        let third = combine(c, f, -s, e);
        let (v2, v3) = (rotation.larger, rotation.smaller);

        // Step 5. First-order correction; the trace of a deviator is zero, which gives the isolated eigenvalue better.
        let v1 = -(v2 + v3);
        let (g_e, g_f) = (dot(first, se), dot(first, sf));
        let (to_second, to_third) = (c * g_e + s * g_f, c * g_f - s * g_e);
        let product = if spherical { 1.0 } else { (v1 - v2) * (v1 - v3) };
        let tilt2 = to_second * (v1 - v3) / product;
        let tilt3 = to_third * (v1 - v2) / product;
        let corrected = combine(1.0, first, 1.0, combine(tilt2, second, tilt3, third));
        let second = combine(1.0, second, -tilt2, first);
        let third = combine(1.0, third, -tilt3, first);

        let [a, b, c] = [v1, v2, v3].map(|v| mean + 4.0 * scale.up(v));
        // The isolated eigenvalue is the largest or the smallest.
        let (values, vectors) =
            if v1 >= v2 { ([a, b, c], [corrected, second, third]) } else { ([b, c, a], [second, third, corrected]) };
        Ok(Eigen { values: SVector::from(values), vectors: SMatrix::from(vectors.map(with_sign)) })
    }
}

/// cos(acos(u)/3) for u in [0, 1]: polynomial of degree 4, error 5e-6, by `tests/references/fit_cosine_third.py`.
#[inline(always)]
fn cosine_of_third(u: f32) -> f32 {
    0.866_030_45 + u * (0.166_411_73 + u * (-0.045_921_933 + u * (0.017_512_19 + u * -0.004_035_399)))
}

/// A rotation (cos, sin) that diagonalizes a 2x2 matrix: (cos, sin) belongs to `larger`, (-sin, cos) to `smaller`.
struct Rotation {
    larger: f32,
    smaller: f32,
    cos: f32,
    sin: f32,
}

/// Diagonalizes [[a, b], [b, c]], entries scaled to about one.
#[inline(always)]
fn diagonalize(a: f32, b: f32, c: f32) -> Rotation {
    let (d, x) = (a - c, 2.0 * b);
    let gap = libm::sqrtf(d * d + x * x);
    // Half-angle from the larger of the two candidates, |d| + gap, so that nothing cancels.
    let u = d.abs() + gap;
    let norm2 = u * u + x * x;
    let round = !(norm2 > 0.0); // equal eigenvalues: the axes themselves
    let inverse = 1.0 / libm::sqrtf(if round { 1.0 } else { norm2 });
    let major = if round { 1.0 } else { u * inverse };
    let minor = x * inverse;
    let shift = gap * (minor * minor);
    if d >= 0.0 {
        Rotation { larger: a + shift, smaller: c - shift, cos: major, sin: minor }
    } else {
        Rotation { larger: c + shift, smaller: a - shift, cos: minor.abs(), sin: major.copysign(x) }
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
fn apply([m00, m10, m20, m11, m21, m22]: [f32; 6], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [m00 * x + m10 * y + m20 * z, m10 * x + m11 * y + m21 * z, m20 * x + m21 * y + m22 * z]
}

#[inline(always)]
fn normalize(v: [f32; 3]) -> [f32; 3] {
    let inverse = 1.0 / libm::sqrtf(dot(v, v));
    v.map(|x| x * inverse)
}

/// The sign convention: the entry of largest magnitude is positive, the first of them when magnitudes tie.
#[inline(always)]
fn with_sign<const N: usize>(v: [f32; N]) -> [f32; N] {
    let leading = v.iter().fold(0.0_f32, |best, x| if x.abs() > best.abs() { *x } else { best });
    v.map(|x| if leading < 0.0 { -x } else { x })
}

/// A power of two that brings the largest entry to between one and two, and back, without rounding.
struct Scale {
    down: f32,
    up: f32,
}

impl Scale {
    #[inline(always)]
    fn of<const K: usize>(entries: [f32; K]) -> Scale {
        const MANTISSA_BITS: u32 = 23;
        let largest = entries.iter().fold(0, |m, a| u32::max(m, a.to_bits() & 0x7fff_ffff));
        // 254 - exponent must itself be the exponent of a normal number.
        let exponent = (largest >> MANTISSA_BITS).clamp(1, 253);
        Scale { down: f32::from_bits((254 - exponent) << MANTISSA_BITS), up: f32::from_bits(exponent << MANTISSA_BITS) }
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
