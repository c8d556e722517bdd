//! The phases of a monitor, and what it does with samples it cannot use.

use super::*;
use crate::moving_average::MovingAverage;
use crate::paper::localize::{Diagnosis, Fault};
use crate::paper::verdict::Rejected;
use crate::sample::{Channel, Pair};
use proptest::prelude::*;

extern crate std;
use std::vec::Vec;

const SET_POINT: f32 = 300.0;

fn config() -> Config {
    let pairs = PerPair { speed_current: 3.0, current_voltage: 3.0, speed_voltage: 3.0 };
    Config { settle_s: 0.05, learn_s: 0.5, cutoff_hz: 20.0, ..Config::paper(1000.0, Bank { full: 3.0, pairs }) }
}

/// A reproducible healthy sample; `k` also seeds it, so any two runs see the same motor.
fn healthy(k: u64) -> [f32; 3] {
    let uniform = |salt: u64| {
        let mixed = (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15 ^ salt.wrapping_mul(0xd1b5_4a32_d192_ed03));
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((mixed ^ (mixed >> 32)) >> 40) as f32 / (1 << 24) as f32 - 0.5
    };
    [300.0 + 0.3 * uniform(1), 2.0 + 0.06 * uniform(2), 9.7 + 0.06 * uniform(3)]
}

fn with(mut x: [f32; 3], channel: Channel, change: f32) -> [f32; 3] {
    x[channel.position()] += change;
    x
}

/// Steps through samples; installs the model when it is due; returns the verdicts.
fn fly<S: Smoother>(monitor: &mut Monitor<S>, samples: impl Iterator<Item = (f32, [f32; 3])>) -> Vec<Verdict> {
    samples
        .map(|(set_point, x)| {
            let verdict = *monitor.step_channels(set_point, x);
            if verdict.phase() == Phase::ModelDue {
                let _ = monitor.finish_learning();
            }
            verdict
        })
        .collect()
}

fn learned() -> Monitor {
    let mut monitor = Monitor::new(&config()).unwrap();
    fly(&mut monitor, (0..600).map(|k| (SET_POINT, healthy(k))));
    assert!(monitor.baseline().is_some());
    monitor
}

#[test]
fn a_monitor_settles_learns_and_judges_the_first_sample_after_the_window() {
    let verdicts = fly(&mut Monitor::new(&config()).unwrap(), (0..600).map(|k| (SET_POINT, healthy(k))));
    assert_eq!(verdicts[0].phase(), Phase::Settling(Settling::Start));
    assert_eq!(verdicts[49].phase(), Phase::Settling(Settling::Start));
    assert_eq!(verdicts[50].phase(), Phase::Learning);
    assert_eq!(verdicts[549].phase(), Phase::ModelDue); // 500 samples, 50..=549
    assert_eq!(verdicts[550].phase(), Phase::Monitoring);
    assert!(verdicts[..550].iter().all(|v| v.residuals().is_none()));
    assert!(verdicts[550..].iter().all(|v| v.residuals().is_some() && !v.relays().any()));
}

#[test]
fn no_sample_is_judged_and_none_is_lost_while_the_model_is_awaited() {
    let mut monitor = Monitor::new(&config()).unwrap();
    let phases: Vec<Phase> = (0..560).map(|k| monitor.step_channels(SET_POINT, healthy(k)).phase()).collect();
    assert!(phases[549..].iter().all(|p| *p == Phase::ModelDue));
    assert_eq!(monitor.learned_window().map(|w| w.samples()), Some(500));
    assert_eq!(monitor.finish_learning(), Ok(true));
    assert_eq!(monitor.step_channels(SET_POINT, healthy(560)).phase(), Phase::Monitoring);
}

#[test]
fn each_fault_of_the_paper_is_detected_and_named_by_the_channels_it_moves() {
    // In the loop a load moves current and voltage, a speed-sensor drift the voltage, a current-sensor drift the current.
    let cases: [(Fault, &[Channel]); 3] = [
        (Fault::LoadTorque, &[Channel::ArmatureCurrent, Channel::ArmatureVoltage]),
        (Fault::SpeedSensor, &[Channel::ArmatureVoltage]),
        (Fault::CurrentSensor, &[Channel::ArmatureCurrent]),
    ];
    for (fault, moved) in cases {
        let mut monitor = learned();
        let faulty = |k| (SET_POINT, moved.iter().fold(healthy(k), |x, channel| with(x, *channel, 0.2)));
        let verdicts = fly(&mut monitor, (600..1100).map(faulty));
        let last = verdicts.last().unwrap();
        assert_eq!(last.diagnosis(), Diagnosis::Fault(fault));
        assert!(last.relays().full);
        assert!(last.alarm_since().is_some_and(|s| (600..650).contains(&s)), "{last:?}");
        let cleared = fly(&mut monitor, (1100..2000).map(|k| (SET_POINT, healthy(k))));
        let last = cleared.last().unwrap();
        assert_eq!((last.diagnosis(), last.alarm_since()), (Diagnosis::Healthy, None));
    }
}

#[test]
fn an_alarm_stands_since_the_sample_that_brought_its_first_relay_up() {
    let mut monitor = learned();
    let drift = |k| if k < 1200 { 0.1 } else { 0.0 };
    let mut since = None;
    let drifting = (600..1800).map(|k| (SET_POINT, with(healthy(k), Channel::ArmatureVoltage, drift(k))));
    for verdict in fly(&mut monitor, drifting) {
        since = verdict.relays().any().then(|| since.unwrap_or(verdict.sample()));
        assert_eq!(verdict.alarm_since(), since);
        assert_eq!(verdict.alarm(), since.is_some());
        let named = matches!(verdict.diagnosis(), Diagnosis::Fault(Fault::SpeedSensor));
        assert!(named || verdict.sample() < 700 || verdict.sample() > 1200, "{verdict:?}");
    }
    assert_eq!(since, None, "the alarm ends with the drift");
}

#[test]
fn a_sample_with_units_is_judged_as_its_three_numbers_are() {
    let (mut named, mut plain) = (learned(), learned());
    for k in 600..700 {
        let [speed, current, voltage] = with(healthy(k), Channel::ArmatureCurrent, 0.1);
        let sample = Sample {
            speed: RadPerSec(speed),
            armature_current: crate::units::Amperes(current),
            armature_voltage: crate::units::Volts(voltage),
        };
        assert_eq!(named.step(RadPerSec(SET_POINT), sample), plain.step_channels(SET_POINT, [speed, current, voltage]));
    }
    assert_eq!(named.thresholds(), config().thresholds);
}

#[test]
fn a_slot_without_a_usable_sample_is_reported_and_leaves_model_filters_and_relays_as_they_were() {
    for drift in [0.0, 0.2] {
        let mut clean = Monitor::new(&config()).unwrap();
        fly(&mut clean, (0..600).map(|k| (SET_POINT, healthy(k))));
        let moved = |k| (SET_POINT, with(healthy(k), Channel::ArmatureVoltage, drift));
        fly(&mut clean, (600..800).map(moved));
        let mut hit = clean.clone();
        let standing = *hit.clone().step_channels(SET_POINT, moved(800).1);
        let bad = |channel, value: f32| {
            let mut x = moved(0).1;
            x[channel] = value;
            x
        };
        let verdicts = [
            (*hit.step_channels(SET_POINT, bad(0, f32::NAN)), Rejected::NonFinite(Channel::Speed)),
            (*hit.step_channels(SET_POINT, bad(2, f32::NEG_INFINITY)), Rejected::OutOfRange(Channel::ArmatureVoltage)),
            (*hit.step_channels(SET_POINT, bad(1, f32::INFINITY)), Rejected::OutOfRange(Channel::ArmatureCurrent)),
            (*hit.step_channels(SET_POINT, bad(2, 1e38)), Rejected::OutOfRange(Channel::ArmatureVoltage)),
            (*hit.step_channels(f32::NAN, moved(0).1), Rejected::NonFiniteSetPoint),
            (*hit.step_channels(f32::INFINITY, moved(0).1), Rejected::NonFiniteSetPoint),
            (*hit.skip(Absence::Late), Rejected::Absent(Absence::Late)),
            (*hit.skip(Absence::Missing), Rejected::Absent(Absence::Missing)),
        ];
        for (index, (verdict, why)) in (800..).zip(&verdicts) {
            assert_eq!((verdict.sample(), verdict.rejected()), (index, Some(*why)));
            assert_eq!((verdict.phase(), verdict.residuals()), (Phase::Monitoring, None));
            assert_eq!((verdict.relays(), verdict.alarm_since()), (standing.relays(), standing.alarm_since()));
        }
        assert_eq!(standing.alarm(), drift > 0.0, "one run with an alarm that must stand, one without");
        for k in 800..1500 {
            let (a, b) = (*clean.step_channels(SET_POINT, moved(k).1), *hit.step_channels(SET_POINT, moved(k).1));
            assert_eq!((a.residuals(), a.relays(), a.sample() + 8), (b.residuals(), b.relays(), b.sample()));
        }
    }
}

#[test]
fn a_learning_window_is_as_long_as_it_should_be_and_learns_from_the_fit_samples_alone() {
    let hole = |k: u64| (100..120).contains(&k) || k == 50 || k == 549;
    let sample = |k| if hole(k) { with(healthy(k), Channel::Speed, f32::NAN) } else { healthy(k) };
    let mut monitor = Monitor::new(&config()).unwrap();
    let phases = fly(&mut monitor, (0..550).map(|k| (SET_POINT, sample(k)))).into_iter().map(|v| v.phase());
    assert_eq!(phases.skip(548).collect::<Vec<_>>(), [Phase::Learning, Phase::ModelDue]); // 500 slots, 50..=549
    let fit: Moments<3> = (51..549).filter(|k| !hole(*k)).map(healthy).collect();
    let (expected, found) = (fit.statistics().unwrap(), monitor.baseline().unwrap().stored());
    assert_eq!(found.samples, 478);
    for channel in 0..3 {
        assert!((found.mean[channel] - expected.mean[channel]).abs() < 1e-4);
        assert!((found.sigma[channel] / expected.sigma()[channel] - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_wild_first_sample_of_a_window_costs_no_digits_and_without_settling_a_window_waits_for_a_fit_one() {
    let wild = |k| if k == 50 { with(healthy(k), Channel::Speed, 1e4) } else { healthy(k) };
    let mut monitor = Monitor::new(&Config { learn_s: 10.0, ..config() }).unwrap();
    fly(&mut monitor, (0..10_050).map(|k| (SET_POINT, wild(k))));
    let exact = 1e4 / 10_000_f64.sqrt(); // the spike alone, by far
    assert!((f64::from(monitor.baseline().unwrap().sigma()[0]) / exact - 1.0).abs() < 1e-3);
    assert!((monitor.baseline().unwrap().sigma()[1] / 0.0173 - 1.0).abs() < 0.02);

    let mut monitor = Monitor::new(&Config { settle_s: 0.0, ..config() }).unwrap();
    let hole = |k| if k < 10 { [f32::NAN; 3] } else { healthy(k) };
    let phases: Vec<Phase> =
        fly(&mut monitor, (0..511).map(|k| (SET_POINT, hole(k)))).iter().map(Verdict::phase).collect();
    assert_eq!(phases[9], Phase::Settling(Settling::Start));
    assert_eq!((phases[10], phases[508], phases[509]), (Phase::Learning, Phase::Learning, Phase::ModelDue));
}

#[test]
fn a_change_of_the_set_point_voids_the_baseline_settles_and_learns_anew() {
    let mut monitor = learned();
    fly(&mut monitor, (600..700).map(|k| (SET_POINT, with(healthy(k), Channel::ArmatureCurrent, 1.0))));
    let verdicts = fly(&mut monitor, (700..1400).map(|k| (200.0, with(healthy(k), Channel::Speed, -100.0))));
    assert_eq!(verdicts[0].phase(), Phase::Settling(Settling::SetPointChanged));
    assert!(!verdicts[0].relays().any() && verdicts[0].alarm_since().is_none());
    assert_eq!(verdicts[50].phase(), Phase::Learning);
    assert_eq!(verdicts[550].phase(), Phase::Monitoring);
    assert!(verdicts.iter().all(|v| v.diagnosis() == Diagnosis::Healthy));
    assert!((monitor.baseline().unwrap().mean()[0] - 200.0).abs() < 0.1);
}

#[test]
fn a_model_that_comes_after_the_set_point_has_changed_is_ignored() {
    let mut monitor = Monitor::new(&config()).unwrap();
    (0..550).for_each(|k| {
        monitor.step_channels(SET_POINT, healthy(k));
    });
    let learned = Baseline::learn(monitor.learned_window().unwrap(), ExplainedShare::PAPER);
    monitor.step_channels(200.0, healthy(550));
    assert!(!monitor.install(learned));
    assert!(monitor.baseline().is_none());
}

#[test]
fn a_window_with_a_constant_channel_is_refused_with_its_name_and_a_new_one_begins() {
    let mut monitor = Monitor::new(&config()).unwrap();
    let stuck = |k| (SET_POINT, [300.0, healthy(k)[1], healthy(k)[2]]);
    let verdicts = fly(&mut monitor, (0..700).map(stuck));
    assert_eq!(verdicts[551].phase(), Phase::Learning);
    assert_eq!(monitor.refused(), Some(LearnError::ConstantChannel(Channel::Speed)));
    let verdicts = fly(&mut monitor, (700..2000).map(|k| (SET_POINT, healthy(k))));
    assert_eq!((verdicts.last().map(|v| v.phase()), monitor.refused()), (Some(Phase::Monitoring), None));
}

#[test]
fn a_refused_window_is_over_at_once_even_for_a_slot_whose_set_point_is_no_number() {
    let mut monitor = Monitor::new(&config()).unwrap();
    (0..550).for_each(|k| {
        monitor.step_channels(SET_POINT, [300.0, healthy(k)[1], healthy(k)[2]]);
    });
    assert!(monitor.finish_learning().is_err());
    assert_eq!(monitor.step_channels(f32::NAN, healthy(550)).phase(), Phase::Learning);
}

#[test]
fn a_monitor_with_a_stored_baseline_judges_from_the_first_sample() {
    let baseline = *learned().baseline().unwrap();
    let stored = Baseline::from_stored(&baseline.stored(), ExplainedShare::PAPER).unwrap();
    let mut monitor = Monitor::new(&config()).unwrap().starting_from(stored, SET_POINT);
    let verdict = *monitor.step_channels(SET_POINT, healthy(0));
    assert_eq!(verdict.phase(), Phase::Monitoring);
    assert!(verdict.residuals().is_some());
    let changed = monitor.step_channels(SET_POINT + 1.0, healthy(1));
    assert_eq!(changed.phase(), Phase::Settling(Settling::SetPointChanged));
}

#[test]
fn a_known_baseline_is_recalled_once_the_loop_has_settled_and_not_before() {
    let mut monitor = learned();
    let baseline = *monitor.baseline().unwrap();
    assert!(!monitor.recall(baseline), "a monitor that judges keeps its baseline");
    fly(&mut monitor, (0..60).map(|k| (200.0, with(healthy(k), Channel::Speed, -100.0))));
    monitor.step_channels(SET_POINT, healthy(60));
    assert!(!monitor.recall(baseline), "the loop is still settling");
    let phases: Vec<Phase> = (61..112).map(|k| monitor.step_channels(SET_POINT, healthy(k)).phase()).collect();
    assert_eq!(phases.last(), Some(&Phase::Learning));
    assert!(monitor.recall(baseline));
    let verdict = *monitor.step_channels(SET_POINT, healthy(112));
    assert_eq!((verdict.phase(), verdict.relays().any()), (Phase::Monitoring, false));
}

#[test]
fn the_moving_average_smooths_in_place_of_the_low_pass() {
    let mut monitor = Monitor::with_smoother(&config(), MovingAverage::<64>::new(50).unwrap()).unwrap();
    fly(&mut monitor, (0..600).map(|k| (SET_POINT, healthy(k))));
    let verdicts = fly(&mut monitor, (600..700).map(|k| (SET_POINT, with(healthy(k), Channel::ArmatureCurrent, 0.2))));
    assert_eq!(verdicts[99].diagnosis(), Diagnosis::Fault(Fault::CurrentSensor));
}

#[test]
fn contributions_name_the_channel_that_moved_while_the_monitor_judges_and_only_then() {
    let x = with(healthy(0), Channel::ArmatureVoltage, 0.5);
    assert_eq!(Monitor::new(&config()).unwrap().contributions(x), None);
    let contributions = learned().contributions(x).unwrap();
    assert!(contributions[2] > 10.0 * (contributions[0] + contributions[1]));
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut Config)| {
        let mut config = config();
        change(&mut config);
        Monitor::new(&config).unwrap_err()
    };
    assert_eq!(refused(|c| c.sample_rate_hz = f32::NAN), ConfigError::Cutoff);
    assert_eq!(refused(|c| c.settle_s = -1.0), ConfigError::SettleTime);
    assert_eq!(refused(|c| c.settle_s = 1e9), ConfigError::SettleTime);
    assert_eq!(refused(|c| c.learn_s = 0.029), ConfigError::LearnTime);
    assert_eq!(refused(|c| c.learn_s = f32::NAN), ConfigError::LearnTime);
    assert_eq!(refused(|c| c.set_point_tolerance = -0.1), ConfigError::SetPointTolerance);
    assert_eq!(refused(|c| c.explained_share = 1.5), ConfigError::ExplainedShare);
    assert_eq!(refused(|c| c.cutoff_hz = 500.0), ConfigError::Cutoff);
    assert_eq!(refused(|c| c.hysteresis = 1.0), ConfigError::Hysteresis);
    assert_eq!(refused(|c| c.thresholds.full = 0.0), ConfigError::Threshold(ModelId::Full));
    assert_eq!(
        refused(|c| c.thresholds.pairs.speed_voltage = f32::NAN),
        ConfigError::Threshold(ModelId::Pair(Pair::SpeedVoltage))
    );
    let average = MovingAverage::<8>::new(4).unwrap();
    let rate = Monitor::with_smoother(&Config { sample_rate_hz: 0.0, ..config() }, average).unwrap_err();
    assert_eq!(rate, ConfigError::SampleRate);
}

proptest! {
    #[test]
    fn no_input_makes_step_panic_or_a_residual_that_is_not_finite(
        bits in prop::collection::vec((any::<u32>(), prop::array::uniform3(any::<u32>())), 1..200),
        wild in any::<bool>(),
    ) {
        let mut monitor = learned();
        for (k, (set_point, x)) in bits.iter().enumerate() {
            let set_point = if wild { f32::from_bits(*set_point) } else { SET_POINT };
            let verdict = *monitor.step_channels(set_point, x.map(f32::from_bits));
            let finite = |r: Bank<f32>| ModelId::ALL.iter().all(|m| r.get(*m).is_finite());
            prop_assert!(verdict.residuals().is_none_or(finite), "sample {k}: {verdict:?}");
            let _ = monitor.finish_learning();
        }
        // Whatever came, healthy samples at a constant set point bring the monitor back to silence.
        let last = fly(&mut monitor, (0..3000).map(|k| (SET_POINT, healthy(k)))).pop().unwrap();
        prop_assert_eq!((last.phase(), last.diagnosis()), (Phase::Monitoring, Diagnosis::Healthy));
    }
}

#[test]
fn a_monitor_fits_into_512_bytes() {
    let size = size_of::<Monitor>();
    assert!(size <= 512, "{size} bytes");
}
