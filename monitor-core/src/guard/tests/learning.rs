//! What `guard` mode learns, in the window and after it, and what that does to its limits.

use super::*;

#[test]
fn spikes_while_learning_are_clipped_and_reported() {
    let mut watch = Watch::new(&config(), 6);
    let spiked = |k: u32, mut x: [f32; 3]| {
        if k % 100 == 17 {
            x[1] += 25.0 * SIGMA[1];
        }
        x
    };
    watch.run(12_000, spiked);
    let (model, quality) = (watch.guard.model().unwrap(), watch.guard.quality());
    assert!((model.sigma()[1] / SIGMA[1] - 1.0).abs() < 0.2, "sigma {}", model.sigma()[1]);
    assert!((0.005..0.02).contains(&quality.clipped_share), "{quality:?}");
}

#[test]
fn a_fault_that_begins_while_learning_refuses_the_window_and_names_the_channel() {
    let mut watch = Watch::new(&config(), 7);
    watch.run(3_000, |_, x| x);
    watch.run(2_200, off(Channel::ArmatureCurrent, 2.0));
    assert_eq!(watch.guard.refused(), Some(LearnError::Drifting(Channel::ArmatureCurrent)));
    assert_eq!(watch.guard.verdict().phase(), Phase::Seeding, "it has begun again");
}

#[test]
fn a_constant_channel_is_refused_and_named() {
    let mut watch = Watch::new(&config(), 8);
    watch.run(1_000, |_, [a, b, _]| [a, b, 10.0]);
    assert_eq!(watch.guard.refused(), Some(LearnError::ConstantChannel(Channel::ArmatureVoltage)));
}

#[test]
fn an_encoder_whose_reading_seldom_changes_by_a_step_makes_no_more_alarms_than_were_asked_for() {
    let step = 15.0 * SIGMA[0];
    for (known_step, spared_s) in [(step, 0), (0.0, 300)] {
        let asked = Config { false_alarms_per_hour: 6.0, converter_steps: [known_step, 0.0, 0.0], ..config() };
        let mut watch = Watch::new(&asked, 34);
        let generator = core::cell::RefCell::new(Motor::new(35));
        let edges = |_: u32, [_, b, c]: [f32; 3]| {
            let early = generator.borrow_mut().uniform() < 0.08;
            [MEAN[0] + if early { step } else { 0.0 }, b, c]
        };
        watch.run(6_000 + spared_s * 1000, edges);
        let verdicts = watch.run(600_000, edges);
        let alarms = verdicts.windows(2).filter(|pair| !pair[0].alarm() && pair[1].alarm()).count();
        assert!(alarms <= 3, "{alarms} alarms in ten minutes, with a step of {known_step}");
    }
}

#[test]
fn a_model_of_few_samples_makes_no_more_false_alarms_than_were_asked_for() {
    for learn_s in [0.2, 0.4, 0.8] {
        let asked = Config {
            false_alarms_per_hour: 36.0, // one in 100,000 samples
            settle_s: 0.05,
            seed_s: 0.031,
            learn_s,
            time_constants_s: [0.004, learn_s / 24.5, learn_s / 5.0, learn_s],
            ..Config::at_rate(1000.0)
        };
        // White, and with a noise that channels share and that remembers, which a window so short hardly sees.
        for shared in [0.0, 1.0] {
            let alarms = |seed| {
                let colour = core::cell::RefCell::new((Motor::new(seed + 1000), 0.0_f32));
                let coloured = |_: u32, x: [f32; 3]| {
                    let (noise, state) = &mut *colour.borrow_mut();
                    *state = 0.7 * *state + 0.714 * noise.normal();
                    core::array::from_fn(|i| x[i] + shared * *state * SIGMA[i])
                };
                let verdicts = Watch::new(&asked, seed).run(30_000, coloured);
                verdicts.windows(2).filter(|pair| !pair[0].alarm() && pair[1].alarm()).count()
            };
            let alarms: usize = (0..40).map(alarms).sum();
            assert!(alarms <= 20, "{alarms} where 12 are tolerable, after {learn_s} s, shared noise {shared}");
        }
    }
}

#[test]
fn a_window_of_few_independent_samples_takes_directions_from_the_quick_scale_and_limits_are_the_lower_for_it() {
    let limits_after = |learn_s| {
        let mut watch = Watch::new(&Config { learn_s, ..config() }, 47);
        watch.run(8_000, |_, x| x);
        watch.guard.limits().unwrap()[super::super::window::MIDDLE - 1]
    };
    // Twelve independent samples and forty of the middle scale.
    let (few, many) = (limits_after(1.81), limits_after(6.0));
    assert!(few < 1.2 * many, "{few} {many}");
}

#[test]
fn limits_are_proven_by_healthy_slots_alone() {
    let unproven = |watch: &Watch| match &watch.guard.stage {
        Stage::Judging(judge) => judge.known.is_unproven(),
        stage => panic!("{stage:?}"),
    };
    let mut watch = Watch::new(&config(), 31);
    watch.run(7_000, |_, x| x);
    watch.run(60_000, off(Channel::Speed, 20.0));
    assert!(unproven(&watch), "a fault proves nothing");
    watch.run(60_000, |_, x| x);
    assert!(!unproven(&watch));
    watch.run(1_000, off(Channel::Speed, 20.0));
    assert!(!unproven(&watch), "what is proven stays so");
}

#[test]
fn a_fault_that_creeps_in_while_limits_are_being_proven_does_not_widen_them() {
    let limits_after = |size: f32| {
        let mut watch = Watch::new(&config(), 23);
        watch.run(7_000, |_, x| x);
        watch.run(2_000, |k, x| off(Channel::ArmatureCurrent, size * k as f32 / 2_000.0)(k, x));
        assert_eq!(watch.guard.verdict().deviates(), size > 0.0);
        watch.run(10_000, |_, x| x);
        assert!(!watch.guard.verdict().alarm());
        watch.guard.limits().unwrap()
    };
    let (faulty, healthy) = (limits_after(8.0), limits_after(0.0));
    for (faulty, healthy) in faulty.into_iter().zip(healthy) {
        // It has learned a little less.
        assert!((1.0..1.3).contains(&(faulty / healthy)), "{faulty} {healthy}");
    }
}

#[test]
fn sensors_are_not_called_stuck_after_a_window_too_short_to_see_how_they_move() {
    let config = Config {
        settle_s: 0.0,
        seed_s: 0.030,
        learn_s: 0.121,
        time_constants_s: [0.001, 0.005, 0.02, 0.1],
        ..config()
    };
    let mut watch = Watch::new(&config, 24);
    let verdicts = watch.run(3_000, |_, x| x);
    assert_eq!(verdicts[200].phase(), Phase::Monitoring);
    assert!(!verdicts.iter().any(|verdict| verdict.losses().next().is_some()));
}

#[test]
fn after_ten_minutes_a_twentieth_of_a_sigma_is_found_within_a_minute_and_its_end_within_another() {
    let watched = |config: &Config| {
        let mut watch = Watch::new(config, 25);
        assert!(!watch.run(614_000, |_, x| x).iter().any(Verdict::alarm));
        let verdicts = watch.run(60_000, off(Channel::Speed, 0.06));
        let withdrawn = verdicts.windows(2).filter(|pair| pair[0].deviates() && !pair[1].deviates()).count();
        assert_eq!(withdrawn, 0, "an alarm stands as long as the fault");
        if watch.guard.verdict().deviates() {
            let [size, ..] = watch.guard.deviation().unwrap();
            assert!((size / (0.06 * SIGMA[0]) - 1.0).abs() < 0.3, "its size is the trend's: {size}");
        }
        assert!(!watch.run(60_000, |_, x| x).last().unwrap().alarm());
        first_alarm(&verdicts)
    };
    assert!(watched(&config()).is_some());
    // The three quicker scales do not see it.
    assert_eq!(watched(&Config { time_constants_s: [0.0075, 0.075, 2.0, 2.0], ..config() }), None);
}

#[test]
fn a_benign_drift_is_followed_and_a_fault_that_grows_as_slowly_is_found_beyond_its_reach() {
    let time_constants_s = [0.0075, 0.075, 2.0, 2.0];
    let drifting = Config { memory_s: 20.0, drift_sigmas: 0.5, time_constants_s, ..config() };
    let ramp = |per_slot: f32, to: f32| {
        move |k: u32, mut x: [f32; 3]| {
            x[1] += (k as f32 * per_slot).min(to) * SIGMA[1];
            x
        }
    };
    // To 0.45 sigmas in 200 s: with the mean as learned, it is found.
    let watched = |config: &Config, to: f32| {
        let mut watch = Watch::new(config, 17);
        watch.run(14_000, |_, x| x);
        first_alarm(&watch.run(260_000, ramp(0.45 / 200_000.0, to))).is_some()
    };
    assert!(!watched(&drifting, 0.45), "followed");
    assert!(watched(&Config { drift_sigmas: 0.0, ..drifting }, 0.45), "not followed, and so found");
    assert!(watched(&Config { drift_sigmas: 0.2, ..drifting }, 0.55), "beyond its reach");
}

#[test]
fn a_mean_that_may_not_follow_is_not_taken_to_be_known_better_with_time() {
    let trend = |drift_sigmas| {
        let mut watch = Watch::new(&Config { drift_sigmas, ..config() }, 46);
        watch.run(100_000, |_, x| x);
        watch.guard.limits().unwrap()[TREND]
    };
    let (follows, fixed) = (trend(0.5), trend(0.0));
    assert!(fixed > 4.0 * follows, "{fixed} {follows}");
}
