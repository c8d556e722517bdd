//! What the wiring adds to a monitor in `guard` mode: names that are asked for, and what is told of when it changes.

use monitor_core::guard::{Cause, Config, Finding, Loss, Monitor, MotorConstants, Phase};
use monitor_core::moments::LearnError;
use monitor_core::sample::Channel;

use super::*;
use crate::mode::Guarded;
use crate::mode::guarded::{News, Rejected, What};

/// Settles for 20 samples, seeds with twice 50, learns from 2000.
fn board(queue: &mut Notes<Guarded>) -> (Bench<'_, Guarded>, Background<'_, Guarded>) {
    let motor = MotorConstants { resistance_ohm: 0.3, torque_constant_nm_per_a: 0.0302, load_slope_nm_s: 0.0 };
    let config = Config { settle_s: 0.02, seed_s: 0.05, learn_s: 2.0, ..Config::at_rate(1000.0) };
    wired(Guarded::new(Monitor::new(&config).unwrap(), motor), queue)
}

/// Slots that the monitor has learned behind.
const LEARNED: u32 = 2200;

/// White noise between -0.5 and 0.5: the bits of slot and channel, well mixed (the finalizer of MurmurHash3).
fn noise(k: u32, channel: u32) -> f32 {
    let mixed = (k ^ channel << 28).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35);
    (mixed ^ mixed >> 16) as f32 / u32::MAX as f32 - 0.5
}

/// A healthy motor's sample.
fn sample(k: u32) -> Sample {
    Sample {
        speed: RadPerSec(300.0 + 0.2 * noise(k, 1)),
        armature_current: Amperes(2.0 + 0.02 * noise(k, 2)),
        armature_voltage: Volts(9.7 + 0.02 * noise(k, 3)),
    }
}

/// What was told in some slots.
#[derive(Default)]
struct Heard {
    news: Vec<News>,
    named: Vec<Named<Finding>>,
    rejections: Vec<Rejected>,
    fault_outputs: Vec<bool>,
}

impl Heard {
    fn what(&self) -> Vec<What> {
        self.news.iter().map(|news| news.what).collect()
    }
}

/// Runs slots as interrupts, with the main loop's turn after each.
fn run<'q>(
    (bench, background): (&mut Bench<'q, Guarded>, &mut Background<'q, Guarded>),
    range: core::ops::Range<u32>,
    mut read: impl FnMut(u32) -> Reading,
) -> Heard {
    let mut heard = Heard::default();
    for k in range {
        bench.0.on_interrupt(IN_TIME, SET_POINT, || read(k), |fault| heard.fault_outputs.push(fault));
        background.learn(bench);
        while let Some(note) = background.next_note() {
            match note {
                Note::News(news) => heard.news.push(news),
                Note::Rejecting { why, .. } => heard.rejections.push(why),
                _ => {}
            }
        }
        heard.named.extend(background.name(bench));
    }
    heard
}

fn healthy(k: u32) -> Reading {
    Reading::Taken(sample(k))
}

/// The speed sensor reads 5 rad/s too much: the loop holds the reading, so the drift shows in the voltage.
fn drifting(k: u32) -> Reading {
    let mut sample = sample(k);
    sample.armature_voltage.0 -= 0.0302 * 5.0;
    Reading::Taken(sample)
}

#[test]
fn phases_and_how_well_was_learned_are_told_in_turn_and_a_healthy_motor_is_silence() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let heard = run((&mut bench, &mut background), 0..2 * LEARNED, healthy);
    let [a, b, c, due, What::Learned(quality), monitoring] = heard.what()[..] else { panic!("{:?}", heard.news) };
    let phases = [Phase::Settling, Phase::Seeding, Phase::Learning, Phase::ModelDue, Phase::Monitoring];
    assert_eq!([a, b, c, due, monitoring], phases.map(What::Phase));
    assert_eq!(quality.samples, 2000);
    assert!(heard.named.is_empty() && heard.rejections.is_empty() && !heard.fault_outputs.contains(&true));
}

#[test]
fn a_fault_is_told_raised_named_once_with_its_size_and_withdrawn_and_drives_the_fault_output() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let heard = run((&mut bench, &mut background), 0..LEARNED, healthy);
    assert!(!heard.fault_outputs.contains(&true));
    let faulty = run((&mut bench, &mut background), LEARNED..2 * LEARNED, drifting);
    let [What::Raised { since, severity }] = faulty.what()[..] else { panic!("{:?}", faulty.news) };
    assert!((LEARNED..LEARNED + 20).contains(&(since as u32)) && severity > 1.0, "{since} {severity}");
    assert_eq!(faulty.fault_outputs.last(), Some(&true));
    let [named] = &faulty.named[..] else { panic!("{:?}", faulty.named) };
    let Finding::Fault(found) = &named.finding else { panic!("{named:?}") };
    assert_eq!((found.cause, named.since), (Cause::SpeedSensor, Some(since)));
    assert!((found.size - 5.0).abs() < 0.5, "{}", found.size);

    let after = run((&mut bench, &mut background), 2 * LEARNED..4 * LEARNED, healthy);
    assert!(
        matches!(after.what()[..], [What::Withdrawn { since: withdrawn }] if withdrawn == since),
        "{:?}",
        after.news
    );
    assert_eq!((after.named.len(), after.fault_outputs.last()), (0, Some(&false)));
    // The same name of another alarm is news.
    let again = run((&mut bench, &mut background), 4 * LEARNED..5 * LEARNED, drifting);
    assert_eq!(again.named.len(), 1, "{:?}", again.named);
}

#[test]
fn a_name_is_asked_of_a_copy_only_while_something_deviates_and_only_so_often() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    run((&mut bench, &mut background), 0..LEARNED, healthy);
    assert!(!bench.0.mode().is_to_be_named(&background.named));
    run((&mut bench, &mut background), LEARNED..LEARNED + 500, drifting);
    let (mut asked, mut k) = (Vec::new(), LEARNED + 500);
    while asked.len() < 3 {
        bench.0.on_interrupt(IN_TIME, SET_POINT, || drifting(k), |_| {});
        if bench.0.mode().is_to_be_named(&background.named) {
            asked.push(k);
            background.name(&mut bench);
        }
        k += 1;
    }
    assert_eq!([asked[1] - asked[0], asked[2] - asked[1]], [100, 100]);
}

#[test]
fn a_sensor_that_goes_silent_is_told_lost_and_back_and_a_gap_begins_and_ends() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    run((&mut bench, &mut background), 0..LEARNED, healthy);
    let heard = run((&mut bench, &mut background), LEARNED..LEARNED + 300, |k| match k - LEARNED {
        0..100 => Reading::Taken(Sample { armature_current: Amperes(f32::NAN), ..sample(k) }),
        200..230 => Reading::Absent(Absence::Missing),
        _ => healthy(k),
    });
    let channel = Channel::ArmatureCurrent;
    assert_eq!(heard.what(), [What::Lost(channel, Loss::Silent), What::Back(channel), What::Gap, What::GapOver]);
    assert_eq!(heard.rejections.first(), Some(&Rejected::Unfit));
    assert_eq!(heard.rejections.last(), Some(&Rejected::Absent(Absence::Missing)));
}

#[test]
fn a_window_that_is_refused_is_told_with_its_reason_each_time_it_ends_so_and_a_seed_once() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    // Every eighth sample is a spike, but not while seeding.
    let spiky = |k: u32| {
        let mut sample = sample(k);
        if k % 2000 > 200 && k.is_multiple_of(8) {
            sample.speed.0 += 50.0;
        }
        Reading::Taken(sample)
    };
    let heard = run((&mut bench, &mut background), 0..4300, spiky);
    let refused = heard.what().into_iter().filter(|what| *what == What::Refused(LearnError::Clipped)).count();
    assert_eq!(refused, 2, "{:?}", heard.news);

    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let heard = run((&mut bench, &mut background), 0..1000, |k| {
        Reading::Taken(Sample { speed: RadPerSec(300.0), ..sample(k) })
    });
    let refused = LearnError::ConstantChannel(Channel::Speed);
    let phases = [Phase::Settling, Phase::Seeding].map(What::Phase);
    assert_eq!(heard.what(), [phases[0], phases[1], What::Refused(refused)]);
}

#[test]
fn what_is_asked_for_is_answered_from_a_copy_with_the_deviation_in_units_and_the_name() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let Answer::ByChannel(none) = background.answer(Request::ByChannel, &mut bench) else { panic!() };
    assert_eq!(none, None, "nothing is learned yet");
    run((&mut bench, &mut background), 0..LEARNED, healthy);
    run((&mut bench, &mut background), LEARNED..2 * LEARNED, drifting);
    let Answer::ByChannel(Some([speed, current, voltage])) = background.answer(Request::ByChannel, &mut bench) else {
        panic!()
    };
    assert!(
        speed.abs() < 0.02 && current.abs() < 0.002 && (voltage + 0.151).abs() < 0.002,
        "{speed} {current} {voltage}"
    );
    let Answer::Verdict(state, finding) = background.answer(Request::Verdict, &mut bench) else { panic!() };
    assert_eq!(state.mode.slot(), u64::from(2 * LEARNED - 1));
    assert!(matches!(finding, Finding::Fault(found) if found.cause == Cause::SpeedSensor), "{finding:?}");
}

#[test]
fn an_alarm_by_which_nothing_is_learned_ends_when_the_motor_is_said_to_be_healthy() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    run((&mut bench, &mut background), 0..LEARNED, healthy);
    run((&mut bench, &mut background), LEARNED..LEARNED + 500, drifting);
    // An unknown set point while a fault stands.
    let phase = |bench: &mut Bench<'_, Guarded>, k| {
        bench.0.on_interrupt(IN_TIME, RadPerSec(200.0), || drifting(k), |_| {});
        bench.0.mode().verdict().phase()
    };
    assert_eq!(phase(&mut bench, LEARNED + 500), Phase::Withheld);
    assert!(matches!(background.answer(Request::Acknowledge, &mut bench), Answer::Acknowledged));
    assert_eq!(phase(&mut bench, LEARNED + 501), Phase::Settling);
}
