//! Exact cases and identities; the comparison with mpmath is in `tests/quantile_goldens.rs` of the workspace.

use super::*;
use proptest::prelude::*;

fn assert_near(found: f32, exact: f64, relative: f64) {
    assert!((f64::from(found) / exact - 1.0).abs() <= relative, "{found} for {exact}");
}

#[test]
fn two_degrees_of_freedom_have_their_closed_forms() {
    for p in [0.1_f32, 1e-2, 1e-5, 1e-12] {
        let log = libm::log(f64::from(p));
        assert_near(upper_chi_square(p, 2.0).unwrap(), -2.0 * log, 1e-6);
        for denominator in [10.0_f32, 37.5, 1e4, 1e6, 1e9] {
            let half = f64::from(denominator) / 2.0;
            assert_near(upper_f(p, 2.0, denominator).unwrap(), half * libm::expm1(-log / half), 2e-6);
        }
    }
}

/// Six of mpmath's goldens, so that this crate's own tests see every term of the continued fraction.
#[test]
fn f_quantiles_over_few_degrees_are_mpmaths() {
    for (p, numerator, denominator, exact) in [
        (0.01_f32, 1.0, 10.0, 10.0442894),
        (1e-6_f32, 1.0, 10.0, 110.596561),
        (0.01_f32, 3.0, 10.0, 6.5523126),
        (1e-6_f32, 3.0, 10.0, 60.8549051),
        (1e-6_f32, 3.0, 300.0, 10.7436371),
        (0.01_f32, 50.0, 10.0, 4.11545177),
    ] {
        assert_near(upper_f(p, numerator, denominator).unwrap(), exact, 5e-6);
    }
}

#[test]
fn arguments_out_of_range_are_refused_by_name() {
    for p in [0.0, -1e-3, 9e-13, 0.11, 1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(upper_normal(p), Err(QuantileError::TailProbability), "{p}");
        assert_eq!(upper_chi_square(p, 2.0), Err(QuantileError::TailProbability), "{p}");
        assert_eq!(upper_f(p, 2.0, 100.0), Err(QuantileError::TailProbability), "{p}");
    }
    for degrees in [0.0, -2.0, 0.99, 50.1, f32::NAN, f32::INFINITY] {
        assert_eq!(upper_chi_square(1e-3, degrees), Err(QuantileError::DegreesOfFreedom), "{degrees}");
        assert_eq!(upper_f(1e-3, degrees, 100.0), Err(QuantileError::DegreesOfFreedom), "{degrees}");
    }
    for degrees in [0.0, 9.9, -10.0, f32::NAN, f32::INFINITY] {
        assert_eq!(upper_f(1e-3, 2.0, degrees), Err(QuantileError::DenominatorDegreesOfFreedom), "{degrees}");
    }
    assert!(upper_f(1e-12, 50.0, f32::MAX).is_ok_and(f32::is_finite));
}

/// How far Wilson and Hilferty's cube root is from half the quantile, by the same formulas in double precision. Newton's
/// iteration makes up for a start that is off, so that no quantile would tell.
#[test]
fn the_iteration_starts_as_far_from_the_quantile_as_the_cube_root_is() {
    for (degrees, offs) in [
        (1.0, [-0.0244, -0.0071, 0.0711, 0.2214, 0.3493]),
        (3.0, [-0.0059, 0.0024, 0.0348, 0.1037, 0.1667]),
        (10.0, [-0.0011, 0.0014, 0.0114, 0.0357, 0.0603]),
        (50.0, [-0.0001, 0.0003, 0.0018, 0.0061, 0.0110]),
    ] {
        for (p, off) in [0.1_f32, 1e-2, 1e-4, 1e-8, 1e-12].into_iter().zip(offs) {
            let start = Tail::chi_square(degrees).start(libm::logf(p));
            let found = f64::from(start) / (0.5 * f64::from(upper_chi_square(p, degrees).unwrap())) - 1.0;
            assert!((found - off).abs() < 2e-4, "{found} for {off} at {degrees} degrees, p = {p:e}");
        }
    }
}

#[test]
fn what_stirlings_formula_lacks_at_five_is_known_to_1e_8() {
    // ln Gamma(5) = ln 24.
    let formula = 4.5 * libm::log(5.0) - 5.0 + 0.5 * libm::log(core::f64::consts::TAU);
    assert!((f64::from(tail::stirling(0.2)) - (libm::log(24.0) - formula)).abs() < 1e-8);
}

/// Tail probabilities over the whole range, evenly in their logarithm.
fn probability() -> impl Strategy<Value = f32> {
    (-27.6_f32..-2.31).prop_map(libm::expf)
}

proptest! {
    #[test]
    fn a_rarer_tail_begins_farther_out(p in probability(), d1 in 1.0_f32..=50.0, d2 in 10.0_f32..1e6) {
        let rarer = 0.99 * p;
        prop_assume!(rarer >= 1e-12);
        prop_assert!(upper_normal(rarer).unwrap() > upper_normal(p).unwrap());
        prop_assert!(upper_chi_square(rarer, d1).unwrap() > upper_chi_square(p, d1).unwrap());
        prop_assert!(upper_f(rarer, d1, d2).unwrap() > upper_f(p, d1, d2).unwrap());
    }

    #[test]
    fn a_chi_square_with_one_degree_of_freedom_is_a_squared_normal(p in probability()) {
        let z = f64::from(upper_normal(0.5 * p.max(2e-12)).unwrap());
        prop_assert!((f64::from(upper_chi_square(p.max(2e-12), 1.0).unwrap()) / (z * z) - 1.0).abs() <= 1e-6);
    }

    /// The normal quantile put into the tail that `libm` has in double precision gives its probability back.
    #[test]
    fn the_normal_tail_beyond_its_quantile_is_the_probability(p in probability()) {
        let z = f64::from(upper_normal(p).unwrap());
        let back = 0.5 * libm::erfc(z * core::f64::consts::FRAC_1_SQRT_2);
        // d ln p / d ln z is about z^2.
        prop_assert!((back / f64::from(p) - 1.0).abs() <= 1e-6 * (1.0 + z * z), "{back} for {p}");
    }

    #[test]
    fn an_f_with_ever_more_degrees_below_becomes_a_chi_square_over_its_degrees(p in probability(), d1 in 1.0_f32..=50.0) {
        let chi_square = upper_chi_square(p, d1).unwrap() / d1;
        let distances = [1e2, 1e4, 1e9].map(|d2| upper_f(p, d1, d2).unwrap() / chi_square - 1.0);
        prop_assert!(distances[0] > distances[1] && distances[1] > 0.0, "{distances:?}");
        prop_assert!(distances[2].abs() <= 4e-6, "{distances:?}");
    }

    #[test]
    fn the_mean_of_more_squares_has_its_tail_closer_in(p in probability(), d2 in 10.0_f32..1e6) {
        let quantiles = [1.0, 1.5, 2.0, 3.0, 10.0, 50.0].map(|d1| upper_f(p, d1, d2).unwrap());
        prop_assert!(quantiles.is_sorted_by(|a, b| a > b), "{quantiles:?}");
    }
}
