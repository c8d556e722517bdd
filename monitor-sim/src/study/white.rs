//! Three channels of white noise without a loop: where theory says how soon a shift can be seen at all.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::watch::Known;
use crate::plant::PlantSample;

/// Samples per second, that of the loops beside it.
pub const RATE_HZ: f64 = 1000.0;

/// Independent standard normal channels about 100 (a mean that is not 0, as a motor's), the first of which is shifted.
#[derive(Clone, Debug)]
pub struct WhiteNoise {
    generator: ChaCha8Rng,
    index: u64,
    samples: u64,
    shift: f64,
    shifted: std::ops::Range<u64>,
}

impl WhiteNoise {
    /// `duration_s` seconds of it, with a shift of `shift` sigmas from `start_s` to `end_s`.
    #[must_use]
    pub fn new(seed: u64, duration_s: f64, shift: f64, [start_s, end_s]: [f64; 2]) -> Self {
        let index = |t_s: f64| (t_s * RATE_HZ).round() as u64;
        let generator = ChaCha8Rng::seed_from_u64(seed);
        Self { generator, index: 0, samples: index(duration_s), shift, shifted: index(start_s)..index(end_s) }
    }
}

impl Iterator for WhiteNoise {
    type Item = PlantSample;

    fn next(&mut self) -> Option<PlantSample> {
        if self.index >= self.samples {
            return None;
        }
        let t_s = self.index as f64 / RATE_HZ;
        let shift = if self.shifted.contains(&self.index) { self.shift } else { 0.0 };
        self.index += 1;
        let mut draw = || 100.0 + self.generator.sample::<f64, _>(StandardNormal);
        let (speed, armature_current, armature_voltage) = (draw() + shift, draw(), draw());
        Some(PlantSample { t_s, set_point: 100.0, speed, armature_current, armature_voltage, missing: false })
    }
}

/// What is known of the noise: when to learn.
#[must_use]
pub fn known(settle_s: f64, learn_s: f64) -> Known {
    Known {
        rate_hz: RATE_HZ,
        settle_s,
        learn_s,
        resistance_ohm: 1.0,
        torque_constant_nm_per_a: 1.0,
        load_slope_nm_s: 0.0,
        adc_steps: [0.0; 3],
    }
}

/// Lorden's bound for a shift of `sigmas` per independent sample with a false alarm in `arl0` samples (G. Lorden, Ann.
/// Math. Statist. 42, 1971): no procedure has a shorter worst mean delay than about 2 ln(ARL0)/sigmas^2 samples.
#[must_use]
pub fn lorden_samples(arl0: f64, sigmas: f64) -> f64 {
    2.0 * arl0.ln() / (sigmas * sigmas)
}
