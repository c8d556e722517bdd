//! The moments against a two-pass reference in `f64`, and what their windows refuse.

use super::*;
use proptest::prelude::*;

/// Textbook two-pass moments in `f64`.
fn two_pass<const N: usize>(data: &[[f32; N]]) -> ([f64; N], [[f64; N]; N]) {
    let n = data.len() as f64;
    let mean: [f64; N] = core::array::from_fn(|i| data.iter().map(|x| f64::from(x[i])).sum::<f64>() / n);
    let covariance = core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            data.iter().map(|x| (f64::from(x[i]) - mean[i]) * (f64::from(x[j]) - mean[j])).sum::<f64>() / (n - 1.0)
        })
    });
    (mean, covariance)
}

fn learned<const N: usize>(data: &[[f32; N]]) -> Result<Statistics<N>, LearnError> {
    data.iter().copied().collect::<Moments<N>>().statistics()
}

/// A reproducible, correlated window around (300, 2, 10), the default motor's operating point.
fn window(n: usize) -> Vec<[f32; 3]> {
    let mut seed = 1_u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 40) as f32 / (1 << 24) as f32 - 0.5
    };
    (0..n)
        .map(|_| {
            let (a, b, c) = (uniform(), uniform(), uniform());
            [300.0 + 0.2 * a, 2.0 + 0.02 * (a + b), 10.0 + 0.02 * (c - b)]
        })
        .collect()
}

extern crate std;
use std::vec::Vec;

#[test]
fn moments_agree_with_a_two_pass_f64_reference_at_every_window_length() {
    for n in [30, 63, 64, 65, 128, 1000, 100_000] {
        let data = window(n);
        let (mean, covariance) = two_pass(&data);
        let found = learned(&data).unwrap();
        let sigma = [0, 1, 2].map(|i| covariance[i][i].sqrt());
        for i in 0..3 {
            assert!((f64::from(found.mean[i]) - mean[i]).abs() < 2e-7 * mean[i].abs() + 1e-4 * sigma[i]);
        }
        for (i, j) in [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let error = f64::from(found.covariance[(i, j)]) - covariance[i][j];
            assert!(error.abs() < 1e-4 * sigma[i] * sigma[j], "n {n}, entry {i} {j}: {error:e}");
        }
    }
}

#[test]
fn a_window_around_an_expected_mean_does_not_care_for_its_first_sample() {
    let mut data = window(6400);
    data[0] = [310.0, 2.0, 10.0];
    let (_, covariance) = two_pass(&data);
    let mut moments = Moments::around([300.05, 2.01, 9.99]);
    data.iter().for_each(|x| moments.push(*x));
    let found = moments.statistics().unwrap();
    assert!((f64::from(found.covariance[(0, 0)]) / covariance[0][0] - 1.0).abs() < 1e-5);
}

#[test]
fn no_slot_merges_more_than_one_sum_and_every_sum_is_merged_in_every_block() {
    let mut moments = Moments::around([300.0, 2.0, 10.0]);
    for x in window(640) {
        let before = moments.sums;
        moments.push(x);
        let totals =
            |sums: Sums<3>| sums.first.into_iter().chain(sums.second.into_iter().flatten()).map(|sum| sum.total);
        assert!(totals(before).zip(totals(moments.sums)).filter(|(a, b)| a != b).count() <= 1);
    }
    // The last block holds what came after each sum's turn: about fifty samples, never all.
    let Sums { first, second } = moments.sums;
    assert!(first.iter().all(|sum| sum.total != 0.0));
    assert!(second.iter().enumerate().all(|(i, row)| row[..=i].iter().all(|sum| sum.total != 0.0)));
    assert!(second[0][0].block < 0.12 * second[0][0].total);
}

#[test]
fn a_window_that_cannot_be_learned_is_refused_and_the_channel_is_named() {
    assert_eq!(learned(&window(29)), Err(LearnError::TooShort { samples: 29 }));
    let mut constant = window(100);
    constant.iter_mut().for_each(|x| x[1] = 2.0);
    assert_eq!(learned(&constant), Err(LearnError::ConstantChannel(Channel::ArmatureCurrent)));
    for bad in [f32::NAN, f32::INFINITY, 1e38] {
        let mut data = window(100);
        data[70][2] = bad;
        assert_eq!(learned(&data), Err(LearnError::NonFinite(Channel::ArmatureVoltage)));
    }
}

#[test]
fn a_channel_that_stands_at_zero_or_moves_by_rounding_alone_is_constant() {
    let mut zero = window(100);
    zero.iter_mut().for_each(|x| x[2] = 0.0);
    assert_eq!(learned(&zero), Err(LearnError::ConstantChannel(Channel::ArmatureVoltage)));
    // One sample in a hundred is off by one unit in the last place of 300.
    let mut rounded = window(100);
    rounded.iter_mut().enumerate().for_each(|(k, x)| x[0] = if k == 50 { 300.0_f32.next_up() } else { 300.0 });
    assert_eq!(learned(&rounded), Err(LearnError::ConstantChannel(Channel::Speed)));
}

#[test]
fn correlations_are_covariances_in_units_of_both_sigmas() {
    let data = window(1000);
    let (_, covariance) = two_pass(&data);
    let found = learned(&data).unwrap().correlation();
    for (i, j) in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let exact = covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt();
        assert!((f64::from(found[(i, j)]) - exact).abs() < 1e-4, "{i} {j}: {} for {exact}", found[(i, j)]);
    }
    assert!(found[(1, 2)] < -0.4, "the window is correlated, or this would show nothing");
}

#[test]
fn a_mean_a_hundred_thousand_sigmas_high_costs_no_digits_of_the_covariance() {
    // 1,000 rad/s with 0.01 rad/s of noise: the reading's own rounding is 0.006 sigma.
    for n in [1_000, 10_000, 1_000_000] {
        let data: Vec<[f32; 3]> = window(n).iter().map(|[a, b, c]| [1000.0 + (a - 300.0) * 0.173, *b, *c]).collect();
        let (_, covariance) = two_pass(&data);
        let found = learned(&data).unwrap();
        for (i, j) in [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)] {
            let error = f64::from(found.covariance[(i, j)]) - covariance[i][j];
            let size = (covariance[i][i] * covariance[j][j]).sqrt();
            assert!(error.abs() < 1e-4 * size, "n {n}, entry {i} {j}: {:e}", error / size);
        }
    }
}

#[test]
fn two_windows_merge_into_the_window_of_all_their_samples() {
    for (n, m) in [(0, 100), (100, 0), (1, 99), (40, 60), (64, 64), (1000, 37), (37, 1000)] {
        // The second window stands elsewhere, as after a drift.
        let data: Vec<[f32; 3]> =
            window(n + m).iter().enumerate().map(|(k, x)| if k < n { *x } else { x.map(|v| v + 0.3) }).collect();
        let gathered = |data: &[[f32; 3]]| data.iter().copied().collect::<Moments<3>>();
        let (mut first, second) = (gathered(&data[..n]), gathered(&data[n..]));
        first.merge(&second);
        // A merged window goes on learning.
        let more: Vec<[f32; 3]> = data.iter().chain(&data[..n.min(70)]).copied().collect();
        more[n + m..].iter().for_each(|x| first.push(*x));
        let (mean, covariance) = two_pass(&more);
        let found = first.statistics().unwrap();
        assert_eq!(found.samples as usize, more.len());
        for i in 0..3 {
            assert!((f64::from(found.mean[i]) - mean[i]).abs() < 1e-4, "{n} and {m}");
            for j in 0..3 {
                let size = (covariance[i][i] * covariance[j][j]).sqrt();
                let error = f64::from(found.covariance[(i, j)]) - covariance[i][j];
                assert!(error.abs() < 1e-4 * size, "{n} and {m}, entry {i} {j}: {:e}", error / size);
            }
        }
    }
}

#[test]
fn a_window_that_forgets_follows_a_drift_and_weighs_samples_exponentially() {
    let (block, keep) = (50, 0.9_f32);
    let data: Vec<[f32; 3]> = window(5_000).iter().enumerate().map(|(k, x)| x.map(|v| v + 1e-3 * k as f32)).collect();
    let mut moments = Moments::around(data[0]);
    let (mut weights, mut weight) = (std::vec![0.0_f64; data.len()], 1.0_f64);
    for (k, samples) in data.chunks(block).enumerate().rev() {
        weights[k * block..k * block + samples.len()].fill(weight);
        weight *= f64::from(keep);
    }
    for (k, samples) in data.chunks(block).enumerate() {
        if k > 0 {
            moments.forget(keep);
        }
        samples.iter().for_each(|x| moments.push(*x));
    }
    let total: f64 = weights.iter().sum();
    let weighted = |f: &dyn Fn(&[f32; 3]) -> f64| data.iter().zip(&weights).map(|(x, w)| w * f(x)).sum::<f64>();
    let found = moments.statistics().unwrap();
    assert!((f64::from(found.samples) - total).abs() <= 1.0);
    for i in 0..3 {
        let mean = weighted(&|x| f64::from(x[i])) / total;
        assert!((f64::from(found.mean[i]) - mean).abs() < 1e-4, "{} for {mean}", found.mean[i]);
        let variance = weighted(&|x| (f64::from(x[i]) - mean).powi(2)) / (total - 1.0);
        assert!((f64::from(found.covariance[(i, i)]) / variance - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_window_may_forget_everything_and_begin_again() {
    let data = window(200);
    for keep in [0.0, -1.0, f32::NAN] {
        let mut moments = Moments::around([300.0, 2.0, 10.0]);
        moments.forget(keep);
        data[..100].iter().for_each(|x| moments.push(x.map(|v| v + 50.0)));
        moments.forget(keep);
        moments.forget(keep);
        assert_eq!(moments.samples(), 0);
        data[100..].iter().for_each(|x| moments.push(*x));
        let (mean, covariance) = two_pass(&data[100..]);
        let found = moments.statistics().unwrap();
        assert!((f64::from(found.mean[0]) - mean[0]).abs() < 1e-4);
        assert!((f64::from(found.covariance[(0, 0)]) / covariance[0][0] - 1.0).abs() < 1e-4);
    }
    let mut kept: Moments<3> = data.iter().copied().collect();
    let before = kept.statistics().unwrap();
    kept.forget(2.0);
    assert_eq!(kept.statistics().unwrap().samples, before.samples, "a weight cannot grow");
}

#[test]
fn windows_that_hold_more_than_can_be_counted_stay_at_the_largest_count() {
    let mut moments: Moments<3> = window(64).into_iter().collect();
    for _ in 0..40 {
        let twin = moments;
        moments.merge(&twin);
    }
    assert_eq!(moments.samples(), u32::MAX);
    assert_eq!(moments.weight(), 64.0 * libm::exp2f(40.0), "and still know their weight");
}

#[test]
fn a_correlation_matrix_is_symmetric_in_every_bit() {
    for n in 30..200 {
        let correlation = learned(&window(n)).unwrap().correlation();
        assert_eq!(correlation, correlation.transpose(), "{n} samples");
    }
}

#[test]
fn deviations_are_taken_from_where_the_mean_is_expected_until_a_window_forgets_and_from_its_mean_then() {
    let expected = [10.0, -2.0, 0.5];
    let mut moments = Moments::<3>::around(expected);
    // There is nothing to forget yet, and no mean.
    moments.forget(0.5);
    (0..100).for_each(|_| moments.push([11.0, -4.0, 0.5]));
    assert_eq!(moments.shift(), expected);
    moments.forget(0.5);
    assert_eq!(moments.shift(), [11.0, -4.0, 0.5]);
}

#[test]
fn windows_that_have_forgotten_weigh_what_is_left_of_both_when_they_merge() {
    let forgotten = |samples: usize| {
        let mut moments = Moments::<3>::around([0.0; 3]);
        window(samples).into_iter().for_each(|x| moments.push(x));
        moments.forget(0.5);
        moments
    };
    let mut merged = forgotten(100);
    merged.merge(&forgotten(200));
    assert_eq!(merged.samples(), 150);
}

#[test]
fn a_clip_moves_spikes_to_its_reach_and_leaves_everything_else() {
    let seed = learned(&window(1000)).unwrap();
    let clip = Clip::at(&seed, 3.0);
    let [a, b, c]: [f32; 3] = seed.mean.into();
    assert_eq!(clip.apply([a, b, c]), ([a, b, c], false));
    let (moved, clipped) = clip.apply([a, b + 5.0, c - 5.0]);
    let reach: [f32; 3] = (seed.sigma() * 3.0).into();
    assert!(clipped && moved[0] == a && moved[1] == b + reach[1] && moved[2] == c - reach[2]);
    assert!(clip.apply([f32::NAN, b, c]).0[0].is_nan());
    assert_eq!(clip.apply([f32::INFINITY, b, c]), ([a + reach[0], b, c], true));
    for end in [b - reach[1], b + reach[1]] {
        assert_eq!(clip.apply([a, end, c]), ([a, end, c], false), "a reading at the end of its reach is within");
    }
    assert_eq!(clip.apply([a, b - 5.0, c]), ([a, b - reach[1], c], true), "a spike downwards alone is told as well");
}

#[test]
fn one_spike_in_a_hundred_does_not_spoil_what_is_learned_behind_a_clip() {
    let clean = window(20_000);
    let clip = Clip::at(&learned(&clean[..500]).unwrap(), 3.0);
    let (mut plain, mut robust) = (Moments::around(clean[0]), Moments::around(clean[0]));
    for (k, x) in clean.iter().enumerate() {
        let x = if k % 100 == 50 { [x[0] + 1.0, x[1], x[2] - 0.2] } else { *x };
        plain.push(x);
        robust.push(clip.apply(x).0);
    }
    let error = |moments: &Moments<3>| {
        let difference = moments.statistics().unwrap().correlation() - learned(&clean).unwrap().correlation();
        difference.amax()
    };
    assert!(error(&robust) < 0.12 && error(&plain) > 0.6, "{} against {}", error(&robust), error(&plain));
}

#[test]
fn two_channels_learn_as_three_do() {
    let data: Vec<[f32; 2]> = window(500).iter().map(|x| [x[0], x[2]]).collect();
    let (_, covariance) = two_pass(&data);
    let found = learned(&data).unwrap();
    assert!((f64::from(found.covariance[(0, 1)]) - covariance[0][1]).abs() < 1e-7);
    assert_eq!(found.correlation()[(0, 0)], 1.0);
}

proptest! {
    #[test]
    fn shifting_and_scaling_the_data_shifts_and_scales_the_moments(
        shift in -1e3_f32..1e3, scale in 0.01_f32..100.0, n in 30_usize..300,
    ) {
        let data = window(n);
        let moved: Vec<[f32; 3]> = data.iter().map(|x| x.map(|v| (v - 2.0) * scale + shift)).collect();
        let (mean, covariance) = two_pass(&moved);
        let found = learned(&moved).unwrap();
        for i in 0..3 {
            let sigma = covariance[i][i].sqrt();
            prop_assert!((f64::from(found.mean[i]) - mean[i]).abs() <= 2e-7 * mean[i].abs() + 1e-4 * sigma);
            prop_assert!((f64::from(found.covariance[(i, i)]) / covariance[i][i] - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn no_window_of_any_bits_makes_a_panic_or_a_statistic_that_is_not_finite(
        bits in prop::collection::vec(prop::array::uniform3(any::<u32>()), 0..200),
    ) {
        let data: Vec<[f32; 3]> = bits.iter().map(|b| b.map(f32::from_bits)).collect();
        if let Ok(found) = learned(&data) {
            prop_assert!(found.mean.iter().all(|m| m.is_finite()));
            prop_assert!(found.correlation().iter().all(|r| r.abs() <= 1.0));
        }
    }
}
