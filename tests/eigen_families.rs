//! Promise: the 3x3 eigen-solver is as accurate as LAPACK's `ssyev` on every family of matrices that breaks closed forms.
//!
//! `references/eigen_families.py` drew a million matrices of each family, had both programs decompose them, and kept the
//! worst of both beside the matrices that were hardest for the core. Here the core meets those again.

use std::collections::BTreeMap;

use monitor_core::eigen::{ClosedFormEigen, Eigen};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

const STUDY: &str = include_str!("references/eigen_families.json");

/// In eps(f32): eigenvalues over the norm, orthogonality, residual over the norm.
type Errors = [f64; 3];

const BOUNDS: Errors = [4.0, 8.0, 8.0];

/// LAPACK leaves a diagonal matrix as it is, and makes no error at all: twice that is no bound for anyone else.
const LEAST_BOUND: f64 = 2.0;

#[derive(Deserialize)]
struct Study {
    draws: u64,
    families: BTreeMap<String, Family>,
}

#[derive(Deserialize)]
struct Family {
    core: Errors,
    lapack: Errors,
    correlation: bool,
    hardest: Vec<Hard>,
}

#[derive(Deserialize)]
struct Hard {
    bits: [u32; 6],
    values: [f64; 3],
}

fn study() -> Study {
    serde_json::from_str(STUDY).unwrap()
}

fn errors(matrix: Matrix3<f32>, exact: [f64; 3], found: &Eigen<3>) -> Errors {
    let scale = (-f64::from(matrix.amax()).max(1e-300).log2().floor()).exp2();
    let a = matrix.cast::<f64>() * scale;
    let norm = a.norm().max(1e-300);
    let (values, vectors) = (found.values.cast::<f64>() * scale, found.vectors.cast::<f64>());
    let of_values = (values - Vector3::from(exact) * scale).amax() / norm;
    let gram = (vectors.transpose() * vectors - Matrix3::identity()).amax();
    let residual = (a * vectors - vectors * Matrix3::from_diagonal(&values)).amax() / norm;
    [of_values, gram, residual].map(|error| error / f64::from(f32::EPSILON))
}

#[test]
fn the_study_is_the_whole_one_and_stays_within_the_bounds_and_twice_lapack() {
    let study = study();
    assert!(study.draws >= 1_000_000 && study.families.len() >= 20);
    for (name, family) in &study.families {
        for (quantity, ((core, lapack), bound)) in family.core.iter().zip(family.lapack).zip(BOUNDS).enumerate() {
            assert!(*core <= bound.min(f64::max(2.0 * lapack, LEAST_BOUND)), "{name}, quantity {quantity}: {core} eps");
        }
    }
}

#[test]
fn the_hardest_matrices_of_each_family_are_no_harder_than_they_were() {
    for (name, family) in study().families {
        assert!(family.hardest.len() >= 12, "{name}");
        let mut worst = [0.0; 3];
        for hard in &family.hardest {
            let [a, b, c, d, e, f] = hard.bits.map(f32::from_bits);
            let matrix = Matrix3::new(a, b, d, b, c, e, d, e, f);
            let found = if family.correlation { matrix.decompose_correlation() } else { matrix.decompose() };
            let found = found.checked().unwrap();
            for (worst, error) in worst.iter_mut().zip(errors(matrix, hard.values, &found)) {
                *worst = f64::max(*worst, error);
            }
        }
        for (quantity, (now, then)) in worst.iter().zip(family.core).enumerate() {
            // The study rounds to hundredths; results are the same on every machine, bit for bit.
            assert!((now - then).abs() <= 0.011, "{name}, quantity {quantity}: {now} eps now, {then} in the study");
        }
    }
}
