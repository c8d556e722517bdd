//! Sensor noise: white Gaussian, seeded, one stream per sensor, with an optional ADC step.
//!
//! Every channel draws from its own ChaCha8 stream of the same seed, so that silencing one channel leaves the
//! samples of the others as they were. The generator is integer arithmetic and the Gaussian (ziggurat) a table look-up:
//! the same numbers on every platform. One draw in 3,900 (beyond 3.65 sigma) takes a logarithm from the
//! platform's mathematical library and may differ there in its last bit.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// Noise and resolution of the three sensors. Default: an incremental encoder and two shunt amplifiers of usual
/// quality, without an ADC step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseParameters {
    /// Standard deviation of the speed reading, rad/s. 0.1 rad/s is 0.95 rpm.
    pub speed_sigma_rad_per_s: f64,
    /// Standard deviation of the armature current reading, A.
    pub current_sigma_a: f64,
    /// Standard deviation of the armature voltage reading, V.
    pub voltage_sigma_v: f64,
    /// One ADC step of the speed reading, rad/s; 0 is no quantization.
    pub speed_step_rad_per_s: f64,
    /// One ADC step of the armature current reading, A; 0 is no quantization.
    pub current_step_a: f64,
    /// One ADC step of the armature voltage reading, V; 0 is no quantization.
    pub voltage_step_v: f64,
}

impl Default for NoiseParameters {
    fn default() -> Self {
        Self {
            speed_sigma_rad_per_s: 0.1,
            current_sigma_a: 0.02,
            voltage_sigma_v: 0.02,
            speed_step_rad_per_s: 0.0,
            current_step_a: 0.0,
            voltage_step_v: 0.0,
        }
    }
}

/// The random streams of one mission. The numbers are part of the recorded behaviour: another numbering is
/// another set of missions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// Noise of the speed sensor.
    Speed = 0,
    /// Noise of the armature current sensor.
    ArmatureCurrent = 1,
    /// Noise of the armature voltage sensor.
    ArmatureVoltage = 2,
    /// Turbulence of the load torque.
    Turbulence = 3,
}

/// White Gaussian noise of one channel.
#[derive(Debug, Clone)]
pub struct WhiteNoise {
    generator: ChaCha8Rng,
    sigma: f64,
}

impl WhiteNoise {
    /// Noise of standard deviation `sigma` (the channel's unit) from stream `stream` of seed `seed`.
    #[must_use]
    pub fn new(seed: u64, stream: Stream, sigma: f64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream as u64);
        Self { generator, sigma }
    }

    /// The next draw, in the channel's unit.
    pub fn draw(&mut self) -> f64 {
        let z: f64 = self.generator.sample(StandardNormal);
        self.sigma * z
    }
}

/// A first-order Gauss-Markov process: white noise through a first-order low-pass, with a given standard deviation.
#[derive(Debug, Clone)]
pub struct GaussMarkov {
    noise: WhiteNoise,
    keep: f64,
    renew: f64,
    value: f64,
}

impl GaussMarkov {
    /// A process of standard deviation `sigma` (any unit) and -3 dB corner `bandwidth_hz`, drawn every `period_s`
    /// seconds. It begins in its stationary distribution.
    ///
    /// The pole is the bilinear image of exp(-2 pi f T), (1 - pi f T)/(1 + pi f T), because arithmetic alone is the
    /// same on every platform. It stays stable for any bandwidth.
    #[must_use]
    pub fn new(seed: u64, stream: Stream, sigma: f64, bandwidth_hz: f64, period_s: f64) -> Self {
        let half_angle = std::f64::consts::PI * bandwidth_hz * period_s;
        let keep = (1.0 - half_angle) / (1.0 + half_angle);
        let mut noise = WhiteNoise::new(seed, stream, sigma);
        let value = noise.draw();
        // keep^2 + renew^2 = 1 keeps the variance at sigma^2.
        Self { noise, keep, renew: (1.0 - keep * keep).sqrt(), value }
    }

    /// The value of this period; the process moves on to the next.
    pub fn draw(&mut self) -> f64 {
        let now = self.value;
        self.value = self.keep * now + self.renew * self.noise.draw();
        now
    }
}

/// A sensor: noise, then whatever fault the caller applies, then the ADC.
#[derive(Debug, Clone)]
pub struct Sensor {
    noise: WhiteNoise,
    step: f64,
}

impl Sensor {
    /// A sensor with noise of standard deviation `sigma` and an ADC step `step` (both in the channel's unit, `step` 0
    /// for none).
    #[must_use]
    pub fn new(seed: u64, stream: Stream, sigma: f64, step: f64) -> Self {
        Self { noise: WhiteNoise::new(seed, stream, sigma), step }
    }

    /// Reads `true_value`. `fault` acts on the analogue signal: after the noise, before the ADC.
    pub fn read(&mut self, true_value: f64, fault: impl Fn(f64) -> f64) -> f64 {
        quantize(fault(true_value + self.noise.draw()), self.step)
    }
}

/// `value` rounded to the nearest multiple of `step`; unchanged where `step` is 0.
#[must_use]
pub fn quantize(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws(seed: u64, stream: Stream, n: usize) -> Vec<f64> {
        let mut noise = WhiteNoise::new(seed, stream, 1.0);
        (0..n).map(|_| noise.draw()).collect()
    }

    #[test]
    fn the_same_seed_and_stream_give_the_same_noise_and_any_other_does_not() {
        let reference = draws(7, Stream::Speed, 100);
        assert_eq!(reference, draws(7, Stream::Speed, 100));
        assert_ne!(reference, draws(8, Stream::Speed, 100));
        assert_ne!(reference, draws(7, Stream::ArmatureCurrent, 100));
    }

    #[test]
    fn noise_is_white_with_mean_zero_and_the_sigma_asked_for() {
        const N: usize = 100_000;
        let mut noise = WhiteNoise::new(1, Stream::Speed, 0.1);
        let x: Vec<f64> = (0..N).map(|_| noise.draw()).collect();
        let n = N as f64;
        let mean = x.iter().sum::<f64>() / n;
        let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let lag_one = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n * variance);
        // Standard errors: sigma/sqrt(n) = 3.2e-4, sigma/sqrt(2n) = 2.2e-4, 1/sqrt(n) = 3.2e-3; four of each.
        assert!(mean.abs() < 1.3e-3, "mean {mean}");
        assert!((variance.sqrt() - 0.1).abs() < 9e-4, "sigma {}", variance.sqrt());
        assert!(lag_one.abs() < 1.3e-2, "lag-one correlation {lag_one}");
        // Gaussian, not merely of that variance: P(|z| > 2) = 0.0455, standard error 6.6e-4.
        let beyond = x.iter().filter(|v| v.abs() > 0.2).count() as f64 / n;
        assert!((beyond - 0.0455).abs() < 2.7e-3, "share beyond two sigma {beyond}");
    }

    #[test]
    fn turbulence_has_its_sigma_from_the_start_and_forgets_with_its_bandwidth() {
        // 4000 processes side by side; 5 Hz: correlation exp(-2 pi 5 Hz 32 ms) = 0.366 after 32 ms.
        const N: usize = 4000;
        let (mut first, mut later, mut product) = (0.0, 0.0, 0.0);
        for seed in 0..N as u64 {
            let mut process = GaussMarkov::new(seed, Stream::Turbulence, 0.3, 5.0, 1e-3);
            let path: Vec<f64> = (0..33).map(|_| process.draw()).collect();
            first += path[0] * path[0];
            later += path[32] * path[32];
            product += path[0] * path[32];
        }
        let n = N as f64;
        // Standard error of a variance is 2.2 % here, so 1.1 % of the sigma; four of each.
        assert!(((first / n).sqrt() / 0.3 - 1.0).abs() < 0.045);
        assert!(((later / n).sqrt() / 0.3 - 1.0).abs() < 0.045);
        let correlation = product / (first * later).sqrt();
        assert!((correlation - 0.366).abs() < 0.055, "correlation {correlation}");
    }

    #[test]
    fn the_first_draws_of_seed_1_are_frozen() {
        // Every recorded mission changes with these numbers: bless new ones only on purpose.
        let frozen = [-0.23484705855592097, -1.4108177006109994, 0.3330286294792717];
        assert_eq!(draws(1, Stream::Speed, 3), frozen);
    }

    #[test]
    fn an_adc_step_rounds_the_reading_to_its_multiples_and_no_step_leaves_it_alone() {
        assert_eq!(quantize(0.37, 0.25), 0.25);
        assert_eq!(quantize(0.38, 0.25), 0.5);
        assert_eq!(quantize(-0.38, 0.25), -0.5);
        assert_eq!(quantize(0.37, 0.0), 0.37);
        let mut sensor = Sensor::new(3, Stream::ArmatureCurrent, 0.5, 0.125);
        for _ in 0..1000 {
            assert_eq!((sensor.read(1.0, |x| x) * 8.0).fract(), 0.0);
        }
    }

    #[test]
    fn a_sensor_fault_acts_after_the_noise_and_before_the_adc() {
        let mut silent = Sensor::new(3, Stream::Speed, 0.0, 0.5);
        assert_eq!(silent.read(1.0, |x| x + 0.3), 1.5);
        let mut healthy = Sensor::new(3, Stream::Speed, 0.1, 0.0);
        let mut doubled = Sensor::new(3, Stream::Speed, 0.1, 0.0);
        assert_eq!(2.0 * healthy.read(1.0, |x| x), doubled.read(1.0, |x| 2.0 * x));
    }
}
