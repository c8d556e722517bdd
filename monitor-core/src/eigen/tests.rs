//! The solver against nalgebra's iterative one in `f64`, over the matrices that break closed forms.

use super::*;
use nalgebra::{Matrix2, Matrix3, Vector3};
use proptest::prelude::*;

/// Bounds in units of eps(f32) times the norm: the worst of the matrices below was 1.8, 4.2 and 2.6.
const VALUE_EPS: f64 = 4.0;
const ORTHOGONALITY_EPS: f64 = 8.0;
const RESIDUAL_EPS: f64 = 8.0;
/// What rounding to the smallest `f32` leaves of matrices of that size: their values, and products with them, are no finer.
const SUBNORMAL: f64 = f32::from_bits(1) as f64;

fn check<const N: usize>(matrix: SMatrix<f32, N, N>)
where
    SMatrix<f32, N, N>: ClosedFormEigen<N>,
{
    check_against(matrix, &matrix.closed_form_eigen().unwrap());
}

/// The cheaper method for correlation matrices, and the general one.
fn check_correlation<const N: usize>(matrix: SMatrix<f32, N, N>)
where
    SMatrix<f32, N, N>: ClosedFormEigen<N>,
{
    check(matrix);
    check_against(matrix, &matrix.decompose_correlation().checked().unwrap());
}

fn check_against<const N: usize>(matrix: SMatrix<f32, N, N>, found: &Eigen<N>) {
    let exact = matrix.cast::<f64>();
    // A power of two keeps f64 products of tiny entries away from underflow.
    let norm = exact.norm().max(f64::MIN_POSITIVE);
    let eps = f64::from(f32::EPSILON);
    let (values, vectors) = (found.values.cast::<f64>(), found.vectors.cast::<f64>());

    let mut reference: std::vec::Vec<f64> = jacobi(exact);
    reference.sort_by(|a, b| b.total_cmp(a));
    for (value, reference) in values.iter().zip(&reference) {
        assert!(
            (value - reference).abs() <= VALUE_EPS * eps * norm + SUBNORMAL,
            "{matrix}: {value:e} for {reference:e}"
        );
    }
    let gram = vectors.transpose() * vectors - SMatrix::<f64, N, N>::identity();
    assert!(gram.amax() <= ORTHOGONALITY_EPS * eps, "{matrix}: not orthonormal by {:e}", gram.amax());
    let residual = exact * vectors - vectors * SMatrix::<f64, N, N>::from_diagonal(&values);
    assert!(
        residual.amax() <= RESIDUAL_EPS * eps * norm + SUBNORMAL,
        "{matrix}: residual {:e}",
        residual.amax() / norm
    );
    for k in 0..N {
        assert!(k == 0 || found.values[k - 1] >= found.values[k], "{matrix}: values do not descend");
        let column = found.vectors.column(k);
        let leading = column.iter().fold(0.0_f32, |best, x| if x.abs() > best.abs() { *x } else { best });
        assert!(leading > 0.0, "{matrix}: the sign of vector {k} is not fixed");
    }
}

extern crate std;

/// Eigenvalues by cyclic Jacobi rotations in f64: an independent method that cannot fail on these sizes.
fn jacobi<const N: usize>(mut a: SMatrix<f64, N, N>) -> std::vec::Vec<f64> {
    for _ in 0..30 {
        for p in 0..N {
            for q in p + 1..N {
                if a[(p, q)] == 0.0 {
                    continue;
                }
                let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
                let t = theta.signum() / (theta.abs() + libm::hypot(theta, 1.0));
                let c = 1.0 / libm::hypot(t, 1.0);
                let s = t * c;
                let mut rotation = SMatrix::<f64, N, N>::identity();
                (rotation[(p, p)], rotation[(q, q)], rotation[(p, q)], rotation[(q, p)]) = (c, c, s, -s);
                a = rotation.transpose() * a * rotation;
            }
        }
    }
    a.diagonal().iter().copied().collect()
}

/// Random orthogonal-similarity transform of given eigenvalues, from three angles.
fn from_values(values: [f64; 3], angles: [f64; 3]) -> Matrix3<f32> {
    let rotation = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
    let v = rotation.matrix();
    let a = v * Matrix3::from_diagonal(&values.into()) * v.transpose();
    ((a + a.transpose()) * 0.5).cast::<f32>()
}

fn angles() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.2..3.2_f64)
}

#[test]
fn every_matrix_with_small_integer_entries_is_decomposed() {
    // 5^6 matrices: repeated, zero, negative and block eigenvalues in every arrangement.
    let entry = |k: u32, place: u32| (k / 5_u32.pow(place) % 5) as f32 - 2.0;
    for k in 0..5_u32.pow(6) {
        let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|place| entry(k, place));
        check(Matrix3::new(a, b, c, b, d, e, c, e, f));
        if e == -2.0 && f == -2.0 && d == -2.0 {
            check(Matrix2::new(a, b, b, c));
        }
    }
}

#[test]
fn correlation_matrices_from_independent_to_perfectly_tied_are_decomposed() {
    let rho =
        [-1.0, -0.999_999_9, -0.999, -0.5, -1e-4, -0.0, 0.0, 1e-30, 1e-10, 3e-8, 1e-7, 0.3, 0.999_9, 0.999_999_9, 1.0];
    for a in rho {
        check_correlation(Matrix2::new(1.0, a, a, 1.0));
        for b in rho {
            for c in rho {
                check_correlation(Matrix3::new(1.0, a, b, a, 1.0, c, b, c, 1.0));
            }
        }
    }
}

#[test]
fn a_standardized_pair_has_the_eigenvalues_one_plus_and_minus_rho() {
    let found = Matrix2::new(1.0, -0.25, -0.25, 1.0).closed_form_eigen().unwrap();
    assert!((found.values[0] - 1.25).abs() < 1e-6 && (found.values[1] - 0.75).abs() < 1e-6);
    assert!((found.vectors[(0, 0)] + found.vectors[(1, 0)]).abs() < 1e-6);
}

#[test]
fn zero_diagonal_and_extreme_scales_are_decomposed() {
    check(Matrix3::<f32>::zeros());
    check(Matrix2::<f32>::zeros());
    for scale in [1e-30_f32, 1.0, 1e30, 1e38] {
        check(Matrix3::<f32>::identity() * scale);
        for d in [[3.0, 2.0, 1.0], [1.0, 2.0, 3.0], [2.0, 2.0, 1.0], [1.0, 2.0, 2.0], [2.0, 1.0, 2.0], [0.0, 0.0, 1.0]]
        {
            check(Matrix3::from_diagonal(&d.into()) * scale);
        }
        check(Matrix3::new(1.0, 0.5, -0.25, 0.5, 2.0, 0.125, -0.25, 0.125, 1.5) * scale);
    }
}

#[test]
fn eigenvalues_that_differ_by_what_keeps_a_radius_from_zero_have_orthonormal_vectors() {
    // Two eigenvalues of -4 but for the diagonal, which leaves differences of a few times that summand in their plane.
    let diagonal = [-3.0, -2.0, -1.0, -0.5, 0.0, 1.0 / 3.0, 0.5, 1.0, 2.0].map(|factor: f32| factor * SMALL);
    for a in diagonal {
        for b in diagonal {
            for c in diagonal {
                check(Matrix3::new(a, 4.0, 4.0, 4.0, b, 4.0, 4.0, 4.0, c));
            }
        }
    }
}

#[test]
fn a_power_of_two_scales_the_values_bit_for_bit_and_leaves_the_vectors_as_they_are() {
    let three = Matrix3::new(1.0, 0.5, -0.25, 0.5, 2.0, 0.125, -0.25, 0.125, 1.5);
    let two = Matrix2::new(1.0, 0.5, 0.5, -2.0);
    let (of_three, of_two) = (three.closed_form_eigen().unwrap(), two.closed_form_eigen().unwrap());
    for exponent in -124..=125 {
        let scale = 2.0_f32.powi(exponent);
        let (found, pair) = ((three * scale).closed_form_eigen().unwrap(), (two * scale).closed_form_eigen().unwrap());
        assert_eq!((found.values, found.vectors), (of_three.values * scale, of_three.vectors), "2^{exponent}");
        assert_eq!((pair.values, pair.vectors), (of_two.values * scale, of_two.vectors), "2^{exponent}");
    }
    // Below, digits are lost before they come here, down to the smallest of all numbers.
    for exponent in -149..-124 {
        let scale = f64::from(exponent).exp2();
        check(three.cast::<f64>().map(|x| (x * scale) as f32));
        check(two.cast::<f64>().map(|x| (x * scale) as f32));
    }
}

#[test]
fn entries_near_the_largest_f32_give_finite_vectors_and_values_that_fit_or_are_infinite() {
    const MAX: f32 = f32::MAX;
    for entries in [[MAX, 0.0, -MAX], [-MAX, MAX, MAX], [MAX, MAX, -MAX], [0.2 * MAX, 0.0, -0.9 * MAX]] {
        let found = Matrix3::from_diagonal(&entries.into()).closed_form_eigen().unwrap();
        assert!(found.vectors.iter().all(|x| x.is_finite()), "{entries:?}");
        let mut sorted = entries;
        sorted.sort_by(|a, b| b.total_cmp(a));
        for (value, exact) in found.values.iter().zip(sorted) {
            assert!(
                (value - exact).abs() <= 4e-7 * MAX || value.abs() >= (1.0 - 4e-7) * MAX,
                "{entries:?}: {value:e} for {exact:e}"
            );
        }
    }
    let full = Matrix3::repeat(MAX).closed_form_eigen().unwrap();
    assert_eq!(full.values[0], f32::INFINITY);
    assert!(full.vectors.column(0).iter().all(|x| (x - 0.57735).abs() < 1e-5));
    assert!(Matrix2::repeat(MAX).closed_form_eigen().unwrap().vectors.iter().all(|x| x.is_finite()));
}

#[test]
fn a_matrix_with_an_entry_that_is_not_finite_is_refused() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for place in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)] {
            let mut matrix = Matrix3::<f32>::identity();
            matrix[place] = bad;
            assert_eq!(matrix.closed_form_eigen(), Err(EigenError::NonFinite));
            if place.0 != place.1 {
                assert_eq!(matrix.decompose_correlation().checked(), Err(EigenError::NonFinite));
            }
        }
        let pair = Matrix2::new(1.0, bad, bad, 1.0);
        assert_eq!(pair.decompose_correlation().checked(), Err(EigenError::NonFinite));
        assert_eq!(Matrix2::new(1.0, bad, bad, 1.0).closed_form_eigen(), Err(EigenError::NonFinite));
    }
}

#[test]
fn whatever_stands_beside_it_an_entry_that_is_not_finite_is_told_and_nothing_else_is() {
    const ENTRIES: [f32; 8] = [0.0, 1.0, -2.0, 1e-30, f32::MAX, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for k in 0..8_usize.pow(6) {
        let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|place| ENTRIES[k >> (3 * place) & 7]);
        let matrix = Matrix3::new(a, b, d, b, c, e, d, e, f);
        let finite = [a, b, c, d, e, f].iter().all(|x| x.is_finite());
        assert_eq!(matrix.decompose().checked().is_ok(), finite, "{matrix}");
        if a == 0.0 && c == 0.0 && f == 0.0 {
            let small = [b, d, e].iter().all(|x| x.abs() <= 1.0);
            let found = matrix.decompose_correlation().checked();
            assert!(if small { found.is_ok() } else { finite || found.is_err() }, "{matrix}");
        }
        if d == 0.0 && e == 0.0 && f == 0.0 {
            assert_eq!(Matrix2::new(a, b, b, c).decompose().checked().is_ok(), finite, "{a} {b} {c}");
        }
    }
}

#[test]
fn cross_products_of_integers_are_the_definitions_own() {
    for k in 0..729_u32 {
        let places: [f32; 6] =
            core::array::from_fn(|place| (k / 3_u32.pow(place as u32) % 3 + place as u32) as f32 - 2.0);
        let [a, b, c, x, y, z] = places;
        let exact = Vector3::new(a, b, c).cross(&Vector3::new(x, y, z));
        assert_eq!(Vector3::from(super::cross([a, b, c], [x, y, z])), exact);
    }
}

#[test]
fn right_handed_vectors_are_the_same_but_for_the_sign_of_the_last() {
    let mut turned = 0;
    for k in 0..64_u32 {
        let angle = f64::from(k);
        let found = from_values([3.0, 2.0, 1.0], [angle, 2.0 * angle, 3.0 * angle]).closed_form_eigen().unwrap();
        let right = found.right_handed();
        assert!(right.vectors.determinant() > 0.99);
        assert_eq!((right.values, right.vectors.columns(0, 2)), (found.values, found.vectors.columns(0, 2)));
        let hand = found.vectors.determinant().signum();
        assert_eq!(right.vectors.column(2), found.vectors.column(2) * hand);
        turned += u32::from(hand < 0.0);
    }
    assert!((8..56).contains(&turned), "{turned} of 64 turned");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_matrices_of_any_scale(entries in prop::array::uniform6(-1.0..1.0_f32), exponent in -30..=30_i32) {
        let [a, b, c, d, e, f] = entries.map(|x| x * 10_f32.powi(exponent));
        check(Matrix3::new(a, b, c, b, d, e, c, e, f));
        check(Matrix2::new(a, b, b, c));
    }

    #[test]
    fn random_correlations_of_any_size(
        signs in prop::array::uniform3(-1.0..1.0_f32), exponents in prop::array::uniform3(-12.0..0.0_f32),
    ) {
        let [a, b, c] = core::array::from_fn(|i| signs[i] * libm::powf(10.0, exponents[i]));
        check_correlation(Matrix3::new(1.0, a, b, a, 1.0, c, b, c, 1.0));
        check_correlation(Matrix3::new(1.0, a, a, a, 1.0, a * (1.0 + b), a, a * (1.0 + b), 1.0));
        let [a, b, c] = signs;
        check_correlation(Matrix3::new(1.0, a, b, a, 1.0, c, b, c, 1.0));
    }

    #[test]
    fn two_eigenvalues_that_nearly_meet(gap in -9.0..-1.0_f64, other in -1.0..1.0_f64, angles in angles()) {
        check(from_values([1.0, 1.0 - 10_f64.powf(gap), other], angles));
        check(from_values([1.0, other, other * (1.0 + 10_f64.powf(gap))], angles));
    }

    #[test]
    fn three_eigenvalues_that_nearly_meet(gaps in prop::array::uniform2(-12.0..-2.0_f64), angles in angles()) {
        check(from_values([1.0 + 10_f64.powf(gaps[0]), 1.0, 1.0 - 10_f64.powf(gaps[1])], angles));
    }

    #[test]
    fn graded_and_nearly_block_matrices(small in prop::array::uniform3(-12.0..0.0_f64), angles in angles()) {
        check(from_values([1.0, 1e-6, 1e-12], angles));
        check(from_values(small.map(|e| 10_f64.powf(e)), angles));
        let [a, b, c] = small.map(|e| 10_f64.powf(e) as f32);
        check(Matrix3::new(1.0, a, b, a, 2.0, c, b, c, 1.0));
        check(Matrix3::new(1.0, 0.7, b, 0.7, 1.0, c, b, c, 0.5));
    }

    #[test]
    fn no_bits_make_a_panic_and_finite_bits_make_finite_vectors(
        bits in prop::array::uniform6(any::<u32>()), huge in any::<bool>(),
    ) {
        // Random bits seldom meet near the largest f32, where sums overflow: half of the cases are put there.
        let near_max = |x: f32| if x.is_finite() { x.signum() * (f32::MAX - x.abs().min(f32::MAX)) } else { x };
        let [a, b, c, d, e, f] = bits.map(f32::from_bits).map(|x| if huge { near_max(x) } else { x });
        if let Ok(found) = Matrix3::new(a, b, c, b, d, e, c, e, f).closed_form_eigen() {
            prop_assert!(found.vectors.iter().all(|x| x.is_finite()));
        }
    }
}
