//! The solver: a matrix of finite entries has orthonormal vectors and descending values, any other is refused.

use bolero::{TypeGenerator, check};
use monitor_core::eigen::{ClosedFormEigen, Decomposition, Eigen, EigenError};
use nalgebra::{Matrix2, Matrix3, SMatrix};

use super::TEST_TIME;
use super::number::Number;

/// Of orthonormality, and of the residual relative to the norm, in eps(f32): `NUMERICS.md`.
const BOUND_EPS: f64 = 8.0;

/// The six entries of a symmetric matrix.
#[derive(Clone, Debug, TypeGenerator)]
enum Entries {
    Any([Number; 6]),
    /// All of about the same size.
    Alike {
        counts: [i16; 6],
        #[generator(-140..113_i32)]
        exponent: i32,
    },
    /// A multiple of the identity, but for a few of its last bits.
    NearIdentity {
        size: u16,
        bits: [i8; 6],
    },
    /// An outer product: two eigenvalues are zero but for rounding.
    RankOne([i16; 3]),
}

impl Entries {
    /// Entries 00, 10, 20, 11, 21, 22.
    fn values(&self) -> [f32; 6] {
        match self {
            Entries::Any(numbers) => numbers.map(Number::value),
            Entries::Alike { counts, exponent } => {
                counts.map(|count| (f64::from(count) * f64::from(*exponent).exp2()) as f32)
            }
            Entries::NearIdentity { size, bits } => {
                let size = f32::from(*size);
                let [a, b, c, d, e, f] = bits.map(|bits| f32::from(bits) * f32::EPSILON * size);
                [size + a, b, c, size + d, e, size + f]
            }
            Entries::RankOne(v) => {
                let [x, y, z] = v.map(f32::from);
                [x * x, x * y, x * z, y * y, y * z, z * z]
            }
        }
    }
}

/// A correlation: between -1 and 1 unless it is `Any`.
#[derive(Clone, Copy, Debug, TypeGenerator)]
enum Rho {
    Any(Number),
    Between(i16),
    /// So many steps of half an eps from one.
    NearOne {
        negative: bool,
        steps: u8,
    },
    /// A power of two.
    Small {
        negative: bool,
        exponent: u8,
    },
}

impl Rho {
    fn value(self) -> f32 {
        let signed = |negative, x: f32| if negative { -x } else { x };
        match self {
            Rho::Any(number) => number.value(),
            Rho::Between(count) => f32::from(count) / 32_768.0,
            Rho::NearOne { negative, steps } => signed(negative, 1.0 - 0.5 * f32::EPSILON * f32::from(steps)),
            Rho::Small { negative, exponent } => signed(negative, (-f32::from(exponent)).exp2()),
        }
    }
}

#[derive(Clone, Debug, TypeGenerator)]
enum Input {
    General(Entries),
    Correlations([Rho; 3]),
}

#[test]
fn every_finite_matrix_is_decomposed_and_every_other_is_refused() {
    check!().with_test_time(TEST_TIME).with_type::<Input>().for_each(|input| match input {
        Input::General(entries) => general(entries.values()),
        Input::Correlations(rho) => correlations(rho.map(Rho::value)),
    });
}

fn general([a, b, c, d, e, f]: [f32; 6]) {
    judge(Matrix2::new(a, b, b, d), [a, b, d].iter().all(|x| x.is_finite()), ClosedFormEigen::decompose);
    let finite = [a, b, c, d, e, f].iter().all(|x| x.is_finite());
    judge(Matrix3::new(a, b, c, b, d, e, c, e, f), finite, ClosedFormEigen::decompose);
}

fn correlations([a, b, c]: [f32; 3]) {
    let (pair, triple) = (Matrix2::new(1.0, a, a, 1.0), Matrix3::new(1.0, a, b, a, 1.0, c, b, c, 1.0));
    // A number beyond one is no correlation: of that, only that nothing panics is promised.
    let promised = |rho: f32| rho.abs() <= 1.0 || !rho.is_finite();
    let _ = (pair.decompose_correlation(), triple.decompose_correlation());
    if promised(a) {
        judge(pair, a.is_finite(), ClosedFormEigen::decompose_correlation);
    }
    if [a, b, c].into_iter().all(promised) {
        let finite = [a, b, c].iter().all(|x| x.is_finite());
        judge(triple, finite, ClosedFormEigen::decompose_correlation);
    }
}

fn judge<const N: usize>(
    matrix: SMatrix<f32, N, N>,
    finite: bool,
    decompose: impl Fn(&SMatrix<f32, N, N>) -> Decomposition<N>,
) {
    match decompose(&matrix).checked() {
        Ok(found) => {
            assert!(finite, "{matrix}: not finite, and not refused");
            judge_decomposition(matrix, &found);
        }
        Err(error) => assert!(!finite && error == EigenError::NonFinite, "{matrix}: refused for {error:?}"),
    }
}

fn judge_decomposition<const N: usize>(matrix: SMatrix<f32, N, N>, found: &Eigen<N>) {
    let eps = f64::from(f32::EPSILON);
    let (values, vectors) = (found.values.cast::<f64>(), found.vectors.cast::<f64>());
    // Written so that NaN fails.
    let gram = (vectors.transpose() * vectors - SMatrix::<f64, N, N>::identity()).map(f64::abs);
    assert!(gram.iter().all(|e| *e <= BOUND_EPS * eps), "{matrix}: not orthonormal, {gram}");
    let mut ordered = found.values.iter().zip(found.values.iter().skip(1));
    assert!(ordered.all(|(above, below)| above >= below), "{matrix}: values do not descend, {}", found.values);
    for column in found.vectors.column_iter() {
        let leading = column.iter().fold(0.0_f32, |best, x| if x.abs() > best.abs() { *x } else { best });
        assert!(leading > 0.0, "{matrix}: a vector's sign is not fixed, {column}");
    }
    // A value that an `f32` cannot hold is infinite, and says no more.
    if values.iter().all(|value| value.is_finite()) {
        let exact = matrix.cast::<f64>();
        // Entries below the normal numbers have fewer digits: those count as the solver's smallest scale.
        let norm = exact.norm().max((-123.0_f64).exp2());
        let residual = (exact * vectors - vectors * SMatrix::<f64, N, N>::from_diagonal(&values)).amax();
        assert!(residual <= BOUND_EPS * eps * norm, "{matrix}: residual {} eps", residual / (eps * norm));
    }
}
