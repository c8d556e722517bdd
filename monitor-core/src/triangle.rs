//! A quadratic form as the squared length of an upper triangle: |U d|^2 costs half the products of the full matrix.

use crate::root::reciprocal_sqrt;

/// An upper triangle U, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle<const N: usize>([[f32; N]; N]);

impl<const N: usize> Triangle<N> {
    /// The triangle with the lengths of `rows`: |U d| = |rows d| for every d.
    ///
    /// rows = Q U with Q orthonormal, and Q does not change a length. A row of zeros costs nothing and counts for nothing.
    pub(crate) fn of_rows(mut rows: [[f32; N]; N]) -> Self {
        for column in 0..N {
            for below in column + 1..N {
                let (upper, lower) = rows.split_at_mut(below);
                if let (Some(upper), Some(lower)) = (upper.get_mut(column), lower.first_mut()) {
                    rotate(upper, lower, column);
                }
            }
        }
        Triangle(rows)
    }

    /// U, row by row.
    pub(crate) const fn rows(&self) -> [[f32; N]; N] {
        self.0
    }

    /// Rows that are an upper triangle already.
    pub(crate) const fn from_upper(rows: [[f32; N]; N]) -> Self {
        Triangle(rows)
    }

    /// Multiplies each row by a factor.
    pub(crate) fn scale_rows(&mut self, factors: [f32; N]) {
        for (row, factor) in self.0.iter_mut().zip(factors) {
            row.iter_mut().for_each(|cell| *cell *= factor);
        }
    }

    /// U d.
    #[inline(always)]
    pub(crate) fn times(&self, d: [f32; N]) -> [f32; N] {
        // All products, then all sums: a floating-point result can be used only after a cycle. Sums begin at -0.0, the one
        // number that added to any other leaves it as it is, so no instruction is spent on it.
        let mut products = [[-0.0; N]; N];
        for (k, (products, row)) in products.iter_mut().zip(&self.0).enumerate() {
            for (j, (product, (u, d))) in products.iter_mut().zip(row.iter().zip(d)).enumerate() {
                if j >= k {
                    *product = u * d;
                }
            }
        }
        products.map(|row| row.iter().fold(-0.0, |sum, product| sum + product))
    }

    /// |U d|^2.
    #[inline(always)]
    pub(crate) fn square_of(&self, d: [f32; N]) -> f32 {
        square(self.times(d))
    }
}

/// A triangle without the zeros below its diagonal, for keeping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Packed([f32; 6]);

impl Packed {
    #[inline(always)]
    pub(crate) const fn of(triangle: &Triangle<3>) -> Self {
        let Triangle([[a, b, c], [_, d, e], [_, _, f]]) = *triangle;
        Packed([a, b, c, d, e, f])
    }

    pub(crate) const fn cells(&mut self) -> &mut [f32; 6] {
        &mut self.0
    }

    #[inline(always)]
    pub(crate) const fn unpacked(&self) -> Triangle<3> {
        let Packed([a, b, c, d, e, f]) = *self;
        Triangle([[a, b, c], [0.0, d, e], [0.0, 0.0, f]])
    }
}

/// |v|^2.
#[inline(always)]
pub(crate) fn square<const N: usize>(v: [f32; N]) -> f32 {
    v.map(|v| v * v).iter().fold(-0.0, |sum, square| sum + square)
}

/// a'b.
#[inline(always)]
pub(crate) fn inner<const N: usize>(a: [f32; N], b: [f32; N]) -> f32 {
    a.iter().zip(b).fold(-0.0, |sum, (a, b)| sum + a * b)
}

/// Rotates two rows so that `lower` becomes zero in a column (Givens). Slices, and never inlined: once in flash for models of
/// two and of three channels, where time is not dear.
#[inline(never)]
fn rotate(upper: &mut [f32], lower: &mut [f32], column: usize) {
    let (Some(p), Some(q)) = (upper.get(column).copied(), lower.get(column).copied()) else { return };
    let larger = f32::max(p.abs(), q.abs());
    // Where both are zero there is nothing to rotate.
    let (p, q) = if larger > 0.0 { (p / larger, q / larger) } else { (1.0, 0.0) };
    let per_length = reciprocal_sqrt(p * p + q * q);
    let (cos, sin) = (p * per_length, q * per_length);
    for (a, b) in upper.iter_mut().zip(lower.iter_mut()) {
        (*a, *b) = (cos * *a + sin * *b, cos * *b - sin * *a);
    }
    if let Some(cell) = lower.get_mut(column) {
        *cell = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_triangle_has_the_lengths_of_the_rows_it_was_made_of(
            rows in prop::array::uniform3(prop::array::uniform3(-3.0_f32..3.0)),
            d in prop::array::uniform3(-10.0_f32..10.0), zero_row in 0_usize..4,
        ) {
            let mut rows = rows;
            if let Some(row) = rows.get_mut(zero_row) {
                *row = [0.0; 3];
            }
            let Triangle([_, second, third]) = Triangle::of_rows(rows);
            prop_assert_eq!([second[0], third[0], third[1]], [0.0; 3]);
            let exact = square(rows.map(|row| inner(row, d)));
            let found = Triangle::of_rows(rows).square_of(d);
            prop_assert!((found - exact).abs() <= 1e-4 * exact + 1e-4, "{} for {}", found, exact);
        }
    }
}
