//! The sweep that shares and time constants come from: delay of smoothed T² in white noise over Lorden's bound.

use std::{print, println};

use super::*;
use crate::ewma::Ewma;
use crate::limit::smoothed_t2_limit;

/// Samples between two false alarms.
const ARL0: f32 = 1e6;

const RUNS: u32 = 3_000;

/// Mean delay, samples, of a shift of the first of three channels, with limits known exactly.
fn delay(noise: &mut Motor, scales: &[(Ewma, f32); 3], shift: f32) -> f32 {
    let mut sum = 0;
    for _ in 0..RUNS {
        let mut y = [[0.0; 3]; 3];
        let (mut waited, mut late) = (0, 0);
        while late == 0 {
            let shifted = waited >= 1_800;
            let x = [noise.normal() + if shifted { shift } else { 0.0 }, noise.normal(), noise.normal()];
            let mut beyond = false;
            for (y, (scale, limit)) in y.iter_mut().zip(scales) {
                *y = smoothed(*y, scale.weight(), x);
                beyond |= y.iter().map(|y| y * y).sum::<f32>() > *limit;
            }
            waited += 1;
            match (beyond, shifted) {
                (true, true) => late = waited - 1_800,
                (true, false) => (waited, y) = (0, [[0.0; 3]; 3]), // a false alarm
                (false, _) => {}
            }
        }
        sum += late;
    }
    sum as f32 / RUNS as f32
}

/// `cargo test --release -p monitor-core lorden -- --ignored --nocapture`, ten seconds.
#[test]
#[ignore = "prints the sweep in GUARD.md"]
fn delay_over_lordens_bound_by_time_constants_and_shares() {
    let mut noise = Motor::new(1);
    let equal = [0.25; 3];
    let mut of_default = 0.0;
    for (fast, middle, shares) in [
        (5.5, 75.0, equal),
        (5.5, 75.0, [0.35, 0.35, 0.2]),
        (7.5, 55.0, [0.35, 0.35, 0.2]),
        (7.5, 75.0, [0.35, 0.35, 0.2]),
    ] {
        print!("{fast} {middle} 2000, shares {shares:?}:");
        let scale = |samples: f32, share: f32| {
            let scale = Ewma::with_time_constant(samples, 1.0).unwrap();
            let limit = smoothed_t2_limit(&scale, 3, 1e6, ARL0 / share).unwrap();
            (scale, limit * scale.variance_ratio())
        };
        let [a, b, c] = shares;
        let scales = [scale(fast, a), scale(middle, b), scale(2_000.0, c)];
        of_default = 0.0;
        for shift in [0.25, 0.5, 0.7, 1.0, 1.4, 2.0] {
            let ratio = delay(&mut noise, &scales, shift) / (2.0 * ARL0.ln() / (shift * shift));
            print!(" {ratio:.2}");
            of_default = f32::max(of_default, ratio);
        }
        println!();
    }
    assert!(of_default < 1.5, "{of_default}");
}
