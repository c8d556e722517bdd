use super::*;

use heapless::spsc::Queue;
use monitor_core::paper::event::{Event, EventKind};
use monitor_core::paper::verdict::Rejected;
use monitor_core::paper::{Config, Diagnosis, Fault, Monitor, Phase};
use monitor_core::sample::Absence;
use monitor_core::sample::{Bank, PerPair, Sample};
use monitor_core::units::{Amperes, Volts};

extern crate std;
use std::vec::Vec;

use crate::deadline::Slot;
use crate::mode::Paper;
use crate::mode::paper::News;
use crate::sampling::{Note, Notes, Reading};

mod guarded;

const SET_POINT: RadPerSec = RadPerSec(300.0);
const IN_TIME: Slot = Slot { lost: 0, late: false };

/// A board whose interrupt is a call.
struct Bench<'q, M: Mode>(Sampling<'q, M>);

impl<'q, M: Mode> Shared<'q, M> for Bench<'q, M> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'q, M>) -> R) -> R {
        f(&mut self.0)
    }
}

/// Settles for 10 samples and learns from 100.
fn config() -> Config {
    let pairs = PerPair { speed_current: 3.0, current_voltage: 3.0, speed_voltage: 3.0 };
    Config { settle_s: 0.01, learn_s: 0.1, cutoff_hz: 20.0, ..Config::paper(1000.0, Bank { full: 3.0, pairs }) }
}

fn board(queue: &mut Notes<Paper>) -> (Bench<'_, Paper>, Background<'_, Paper>) {
    wired(Paper::new(Monitor::new(&config()).unwrap()), queue)
}

fn wired<M: Mode>(mode: M, queue: &mut Notes<M>) -> (Bench<'_, M>, Background<'_, M>) {
    let (notes, heard) = queue.split();
    (Bench(Sampling::new(mode, notes)), Background::new(heard))
}

/// Reading number `k` of a motor whose readings wobble; `drift` of the speed sensor shows in the voltage.
fn reading(k: u32, drift: f32) -> Reading {
    let wobble = |period: u32| (k % period) as f32 / period as f32 - 0.5;
    Reading::Taken(Sample {
        speed: RadPerSec(300.0 + 0.2 * wobble(7)),
        armature_current: Amperes(2.0 + 0.02 * wobble(11)),
        armature_voltage: Volts(9.7 + 0.02 * wobble(13) - 0.0302 * drift),
    })
}

/// Runs slots `range` as interrupts, with the main loop's turn after each. Returns the notes.
fn run<'q, M: Mode>(
    (bench, background): (&mut Bench<'q, M>, &mut Background<'q, M>),
    range: core::ops::Range<u32>,
    drift: f32,
) -> Vec<NoteOf<M>> {
    let mut notes = Vec::new();
    for k in range {
        bench.0.on_interrupt(IN_TIME, SET_POINT, || reading(k, drift), |_| {});
        background.learn(bench);
        notes.extend(core::iter::from_fn(|| background.next_note()));
    }
    notes
}

fn events(notes: &[NoteOf<Paper>]) -> impl Iterator<Item = &News> {
    notes.iter().filter_map(|note| if let Note::News(news) = note { Some(news) } else { None })
}

#[test]
fn a_drifting_sensor_is_learned_about_judged_named_and_drives_the_fault_output() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let healthy = run((&mut bench, &mut background), 0..400, 0.0);
    let phases = events(&healthy).map(|news| news.event.kind);
    let expected = [
        Phase::Settling(monitor_core::paper::verdict::Settling::Start),
        Phase::Learning,
        Phase::ModelDue,
        Phase::Monitoring,
    ];
    assert!(phases.eq(expected.map(EventKind::Phase)), "{healthy:?}");

    let faulty = run((&mut bench, &mut background), 400..800, 5.0);
    let located = events(&faulty).filter(|news| matches!(news.event.kind, EventKind::Located(_))).last().unwrap();
    assert_eq!(located.event.kind, EventKind::Located(Diagnosis::Fault(Fault::SpeedSensor)));
    assert!(located.residual > 3.0 && located.alarm_since.is_some_and(|since| (400..420).contains(&since)));
    assert_eq!(located.limit, 3.0);
    let mut output = false;
    bench.0.on_interrupt(IN_TIME, SET_POINT, || reading(800, 5.0), |fault| output = fault);
    assert!(output);
}

#[test]
fn a_full_queue_keeps_the_oldest_notes_and_counts_what_it_dropped() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let absent = |bench: &mut Bench<'_, Paper>, k: u32| {
        let slot = Slot { lost: 0, late: k.is_multiple_of(2) };
        bench.0.on_interrupt(slot, SET_POINT, || reading(k, 0.0), |_| {});
    };
    (0..40).for_each(|k| absent(&mut bench, k));
    let kept: Vec<NoteOf<Paper>> = core::iter::from_fn(|| background.next_note()).collect();
    let why = Rejected::Absent(Absence::Late);
    assert!(kept[..2].contains(&Note::Rejecting { sample: 0, why }), "{kept:?}");
    // The queue has 32 places, of which one stays free. Each slot but those of the same reason has a note; one tells that
    // the monitor settles, one that it learns.
    assert_eq!(kept.len(), 31);
    assert_eq!(bench.0.snapshot().counts.dropped, 42 - 31);
}

#[test]
fn lost_and_late_slots_are_verdicts_of_their_own_and_no_late_slot_is_read() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    run((&mut bench, &mut background), 0..300, 0.0);
    let verdict = *bench.0.on_interrupt(Slot { lost: 3, late: true }, SET_POINT, || panic!("too late to read"), |_| {});
    assert_eq!(verdict.sample(), 303);
    assert_eq!(verdict.rejected(), Some(Rejected::Absent(Absence::Late)));
    let (missing, late) = (Rejected::Absent(Absence::Missing), Rejected::Absent(Absence::Late));
    let notes: Vec<NoteOf<Paper>> = core::iter::from_fn(|| background.next_note()).collect();
    assert_eq!(notes, [Note::Rejecting { sample: 300, why: missing }, Note::Rejecting { sample: 303, why: late }]);
    let notes = run((&mut bench, &mut background), 304..305, 0.0);
    assert_eq!(notes, [Note::Accepting { sample: 304, after: 4 }]);
    let counts = bench.0.snapshot().counts;
    assert_eq!((counts.rejected, counts.absent), (4, 4));
}

#[test]
fn slots_are_counted_from_none_on() {
    let mut queue = Queue::new();
    let (mut bench, _) = board(&mut queue);
    assert_eq!(bench.0.slots(), 0);
    bench.0.on_interrupt(Slot { lost: 2, late: false }, SET_POINT, || reading(0, 0.0), |_| {});
    assert_eq!(bench.0.slots(), 3);
}

#[test]
fn an_overrun_is_counted_and_told_of_with_its_slot() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    run((&mut bench, &mut background), 0..5, 0.0);
    bench.0.overran();
    assert_eq!(background.next_note(), Some(Note::Overrun { sample: 4 }));
    assert_eq!(bench.0.snapshot().counts.overruns, 1);
}

#[test]
fn a_model_of_a_set_point_that_has_changed_meanwhile_is_thrown_away_and_counted() {
    /// A board whose set point moves between the two critical sections of learning.
    struct Moving<'q>(Bench<'q, Paper>, u32);
    impl<'q> Shared<'q, Paper> for Moving<'q> {
        fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'q, Paper>) -> R) -> R {
            self.1 += 1;
            if self.1 == 2 {
                self.0.0.on_interrupt(IN_TIME, RadPerSec(200.0), || reading(0, 0.0), |_| {});
            }
            f(&mut self.0.0)
        }
    }
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    while bench.0.mode().learned_window().is_none() {
        let k = bench.0.slots() as u32;
        bench.0.on_interrupt(IN_TIME, SET_POINT, || reading(k, 0.0), |_| {});
    }
    let mut moving = Moving(bench, 0);
    assert_eq!(background.learn(&mut moving), Some(Learned::InVain));
    assert_eq!(background.in_vain(), 1);
    assert_eq!(background.learn(&mut moving), None, "the monitor settles again");
}

#[test]
fn a_window_that_cannot_be_learned_from_is_refused_and_told_of() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let mut refused = None;
    for _ in 0..200 {
        bench.0.on_interrupt(IN_TIME, SET_POINT, || reading(0, 0.0), |_| {});
        refused = refused.or(background.learn(&mut bench));
    }
    assert!(matches!(refused, Some(Learned::Refused(LearnError::ConstantChannel(_)))), "{refused:?}");
    let told = core::iter::from_fn(|| background.next_note())
        .any(|note| matches!(note, Note::News(News { event: Event { kind: EventKind::LearningRefused(_), .. }, .. })));
    assert!(told);
}

#[test]
fn requests_are_answered_from_the_state_of_the_last_slot() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    let Answer::ByChannel(none) = background.answer(Request::ByChannel, &mut bench) else { panic!() };
    assert_eq!(none, None, "nothing is learned yet");
    run((&mut bench, &mut background), 0..400, 0.0);
    bench.0.on_interrupt(IN_TIME, SET_POINT, || reading(400, 5.0), |_| {});
    let Answer::ByChannel(Some([speed, current, voltage])) = background.answer(Request::ByChannel, &mut bench) else {
        panic!()
    };
    assert!(voltage > 100.0 * (speed + current), "the drift shows in the voltage: {speed} {current} {voltage}");
    let Answer::Statistics(state) = background.answer(Request::Statistics, &mut bench) else { panic!() };
    let [mean, ..] = state.mode.monitor().baseline().unwrap().mean();
    assert!((mean - 300.0).abs() < 0.1);
    let Answer::Verdict(state, _) = background.answer(Request::Verdict, &mut bench) else { panic!() };
    assert_eq!(state.mode.slot(), 400);
}

#[test]
fn the_sampling_interrupt_counts_as_alive_only_while_slots_go_by() {
    let mut queue = Queue::new();
    let (mut bench, mut background) = board(&mut queue);
    run((&mut bench, &mut background), 0..2, 0.0);
    assert!(background.sampling_is_alive(&mut bench));
    assert!(!background.sampling_is_alive(&mut bench));
    run((&mut bench, &mut background), 2..3, 0.0);
    assert!(background.sampling_is_alive(&mut bench));
}
