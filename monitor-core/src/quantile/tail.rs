//! The upper tail of the chi-square and F distributions, one expression for both.
//!
//! With b half the (numerator's) degrees of freedom and a half the denominator's, u = b F, or half the chi-square, has
//!
//! Q(u) = u^b (1 + u/a)^-(a+b) r(u) Gamma(a+b) / (Gamma(a) Gamma(b) a^b)
//!
//! where r is the continued fraction of DiDonato and Morris for the incomplete beta function (ACM TOMS 18(3), 1992,
//! algorithm 708, `bfrac`). It converges where b/a is small and u is beyond the mode, which upper tails are; for
//! 1/a = 0 it is Legendre's for the incomplete gamma function, and Q that of a chi-square; for b = 1 it ends after one
//! term, and Q is (1 + u/a)^-a. So the argument is 1/a, and a chi-square is an F whose 1/a is zero.
//!
//! The variable is t = a ln(1 + u/a), in which ln Q falls with a slope near minus one.

/// ln of the square root of 2 pi.
const LN_SQRT_TAU: f32 = 0.918_938_5;

/// Terms of the continued fraction. From 24 on the quantiles no longer change; 16 cost the normal quantile at p = 0.1 one
/// part in a million, and less elsewhere.
const TERMS: u8 = 24;

/// Newton's steps: four are enough from 3 to 50 over 10 degrees of freedom, where three leave 2e-4, and one is to spare.
/// Wilson and Hilferty's start is off by a third at worst, at one degree of freedom and p = 1e-12.
const STEPS: u8 = 5;

/// The tail of one distribution.
pub(super) struct Tail {
    /// b.
    half_degrees: f32,
    /// 1/a; zero for a chi-square.
    inverse: f32,
    /// ln of Gamma(a+b) / (Gamma(a) Gamma(b) a^b).
    log_norm: f32,
}

impl Tail {
    /// Of half a chi-square.
    pub(super) fn chi_square(degrees_of_freedom: f32) -> Self {
        let b = 0.5 * degrees_of_freedom;
        Tail { half_degrees: b, inverse: 0.0, log_norm: -ln_gamma(b) }
    }

    /// Of an F times half the numerator's degrees of freedom.
    pub(super) fn f(numerator: f32, denominator: f32) -> Self {
        let (a, b) = (0.5 * denominator, 0.5 * numerator);
        // ln Gamma(a+b) - ln Gamma(a) - b ln a by Stirling's series of both; b/a is small, so ln(1 + b/a) is what keeps the
        // digits.
        let growth = libm::log1pf(b / a);
        let ratio = a * growth - b + (b - 0.5) * growth + stirling(1.0 / (a + b)) - stirling(1.0 / a);
        Tail { half_degrees: b, inverse: 1.0 / a, log_norm: ratio - ln_gamma(b) }
    }

    /// u with Q(u) = p.
    pub(super) fn quantile(&self, p: f32) -> f32 {
        let goal = libm::logf(p);
        let mut t = self.start(goal);
        for _ in 0..STEPS {
            let at = self.at(t);
            t += (at.log_tail - goal) / at.hazard;
        }
        self.at(t).u
    }

    /// Wilson and Hilferty's cube root of a chi-square (1931), at a normal quantile good to 4.5e-4 (Abramowitz and
    /// Stegun 26.2.23).
    pub(super) fn start(&self, log_p: f32) -> f32 {
        let s = libm::sqrtf(-2.0 * log_p);
        let z = s
            - (2.515_517 + s * (0.802_853 + s * 0.010_328)) / (1.0 + s * (1.432_788 + s * (0.189_269 + s * 0.001_308)));
        let b = self.half_degrees;
        let root = 1.0 - 1.0 / (9.0 * b) + z / (3.0 * libm::sqrtf(b));
        b * root * root * root
    }

    fn at(&self, t: f32) -> Point {
        let (b, inverse) = (self.half_degrees, self.inverse);
        // u/a and u.
        let (w, u) = if inverse > 0.0 {
            let w = libm::expm1f(t * inverse);
            (w, w / inverse)
        } else {
            (0.0, t)
        };
        let r = self.fraction(w, u);
        let log_tail = b * libm::logf(u) - t - b * inverse * t + libm::logf(r) + self.log_norm;
        // The density of u over Q is 1 / (u r), and du/dt is 1 + w.
        Point { u, log_tail, hazard: (1.0 + w) / (u * r) }
    }

    /// r, from its last term backwards. Names of `bfrac`, whose a, b, x, y are ours, ours, 1/(1+w), w/(1+w).
    fn fraction(&self, w: f32, u: f32) -> f32 {
        let (b, i) = (self.half_degrees, self.inverse);
        let (x, y) = (1.0 / (1.0 + w), w / (1.0 + w));
        let lambda = (u - b) * x; // a - (a+b) x, without its cancellation
        let mut rest = 0.0;
        for n in (1..=TERMS).rev() {
            let n = f32::from(n);
            let before = 1.0 + (n - 1.0) * i;
            let middle = 1.0 / (1.0 + (2.0 * n - 1.0) * i);
            let alpha = before * (before + b * i) * middle * middle * n * (b - n) * x * x;
            let beta = n
                + n * (b - n) * x * i * middle
                + (1.0 + n * i) / (1.0 + (2.0 * n + 1.0) * i) * (1.0 + lambda + n * (1.0 + y));
            rest = alpha / (beta + rest);
        }
        1.0 / ((1.0 + lambda) / (1.0 + i) + rest)
    }
}

/// The tail at one t.
struct Point {
    u: f32,
    /// ln Q.
    log_tail: f32,
    /// -d ln Q / dt.
    hazard: f32,
}

/// ln Gamma(b) for b from one half: Stirling's series at b + 7, and the recurrence back.
fn ln_gamma(b: f32) -> f32 {
    let shifted = b + 7.0;
    let product = b * (b + 1.0) * (b + 2.0) * (b + 3.0) * (b + 4.0) * (b + 5.0) * (b + 6.0);
    (shifted - 0.5) * libm::logf(shifted) - shifted + LN_SQRT_TAU + stirling(1.0 / shifted) - libm::logf(product)
}

/// What Stirling's formula for ln Gamma(a) lacks, by 1/a up to 1/5; the first term left out is below 8e-9 there
/// (Abramowitz and Stegun 6.1.41).
pub(super) fn stirling(inverse: f32) -> f32 {
    let square = inverse * inverse;
    inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0)))
}
