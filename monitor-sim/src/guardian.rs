//! The monitor in `guard` mode with what its user tells it, as the mission, the replay and the studies drive it.

use monitor_core::guard::{
    Cause, Config, ConfigError, Directions, Explanation, Finding, Monitor, MotorConstants, Phase, SCALES, Verdict,
};
use monitor_core::moments::{LearnError, Moments};
use monitor_core::sample::Absence;
use serde::Serialize;

use crate::models::{Models, ModelsError};
use crate::names::name::Name;

pub mod summary;

/// The monitor, and the directions by which it names faults once it has learned.
#[derive(Clone, Debug)]
pub struct Guardian {
    guard: Monitor,
    motor: Option<MotorConstants>,
    directions: Directions,
    /// The healthy readings that the directions are of: each set point has its own.
    directed_at: [f32; 3],
}

/// What is said of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Said {
    /// By the monitor.
    pub verdict: Verdict,
    /// The name of what is wrong, once there is one.
    pub found: Option<Found>,
    /// With the last sample of a learning window: whether it was accepted.
    pub learned: Option<Result<(), LearnError>>,
}

/// A name for what is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The name.
    pub name: Name,
    /// The size, where the name has one.
    pub size: Option<Size>,
}

/// How large a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// The size, in its unit.
    pub value: f64,
    /// Its standard deviation, by noise and by what the constants are uncertain.
    pub sigma: f64,
    /// The unit of both.
    pub unit: &'static str,
}

impl Guardian {
    /// A monitor before its first sample. Without constants of the motor, faults are found but not named.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    pub fn new(config: &Config, motor: Option<MotorConstants>) -> Result<Self, ConfigError> {
        let guard = Monitor::new(config)?;
        Ok(Guardian { guard, motor, directions: Directions::none(), directed_at: [f32::NAN; 3] })
    }

    /// Gives the monitor what was learned of set points before.
    ///
    /// # Errors
    /// [`ModelsError`] when that was under other settings.
    pub fn restore(&mut self, models: &Models) -> Result<(), ModelsError> {
        models.restore(&mut self.guard)
    }

    /// Takes one sample.
    pub fn step(&mut self, set_point: f32, x: [f32; 3]) -> Said {
        self.guard.step_channels(set_point, x);
        self.said()
    }

    /// Lets a slot go by that has no sample.
    pub fn skip(&mut self) -> Said {
        self.guard.skip(Absence::Missing);
        self.said()
    }

    /// The monitor itself.
    #[must_use]
    pub const fn guard(&self) -> &Monitor {
        &self.guard
    }

    fn said(&mut self) -> Said {
        let verdict = *self.guard.verdict();
        let learned = (verdict.phase() == Phase::ModelDue).then(|| self.learn());
        Said { verdict, found: self.found(&verdict), learned }
    }

    fn learn(&mut self) -> Result<(), LearnError> {
        self.guard.finish_learning().map(drop)
    }

    fn found(&mut self, verdict: &Verdict) -> Option<Found> {
        if verdict.deviates() {
            self.direct();
            return found(&self.guard.finding(&self.directions));
        }
        let lost = verdict.gap() || verdict.losses().next().is_some();
        lost.then_some(Found { name: Name::SensorLoss, size: None })
    }

    /// What would be said of a fault of this size that has stood for a while, without its noise: known before a mission. None while
    /// nothing is judged.
    pub fn foretold(&mut self, cause: Cause, size: f32) -> Option<Name> {
        self.direct();
        let noise = self.guard.noise()?;
        found(&self.directions.rehearse(cause, size, &noise)).map(|found| found.name)
    }

    /// Works out the directions if the monitor judges by another model than it did when they were.
    fn direct(&mut self) {
        let mean = self.guard.model().map(monitor_core::guard::Model::mean);
        if let Some((motor, mean)) = self.motor.zip(mean)
            && mean != self.directed_at
        {
            self.directions = Directions::of_motor(&motor, mean).unwrap_or_default();
            self.directed_at = mean;
        }
    }

    /// Share of each channel in how far the motor is from healthy, by the squares of its deviations in sigmas: of the
    /// estimate where a fault has stood still, of this sample's readings where it has not. None while nothing is judged.
    #[must_use]
    pub fn contributions(&self, x: [f32; 3]) -> Option<[f64; 3]> {
        let (model, estimate) = (self.guard.model()?, self.guard.deviation()?);
        let read = [0, 1, 2].map(|k| x[k] - model.mean()[k]);
        let deviation = if self.guard.verdict().settled() { estimate } else { read };
        let squares = [0, 1, 2].map(|k| f64::from(deviation[k] / model.sigma()[k]).powi(2));
        let total: f64 = squares.iter().sum();
        (total > 0.0 && total.is_finite()).then(|| squares.map(|square| square / total))
    }
}

fn found(finding: &Finding) -> Option<Found> {
    match finding {
        Finding::Healthy | Finding::Locating => None,
        Finding::Fault(Explanation { cause, size, size_sigma, .. }) => {
            let name = Name::of_cause(*cause);
            let size = Size { value: f64::from(*size), sigma: f64::from(*size_sigma), unit: name.unit() };
            Some(Found { name, size: Some(size) })
        }
        Finding::Ambiguous(..) => Some(Found { name: Name::Ambiguous, size: None }),
        Finding::Unknown => Some(Found { name: Name::Unknown, size: None }),
    }
}

/// What the time scales are called, the quickest first.
pub const SCALE_NAMES: [&str; SCALES] = ["fast", "middle", "slow", "trend"];

/// Least of each time constant, in samples: what is faster does not average, and slower sensors need the rest as well. The last
/// takes a sample in 64.
const LEAST_SAMPLES: [f64; SCALES] = [1.0, 16.0, 250.0, 500.0];

/// How many middle time constants a learning window must hold (the core's rule), and how many slow ones are enough that its
/// metric has been seen: at the default rate and window there are seven.
const MIDDLES_IN_WINDOW: f64 = 24.0;
const SLOWS_IN_WINDOW: f64 = 5.0;

/// Longest seeding window, s.
const SEED_S: f64 = 1.0;

/// How many learning windows the mean remembers, at least.
const MEMORY_IN_WINDOWS: f64 = 4.0;

/// Fewest samples for which the motor must look healthy before an alarm is withdrawn.
const CLEAR_HOLD_SAMPLES: f64 = 4.0;

/// When an alarm is raised, and when it is withdrawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarming {
    /// False alarms that are tolerable per hour.
    pub false_alarms_per_hour: f64,
    /// How long something must be wrong before an alarm is raised, s.
    pub raise_hold_s: f64,
    /// How long the motor must look healthy before it is withdrawn, s; the core's own if none.
    pub clear_hold_s: Option<f64>,
}

impl Alarming {
    /// At once, and with so many false alarms per hour.
    #[must_use]
    pub const fn at(false_alarms_per_hour: f64) -> Self {
        Alarming { false_alarms_per_hour, raise_hold_s: 0.0, clear_hold_s: None }
    }
}

impl Default for Alarming {
    /// One false alarm in a hundred hours.
    fn default() -> Self {
        Self::at(0.01)
    }
}

/// Settings for a rate, and for times in which to settle, to seed (twice) and to learn, each in s: the core's own, but for logs that are so slow, or stretches so short, that those would average over no samples.
#[must_use]
pub fn settings(rate_hz: f64, alarming: &Alarming, settle_s: f64, seed_s: f64, learn_s: f64) -> Config {
    let usual = Config::at_rate(rate_hz as f32);
    let [fast, middle, slow, trend] = usual.time_constants_s.map(f64::from);
    let [least_fast, least_middle, least_slow, least_trend] = LEAST_SAMPLES.map(|samples| samples / rate_hz);
    // A little less, so that a window of exactly so many still holds them when both are rounded to f32.
    let middle = middle.max(least_middle).min(learn_s / MIDDLES_IN_WINDOW * (1.0 - 1e-6));
    let fast = fast.max(least_fast).min(middle);
    let slow = slow.max(least_slow).min(learn_s / SLOWS_IN_WINDOW).max(middle);
    let trend = trend.max(least_trend).max(slow);
    Config {
        false_alarms_per_hour: alarming.false_alarms_per_hour as f32,
        raise_hold_s: alarming.raise_hold_s as f32,
        settle_s: settle_s as f32,
        seed_s: whole_samples(seed_s, rate_hz),
        learn_s: whole_samples(learn_s, rate_hz),
        time_constants_s: [fast, middle, slow, trend].map(|time| time as f32),
        memory_s: usual.memory_s.max((MEMORY_IN_WINDOWS * learn_s) as f32),
        clear_hold_s: alarming
            .clear_hold_s
            .map_or_else(|| usual.clear_hold_s.max((CLEAR_HOLD_SAMPLES / rate_hz) as f32), |hold_s| hold_s as f32),
        ..usual
    }
}

/// The learning time for which [`settings`] shortens no time scale, s.
#[must_use]
pub fn ample_learn_s(rate_hz: f64) -> f64 {
    let usual = Config::at_rate(rate_hz as f32);
    let [_, middle, slow, _] = usual.time_constants_s.map(f64::from);
    let [_, least_middle, least_slow, _] = LEAST_SAMPLES.map(|samples| samples / rate_hz);
    let scales = f64::max(MIDDLES_IN_WINDOW * middle.max(least_middle), SLOWS_IN_WINDOW * slow.max(least_slow));
    // A thousandth more than it takes, so that rounding to rows and to f32 shortens nothing either.
    f64::from(usual.learn_s).max(1.001 * scales)
}

/// A time that the core, which cuts fractions of a sample off, takes for this number of samples.
fn whole_samples(time_s: f64, rate_hz: f64) -> f32 {
    (((time_s * rate_hz).round() + 0.25) / rate_hz) as f32
}

/// How a stretch that is healthy from `start_s` to `end_s` is spent (settling, seeding, learning, each in s): the two seeding
/// windows lie before it where there is room, and take its beginning where there is not.
#[must_use]
pub fn spent(rate_hz: f64, start_s: f64, end_s: f64) -> [f64; 3] {
    let least_s = f64::from(Moments::<3>::MIN_SAMPLES) / rate_hz;
    let seed_s = SEED_S.min(start_s / 2.0).max(least_s);
    let settle_s = (start_s - 2.0 * seed_s).max(0.0);
    [settle_s, seed_s, end_s - settle_s - 2.0 * seed_s]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn at_the_usual_rate_and_window_the_settings_are_the_cores_own() {
        assert_eq!(spent(1000.0, 5.0, 20.0), [3.0, 1.0, 15.0]);
        let usual = Config::at_rate(1000.0);
        let ours = settings(1000.0, &Alarming::default(), 2.0, 1.0, 15.0);
        assert_eq!(ours.time_constants_s, usual.time_constants_s);
        assert_eq!((ours.memory_s, ours.clear_hold_s), (usual.memory_s, usual.clear_hold_s));
    }

    #[test]
    fn a_fault_is_sized_by_the_current_of_the_set_point_at_which_it_stands() {
        let motor = MotorConstants { resistance_ohm: 0.3, torque_constant_nm_per_a: 0.03, load_slope_nm_s: 2e-4 };
        let config = Config { settle_s: 0.1, seed_s: 0.5, learn_s: 4.0, ..Config::at_rate(1000.0) };
        let mut guardian = Guardian::new(&config, Some(motor)).unwrap();
        let mut draw = ChaCha8Rng::seed_from_u64(1);
        let mut noise = || (0..12).map(|_| draw.random::<f32>()).sum::<f32>() - 6.0;
        let mut run = |slots: u32, set_point: f32, current: f32, grown: f32| {
            let voltage = (0.3 + grown) * current + 0.03 * set_point;
            let mut step = || {
                let x = [set_point + 0.1 * noise(), current + 0.02 * noise(), voltage + 0.02 * noise()];
                guardian.step(set_point, x).found
            };
            (0..slots).map(|_| step()).last().flatten()
        };
        run(10_000, 300.0, 2.0, 0.0);
        run(10_000, 200.0, 1.0, 0.0);
        for (set_point, current) in [(200.0, 1.0), (300.0, 2.0)] {
            run(3_000, set_point, current, 0.0);
            let found = run(3_000, set_point, current, 0.1).unwrap();
            assert_eq!(found.name, Name::ArmatureResistance);
            let size = found.size.unwrap().value;
            assert!((size - 0.1).abs() < 0.01, "{size} at {set_point}");
            run(3_000, set_point, current, 0.0);
        }
    }

    proptest! {
        #[test]
        fn a_window_that_is_long_enough_makes_settings_that_the_core_takes_and_is_spent_to_the_row(
            rate_hz in prop_oneof![Just(1.0), Just(10.0), 0.1..20_000.0_f64],
            seed in 30_u64..5_000,
            learn in 120_u64..200_000,
        ) {
            let [seed_s, learn_s] = [seed, learn].map(|rows| rows as f64 / rate_hz);
            let config = settings(rate_hz, &Alarming::default(), 0.0, seed_s, learn_s);
            let mut guardian = Guardian::new(&config, None);
            prop_assert!(guardian.is_ok(), "{:?} {config:?}", guardian.err());
            if let Ok(guardian) = &mut guardian
                && learn < 2_000
            {
                // The gate takes one slot to find the set point. Readings that repeat with the noise of a converter.
                let read = |k: u64| [0, 1, 2].map(|n| ((k * (7 + 4 * n) + k * k) % 31) as f32);
                let slots = 2 * seed + learn;
                let learned = (0..slots + 2).position(|k| guardian.step(0.0, read(k)).learned.is_some());
                prop_assert_eq!(learned, Some(slots as usize));
            }
        }
    }
}
