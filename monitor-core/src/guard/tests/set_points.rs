//! What is known of set points: recalled, kept, stored, learned anew, and refused.

use super::*;

#[test]
fn a_loop_that_needs_longer_than_the_settling_time_is_learned_once_it_has_settled() {
    let mut watch = Watch::new(&config(), 26);
    let swinging_in = |k: u32, [a, b, c]: [f32; 3]| [a - 50.0 * (-(k as f32) / 600.0).exp(), b, c];
    watch.run(2_000, swinging_in);
    assert_eq!(watch.guard.refused(), Some(LearnError::Drifting(Channel::Speed)));
    let verdicts = watch.run(20_000, |k, x| swinging_in(k + 2_000, x));
    assert!(verdicts.last().unwrap().phase() == Phase::Monitoring && !verdicts.iter().any(Verdict::alarm));
    let sigma = watch.guard.model().unwrap().sigma()[0];
    assert!(sigma < 1.1 * SIGMA[0], "{sigma}");
}

#[test]
fn a_stored_model_judges_after_a_loss_of_power_as_it_did_before() {
    let mut watch = Watch::learned(27);
    (watch.set_point, watch.motor.mean) = (200.0, [200.0, 1.5, 7.0]);
    watch.run(30_000, |_, x| x);
    let bytes: Vec<Vec<u8>> = watch.guard.stored().map(|stored| stored.bytes().to_vec()).collect();
    assert_eq!(bytes.len(), 2);
    let mut next = Watch::new(&config(), 28);
    for bytes in &bytes {
        next.guard.restore(&Stored::of_bytes(bytes).unwrap()).unwrap();
    }
    (next.set_point, next.motor.mean) = (watch.set_point, watch.motor.mean);
    next.run(1, |_, x| x);
    assert_eq!((next.guard.model(), next.guard.limits()), (watch.guard.model(), watch.guard.limits()));
    let verdicts = next.run(1_000, |_, x| x);
    assert_eq!(phases(&verdicts), [Phase::Settling, Phase::Monitoring]);
    assert!(!next.run(20_000, |_, x| x).iter().any(Verdict::alarm));
    assert!(first_alarm(&next.run(500, off(Channel::Speed, 5.0))).is_some());
}

#[test]
fn a_model_of_another_sampling_rate_or_of_other_settings_or_a_damaged_one_is_refused_and_changes_nothing() {
    let watch = Watch::learned(29);
    let stored = watch.guard.stored().next().unwrap();
    let restored = |change: fn(&mut Config)| {
        let mut config = config();
        change(&mut config);
        let mut guard = Monitor::new(&config).unwrap();
        let result = guard.restore(&stored);
        assert_eq!(guard.stored().count(), usize::from(result.is_ok()));
        result
    };
    assert_eq!(restored(|_| ()), Ok(()));
    assert_eq!(restored(|c| c.sample_rate_hz = 500.0), Err(RestoreError::SampleRate(1_000.0)));
    assert_eq!(restored(|c| c.time_constants_s[2] = 3.0), Err(RestoreError::TimeConstants));
    assert_eq!(restored(|c| c.false_alarms_per_hour = 1.0), Err(RestoreError::FalseAlarmRate));
    let damaged = |place: usize| {
        let mut bytes = *stored.bytes();
        bytes[place] ^= 16;
        Stored::of_bytes(&bytes).map(|_| ())
    };
    assert_eq!(damaged(0), Err(RestoreError::Format));
    for place in 4..Stored::BYTES {
        assert_eq!(damaged(place), Err(RestoreError::Damaged));
    }
    assert_eq!(Stored::of_bytes(&stored.bytes()[1..]).map(|_| ()), Err(RestoreError::Length));
    assert_eq!(Stored::of_bytes(&[0; Stored::BYTES]).map(|_| ()), Err(RestoreError::Format));
}

#[test]
fn a_new_set_point_between_known_ones_is_healthy_where_a_propellers_load_lies_and_is_an_alarm_where_none_does() {
    let at = |speed: f32| [speed, 0.5 + 1.5 * (speed / 300.0).powi(2), 0.04 * speed];
    let mut watch = Watch::new(&config(), 30);
    let go = |watch: &mut Watch, speed: f32, extra: f32| {
        (watch.set_point, watch.motor.mean) = (speed, at(speed));
        watch.motor.mean[1] += extra;
        watch.run(14_000, |_, x| x)
    };
    for speed in [100.0, 300.0, 200.0] {
        let verdicts = go(&mut watch, speed, 0.0);
        assert!(
            verdicts.last().unwrap().phase() == Phase::Monitoring && !verdicts.iter().any(Verdict::alarm),
            "{speed}"
        );
    }
    // Half the load more.
    let verdicts = go(&mut watch, 150.0, 0.5);
    let found = first_alarm(&verdicts).unwrap();
    assert!(found < 1_200, "when the seeding windows are over: {found}");
    assert_eq!(watch.guard.refused(), Some(LearnError::Unexpected(Channel::ArmatureCurrent)));
    assert!(
        verdicts[found..].iter().all(|v| v.phase() == Phase::Withheld && v.since() == Some(verdicts[found].sample()))
    );
    // It is said to be healthy, and learned.
    watch.guard.acknowledge();
    let verdicts = watch.run(14_000, |_, x| x);
    assert!(verdicts.last().unwrap().phase() == Phase::Monitoring && !verdicts.iter().any(Verdict::alarm));
}

#[test]
fn a_known_set_point_is_recalled_and_an_unknown_one_is_learned() {
    let mut watch = Watch::learned(9);
    (watch.set_point, watch.motor.mean) = (200.0, [200.0, 1.5, 7.0]);
    let verdicts = watch.run(14_000, |_, x| x);
    assert_eq!(verdicts[0].phase(), Phase::Settling);
    assert!(!verdicts.iter().any(Verdict::alarm));
    assert_eq!(watch.guard.verdict().phase(), Phase::Monitoring);
    // Back, through a transient of half a second.
    (watch.set_point, watch.motor.mean) = (SET_POINT, MEAN);
    let transient = |k: u32, [a, b, c]: [f32; 3]| {
        let rest = (-(k as f32) / 150.0).exp();
        [a - 100.0 * rest, b + 3.0 * rest, c + 2.0 * rest]
    };
    let verdicts = watch.run(6_000, transient);
    assert_eq!(phases(&verdicts), [Phase::Settling, Phase::Monitoring], "recalled, and judged once it has settled");
    let settled = verdicts.iter().position(|v| v.phase() == Phase::Monitoring).unwrap();
    assert!((600..2_000).contains(&settled), "{settled}");
    assert!(!verdicts.iter().any(|v| v.alarm() || v.recovering()));
    let found = first_alarm(&watch.run(2_000, off(Channel::ArmatureVoltage, 2.0))).unwrap();
    assert!(found < 200, "{found}");
}

#[test]
fn nothing_is_learned_at_an_unknown_set_point_that_is_reached_with_a_fault() {
    let mut watch = Watch::learned(10);
    watch.run(1_000, off(Channel::ArmatureCurrent, 10.0));
    watch.set_point = 250.0;
    let verdicts = watch.run(8_000, off(Channel::ArmatureCurrent, 10.0));
    assert!(verdicts.iter().all(|v| v.phase() == Phase::Withheld && v.deviates()), "the alarm stands");
    // At the known one it goes on, and when the fault is gone it is silent, and learns again.
    watch.set_point = SET_POINT;
    let verdicts = watch.run(4_000, off(Channel::ArmatureCurrent, 10.0));
    assert!(verdicts.last().unwrap().deviates());
    assert!(!watch.run(4_000, |_, x| x).last().unwrap().deviates());
    watch.set_point = 250.0;
    watch.run(14_000, |_, x| x);
    assert_eq!(watch.guard.verdict().phase(), Phase::Monitoring);
}

#[test]
fn a_fault_that_begins_inside_the_gate_of_a_known_set_point_is_found_when_it_opens() {
    let mut watch = Watch::learned(20);
    (watch.set_point, watch.motor.mean) = (200.0, [200.0, 1.5, 7.0]);
    watch.run(14_000, |_, x| x);
    (watch.set_point, watch.motor.mean) = (SET_POINT, MEAN);
    let verdicts = watch.run(4_000, off(Channel::ArmatureCurrent, 4.0));
    assert_eq!(phases(&verdicts), [Phase::Settling, Phase::Monitoring]);
    let found = first_alarm(&verdicts).unwrap();
    assert!(found < 1_600, "{found}");
    assert!(verdicts[found..].iter().all(Verdict::deviates));
}

#[test]
fn a_loop_that_takes_its_time_to_settle_at_a_known_set_point_is_no_alarm() {
    for time_constant_s in [0.3, 1.0, 2.0] {
        let mut watch = Watch::learned(23);
        (watch.set_point, watch.motor.mean) = (200.0, [200.0, 1.5, 7.0]);
        watch.run(14_000, |_, x| x);
        (watch.set_point, watch.motor.mean) = (SET_POINT, MEAN);
        let settling = |k: u32, [a, b, c]: [f32; 3]| {
            let rest = (-(k as f32) / (1000.0 * time_constant_s)).exp();
            [a - 100.0 * rest, b + 3.0 * rest, c + 2.0 * rest]
        };
        let verdicts = watch.run(25_000, settling);
        assert_eq!(phases(&verdicts), [Phase::Settling, Phase::Monitoring]);
        assert_eq!(first_alarm(&verdicts), None, "{time_constant_s} s");
    }
}

#[test]
fn a_loop_that_does_not_settle_at_a_known_set_point_is_an_alarm_when_its_time_is_over() {
    let mut watch = Watch::learned(21);
    (watch.set_point, watch.motor.mean) = (200.0, [200.0, 1.5, 7.0]);
    watch.run(14_000, |_, x| x);
    (watch.set_point, watch.motor.mean) = (SET_POINT, MEAN);
    let settled = watch.guard.clone();
    for per_slot in [0.002, 0.005, 0.01, 0.02] {
        watch.guard = settled.clone();
        let swinging = |k: u32, [a, b, c]: [f32; 3]| [a + (k as f32 * per_slot).sin(), b, c];
        let found = first_alarm(&watch.run(16_000, swinging)).unwrap();
        assert!((1_000..15_000).contains(&found), "{found}");
    }
}

#[test]
fn a_fault_that_stands_is_found_at_ten_samples_a_second_and_in_visits_of_six_seconds() {
    let slow = Config {
        settle_s: 5.0,
        seed_s: 3.0,
        learn_s: 14.0,
        time_constants_s: [0.1, 0.58, 2.8, 50.0],
        ..Config::at_rate(10.0)
    };
    for size in [0.0, 3.0] {
        let mut watch = Watch::new(&slow, 48);
        let mut go = |speed: f32, slots: u32, size: f32| {
            (watch.set_point, watch.motor.mean[0]) = (speed, speed);
            watch.run(slots, off(Channel::ArmatureVoltage, size)).iter().any(Verdict::alarm)
        };
        assert!(!go(200.0, 600, 0.0) && !go(300.0, 600, 0.0));
        let found = (0..20).map(|_| go(200.0, 10, size) | go(300.0, 60, size)).position(|found| found);
        assert!(if size > 0.0 { found <= Some(1) && found.is_some() } else { found.is_none() }, "{size}: {found:?}");
    }
}

#[test]
fn what_has_become_known_of_a_set_point_is_kept_for_the_next_visit() {
    let mut watch = Watch::learned(22);
    let young = watch.guard.limits().unwrap();
    watch.run(60_000, |_, x| x);
    let sharp = watch.guard.limits().unwrap();
    (watch.set_point, watch.motor.mean) = (200.0, [200.0, 1.5, 7.0]);
    watch.run(14_000, |_, x| x);
    (watch.set_point, watch.motor.mean) = (SET_POINT, MEAN);
    watch.run(1, |_, x| x);
    assert_eq!(watch.guard.limits(), Some(sharp));
    assert!(sharp[2] < 0.9 * young[2], "{sharp:?} {young:?}");
}

/// The readings of a propeller at a speed.
fn propeller(speed: f32) -> [f32; 3] {
    [speed, 0.5 + 1.5 * (speed / 300.0).powi(2), 0.04 * speed]
}

/// One that has learned two set points, and goes to one between them.
fn between(seed: u64) -> Watch {
    let mut watch = Watch::new(&config(), seed);
    for speed in [100.0, 300.0] {
        (watch.set_point, watch.motor.mean) = (speed, propeller(speed));
        watch.run(20_000, |_, x| x);
        assert_eq!(watch.guard.verdict().phase(), Phase::Monitoring);
    }
    (watch.set_point, watch.motor.mean) = (220.0, propeller(220.0));
    watch
}

#[test]
fn a_set_point_between_known_ones_is_judged_as_soon_as_it_has_been_seeded_and_limits_sharpen() {
    let mut watch = between(40);
    let sharp = watch.guard.limits().unwrap();
    let verdicts = watch.run(1_300, |_, x| x);
    assert_eq!(phases(&verdicts), [Phase::Settling, Phase::Seeding, Phase::Settling, Phase::Monitoring]);
    let young = watch.guard.limits().unwrap();
    assert!(young[0] < 1.5 * sharp[0] && young[2] > 2.0 * sharp[2], "a mean of half a second: {young:?} {sharp:?}");
    // A fault of five sigmas is found in milliseconds, and does not become the new normal.
    let mut struck = Watch { guard: watch.guard.clone(), ..watch };
    let verdicts = struck.run(20_000, off(Channel::ArmatureCurrent, 5.0));
    let found = first_alarm(&verdicts).unwrap();
    assert!(found < 40 && verdicts[found..].iter().all(Verdict::deviates), "{found}");
    let mut watch = between(40);
    let verdicts = watch.run(60_000, |_, x| x);
    assert!(!verdicts.iter().any(Verdict::alarm));
    let old = watch.guard.limits().unwrap();
    assert!(old[2] < 1.1 * sharp[2], "{old:?} {sharp:?}");
    let found = first_alarm(&watch.run(4_000, off(Channel::ArmatureVoltage, 0.2))).unwrap();
    assert!(found > 100, "{found}");
}

#[test]
fn a_set_point_between_known_ones_whose_noise_is_another_is_learned_whole() {
    let mut watch = between(41);
    let louder = |_, x: [f32; 3]| {
        let [speed, ..] = propeller(220.0);
        [speed + 1.5 * (x[0] - speed), x[1], x[2]]
    };
    let verdicts = watch.run(6_000, louder);
    let phases = phases(&verdicts);
    assert_eq!(phases, [Phase::Settling, Phase::Seeding, Phase::Learning, Phase::ModelDue, Phase::Monitoring]);
}

#[test]
fn what_neighbours_have_lent_drives_nothing_out_that_was_learned() {
    let mut watch = Watch::new(&config(), 42);
    let mut go = |speed: f32, slots: u32| {
        (watch.set_point, watch.motor.mean) = (speed, propeller(speed));
        watch.run(slots, |_, x| x);
        let kept: Vec<f32> = watch.guard.stored().map(|stored| stored.set_point()).collect();
        kept
    };
    for speed in [100.0, 300.0, 400.0, 500.0] {
        go(speed, 14_000);
    }
    // Judged, but not for as long as a window: not kept.
    go(200.0, 3_000);
    assert_eq!(go(250.0, 2_000), [100.0, 300.0, 400.0, 500.0]);
    // For longer, it is as good as learned.
    go(200.0, 9_000);
    assert_eq!(go(250.0, 2_000), [200.0, 300.0, 400.0, 500.0]);
}
