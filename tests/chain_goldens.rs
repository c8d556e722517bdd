//! Promise: the whole chain computes what numpy and scipy compute from the same samples.

use monitor_core::hotelling::Model;
use monitor_core::moments::Moments;
use monitor_core::paper::{Baseline, Config, Monitor};
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::{Bank, ModelId, Pair, PerPair};
use serde::Deserialize;

/// `tests/references/goldens.py` made it.
const GOLDENS: &str = include_str!("references/chain.json");

#[derive(Deserialize)]
struct Goldens {
    window: usize,
    cutoff: f64,
    samples: Vec<[f32; 3]>,
    full: Golden,
    speed_current: Golden,
    current_voltage: Golden,
    speed_voltage: Golden,
}

#[derive(Deserialize)]
struct Golden {
    mean: Vec<f64>,
    sigma: Vec<f64>,
    eigenvalues: Vec<f64>,
    loadings: Vec<Vec<f64>>,
    explained: Vec<f64>,
    retained: usize,
    t2: Vec<f64>,
    smoothed: Vec<f64>,
}

impl Goldens {
    fn load() -> Self {
        serde_json::from_str(GOLDENS).unwrap()
    }

    fn of(&self, model: ModelId) -> &Golden {
        match model {
            ModelId::Full => &self.full,
            ModelId::Pair(Pair::SpeedCurrent) => &self.speed_current,
            ModelId::Pair(Pair::CurrentVoltage) => &self.current_voltage,
            ModelId::Pair(Pair::SpeedVoltage) => &self.speed_voltage,
        }
    }

    fn baseline(&self) -> Baseline {
        let moments: Moments<3> = self.samples[..self.window].iter().copied().collect();
        Baseline::learn(&moments, ExplainedShare::PAPER).unwrap()
    }
}

fn assert_near(found: f64, golden: f64, relative: f64, what: &str) {
    assert!((found - golden).abs() <= relative * golden.abs().max(1e-3), "{what}: {found} for {golden}");
}

/// A standardized value is known to the rounding of the mean, eps(f32) * mean/sigma = 1e-4 here at most, so T2, its
/// square, is known to that times its square root.
fn assert_near_t2(found: f64, golden: f64, what: &str) {
    assert!((found - golden).abs() <= 1e-4 * (golden.sqrt() + golden), "{what}: {found} for {golden}");
}

fn check_pca<const N: usize>(model: &Model<N>, golden: &Golden) {
    let pca = model.pca();
    for k in 0..N {
        assert_near(pca.eigenvalues()[k].into(), golden.eigenvalues[k], 1e-5, "eigenvalue");
        assert_near(pca.explained()[k].into(), golden.explained[k], 1e-5, "explained variance");
        for i in 0..N {
            assert_near(pca.loadings()[(i, k)].into(), golden.loadings[k][i], 2e-5, "loading");
        }
    }
    assert_eq!(pca.retained(), golden.retained);
}

#[test]
fn a_window_gives_numpys_means_sigmas_loadings_and_retained_components() {
    let goldens = Goldens::load();
    let baseline = goldens.baseline();
    for channel in 0..3 {
        assert_near(baseline.mean()[channel].into(), goldens.full.mean[channel], 1e-6, "mean");
        assert_near(baseline.sigma()[channel].into(), goldens.full.sigma[channel], 1e-5, "sigma");
    }
    check_pca(baseline.full(), &goldens.full);
    for pair in Pair::ALL {
        check_pca(baseline.pairs().get(pair), goldens.of(ModelId::Pair(pair)));
    }
    // The goldens hold one, and two retained components of two and of three: none of these cases is left untried.
    assert_eq!(goldens.full.retained, 2);
    assert_eq!((goldens.speed_current.retained, goldens.speed_voltage.retained), (2, 1));
}

#[test]
fn every_sample_gives_numpys_t2_and_scipys_smoothed_residual() {
    let goldens = Goldens::load();
    let limit = 1e9;
    let pairs = PerPair { speed_current: limit, current_voltage: limit, speed_voltage: limit };
    let config = Config { cutoff_hz: goldens.cutoff as f32, ..Config::paper(1.0, Bank { full: limit, pairs }) };
    let config = Config { learn_s: 600.0, ..config };
    let baseline = goldens.baseline();
    let mut monitor = Monitor::new(&config).unwrap().starting_from(baseline, 0.0);
    for (k, x) in goldens.samples[goldens.window..].iter().enumerate() {
        let t2 = baseline.t2(baseline.deviation(*x));
        let residuals = monitor.step_channels(0.0, *x).residuals().unwrap();
        for model in ModelId::ALL {
            assert_near_t2((*t2.get(model)).into(), goldens.of(model).t2[k], "T2");
            assert_near_t2((*residuals.get(model)).into(), goldens.of(model).smoothed[k], "smoothed");
        }
    }
}
