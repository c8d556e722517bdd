//! Symmetric 3x3 matrices of trace zero: deviators, and correlation matrices less their ones, where products with the
//! diagonal are left out.

/// What the method asks of a symmetric 3x3 matrix S of trace zero.
pub(super) trait Traceless {
    /// Half the sum of squares of all entries: J2 of the literature.
    fn half_square(&self) -> f32;
    /// The determinant.
    fn determinant(&self) -> f32;
    /// adj(S - shift I); the entries above the diagonal are not filled in.
    fn adjugate_less(&self, shift: f32) -> [[f32; 3]; 3];
    /// S v.
    fn times(&self, v: [f32; 3]) -> [f32; 3];
    fn diagonal(&self) -> [f32; 3];
    fn below(&self) -> Below;
}

/// The entries below the diagonal; alone, a matrix whose diagonal is zero.
#[derive(Clone, Copy)]
pub(super) struct Below {
    pub(super) s10: f32,
    pub(super) s20: f32,
    pub(super) s21: f32,
}

/// The entries on and below the diagonal.
pub(super) struct Deviator {
    pub(super) diagonal: [f32; 3],
    pub(super) below: Below,
}

impl Traceless for Below {
    #[inline(always)]
    fn half_square(&self) -> f32 {
        self.s10 * self.s10 + self.s20 * self.s20 + self.s21 * self.s21
    }

    #[inline(always)]
    fn determinant(&self) -> f32 {
        let half = self.s10 * (self.s20 * self.s21);
        half + half
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

    #[inline(always)]
    fn diagonal(&self) -> [f32; 3] {
        [-0.0; 3] // x + -0.0 is x for every x, so additions of it are left out
    }

    #[inline(always)]
    fn below(&self) -> Below {
        *self
    }
}

impl Traceless for Deviator {
    #[inline(always)]
    fn half_square(&self) -> f32 {
        // The trace is zero, so the squares on the diagonal are minus twice the products that the determinant needs too.
        let ([s00, s11, s22], Below { s10, s20, s21 }) = (self.diagonal, self.below);
        (s21 * s21 - s11 * s22) + s00 * s00 + (s10 * s10 + s20 * s20)
    }

    #[inline(always)]
    fn determinant(&self) -> f32 {
        let ([s00, s11, s22], Below { s10, s20, s21 }) = (self.diagonal, self.below);
        let half = s10 * (s20 * s21);
        (half + half) - (s00 * (s21 * s21 - s11 * s22) + s11 * (s20 * s20) + s22 * (s10 * s10))
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

    #[inline(always)]
    fn diagonal(&self) -> [f32; 3] {
        self.diagonal
    }

    #[inline(always)]
    fn below(&self) -> Below {
        self.below
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    /// Every integer from -2 to 2 in each of the places.
    fn integers<const PLACES: usize>() -> impl Iterator<Item = [f32; PLACES]> {
        (0..5_u32.pow(PLACES as u32))
            .map(|k| core::array::from_fn(|place| (k / 5_u32.pow(place as u32) % 5) as f32 - 2.0))
    }

    /// On integers `f32` makes no error, so that each product is the definition's own.
    fn check(matrix: &impl Traceless, diagonal: [f32; 3], [s10, s20, s21]: [f32; 3]) {
        let [s00, s11, s22] = diagonal;
        let full = Matrix3::new(s00, s10, s20, s10, s11, s21, s20, s21, s22);
        let below = matrix.below();
        assert_eq!((matrix.diagonal(), [below.s10, below.s20, below.s21]), (diagonal, [s10, s20, s21]));
        assert_eq!(matrix.half_square(), 0.5 * full.norm_squared(), "{full}");
        assert_eq!(matrix.determinant(), determinant(&full), "{full}");
        assert_eq!(Vector3::from(matrix.times([2.0, -3.0, 7.0])), full * Vector3::new(2.0, -3.0, 7.0), "{full}");
        for shift in [-3.0, 1.0, 2.0] {
            let [[j00, j10, j20], [_, j11, j21], [_, _, j22]] = matrix.adjugate_less(shift);
            let adjugate = Matrix3::new(j00, j10, j20, j10, j11, j21, j20, j21, j22);
            let shifted = full - Matrix3::identity() * shift;
            assert_eq!(shifted * adjugate, Matrix3::identity() * determinant(&shifted), "{full} less {shift}");
        }
    }

    /// By the rule of Sarrus.
    fn determinant(m: &Matrix3<f32>) -> f32 {
        let diagonals = |step: usize| -> f32 {
            (0..3).map(|k| (0..3).map(|row| m[(row, (k + step * row) % 3)]).product::<f32>()).sum()
        };
        diagonals(1) - diagonals(2)
    }

    #[test]
    fn matrices_without_a_diagonal_have_the_invariants_products_and_adjugate_of_the_definitions() {
        for below @ [s10, s20, s21] in integers() {
            check(&Below { s10, s20, s21 }, [0.0; 3], below);
        }
    }

    #[test]
    fn deviators_have_the_invariants_products_and_adjugate_of_the_definitions() {
        for [s00, s11, s10, s20, s21] in integers() {
            let diagonal = [s00, s11, -s00 - s11];
            check(&Deviator { diagonal, below: Below { s10, s20, s21 } }, diagonal, [s10, s20, s21]);
        }
    }
}
