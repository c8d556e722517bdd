//! The monitor in `guard` mode: whatever it is fed, what it says stays within its promises, and it comes back to work.

use bolero::{TypeGenerator, check};
use monitor_core::guard::{Cause, Config, Directions, Finding, Monitor, MotorConstants, Phase, Verdict};
use monitor_core::sample::Absence;

use super::TEST_TIME;
use super::moments::Noise;
use super::number::Number;

/// What is done with the monitor.
#[derive(Clone, Debug, TypeGenerator)]
enum Op {
    /// Samples of a motor that is well but for an offset, at the set point that stands.
    Fly {
        samples: u16,
        offset: [i8; 3],
    },
    /// A sample of anything, for a while.
    Wild {
        x: [Number; 3],
        samples: u8,
    },
    Sample(Number, [Number; 3]),
    SetPoint(i8),
    Skip {
        late: bool,
        slots: u8,
    },
    Acknowledge,
}

const MEAN: [f32; 3] = [300.0, 2.0, 9.7];
const SIGMA: [f32; 3] = [0.1, 0.02, 0.02];

/// A monitor that learns in half a second.
fn config() -> Config {
    Config {
        settle_s: 0.01,
        seed_s: 0.05,
        learn_s: 0.4,
        time_constants_s: [0.002, 0.01, 0.1, 0.2],
        ..Config::at_rate(1000.0)
    }
}

struct Flight {
    guard: Monitor,
    noise: Noise,
    set_point: f32,
    directions: Directions,
}

#[test]
fn a_guard_keeps_its_promises_whatever_it_is_fed() {
    let motor = MotorConstants { resistance_ohm: 0.3, torque_constant_nm_per_a: 0.03, load_slope_nm_s: 1e-4 };
    let directions = Directions::of_motor(&motor, MEAN).unwrap();
    check!().with_test_time(TEST_TIME).with_type::<Vec<Op>>().for_each(|ops| {
        let guard = Monitor::new(&config()).unwrap();
        let mut flight = Flight { guard, noise: Noise(1), set_point: 300.0, directions: directions.clone() };
        // A monitor that has learned, so that there is something to spoil.
        flight.fly(700, [0; 3]);
        ops.iter().for_each(|op| flight.apply(op));
        // However it was treated, at a set point of its own it learns and judges again.
        flight.guard.acknowledge();
        flight.set_point = 300.0;
        flight.fly(1_500, [0; 3]);
        flight.set_point = -77.5;
        flight.fly(1_500, [0; 3]);
        let phase = flight.guard.verdict().phase();
        assert!(
            phase == Phase::Monitoring || phase == Phase::Withheld && flight.guard.verdict().deviates(),
            "{phase:?}"
        );
    });
}

impl Flight {
    fn apply(&mut self, op: &Op) {
        match op {
            Op::Fly { samples, offset } => self.fly(u32::from(*samples % 300), *offset),
            Op::Wild { x, samples } => {
                (0..*samples).for_each(|_| self.give(self.set_point, x.map(Number::value)));
            }
            Op::Sample(set_point, x) => self.give(set_point.value(), x.map(Number::value)),
            Op::SetPoint(set_point) => self.set_point = f32::from(*set_point),
            Op::Skip { late, slots } => {
                let why = if *late { Absence::Late } else { Absence::Missing };
                for _ in 0..*slots {
                    let before = self.guard.verdict().sample();
                    let verdict = *self.guard.skip(why);
                    assert_eq!((verdict.absent(), verdict.sample()), (Some(why), before.wrapping_add(1)));
                    judge(&verdict);
                }
            }
            Op::Acknowledge => self.guard.acknowledge(),
        }
    }

    fn fly(&mut self, samples: u32, offset: [i8; 3]) {
        for _ in 0..samples {
            let x = std::array::from_fn(|i| MEAN[i] + SIGMA[i] * (3.46 * self.noise.draw() + f32::from(offset[i])));
            self.give(self.set_point, x);
        }
    }

    fn give(&mut self, set_point: f32, x: [f32; 3]) {
        let before = self.guard.verdict().sample();
        let verdict = *self.guard.step_channels(set_point, x);
        assert_eq!(verdict.sample(), before.wrapping_add(1));
        judge(&verdict);
        let _refused = self.guard.finish_learning();
        if let Some(limits) = self.guard.limits() {
            assert!(limits.iter().all(|limit| limit.is_finite() && *limit > 0.0), "{limits:?}");
        }
        if !verdict.sample().is_multiple_of(16) {
            return;
        }
        let finding = self.guard.finding(&self.directions);
        assert_eq!(finding == Finding::Healthy, !verdict.deviates());
        if let Finding::Fault(found) | Finding::Ambiguous(found, _) = finding {
            assert!(found.size.is_finite() && found.size_sigma > 0.0 && found.misfit >= 0.0, "{found:?}");
            assert_ne!(found.cause, Cause::Supply, "no direction was given for it");
        }
    }
}

fn judge(verdict: &Verdict) {
    let severity = verdict.severity();
    assert!(severity.is_none_or(|severity| severity.iter().all(|s| s.is_finite() && *s >= 0.0)), "{verdict:?}");
    assert!(verdict.since().is_none_or(|since| since <= verdict.sample()), "{verdict:?}");
    assert!(!verdict.deviates() || verdict.alarm());
}
