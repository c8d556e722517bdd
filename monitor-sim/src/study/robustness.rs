//! `study robustness`: what readings and knowledge that are worse than assumed do to a monitor, over random motors.
//!
//! Limits are set on undisturbed runs. Then, for each disturbance, the motor runs without a fault (how often is there an
//! alarm?) and with each of the paper's three (is it still found and named?); the disturbance is there from the
//! beginning, while learning too. A stuck sensor is a fault of its own: it begins when a fault would.

mod figures;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::calibrate::Asked;
use super::false_alarms::{calibration_steps, limits_of};
use super::faults::{Culprit, raw_baseline};
use super::flight::{Alarms, Outcome, fly, outcome};
use super::jitter::Jittered;
use super::poisson::interval;
use super::raw::RawBaseline;
use super::summary::{Spread, percent};
use super::watch::{Known, Limits, Mode, Name};
use super::{Findings, Study, StudyError, purpose, seed_of};
use crate::fault::{Fault, FaultKind, FaultPoint, FaultProfile};
use crate::plant::Plant;
use crate::random_motor::random_motor;
use crate::scenario::Scenario;
use crate::tables::{TextTable, shown, significant};
use figures::Found;

/// When a fault stands, to the end of its flight, s: learning ends at 15.5 s.
const FAULT_S: [f64; 2] = [17.5, 27.5];

/// How large a spike is, sigmas of its sensor: beyond anything that noise does.
const SPIKE_SIGMAS: f64 = 20.0;

const SENSORS: [FaultPoint; 3] = [FaultPoint::SpeedSensor, FaultPoint::CurrentSensor, FaultPoint::VoltageSensor];

/// What is worse than assumed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "disturbance", content = "level")]
enum Disturbance {
    /// Nothing.
    None,
    /// Share of the readings of each sensor that are off by [`SPIKE_SIGMAS`], either way.
    Outliers(f64),
    /// Share of the slots without a sample.
    Missing(f64),
    /// ADC step of each sensor, in its sigmas.
    Coarse(f64),
    /// Share by which resistance, torque constant and load slope are wrong, each up or down.
    WrongConstants(f64),
    /// Samples late by up to this share of the control period.
    Jitter(f64),
}

use Disturbance::{Coarse, Jitter, Missing, Outliers, WrongConstants};

const DISTURBANCES: [Disturbance; 15] = [
    Disturbance::None,
    Outliers(1e-4),
    Outliers(1e-3),
    Outliers(1e-2),
    Missing(0.01),
    Missing(0.1),
    Missing(0.5),
    Coarse(1.0),
    Coarse(4.0),
    Coarse(16.0),
    WrongConstants(0.2),
    WrongConstants(0.5),
    Jitter(0.1),
    Jitter(0.5),
    Jitter(1.0),
];

impl Disturbance {
    /// In words, and its level.
    fn words(&self) -> [String; 2] {
        let percent = |share: f64| format!("{} %", significant(100.0 * share));
        match *self {
            Self::None => ["none", ""].map(str::to_owned),
            Outliers(share) => ["outliers of 20 sigma".to_owned(), percent(share)],
            Missing(share) => ["missing samples".to_owned(), percent(share)],
            Coarse(sigmas) => ["ADC step".to_owned(), format!("{sigmas} sigma")],
            WrongConstants(share) => ["wrong constants".to_owned(), percent(share)],
            Jitter(share) => ["late by up to".to_owned(), percent(share)],
        }
    }

    /// As faults that stand from the beginning to `end_s`.
    fn faults(&self, scenario: &Scenario, end_s: f64) -> Vec<Fault> {
        let fault = |id: String, point, kind, amplitude, share| Fault {
            name: id.clone(),
            id,
            point,
            kind,
            profile: FaultProfile::Step,
            amplitude,
            start_s: 0.0,
            end_s,
            share,
        };
        let sensors = || SENSORS.into_iter().zip(sigmas(scenario));
        match *self {
            Outliers(share) => sensors()
                .flat_map(|(point, sigma)| [1.0, -1.0].map(|sign| (point, sign * SPIKE_SIGMAS * sigma)))
                .map(|(point, spike)| fault(format!("{point:?} {spike}"), point, FaultKind::Offset, spike, 0.5 * share))
                .collect(),
            Missing(share) => {
                vec![fault("missing".to_owned(), FaultPoint::Sampling, FaultKind::Missing, share, 1.0)]
            }
            Coarse(steps) => sensors()
                .map(|(point, sigma)| fault(format!("{point:?}"), point, FaultKind::Coarse, steps * sigma, 1.0))
                .collect(),
            Self::None | WrongConstants(_) | Jitter(_) => Vec::new(),
        }
    }
}

/// Standard deviation of each sensor's noise.
const fn sigmas(scenario: &Scenario) -> [f64; 3] {
    let noise = &scenario.noise;
    [noise.speed_sigma_rad_per_s, noise.current_sigma_a, noise.voltage_sigma_v]
}

/// The study's settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Robustness {
    /// Which monitor.
    pub mode: Mode,
    /// Seed of everything.
    pub seed: u64,
    /// What the limits are for.
    pub asked: Asked,
    /// Random motors.
    pub motors: u64,
    /// How far the paper's faults shift the settled readings, sigmas of one sample.
    pub size: f64,
    /// How long a motor is judged without a fault under each disturbance, s.
    pub healthy_s: f64,
}

/// One motor under all disturbances.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MotorTrials {
    motor_seed: u64,
    rate_hz: f64,
    trials: Vec<Trial>,
    stuck: Vec<Outcome>,
    steps: u64,
}

/// One disturbance.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Trial {
    alarms: Alarms,
    faults: Vec<Outcome>,
}

/// One motor and what it is flown with.
struct Rig<'a> {
    study: &'a Robustness,
    scenario: Scenario,
    limits: Limits,
    baseline: RawBaseline,
    motor_seed: u64,
    steps: u64,
}

impl Rig<'_> {
    /// Flies a disturbance with `faults` beside it; `fly` gets the samples and the monitor.
    fn flight<T>(
        &mut self,
        disturbance: Disturbance,
        faults: Vec<Fault>,
        duration_s: f64,
        purpose_number: u64,
        fly: impl FnOnce(&mut dyn Iterator<Item = crate::plant::PlantSample>, &mut dyn super::watch::Watch) -> (T, u64),
    ) -> Result<T, StudyError> {
        let mut all = disturbance.faults(&self.scenario, duration_s);
        all.extend(faults);
        let scenario = Scenario { duration_s, faults: all, ..self.scenario.clone() };
        scenario.validate()?;
        let known = Known::of(&self.scenario);
        let known = match disturbance {
            WrongConstants(share) => known.off_by(self.wrong_by(share)),
            // A converter's step is in its data sheet.
            Coarse(steps) => Known { adc_steps: sigmas(&self.scenario).map(|sigma| steps * sigma), ..known },
            _ => known,
        };
        let mut watch = self.study.mode.watch(&known, &self.limits)?;
        let seed = seed_of(self.motor_seed, purpose::FLIGHT, purpose_number);
        let mut plant = Plant::exponential(&scenario, seed);
        let (found, steps) = match disturbance {
            Jitter(latest) => {
                let late = seed_of(self.motor_seed, purpose::DRAW, 1 + purpose_number);
                fly(&mut Jittered::new(plant, latest, late), watch.as_mut())
            }
            _ => fly(&mut plant, watch.as_mut()),
        };
        self.steps += steps;
        Ok(found)
    }

    /// Each constant is wrong by the whole share, up or down.
    fn wrong_by(&self, share: f64) -> [f64; 3] {
        let mut draw = ChaCha8Rng::seed_from_u64(seed_of(self.motor_seed, purpose::DRAW, 0));
        [(); 3].map(|()| if draw.random::<bool>() { 1.0 + share } else { 1.0 - share })
    }

    fn trial(&mut self, disturbance: Disturbance) -> Result<Trial, StudyError> {
        let healthy_s = self.scenario.learn.end_s + self.study.healthy_s;
        // Every disturbance meets the same noise.
        let alarms = self.flight(disturbance, Vec::new(), healthy_s, 0, |samples, watch| {
            let mut alarms = Alarms::default();
            let steps = fly(samples, watch, |_, _, said| alarms.push(said));
            (alarms, steps)
        })?;
        let mut faults = Vec::new();
        for (n, culprit) in (1..).zip(Culprit::papers()) {
            let (amplitude, _) = culprit.amplitude(&self.scenario, &self.baseline, self.study.size);
            let [start_s, end_s] = FAULT_S;
            let fault = culprit.fault(amplitude, FaultProfile::Step, start_s, end_s);
            faults.push(self.faulty(disturbance, fault, Name::of(culprit.point), n)?);
        }
        Ok(Trial { alarms, faults })
    }

    fn faulty(&mut self, disturbance: Disturbance, fault: Fault, right: Name, n: u64) -> Result<Outcome, StudyError> {
        let rate_hz = self.scenario.rate_hz();
        self.flight(disturbance, vec![fault], FAULT_S[1], n, |samples, watch| {
            outcome(samples, watch, right, FAULT_S, rate_hz)
        })
    }

    fn stuck(&mut self, point: FaultPoint, n: u64) -> Result<Outcome, StudyError> {
        let [start_s, end_s] = FAULT_S;
        let stuck = Culprit { id: "stuck", point, kind: FaultKind::Stuck };
        let fault = stuck.fault(1.0, FaultProfile::Step, start_s, end_s);
        self.faulty(Disturbance::None, fault, Name::SensorLoss, n)
    }
}

impl Study for Robustness {
    type Shared = ();
    type Unit = MotorTrials;
    const NAME: &'static str = "robustness";

    fn units(&self) -> u64 {
        self.motors
    }

    fn prepare(&self) -> Result<(), StudyError> {
        Ok(())
    }

    fn unit(&self, (): &(), unit: u64) -> Result<MotorTrials, StudyError> {
        let motor_seed = seed_of(self.seed, purpose::MOTOR, unit);
        let scenario = random_motor(motor_seed);
        let limits = limits_of(self.mode, &self.asked, &scenario, motor_seed)?;
        let baseline = raw_baseline(&scenario, motor_seed).ok_or(StudyError::NothingLearned(None))?;
        let steps = calibration_steps(&limits, &self.asked, &scenario);
        let rate_hz = scenario.rate_hz();
        let mut rig = Rig { study: self, scenario, limits, baseline, motor_seed, steps };
        let trials = DISTURBANCES.into_iter().map(|d| rig.trial(d)).collect::<Result<_, _>>()?;
        let stuck = SENSORS.into_iter().zip(1..).map(|(p, n)| rig.stuck(p, n)).collect::<Result<_, _>>()?;
        Ok(MotorTrials { motor_seed, rate_hz, trials, stuck, steps: rig.steps })
    }

    fn findings(&self, (): &(), units: &[MotorTrials]) -> Findings {
        let mut table = TextTable::new(
            format!("Random motors, faults of {} sigma: detected and named right, %", significant(self.size)),
            [
                "disturbance",
                "level",
                "judged, %",
                "false alarms",
                "per hour",
                "95 % from",
                "to",
                "F1 found",
                "right",
                "F2 found",
                "right",
                "F3 found",
                "right",
                "median delay, s",
            ],
        );
        let mut stuck = TextTable::new(
            "A sensor that sticks: detected, and named a loss of the sensor",
            ["sensor", "motors", "detected, %", "named, %", "median delay, s", "longest, s"],
        );
        let mut rows = Vec::new();
        let trials: Vec<TrialRow> = (0..DISTURBANCES.len()).map(|n| TrialRow::of(self, units, n)).collect();
        for (disturbance, row) in DISTURBANCES.iter().zip(&trials) {
            rows.push(row.json(disturbance, self));
            table.rows.push(row.cells(disturbance));
        }
        let mut sensors = Vec::new();
        for (n, point) in SENSORS.iter().enumerate() {
            let outcomes = || units.iter().filter_map(|unit| unit.stuck.get(n));
            let found = Found::of(outcomes(), Name::SensorLoss);
            let (row, cells) = stuck_row(*point, found, outcomes().filter_map(|outcome| outcome.detected_s), self.seed);
            rows.push(row);
            stuck.rows.push(cells);
            sensors.push(found);
        }
        let steps = units.iter().map(|unit| unit.steps).sum();
        let figures = figures::figures(self, &trials, &sensors);
        Findings { summary: figures::summary(&trials), figures, rows, tables: vec![table, stuck], steps }
    }
}

/// One disturbance over all motors.
struct TrialRow {
    judged_share: f64,
    hours: f64,
    alarms: u64,
    /// Of each fault.
    faults: Vec<Found>,
    delay_s: Option<Spread>,
}

impl TrialRow {
    fn of(study: &Robustness, units: &[MotorTrials], n: usize) -> Self {
        let trials: Vec<(&MotorTrials, &Trial)> =
            units.iter().filter_map(|unit| Some((unit, unit.trials.get(n)?))).collect();
        let hours: f64 = trials.iter().map(|(unit, trial)| trial.alarms.judged as f64 / unit.rate_hz / 3600.0).sum();
        let fault = |(k, culprit): (usize, &Culprit)| {
            Found::of(trials.iter().filter_map(|(_, trial)| trial.faults.get(k)), Name::of(culprit.point))
        };
        let delays = trials.iter().flat_map(|(_, trial)| trial.faults.iter().filter_map(|outcome| outcome.detected_s));
        Self {
            judged_share: hours * 3600.0 / (study.healthy_s * trials.len() as f64),
            hours,
            alarms: trials.iter().map(|(_, trial)| trial.alarms.begun).sum(),
            faults: Culprit::papers().iter().enumerate().map(fault).collect(),
            delay_s: Spread::of(delays),
        }
    }

    /// Rate of false alarms and its interval, per hour judged; none where nothing was.
    fn rate(&self) -> Option<[f64; 3]> {
        let [low, high] = interval(self.alarms);
        (self.hours > 0.0).then(|| [self.alarms as f64, low, high].map(|count| count / self.hours))
    }

    fn json(&self, disturbance: &Disturbance, study: &Robustness) -> Value {
        let [rate, low, high] = self.rate().map_or([None; 3], |rates| rates.map(Some));
        let faults = self.faults.iter().zip(&Culprit::ALL).map(|(found, culprit)| {
            let Found { flights, detected, right, early } = found;
            json!({"fault": culprit.id, "flights": flights, "detected": detected, "named_right": right, "early_alarms": early})
        });
        let [words, level] = disturbance.words();
        json!({
            "row": "disturbance", "disturbance": words, "level": level, "kind": disturbance, "seed": study.seed,
            "motors": study.motors, "size_sigmas": study.size, "judged_share": self.judged_share, "hours": self.hours,
            "alarms": self.alarms, "alarms_per_hour": rate, "alarms_per_hour_low_95": low,
            "alarms_per_hour_high_95": high, "faults": faults.collect::<Vec<_>>(), "delay_s": self.delay_s,
        })
    }

    fn cells(&self, disturbance: &Disturbance) -> Vec<String> {
        let rates = self.rate().map_or([None; 3], |rates| rates.map(Some)).map(shown);
        let faults = self
            .faults
            .iter()
            .flat_map(|found| [percent(found.detected, found.flights), percent(found.right, found.detected)]);
        let front = [format!("{:.1}", 100.0 * self.judged_share), self.alarms.to_string()];
        let delay = shown(self.delay_s.map(|s| s.median));
        disturbance.words().into_iter().chain(front).chain(rates).chain(faults).chain([delay]).collect()
    }
}

fn stuck_row(point: FaultPoint, found: Found, delays_s: impl Iterator<Item = f64>, seed: u64) -> (Value, Vec<String>) {
    let delay_s = Spread::of(delays_s);
    let row = json!({
        "row": "stuck", "point": point, "seed": seed, "flights": found.flights, "detected": found.detected,
        "named_sensor_loss": found.right, "early_alarms": found.early, "delay_s": delay_s,
    });
    let cells = vec![
        Name::of(point).words().to_owned(),
        found.flights.to_string(),
        percent(found.detected, found.flights),
        percent(found.right, found.detected),
        shown(delay_s.map(|s| s.median)),
        shown(delay_s.map(|s| s.max)),
    ];
    (row, cells)
}
