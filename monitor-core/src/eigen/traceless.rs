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
