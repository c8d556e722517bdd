//! The monitor in `guard` mode as a whole: what it finds, when it is silent, and what bad situations do to it.

use super::*;

mod learning;
mod lorden;
mod set_points;

extern crate std;
use std::vec::Vec;

const MEAN: [f32; 3] = [300.0, 2.0, 10.0];
const SIGMA: [f32; 3] = [0.1, 0.02, 0.02];
const SET_POINT: f32 = 300.0;

/// Normal noise, current and voltage correlated.
struct Motor {
    seed: u64,
    mean: [f32; 3],
}

impl Motor {
    fn new(seed: u64) -> Self {
        Motor { seed: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15), mean: MEAN }
    }

    fn uniform(&mut self) -> f32 {
        self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.seed >> 40) as f32 / (1 << 24) as f32
    }

    fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.uniform()).sum::<f32>() - 6.0
    }

    fn sample(&mut self) -> [f32; 3] {
        let (a, b, c) = (self.normal(), self.normal(), self.normal());
        let z = [a, b, 0.8 * b + 0.6 * c];
        core::array::from_fn(|i| self.mean[i] + SIGMA[i] * z[i])
    }
}

fn config() -> Config {
    Config { settle_s: 0.1, seed_s: 0.5, learn_s: 4.0, ..Config::at_rate(1000.0) }
}

/// A monitor and the motor it watches.
struct Watch {
    guard: Monitor,
    motor: Motor,
    set_point: f32,
}

impl Watch {
    fn new(config: &Config, seed: u64) -> Self {
        Watch { guard: Monitor::new(config).unwrap(), motor: Motor::new(seed), set_point: SET_POINT }
    }

    /// One that has learned, and proven its limits.
    fn learned(seed: u64) -> Self {
        let mut watch = Watch::new(&config(), seed);
        watch.run(14_000, |_, x| x);
        assert_eq!(watch.guard.verdict().phase(), Phase::Monitoring);
        watch
    }

    /// Runs so many slots, samples changed by `change`; returns the verdicts.
    fn run(&mut self, slots: u32, change: impl Fn(u32, [f32; 3]) -> [f32; 3]) -> Vec<Verdict> {
        (0..slots)
            .map(|k| {
                let x = change(k, self.motor.sample());
                let verdict = *self.guard.step_channels(self.set_point, x);
                let _ = self.guard.finish_learning();
                verdict
            })
            .collect()
    }
}

/// Moves a reading by so many of its sigmas.
fn off(channel: Channel, sigmas: f32) -> impl Fn(u32, [f32; 3]) -> [f32; 3] {
    move |_, mut x| {
        x[channel.position()] += sigmas * SIGMA[channel.position()];
        x
    }
}

/// Phases one after the other.
fn phases(verdicts: &[Verdict]) -> Vec<Phase> {
    let mut phases: Vec<Phase> = verdicts.iter().map(Verdict::phase).collect();
    phases.dedup();
    phases
}

fn first_alarm(verdicts: &[Verdict]) -> Option<usize> {
    verdicts.iter().position(Verdict::deviates)
}

#[test]
fn a_monitor_settles_seeds_learns_and_then_is_silent() {
    let mut watch = Watch::new(&config(), 1);
    let verdicts = watch.run(120_000, |_, x| x);
    assert_eq!(
        phases(&verdicts),
        [Phase::Settling, Phase::Seeding, Phase::Learning, Phase::ModelDue, Phase::Monitoring]
    );
    assert!(!verdicts.iter().any(Verdict::alarm));
    let model = watch.guard.model().unwrap();
    for i in 0..3 {
        assert!((model.mean()[i] - MEAN[i]).abs() < 0.1 * SIGMA[i]);
        assert!((model.sigma()[i] / SIGMA[i] - 1.0).abs() < 0.05);
    }
}

#[test]
fn a_large_shift_is_found_in_a_few_samples_and_one_of_a_quarter_of_a_sigma_in_two_seconds() {
    for channel in Channel::ALL {
        let mut watch = Watch::learned(2);
        watch.run(60_000, |_, x| x);
        let since = watch.guard.verdict().sample() + 1;
        let verdicts = watch.run(2_000, off(channel, 20.0));
        let found = first_alarm(&verdicts).unwrap();
        assert!(found <= 2, "{channel:?}: {found}");
        assert!(!verdicts[found..found + 50].iter().any(Verdict::settled), "too early for a name");
        assert_eq!(watch.guard.verdict().since(), Some(since + found as u64));
        let mut watch = Watch::learned(3);
        watch.run(60_000, |_, x| x);
        let found = first_alarm(&watch.run(2_000, off(channel, 0.25))).unwrap();
        assert!(found > 20, "{channel:?}: {found}");
    }
}

#[test]
fn an_alarm_is_withdrawn_as_fast_after_a_huge_fault_as_after_a_small_one() {
    let clear = |seed, sigmas| {
        let mut watch = Watch::learned(seed);
        watch.run(5_000, off(Channel::ArmatureVoltage, sigmas));
        assert!(watch.guard.verdict().deviates(), "{sigmas}");
        watch.run(2_000, |_, x| x).iter().rposition(Verdict::deviates).unwrap()
    };
    let medians = [5.0, 50.0, 500.0, 5_000.0].map(|sigmas| {
        let mut slots: Vec<usize> = (50..61).map(|seed| clear(seed, sigmas)).collect();
        slots.sort_unstable();
        assert!(slots[0] >= 20 && slots[10] < 90, "{sigmas} sigmas: {slots:?}");
        slots[5] as f32
    });
    let [least, greatest] = [f32::min, f32::max].map(|of| medians.into_iter().reduce(of).unwrap());
    assert!(greatest - least <= 0.2 * (greatest + least), "flat within a fifth to either side: {medians:?}");
}

#[test]
fn an_alarm_is_withdrawn_when_a_small_fault_goes_as_slowly_as_a_loop_lets_it() {
    for (seed, sigmas) in (40..60).zip([0.5, 1.0, 1.5, 2.0].into_iter().cycle()) {
        let mut watch = Watch::learned(seed);
        watch.run(8_000, off(Channel::ArmatureCurrent, sigmas));
        assert!(watch.guard.verdict().deviates(), "{sigmas}");
        let going = |k: u32, x| off(Channel::ArmatureCurrent, sigmas * (-(k as f32) / 150.0).exp())(k, x);
        let last = watch.run(8_000, going).iter().rposition(Verdict::deviates).unwrap();
        assert!(last < 2_000, "{sigmas} sigmas: {last} slots");
    }
}

#[test]
fn after_an_alarm_the_monitor_finds_the_next_fault() {
    let mut watch = Watch::learned(5);
    watch.run(3_000, off(Channel::Speed, 50.0));
    let between = watch.run(3_000, |_, x| x);
    assert!(!between.last().unwrap().alarm() && !between.last().unwrap().recovering());
    assert!(first_alarm(&watch.run(2_000, off(Channel::ArmatureCurrent, 0.4))).is_some());
}

#[test]
fn a_dead_sensor_is_a_verdict_of_its_own_and_the_other_two_are_still_judged() {
    for (channel, other) in [
        (Channel::Speed, Channel::ArmatureVoltage),
        (Channel::ArmatureCurrent, Channel::Speed),
        (Channel::ArmatureVoltage, Channel::ArmatureCurrent),
    ] {
        let position = channel.position();
        let dead = move |mut x: [f32; 3]| {
            x[position] = f32::NAN;
            x
        };
        let mut watch = Watch::learned(11);
        let verdicts = watch.run(5_000, |_, x| dead(x));
        assert!(verdicts[0].rejected() && !verdicts[0].alarm(), "one reading is no loss");
        assert_eq!(verdicts[20].losses().collect::<Vec<_>>(), [(channel, Loss::Silent)]);
        assert!(verdicts[20].alarm() && !verdicts.iter().any(Verdict::deviates));
        assert!(verdicts[100..].iter().all(|v| v.severity().is_some()), "two are judged");
        let found = first_alarm(&watch.run(2_000, |k, x| dead(off(other, 3.0)(k, x)))).unwrap();
        assert!(found < 200, "{channel:?} lost, {other:?} off: {found}");
        watch.run(2_000, |_, x| dead(x));
        // It comes back.
        let verdicts = watch.run(1_000, |_, x| x);
        assert!(verdicts[100..].iter().all(|v| !v.alarm() && v.severity().is_some()));
    }
}

#[test]
fn a_sensor_that_stands_still_is_stuck_and_a_coarse_converter_is_not() {
    let mut watch = Watch::learned(12);
    let held = watch.guard.verdict().readings()[0];
    let verdicts = watch.run(1_000, |_, [_, b, c]| [held, b, c]);
    let found = verdicts.iter().position(|v| v.losses().next() == Some((Channel::Speed, Loss::Stuck))).unwrap();
    assert!(found < 500, "{found}");
    assert!(!watch.run(1_000, |_, x| x)[200..].iter().any(Verdict::alarm), "it moves again");
    // Readings that repeat nine times of ten.
    let step = 0.15;
    let coarse = |_: u32, [a, b, c]: [f32; 3]| [a, (b / step).round() * step, c];
    let mut watch = Watch::new(&Config { converter_steps: [0.0, step, 0.0], ..config() }, 13);
    watch.motor.mean[1] = 2.07;
    let verdicts = watch.run(60_000, coarse);
    assert_eq!(verdicts.last().unwrap().phase(), Phase::Monitoring, "{:?}", watch.guard.refused());
    let alarm = verdicts.iter().find(|v| v.alarm());
    assert!(alarm.is_none(), "{alarm:?} {:?} {:?}", watch.guard.limits(), watch.guard.model());
}

#[test]
fn with_two_sensors_lost_nothing_is_judged_and_nothing_is_poisoned() {
    let mut watch = Watch::learned(14);
    let verdicts = watch.run(2_000, |_, [a, _, _]| [a + 100.0, f32::NAN, f32::INFINITY]);
    assert!(verdicts.iter().all(|v| v.rejected() && !v.deviates()));
    assert_eq!(verdicts[500].losses().count(), 2);
    let verdicts = watch.run(5_000, |_, x| x);
    assert!(!verdicts[200..].iter().any(Verdict::alarm));
}

#[test]
fn slots_without_a_sample_are_said_and_change_nothing() {
    let mut watch = Watch::learned(15);
    let before = watch.guard.deviation();
    assert_eq!(watch.guard.skip(Absence::Missing).absent(), Some(Absence::Missing));
    assert!(watch.guard.verdict().rejected() && watch.guard.deviation() == before);
    assert_eq!(watch.guard.skip(Absence::Late).absent(), Some(Absence::Late));
    assert!(!watch.run(1_000, |_, x| x).iter().any(Verdict::alarm));
    // Every other one missing is no lost sensor; sixteen in a row are a gap.
    for _ in 0..1_000 {
        assert!(!watch.guard.skip(Absence::Missing).alarm() && !watch.run(1, |_, x| x)[0].alarm());
    }
    let gaps = (0..20).filter(|_| watch.guard.skip(Absence::Missing).gap()).count();
    assert!(gaps == 5 && watch.guard.verdict().alarm() && watch.guard.verdict().losses().next().is_none());
    assert!(!watch.run(1_000, |_, x| x).iter().any(Verdict::alarm));
}

#[test]
fn readings_of_any_size_leave_a_monitor_that_works() {
    let mut watch = Watch::learned(16);
    for wild in [f32::MAX, -f32::MAX, 1e38, 1e30, 1e-40, f32::NEG_INFINITY, f32::NAN] {
        watch.run(3, |_, [a, b, _]| [a, b, wild]);
        let verdicts = watch.run(4_000, |_, x| x);
        assert!(!verdicts.last().unwrap().alarm(), "after {wild}");
    }
    assert!(first_alarm(&watch.run(2_000, off(Channel::Speed, 1.0))).is_some());
}

#[test]
fn a_latched_alarm_stands_until_it_is_acknowledged() {
    let mut watch = Watch::new(&Config { latch: true, ..config() }, 18);
    watch.run(14_000, |_, x| x);
    watch.run(500, off(Channel::Speed, 20.0));
    assert!(watch.run(5_000, |_, x| x).iter().all(Verdict::deviates));
    watch.guard.acknowledge();
    assert!(!watch.run(3_000, |_, x| x)[2_500..].iter().any(Verdict::deviates));
}

#[test]
fn two_faults_at_once_are_an_alarm_and_leave_a_healthy_monitor_behind() {
    let mut watch = Watch::learned(19);
    let verdicts = watch.run(4_000, |k, x| off(Channel::Speed, 8.0)(k, off(Channel::ArmatureVoltage, -6.0)(k, x)));
    assert!(verdicts[100..].iter().all(Verdict::deviates));
    assert!(!watch.run(5_000, |_, x| x)[3_000..].iter().any(Verdict::alarm));
}

#[test]
fn one_wild_reading_is_turned_away_and_a_second_one_is_a_fault() {
    for channel in Channel::ALL {
        for sigmas in [12.0, 100.0, 1e6, -1e9] {
            let mut watch = Watch::learned(32);
            let wild = off(channel, sigmas);
            let verdicts = watch.run(20_000, |k, x| if k % 40 == 20 { wild(k, x) } else { x });
            assert!(!verdicts.iter().any(Verdict::alarm), "{channel:?} off by {sigmas}");
            assert!(verdicts.iter().enumerate().all(|(k, v)| v.rejected() == (k % 40 == 20)));
            let found = first_alarm(&watch.run(100, &wild)).unwrap();
            assert!(found <= 3, "{channel:?} off by {sigmas}: {found}");
            let mut watch = Watch::learned(33);
            let found = first_alarm(&watch.run(100, |k, x| if k % 2 == 0 { wild(k, x) } else { x })).unwrap();
            assert!(found <= 8, "every second reading, {channel:?} off by {sigmas}: {found}");
        }
    }
}

#[test]
fn with_a_hold_a_disturbance_is_silence_and_a_fault_is_raised_as_late_and_dated_as_when_it_was_seen() {
    let learned = |raise_hold_s| {
        let mut watch = Watch::new(&Config { raise_hold_s, ..config() }, 45);
        watch.run(5_110, |_, x| x);
        assert!(watch.guard.verdict().phase() == Phase::Monitoring, "and limits are not proven");
        watch
    };
    let (mut at_once, mut held) = (learned(0.0), learned(0.1));
    // A hundredth of a second, again and again, while limits are proven by the largest distance that is seen.
    let disturbed = |k: u32, x| if k % 2_000 < 10 { off(Channel::ArmatureCurrent, 5.0)(k, x) } else { x };
    assert!(first_alarm(&at_once.run(20_000, disturbed)).is_some());
    assert_eq!(first_alarm(&held.run(20_000, disturbed)), None);
    let [[fast, ..], [undisturbed, ..]] = [held, Watch::learned(45)].map(|watch| watch.guard.limits().unwrap());
    assert!(fast < 1.1 * undisturbed, "what is beyond a limit is no tail: {fast} {undisturbed}");
    let mut held = learned(0.1);
    let begins = held.guard.verdict().sample() + 1;
    let verdicts = held.run(1_000, off(Channel::ArmatureCurrent, 5.0));
    let found = first_alarm(&verdicts).unwrap() as u64;
    let since = verdicts[found as usize].since().unwrap();
    assert!((100..120).contains(&found) && since == begins + found - 99, "{found} {since}");
}

#[test]
fn settings_that_make_no_sense_are_refused_by_name() {
    let refused = |change: fn(&mut Config)| {
        let mut config = config();
        change(&mut config);
        Monitor::new(&config).unwrap_err()
    };
    assert_eq!(refused(|c| c.sample_rate_hz = 0.0), ConfigError::SampleRate);
    assert_eq!(refused(|c| c.sample_rate_hz = f32::NAN), ConfigError::SampleRate);
    assert_eq!(refused(|c| c.false_alarms_per_hour = 0.0), ConfigError::FalseAlarmRate);
    assert_eq!(refused(|c| c.false_alarms_per_hour = f32::NAN), ConfigError::FalseAlarmRate);
    assert_eq!(refused(|c| c.settle_s = -1.0), ConfigError::SettleTime);
    assert_eq!(refused(|c| c.seed_s = 0.01), ConfigError::SeedTime);
    assert_eq!(refused(|c| c.learn_s = 1.0), ConfigError::LearnTime);
    assert_eq!(refused(|c| c.learn_s = f32::NAN), ConfigError::LearnTime);
    assert_eq!(refused(|c| c.set_point_tolerance = f32::NAN), ConfigError::SetPointTolerance);
    assert_eq!(refused(|c| c.time_constants_s = [0.1, 0.05, 1.0, 2.0]), ConfigError::TimeConstants);
    assert_eq!(refused(|c| c.time_constants_s[3] = 1.0), ConfigError::TimeConstants);
    assert_eq!(refused(|c| c.time_constants_s[0] = f32::NAN), ConfigError::TimeConstants);
    assert_eq!(refused(|c| c.converter_steps[2] = -1.0), ConfigError::ConverterStep(Channel::ArmatureVoltage));
    assert_eq!(refused(|c| c.memory_s = 1.0), ConfigError::Memory);
    assert_eq!(refused(|c| c.drift_sigmas = f32::NAN), ConfigError::Drift);
    assert_eq!(refused(|c| c.raise_hold_s = -1.0), ConfigError::RaiseHold);
    assert_eq!(refused(|c| c.clear_hold_s = f32::INFINITY), ConfigError::ClearHold);
}

#[test]
fn a_monitor_is_as_large_as_it_should_be() {
    let bytes = core::mem::size_of::<Monitor>();
    assert!(bytes <= 2_048, "{bytes} bytes");
}
