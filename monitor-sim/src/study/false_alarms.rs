//! `study false-alarms`: hours of fault-free operation over random motors, each with limits of its own, at one set point or at
//! many.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::calibrate::Asked;
use super::flight::{Alarms, fly};
use super::poisson::interval;
use super::watch::{Known, Limits, Mode};
use super::{Findings, Study, StudyError, purpose, seed_of};
use crate::chart::{Axis, Range, range_chart};
use crate::page::Block;
use crate::plant::Plant;
use crate::random_motor::random_motor;
use crate::scenario::{Scenario, SetPoint};
use crate::tables::{TextTable, significant};

const SECONDS_PER_HOUR: f64 = 3600.0;

/// Set points of a mission that changes them, as shares of the motor's own: each of these is as likely as another, after the
/// highest and the lowest.
const LEVELS: u32 = 9;
const LOWEST: f64 = 0.6;

/// What such a mission tells its monitor of the loop: nothing is learned for 2 s, then two seeding windows of 1 s come.
const SETTLE_S: f64 = 4.0;

/// Motors that are pictured by themselves.
const PICTURED_MOTORS: usize = 12;

/// The study's settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FalseAlarms {
    /// Which monitor.
    pub mode: Mode,
    /// Seed of everything.
    pub seed: u64,
    /// What the limits are for.
    pub asked: Asked,
    /// Random motors.
    pub motors: u64,
    /// Hours judged, over all motors.
    pub hours: f64,
    /// How long a set point stands before another one is taken, s; for ever if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change_s: Option<f64>,
    /// Length of the learning window, s; the motor's own if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learn_s: Option<f64>,
}

/// The set points of a mission that changes them, of a motor whose own is the highest.
fn changing(motor: &Scenario, change_s: f64, duration_s: f64, seed: u64) -> Vec<SetPoint> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed_of(seed, purpose::DRAW, 0));
    let own = motor.set_point(0.0);
    let changes = (duration_s / change_s).ceil() as u32;
    let level = |n: u32| match n {
        0 => LEVELS - 1,
        1 => 0,
        _ => draw.random_range(0..LEVELS),
    };
    let share = |level: u32| LOWEST + (1.0 - LOWEST) * f64::from(level) / f64::from(LEVELS - 1);
    let levels = (0..changes).map(level);
    levels.enumerate().map(|(n, at)| SetPoint { at_s: n as f64 * change_s, rad_per_s: own * share(at) }).collect()
}

/// What one motor did.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MotorAlarms {
    motor_seed: u64,
    flight_seed: u64,
    rate_hz: f64,
    alarms: Alarms,
    /// Samples of the flight.
    flown: u64,
    limits: Limits,
    steps: u64,
}

/// Limits for a random motor, from fault-free runs with seeds of their own.
pub(super) fn limits_of(mode: Mode, asked: &Asked, scenario: &Scenario, seed: u64) -> Result<Limits, StudyError> {
    let known = Known::of(scenario);
    let healthy = Scenario { duration_s: asked.run_s(&known), ..scenario.without_faults() };
    mode.limits(&known, asked, |run| Plant::exponential(&healthy, seed_of(seed, purpose::CALIBRATION, run)))
}

/// Control periods that [`limits_of`] flies for a mode that calibrates.
pub(super) fn calibration_steps(limits: &Limits, asked: &Asked, scenario: &Scenario) -> u64 {
    let run = asked.run_s(&Known::of(scenario)) * scenario.rate_hz();
    if limits.thresholds.is_some() { asked.calibration_runs * run.round() as u64 } else { 0 }
}

/// The motors with most alarms, if they had any; they are counted from 1, in the order of the rows for machines.
fn noisiest(units: &[MotorAlarms], hours_of: impl Fn(&MotorAlarms) -> f64) -> Vec<Range> {
    let mut noisy: Vec<(usize, &MotorAlarms)> = (1..).zip(units).filter(|(_, unit)| unit.alarms.begun > 0).collect();
    noisy.sort_by_key(|(_, unit)| std::cmp::Reverse(unit.alarms.begun));
    let range = |(n, unit): (usize, &MotorAlarms)| {
        let hours = hours_of(unit);
        let [low, high] = interval(unit.alarms.begun).map(|count| count / hours);
        let name = format!("motor {n}");
        Range { name, ends: (low, high), half: None, middle: unit.alarms.begun as f64 / hours }
    };
    noisy.into_iter().take(PICTURED_MOTORS).map(range).collect()
}

impl Study for FalseAlarms {
    type Shared = ();
    type Unit = MotorAlarms;
    const NAME: &'static str = "false-alarms";

    fn units(&self) -> u64 {
        self.motors
    }

    fn prepare(&self) -> Result<(), StudyError> {
        Ok(())
    }

    fn unit(&self, (): &(), unit: u64) -> Result<MotorAlarms, StudyError> {
        let motor_seed = seed_of(self.seed, purpose::MOTOR, unit);
        let flight_seed = seed_of(motor_seed, purpose::FLIGHT, 0);
        let mut motor = random_motor(motor_seed);
        if let Some(learn_s) = self.learn_s {
            motor.learn.end_s = motor.learn.start_s + learn_s;
        }
        let limits = limits_of(self.mode, &self.asked, &motor, motor_seed)?;
        let duration_s = motor.learn.end_s + self.hours * SECONDS_PER_HOUR / self.motors as f64;
        let set_points = match self.change_s {
            Some(change_s) => changing(&motor, change_s, duration_s, motor_seed),
            None => motor.set_points.clone(),
        };
        let scenario = Scenario { duration_s, set_points, ..motor };
        scenario.validate()?;
        let known = Known::of(&scenario);
        let settle_s = self.change_s.map_or(known.settle_s, |_| SETTLE_S);
        let mut watch = self.mode.watch(&Known { settle_s, ..known }, &limits)?;
        let mut alarms = Alarms::default();
        let flown = fly(Plant::exponential(&scenario, flight_seed), watch.as_mut(), |_, _, said| alarms.push(said));
        let steps = flown + calibration_steps(&limits, &self.asked, &scenario);
        Ok(MotorAlarms { motor_seed, flight_seed, rate_hz: scenario.rate_hz(), alarms, flown, limits, steps })
    }

    fn findings(&self, (): &(), units: &[MotorAlarms]) -> Findings {
        let hours_of = |unit: &MotorAlarms| unit.alarms.judged as f64 / unit.rate_hz / SECONDS_PER_HOUR;
        let hours: f64 = units.iter().map(hours_of).sum();
        let alarms: u64 = units.iter().map(|unit| unit.alarms.begun).sum();
        let stood_s: f64 = units.iter().map(|unit| unit.alarms.stood as f64 / unit.rate_hz).sum();
        let flown: u64 = units.iter().map(|unit| unit.flown).sum();
        let judged_share = units.iter().map(|unit| unit.alarms.judged).sum::<u64>() as f64 / flown.max(1) as f64;
        let affected = units.iter().filter(|unit| unit.alarms.begun > 0).count();
        let [low, high] = interval(alarms).map(|count| count / hours);
        let rate = alarms as f64 / hours;
        let mut total = json!({
            "row": "total", "seed": self.seed, "motors": units.len(), "motors_with_alarms": affected, "hours": hours, "alarms": alarms,
            "alarms_per_hour": rate, "alarms_per_hour_low_95": low, "alarms_per_hour_high_95": high,
            "asked_per_hour": self.asked.false_alarms_per_hour, "alarm_s": stood_s, "judged_share": judged_share,
            "change_s": self.change_s,
        });
        if let Some(learn_s) = self.learn_s {
            total["learn_s"] = learn_s.into();
        }
        let rows = units.iter().map(|unit| {
            json!({
                "row": "motor", "motor_seed": unit.motor_seed, "flight_seed": unit.flight_seed,
                "hours": hours_of(unit), "judged_share": unit.alarms.judged as f64 / unit.flown.max(1) as f64, "alarms": unit.alarms.begun,
                "alarm_s": unit.alarms.stood as f64 / unit.rate_hz, "thresholds": unit.limits.thresholds,
            })
        });
        let header =
            ["motors", "with alarms", "hours", "judged, %", "alarms", "per hour", "95 % from", "to", "asked for"];
        let caption = "False alarms of fault-free random motors, with the exact Poisson interval";
        let row = [
            units.len().to_string(),
            affected.to_string(),
            significant(hours),
            format!("{:.1}", 100.0 * judged_share),
            alarms.to_string(),
            significant(rate),
            significant(low),
            significant(high),
            significant(self.asked.false_alarms_per_hour),
        ];
        let summary = format!(
            "{alarms} false alarms in {} judged hours of {} motors ({:.1} % of the time): {} an hour (95 %: {} to {}), {} asked \
             for.",
            significant(hours),
            units.len(),
            100.0 * judged_share,
            significant(rate),
            significant(low),
            significant(high),
            significant(self.asked.false_alarms_per_hour)
        );
        let all = Range { name: "all motors".to_owned(), ends: (low, high), half: None, middle: rate };
        let ranges: Vec<Range> = std::iter::once(all).chain(noisiest(units, hours_of)).collect();
        let asked = Some(("asked for", self.asked.false_alarms_per_hour));
        let axis = Axis { name: "false alarms an hour", log: true };
        let pictured = "False alarms an hour with the exact Poisson interval of 95 %: of all motors, and of those with most. A ring at \
                        the left edge: there was none.";
        let figures =
            vec![Block::Figure { caption: pictured.to_owned(), pictures: vec![range_chart(&ranges, axis, asked)] }];
        Findings {
            summary,
            figures,
            rows: std::iter::once(total).chain(rows).collect(),
            tables: vec![TextTable::new(caption, header).with_rows([row])],
            steps: units.iter().map(|unit| unit.steps).sum(),
        }
    }
}
