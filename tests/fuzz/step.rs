//! The monitor: whatever it is fed, and in whatever order it is called, what it says stays within its promises.

use bolero::{TypeGenerator, check};
use monitor_core::moments::LearnError;
use monitor_core::paper::baseline::Stored;
use monitor_core::paper::event::{EVENTS_PER_VERDICT, Watch};
use monitor_core::paper::verdict::{Rejected, Settling};
use monitor_core::paper::{Baseline, Config, Monitor, Phase, Verdict};
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::Absence;
use monitor_core::sample::{Bank, Channel, ModelId};

use super::TEST_TIME;
use super::moments::Noise;
use super::number::Number;

/// Settings: of a kind that is accepted, or any at all.
#[derive(Clone, Debug, TypeGenerator)]
enum Settings {
    Sound {
        settle: u8,
        #[generator(30..=120_u8)]
        learn: u8,
        tolerance: u8,
        /// fc/fs, in 2^-17.
        cutoff: u16,
        threshold: u8,
    },
    Any([Number; 11]),
}

/// What is done with the monitor.
#[derive(Clone, Debug, TypeGenerator)]
enum Op {
    /// Samples of a motor that is well but for an offset, at the set point that stands.
    Fly {
        samples: u8,
        seed: u32,
        offset: [i8; 3],
    },
    Sample(Number, [Number; 3]),
    /// A sample at the set point that stands.
    Reading([Number; 3]),
    SetPoint(i8),
    Skip(bool),
    Finish,
    Refuse,
    Recall(Table),
}

/// An offline baseline: that of the motor, or any.
#[derive(Clone, Debug, TypeGenerator)]
enum Table {
    Motor,
    Any { mean: [Number; 3], sigma: [Number; 3] },
}

const MEAN: [f32; 3] = [300.0, 2.0, 9.7];
const SIGMA: [f32; 3] = [0.1, 0.02, 0.02];

#[test]
fn a_monitor_keeps_its_promises_whatever_it_is_fed() {
    check!().with_test_time(TEST_TIME).with_type::<(Settings, Vec<Op>)>().for_each(|(settings, ops)| {
        if let Ok(monitor) = Monitor::new(&settings.config()) {
            let verdict = *monitor.verdict();
            let watch = Watch::default();
            let mut flight = Flight { monitor, watch, last: verdict, phase: verdict.phase(), set_point: 300.0 };
            ops.iter().for_each(|op| flight.apply(op));
        }
    });
}

impl Settings {
    fn config(&self) -> Config {
        match self {
            Settings::Sound { settle, learn, tolerance, cutoff, threshold } => Config {
                settle_s: f32::from(*settle % 16) / 1000.0,
                learn_s: f32::from(*learn) / 1000.0,
                set_point_tolerance: f32::from(*tolerance % 4),
                cutoff_hz: 1000.0 * (f32::from(*cutoff) + 1.0) / 131_073.0,
                ..Config::paper(1000.0, Bank::from_fn(|_| 0.5 + f32::from(*threshold) / 32.0))
            },
            Settings::Any(numbers) => {
                let [rate, settle, learn, tolerance, share, cutoff, a, b, c, d, hysteresis] =
                    numbers.map(Number::value);
                let mut thresholds = [a, b, c, d].into_iter();
                Config {
                    sample_rate_hz: rate,
                    settle_s: settle,
                    learn_s: learn,
                    set_point_tolerance: tolerance,
                    explained_share: share,
                    cutoff_hz: cutoff,
                    thresholds: Bank::from_fn(|_| thresholds.next().unwrap_or_default()),
                    hysteresis,
                }
            }
        }
    }
}

impl Table {
    fn baseline(&self) -> Option<Baseline> {
        let (mean, sigma) = match self {
            Table::Motor => (MEAN, SIGMA),
            Table::Any { mean, sigma } => (mean.map(Number::value), sigma.map(Number::value)),
        };
        let h = core::f32::consts::FRAC_1_SQRT_2;
        let loadings = [[0.0, h, h], [1.0, 0.0, 0.0], [0.0, h, -h]];
        let stored = Stored { mean, sigma, loadings, eigenvalues: [1.8, 1.0, 0.2], samples: 15_000 };
        Baseline::from_stored(&stored, ExplainedShare::PAPER).ok()
    }
}

/// A monitor, and what is known of it.
struct Flight {
    monitor: Monitor,
    watch: Watch,
    /// The verdict before.
    last: Verdict,
    /// Where the monitor stands after the last call; after [`Monitor::install`] it is further than the verdict says.
    phase: Phase,
    set_point: f32,
}

impl Flight {
    fn apply(&mut self, op: &Op) {
        match op {
            Op::Fly { samples, seed, offset } => self.fly(*samples, *seed, *offset),
            Op::Sample(set_point, x) => self.slot(set_point.value(), x.map(Number::value)),
            Op::Reading(x) => self.slot(self.set_point, x.map(Number::value)),
            Op::SetPoint(change) => self.set_point = 300.0 + f32::from(*change),
            Op::Skip(late) => self.skip(if *late { Absence::Late } else { Absence::Missing }),
            Op::Finish => self.finish(),
            Op::Refuse => self.refuse(),
            Op::Recall(table) => self.recall(table),
        }
        assert_eq!(self.monitor.learned_window().is_some(), self.phase == Phase::ModelDue);
        assert_eq!(self.monitor.baseline().is_some(), self.phase == Phase::Monitoring);
    }

    fn fly(&mut self, samples: u8, seed: u32, offset: [i8; 3]) {
        let mut noise = Noise(seed);
        for _ in 0..samples {
            let channels = [0, 1, 2];
            let x = channels.map(|i| MEAN[i] + SIGMA[i] * (3.0 * noise.draw() + f32::from(offset[i]) / 16.0));
            self.slot(self.set_point, x);
            self.finish();
        }
    }

    fn slot(&mut self, set_point: f32, x: [f32; 3]) {
        let verdict = *self.monitor.step_channels(set_point, x);
        if let Some(Rejected::Absent(_)) = verdict.rejected() {
            panic!("a slot with a sample is absent: {verdict:?}");
        }
        // A set point that is no number is turned away before anything else, but for a reading that is none either.
        assert!(set_point.is_finite() || verdict.rejected().is_some(), "{verdict:?}");
        assert!(verdict.rejected() != Some(Rejected::NonFiniteSetPoint) || !set_point.is_finite(), "{verdict:?}");
        assert_eq!(verdict.readings().map(f32::to_bits), x.map(f32::to_bits));
        let _ = self.monitor.contributions(x);
        // A set point that is no number moves nothing, the phase neither.
        let stands = verdict.rejected() == Some(Rejected::NonFiniteSetPoint);
        assert!(!stands || verdict.phase() == self.phase, "{verdict:?} after {:?}", self.phase);
        self.judge(verdict, verdict.phase());
    }

    fn skip(&mut self, why: Absence) {
        let verdict = *self.monitor.skip(why);
        assert_eq!(verdict.rejected(), Some(Rejected::Absent(why)));
        assert_eq!(verdict.relays(), self.last.relays());
        self.judge(verdict, verdict.phase());
    }

    fn finish(&mut self) {
        let due = self.phase == Phase::ModelDue;
        match self.monitor.finish_learning() {
            Ok(installed) => {
                assert_eq!(installed, due);
                self.phase = if due { Phase::Monitoring } else { self.phase };
            }
            Err(error) => {
                assert!(due && self.monitor.refused() == Some(error));
                self.phase = Phase::Learning;
            }
        }
    }

    fn refuse(&mut self) {
        let due = self.phase == Phase::ModelDue;
        assert_eq!(self.monitor.install(Err(LearnError::TooShort { samples: 0 })), due);
        self.phase = if due { Phase::Learning } else { self.phase };
    }

    fn recall(&mut self, table: &Table) {
        if let Some(baseline) = table.baseline() {
            let wanted = matches!(self.phase, Phase::Learning | Phase::ModelDue);
            assert_eq!(self.monitor.recall(baseline), wanted);
            self.phase = if wanted { Phase::Monitoring } else { self.phase };
        }
    }

    fn judge(&mut self, verdict: Verdict, phase: Phase) {
        let last = self.last;
        assert_eq!(verdict.sample(), last.sample().wrapping_add(1), "every slot counts");
        assert!(follows(self.phase, phase), "{phase:?} after {:?}", self.phase);
        if let Some(rejected) = verdict.rejected() {
            judge_rejected(rejected, verdict.readings());
            assert_eq!(verdict.residuals(), None);
            // Only a set point that has moved voids the relays.
            if phase == self.phase {
                assert_eq!((verdict.relays(), verdict.alarm_since()), (last.relays(), last.alarm_since()));
            }
        } else {
            assert_eq!(verdict.residuals().is_some(), phase == Phase::Monitoring);
        }
        if let Some(residuals) = verdict.residuals() {
            self.judge_residuals(&verdict, residuals);
        }
        assert!(phase == Phase::Monitoring || !verdict.alarm(), "{verdict:?}");
        self.judge_alarm(&verdict);
        let mut events = 0;
        self.watch.observe(&verdict, |event| {
            assert_eq!(event.sample, verdict.sample());
            events += 1;
        });
        assert!(events <= EVENTS_PER_VERDICT);
        (self.last, self.phase) = (verdict, phase);
    }

    fn judge_residuals(&self, verdict: &Verdict, residuals: Bank<f32>) {
        let thresholds = self.monitor.thresholds();
        for model in ModelId::ALL {
            let residual = *residuals.get(model);
            assert!(residual.is_finite(), "{model:?}: {verdict:?}");
            assert!(residual <= *thresholds.get(model) || *verdict.relays().get(model), "{model:?}: {verdict:?}");
        }
    }

    fn judge_alarm(&self, verdict: &Verdict) {
        assert_eq!(verdict.alarm(), verdict.relays().any());
        let since = match (verdict.alarm(), self.last.alarm_since()) {
            (false, _) => None,
            (true, None) => Some(verdict.sample()),
            (true, before) => before,
        };
        assert_eq!(verdict.alarm_since(), since, "{verdict:?}");
    }
}

/// Whether a slot may lead from one phase to another.
fn follows(before: Phase, now: Phase) -> bool {
    let changed = now == Phase::Settling(Settling::SetPointChanged);
    match before {
        Phase::Settling(_) => now == before || now == Phase::Learning,
        Phase::Learning => now == before || now == Phase::ModelDue || changed,
        Phase::ModelDue | Phase::Monitoring => now == before || changed,
    }
}

/// The reason must be one that the readings give.
fn judge_rejected(rejected: Rejected, x: [f32; 3]) {
    let not_a_number = x.iter().position(|x| x.is_nan()).map(Channel::at);
    match rejected {
        Rejected::NonFinite(channel) => assert_eq!(Some(channel), not_a_number),
        Rejected::OutOfRange(channel) => {
            let magnitude = x[channel.position()].abs();
            assert!(not_a_number.is_none() && x.iter().all(|x| x.abs() <= magnitude), "{channel:?} of {x:?}");
        }
        _ => {}
    }
}
