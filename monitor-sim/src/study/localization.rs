//! `study localization`: which name each fault is given, over random motors and sizes from just detectable to large.
//!
//! The monitor is told the motor's constants wrongly by up to `constants_off`. A size is how far the settled readings
//! move, in sigmas of one sample by the learned covariance, so that it means the same for every motor and fault.

mod figures;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::calibrate::Asked;
use super::false_alarms::{calibration_steps, limits_of};
use super::faults::{Culprit, raw_baseline};
use super::flight::{Outcome, outcome};
use super::raw::RawBaseline;
use super::summary::{Spread, percent};
use super::watch::{Known, Limits, Mode, Name};
use super::{Findings, Study, StudyError, purpose, seed_of};
use crate::fault::FaultProfile;
use crate::plant::Plant;
use crate::random_motor::random_motor;
use crate::scenario::Scenario;
use crate::tables::{TextTable, shown, significant};

/// When the fault stands, to the end of the flight, s: learning ends at 15.5 s.
const FAULT_S: [f64; 2] = [17.5, 27.5];

/// A fault counts as isolable if this many sigmas of its shift look like no other fault.
const ISOLABLE_SIGMAS: f64 = 1.0;

/// The study's settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Localization {
    /// Which monitor.
    pub mode: Mode,
    /// Seed of everything.
    pub seed: u64,
    /// What the limits are for.
    pub asked: Asked,
    /// Random motors.
    pub motors: u64,
    /// How far the settled readings move, sigmas of one sample.
    pub sizes: Vec<f64>,
    /// How far the constants that the monitor is told may be off, as a share.
    pub constants_off: f64,
    /// Which faults there are, for the plant and for what counts as isolable.
    pub faults: Faults,
}

/// The faults that a motor may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Faults {
    /// The paper's three: load torque, speed sensor, current sensor
    Paper,
    /// Those, and armature resistance, torque constant, voltage actuator, load inertia
    All,
}

impl Faults {
    const fn culprits(self) -> &'static [Culprit] {
        match self {
            Self::Paper => Culprit::papers(),
            Self::All => &Culprit::ALL,
        }
    }
}

/// One motor.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MotorCases {
    motor_seed: u64,
    /// By fault, then by size.
    cases: Vec<Case>,
    steps: u64,
}

/// One flight.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Case {
    amplitude: f64,
    sigmas: f64,
    /// How many of the sigmas no other fault can look like.
    apart: f64,
    /// What the monitor's own checker says that it would be called.
    foretold: Option<Name>,
    outcome: Outcome,
}

/// What a study of this motor is flown with.
struct Rig<'a> {
    scenario: &'a Scenario,
    known: Known,
    limits: Limits,
    baseline: RawBaseline,
    motor_seed: u64,
}

impl Localization {
    fn case(&self, rig: &Rig<'_>, culprit: &Culprit, size: f64, flight: u64) -> Result<(Case, u64), StudyError> {
        let (magnitude, sigmas) = culprit.amplitude(rig.scenario, &rig.baseline, size);
        let mut draw = ChaCha8Rng::seed_from_u64(seed_of(rig.motor_seed, purpose::DRAW, 1 + flight));
        let downwards = match culprit.has_both_signs() {
            true => draw.random::<bool>(),
            false => culprit.figure_1_amplitude() < 0.0,
        };
        let amplitude = if downwards { -magnitude } else { magnitude };
        let [start_s, end_s] = FAULT_S;
        let faults = vec![culprit.fault(amplitude, FaultProfile::Step, start_s, end_s)];
        let scenario = Scenario { duration_s: end_s, faults, ..rig.scenario.clone() };
        scenario.validate()?;
        let plant = Plant::exponential(&scenario, seed_of(rig.motor_seed, purpose::FLIGHT, flight));
        let mut watch = self.mode.watch(&rig.known, &rig.limits)?;
        let (outcome, steps) = outcome(plant, watch.as_mut(), Name::of(culprit.point), FAULT_S, scenario.rate_hz());
        let apart = sigmas * culprit.isolation(self.faults.culprits(), rig.scenario, &rig.baseline);
        let foretold = watch.foretold(culprit.point, amplitude);
        Ok((Case { amplitude, sigmas, apart, foretold, outcome }, steps))
    }

    /// The flights of the `n`-th fault at the `k`-th size.
    fn cases<'a>(&self, units: &'a [MotorCases], n: usize, k: usize) -> Vec<&'a Case> {
        units.iter().filter_map(|motor| motor.cases.get(n * self.sizes.len() + k)).collect()
    }

    /// How the isolable cases fared: by what looks like no other fault in the noise if the constants were known, and by what the
    /// monitor foretells from the constants that it is told.
    fn isolable(&self, units: &[MotorCases]) -> (TextTable, Vec<Value>) {
        let culprits = || self.faults.culprits().iter().flat_map(|culprit| self.sizes.iter().map(move |_| culprit));
        let count = |faults: usize, is_isolable: &dyn Fn(&Culprit, &Case) -> bool| {
            let of = |motor: &MotorCases| {
                let cases = culprits().zip(motor.cases.clone()).take(faults * self.sizes.len());
                cases.filter(|(_, case)| case.outcome.detected_s.is_some()).collect::<Vec<_>>()
            };
            let cases: Vec<_> =
                units.iter().flat_map(of).filter(|(culprit, case)| is_isolable(culprit, case)).collect();
            (cases.len(), cases.iter().filter(|(culprit, case)| is_group_right(culprit, &case.outcome)).count())
        };
        let apart = |_: &Culprit, case: &Case| case.apart >= ISOLABLE_SIGMAS;
        let foretold = |culprit: &Culprit, case: &Case| case.foretold == Some(Name::of(culprit.point));
        let mut table =
            TextTable::new("Detected cases that can be told from others", ["faults", "by", "cases", "right group, %"]);
        let mut rows = Vec::new();
        let by_sigmas = format!("{ISOLABLE_SIGMAS} sigma or more like no other fault");
        for (faults, by, key, (cases, right)) in [
            ("all", by_sigmas.as_str(), "apart", count(Culprit::ALL.len(), &apart)),
            ("F1, F2, F3", by_sigmas.as_str(), "apart", count(Culprit::papers().len(), &apart)),
            ("F1, F2, F3", "what the monitor foretells", "foretold", count(Culprit::papers().len(), &foretold)),
        ] {
            table.rows.push(vec![faults.to_owned(), by.to_owned(), cases.to_string(), percent(right, cases)]);
            rows.push(json!({
                "row": "isolable", "faults": faults, "by": key, "apart_sigmas": ISOLABLE_SIGMAS, "seed": self.seed,
                "motors": units.len(), "cases": cases, "right_group": right,
            }));
        }
        (table, rows)
    }

    /// Factors of resistance, torque constant and load slope.
    fn wrong_by(&self, motor_seed: u64) -> [f64; 3] {
        let mut draw = ChaCha8Rng::seed_from_u64(seed_of(motor_seed, purpose::DRAW, 0));
        [(); 3].map(|()| 1.0 + self.constants_off * (2.0 * draw.random::<f64>() - 1.0))
    }
}

impl Study for Localization {
    type Shared = ();
    type Unit = MotorCases;
    const NAME: &'static str = "localization";

    fn units(&self) -> u64 {
        self.motors
    }

    fn prepare(&self) -> Result<(), StudyError> {
        Ok(())
    }

    fn unit(&self, (): &(), unit: u64) -> Result<MotorCases, StudyError> {
        let motor_seed = seed_of(self.seed, purpose::MOTOR, unit);
        let scenario = random_motor(motor_seed);
        let limits = limits_of(self.mode, &self.asked, &scenario, motor_seed)?;
        let baseline = raw_baseline(&scenario, motor_seed).ok_or(StudyError::NothingLearned(None))?;
        let known = Known::of(&scenario).off_by(self.wrong_by(motor_seed));
        let mut steps = calibration_steps(&limits, &self.asked, &scenario);
        let rig = Rig { scenario: &scenario, known, limits, baseline, motor_seed };
        let flights =
            self.faults.culprits().iter().flat_map(|culprit| self.sizes.iter().map(move |size| (culprit, *size)));
        let mut cases = Vec::new();
        for (flight, (culprit, size)) in (0..).zip(flights) {
            let (case, flown) = self.case(&rig, culprit, size, flight)?;
            steps += flown;
            cases.push(case);
        }
        Ok(MotorCases { motor_seed, cases, steps })
    }

    fn findings(&self, (): &(), units: &[MotorCases]) -> Findings {
        let mut sizes = TextTable::new(
            "Names over random motors (medians). Apart: sigmas that look like no other fault. Right: the name that stood \
             longest; group: it or one of the same direction; stands: right for 99 % of the time from 1 s after detection",
            ["fault", "sigmas", "flights", "detected, %", "apart", "right, %", "group, %", "stands, %", "delay, s"],
        );
        let mut rows = Vec::new();
        for (n, culprit) in self.faults.culprits().iter().enumerate() {
            for (k, size) in self.sizes.iter().enumerate() {
                let cases = self.cases(units, n, k);
                let row = SizeRow::of(culprit, &cases);
                rows.push(row.json(culprit, *size, self.seed));
                sizes.rows.push(row.cells(culprit, *size));
            }
        }
        let confusions = self.faults.culprits().iter().enumerate().map(|(n, culprit)| {
            let of_fault = |motor: &MotorCases| {
                let cases = motor.cases.iter().skip(n * self.sizes.len()).take(self.sizes.len());
                cases.map(|case| case.outcome).collect::<Vec<_>>()
            };
            (culprit, Confusion::of(units.iter().flat_map(of_fault)))
        });
        let confusions: Vec<_> = confusions.collect();
        rows.extend(confusions.iter().map(|(culprit, confusion)| confusion.json(culprit, self.seed)));
        let steps = units.iter().map(|unit| unit.steps).sum();
        let (isolable, isolable_rows) = self.isolable(units);
        rows.extend(isolable_rows);
        Findings {
            summary: figures::summary(self, units),
            figures: figures::figures(self, units, &confusions),
            rows,
            tables: vec![sizes, confusion_table(&confusions), isolable],
            steps,
        }
    }
}

/// One fault at one size.
struct SizeRow {
    flights: usize,
    early: usize,
    detected: usize,
    right: usize,
    right_group: usize,
    stands: usize,
    isolable: usize,
    isolable_right_group: usize,
    delay_s: Option<Spread>,
    sigmas: Option<Spread>,
    apart: Option<Spread>,
}

/// Whether a fault was given its name or that of one in the same direction.
fn is_group_right(culprit: &Culprit, outcome: &Outcome) -> bool {
    outcome.named.is_some_and(|name| is_of_group(culprit, name))
}

fn is_of_group(culprit: &Culprit, name: Name) -> bool {
    Culprit::ALL.iter().any(|other| culprit.is_in_group_with(other) && Name::of(other.point) == name)
}

impl SizeRow {
    fn of(culprit: &Culprit, cases: &[&Case]) -> Self {
        let found = || cases.iter().map(|case| &case.outcome).filter(|outcome| outcome.detected_s.is_some());
        let isolable =
            || cases.iter().filter(|case| case.outcome.detected_s.is_some() && case.apart >= ISOLABLE_SIGMAS);
        Self {
            flights: cases.len(),
            early: cases.iter().filter(|case| case.outcome.early).count(),
            detected: found().count(),
            right: found().filter(|outcome| outcome.named == Some(Name::of(culprit.point))).count(),
            right_group: found().filter(|outcome| is_group_right(culprit, outcome)).count(),
            stands: found().filter(|outcome| outcome.right_stands()).count(),
            isolable: isolable().count(),
            isolable_right_group: isolable().filter(|case| is_group_right(culprit, &case.outcome)).count(),
            delay_s: Spread::of(found().filter_map(|outcome| outcome.detected_s)),
            sigmas: Spread::of(cases.iter().map(|case| case.sigmas)),
            apart: Spread::of(cases.iter().map(|case| case.apart)),
        }
    }

    fn json(&self, culprit: &Culprit, size: f64, seed: u64) -> Value {
        json!({
            "row": "size", "fault": culprit.id, "point": culprit.point, "kind": culprit.kind, "asked_sigmas": size,
            "sigmas": self.sigmas, "seed": seed, "flights": self.flights, "early_alarms": self.early,
            "detected": self.detected, "named_right": self.right, "named_right_group": self.right_group, "apart_sigmas": self.apart,
            "isolable": self.isolable, "isolable_right_group": self.isolable_right_group, "right_name_stands": self.stands,
            "delay_s": self.delay_s,
        })
    }

    fn cells(&self, culprit: &Culprit, size: f64) -> Vec<String> {
        vec![
            format!("{} {}", culprit.id, Name::of(culprit.point).words()),
            significant(size),
            self.flights.to_string(),
            percent(self.detected, self.flights),
            shown(self.apart.map(|s| s.median)),
            percent(self.right, self.detected),
            percent(self.right_group, self.detected),
            percent(self.stands, self.detected),
            shown(self.delay_s.map(|s| s.median)),
        ]
    }
}

/// How often a fault was given each name, over all sizes.
#[derive(Default)]
struct Confusion {
    named: [usize; Name::ALL.len()],
    nameless: usize,
    missed: usize,
    early: usize,
}

impl Confusion {
    fn of(outcomes: impl Iterator<Item = Outcome>) -> Self {
        outcomes.fold(Self::default(), |mut all, outcome| {
            match (outcome.early, outcome.detected_s, outcome.named) {
                (true, ..) => all.early += 1,
                (_, None, _) => all.missed += 1,
                (_, _, None) => all.nameless += 1,
                (_, _, Some(name)) => all.named[name as usize] += 1,
            }
            all
        })
    }

    fn flights(&self) -> usize {
        self.named.iter().sum::<usize>() + self.nameless + self.missed + self.early
    }

    fn json(&self, culprit: &Culprit, seed: u64) -> Value {
        let named: Map<String, Value> =
            Name::ALL.iter().map(|name| (name.words().replace(' ', "_"), self.named[*name as usize].into())).collect();
        json!({
            "row": "confusion", "fault": culprit.id, "point": culprit.point, "seed": seed, "flights": self.flights(), "named": named,
            "nameless": self.nameless, "missed": self.missed, "early_alarms": self.early,
        })
    }
}

/// The names that were given at all.
fn given_names(confusions: &[(&Culprit, Confusion)]) -> Vec<Name> {
    Name::ALL.into_iter().filter(|name| confusions.iter().any(|(_, c)| c.named[*name as usize] > 0)).collect()
}

/// Faults down, names across; names that nobody gave are left out.
fn confusion_table(confusions: &[(&Culprit, Confusion)]) -> TextTable {
    let given = given_names(confusions);
    let names = given.iter().map(|name| name.words());
    let header = std::iter::once("named").chain(names).chain(["no name", "missed", "alarm before"]);
    let mut table =
        TextTable::new("Confusion table, all sizes: flights of each fault by the name that stood longest", header);
    for (culprit, confusion) in confusions {
        let counts = given.iter().map(|name| confusion.named[*name as usize]);
        let counts = counts.chain([confusion.nameless, confusion.missed, confusion.early]).map(|n| n.to_string());
        let first = format!("{} {}", culprit.id, Name::of(culprit.point).words());
        table.rows.push(std::iter::once(first).chain(counts).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flight_is_named_nameless_missed_or_under_an_alarm_before_its_fault() {
        let outcome =
            |early, detected_s, named| Outcome { early, detected_s, cleared_s: None, named, right_share: None };
        let outcomes = [
            outcome(true, None, None),
            outcome(false, None, None),
            outcome(false, Some(0.1), None),
            outcome(false, Some(0.1), Some(Name::SpeedSensor)),
        ];
        let confusion = Confusion::of(outcomes.into_iter());
        let counts =
            [confusion.early, confusion.missed, confusion.nameless, confusion.named[Name::SpeedSensor as usize]];
        assert_eq!((counts, confusion.named.iter().sum::<usize>()), ([1; 4], 1));
    }

    #[test]
    fn resistance_and_supply_are_one_group_and_either_name_is_right() {
        let named = |name| Outcome {
            early: false,
            detected_s: Some(0.1),
            cleared_s: None,
            named: Some(name),
            right_share: None,
        };
        let [f1, _, _, resistance, ..] = &Culprit::ALL;
        assert!(is_group_right(resistance, &named(Name::VoltageActuator)));
        assert!(is_group_right(resistance, &named(Name::ArmatureResistance)));
        assert!(!is_group_right(resistance, &named(Name::SpeedSensor)));
        assert!(!is_group_right(f1, &named(Name::LoadInertia)));
    }
}
