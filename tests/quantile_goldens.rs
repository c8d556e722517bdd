//! Promise: the core's quantiles are mpmath's, over their whole range.

use monitor_core::quantile::{upper_chi_square, upper_f, upper_normal};
use serde::Deserialize;

/// `tests/references/quantiles.py` made it.
const GOLDENS: &str = include_str!("references/quantiles.json");

#[derive(Deserialize)]
struct Goldens {
    normal: Vec<[f64; 2]>,
    chi_square: Vec<[f64; 3]>,
    f: Vec<[f64; 4]>,
}

/// The largest relative error over rows of a found and an exact quantile.
fn worst(rows: impl Iterator<Item = (f32, f64)>) -> f64 {
    rows.map(|(found, exact)| (f64::from(found) / exact - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn normal_chi_square_and_f_quantiles_are_mpmaths_to_a_few_parts_in_a_million() {
    let goldens: Goldens = serde_json::from_str(GOLDENS).unwrap();
    // Twelve probabilities from 0.1 to 1e-12, 13 chi-squares, 54 F.
    assert_eq!([goldens.normal.len(), goldens.chi_square.len(), goldens.f.len()], [12, 12 * 13, 12 * 54]);
    let normal = worst(goldens.normal.iter().map(|[p, z]| (upper_normal(*p as f32).unwrap(), *z)));
    let chi_square = goldens.chi_square.iter().map(|[p, d, x]| (upper_chi_square(*p as f32, *d as f32).unwrap(), *x));
    let chi_square = worst(chi_square);
    let f = |from: f64, to: f64| {
        let rows = goldens.f.iter().filter(|[_, d1, ..]| (from..=to).contains(d1));
        worst(rows.map(|[p, d1, d2, x]| (upper_f(*p as f32, *d1 as f32, *d2 as f32).unwrap(), *x)))
    };
    let (few, many) = (f(1.0, 3.0), f(3.0, 50.0));
    println!("normal {normal:.1e}, chi-square {chi_square:.1e}, F {few:.1e} to 3 over, {many:.1e} to 50 over");
    assert!(normal <= 1e-6 && chi_square <= 2e-6 && few <= 1e-6 && many <= 5e-6);
}
