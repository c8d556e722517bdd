//! How far a rate may be from what was counted.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The exact (Garwood 1936) two-sided interval of 95 % for the mean of a Poisson variable of which `count` was seen:
/// half the chi-square quantiles at 2.5 % with 2 n degrees of freedom and at 97.5 % with 2 n + 2.
#[must_use]
pub fn interval(count: u64) -> [f64; 2] {
    let half_quantile = |freedom: f64, p: f64| {
        // Degrees of freedom above zero are never refused.
        ChiSquared::new(freedom).map_or(f64::NAN, |chi_square| 0.5 * chi_square.inverse_cdf(p))
    };
    let n = count as f64;
    let low = if count == 0 { 0.0 } else { half_quantile(2.0 * n, 0.025) };
    [low, half_quantile(2.0 * n + 2.0, 0.975)]
}

/// What a T2 of `channels` normal channels with known mean and covariance exceeds with probability `p`.
#[must_use]
pub fn chi_square_limit(channels: u32, p: f64) -> f64 {
    ChiSquared::new(f64::from(channels)).map_or(f64::NAN, |chi_square| chi_square.inverse_cdf(1.0 - p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_interval_is_the_one_in_the_tables() {
        // scipy.stats.chi2.ppf(0.025, 2 n) / 2 and chi2.ppf(0.975, 2 n + 2) / 2; the first from -ln(0.025).
        for (count, low, high) in [
            (0, 0.0, 3.688_879_454_114),
            (1, 0.025_317_807_984, 5.571_643_390_939),
            (10, 4.795_388_696_132, 18.390_356_042_018),
            (100, 81.363_991_250_923, 121.626_793_792_427),
        ] {
            let [l, h] = interval(count);
            assert!((l - low).abs() < 1e-8 * (1.0 + low), "{count}: low {l}, not {low}");
            assert!((h - high).abs() < 1e-8 * high, "{count}: high {h}, not {high}");
        }
    }

    #[test]
    fn the_one_sample_limit_of_three_channels_is_the_chi_square_quantile() {
        // scipy.stats.chi2.isf(1e-6, 3).
        assert_relative_eq!(chi_square_limit(3, 1e-6), 30.664_849_706_214, max_relative = 1e-9);
    }
}
