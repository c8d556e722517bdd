//! `study ramp`: the value that a growing fault has reached when it is detected, over seeds, in the motor of figure 1 or
//! in one's own.

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::calibrate::Asked;
use super::false_alarms::{calibration_steps, limits_of};
use super::faults::{Culprit, steady};
use super::flight::{Episode, fly};
use super::summary::Spread;
use super::watch::{Known, Limits, Mode, Name, Watch};
use super::{Findings, Study, StudyError, purpose, seed_of};
use crate::chart::{Axis, Range, range_chart};
use crate::fault::{Fault, FaultProfile};
use crate::page::Block;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::tables::{TextTable, shown, significant};

/// From the end of the learning window to the first ramp, s.
const AFTER_LEARNING_S: f64 = 4.5;

/// The study's settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Ramp {
    /// Which monitor.
    pub mode: Mode,
    /// Seed of everything.
    pub seed: u64,
    /// What the limits are for.
    pub asked: Asked,
    /// Flights of each fault.
    pub seeds: u64,
    /// Last value of each ramp, as a share of [`Culprit::figure_1_amplitude`], or of the scenario's own.
    pub size: f64,
    /// How long a ramp takes to its last value, s.
    pub ramp_s: f64,
    /// How long the monitor has watched the healthy motor before, s.
    pub known_s: f64,
    /// Look for the smallest ramp that is detected before it ends, in place of the value at detection.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub smallest: bool,
    /// The motor at its first set point, and the faults that grow; the motor of figure 1 with [`Culprit::ALL`] if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenario: Option<Scenario>,
}

/// How many ramps there are from one to another that is twice as large, when the smallest is looked for, and how often it may
/// halve.
const PER_OCTAVE: u32 = 8;
const OCTAVES: u32 = 10;

/// One flight, or the search for the smallest ramp.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RampFlight {
    /// An alarm stood before the ramp began; of a search also, if one comes without a ramp.
    early: bool,
    /// The fault's value when the alarm came, or the last one of the smallest ramp that is detected; in its unit.
    value: Option<f64>,
    steps: u64,
}

impl Ramp {
    /// What grows, each by itself: from nothing at the beginning of the ramp to its last value at the end.
    fn faults(&self) -> Vec<Fault> {
        let of_figure_1 = |culprit: &Culprit| culprit.fault(culprit.figure_1_amplitude(), FaultProfile::Step, 0.0, 1.0);
        let faults = match &self.scenario {
            Some(scenario) => scenario.faults.clone(),
            None => Culprit::ALL.iter().map(of_figure_1).collect(),
        };
        let [start_s, end_s] = self.interval_s();
        let grown = |fault: Fault| {
            let amplitude = self.size * fault.amplitude;
            Fault { amplitude, profile: FaultProfile::Ramp, start_s, end_s, ..fault }
        };
        faults.into_iter().map(grown).collect()
    }

    /// Beginning and end of the ramp, s.
    fn interval_s(&self) -> [f64; 2] {
        let start_s = self.motor_for(0.0).learn.end_s + AFTER_LEARNING_S + self.known_s;
        [start_s, start_s + self.ramp_s]
    }

    fn motor(&self) -> Scenario {
        let [_, end_s] = self.interval_s();
        self.motor_for(end_s)
    }

    fn motor_for(&self, duration_s: f64) -> Scenario {
        let own = self.scenario.clone().unwrap_or_else(Scenario::figure_1);
        steady(&own, duration_s)
    }

    /// What comes before the ramp of a fault.
    fn healthy(&self, limits: &Limits, fault: &Fault, seed: u64) -> Result<Healthy, StudyError> {
        let motor = self.motor();
        Scenario { faults: vec![fault.clone()], ..motor.clone() }.validate()?;
        let mut watch = self.mode.watch(&Known::of(&motor), limits)?;
        let mut episode = Episode::new(Name::of(fault.point), fault.start_s, fault.end_s, motor.rate_hz());
        let mut plant = Plant::exponential(&motor, seed);
        let before = (fault.start_s * motor.rate_hz()) as usize;
        let flown = fly(plant.by_ref().take(before), watch.as_mut(), |index, _, said| episode.push(index, said));
        Ok(Healthy { plant, seed, watch, episode, flown })
    }

    fn flight_seed(&self, unit: u64) -> u64 {
        seed_of(self.seed, purpose::FLIGHT, unit % self.seeds)
    }
}

/// A flight up to the ramp: what follows differs by the fault alone.
struct Healthy {
    plant: Plant,
    seed: u64,
    watch: Box<dyn Watch>,
    episode: Episode,
    flown: u64,
}

impl Healthy {
    /// Goes on with a fault.
    fn with(&self, fault: &Fault) -> RampFlight {
        let flight = self.go_on(std::slice::from_ref(fault));
        RampFlight { value: flight.value.map(|t_s| fault.value(fault.start_s + t_s)), ..flight }
    }

    /// Goes on to the end; the value is the time until the alarm, s.
    fn go_on(&self, faults: &[Fault]) -> RampFlight {
        let (mut watch, mut episode) = (self.watch.copy(), self.episode.clone());
        let plant = self.plant.clone().with_faults(self.seed, faults);
        let steps = fly(plant, watch.as_mut(), |index, _, said| episode.push(self.flown + index, said));
        let outcome = episode.outcome();
        RampFlight { early: outcome.early, value: outcome.detected_s, steps }
    }
}

/// By halves, all in the same noise: of two ramps the larger one is the easier to find.
fn least_ramp(healthy: &Healthy, fault: &Fault) -> RampFlight {
    let amplitude = |n: u32| fault.amplitude * (-f64::from(n) / f64::from(PER_OCTAVE)).exp2();
    let without = healthy.go_on(&[]);
    let mut steps = without.steps;
    if without.early || without.value.is_some() {
        return RampFlight { early: true, value: None, steps };
    }
    let mut is_found = |n| {
        let flight = healthy.with(&Fault { amplitude: amplitude(n), ..fault.clone() });
        steps += flight.steps;
        flight.value.is_some()
    };
    let (mut found, mut missed) = (None, PER_OCTAVE * OCTAVES);
    let mut next = 0;
    while found != Some(next) {
        if is_found(next) {
            found = Some(next);
        } else if found.is_none() {
            break;
        } else {
            missed = next;
        }
        next = found.unwrap_or_default().midpoint(missed);
    }
    RampFlight { early: false, value: found.map(amplitude), steps }
}

impl Study for Ramp {
    type Shared = Limits;
    type Unit = RampFlight;
    const NAME: &'static str = "ramp";

    fn units(&self) -> u64 {
        let faults = self.scenario.as_ref().map_or(Culprit::ALL.len(), |scenario| scenario.faults.len());
        faults as u64 * self.seeds
    }

    fn prepare(&self) -> Result<Limits, StudyError> {
        limits_of(self.mode, &self.asked, &self.motor(), self.seed)
    }

    fn unit(&self, limits: &Limits, unit: u64) -> Result<RampFlight, StudyError> {
        let fault = self.faults().swap_remove((unit / self.seeds) as usize);
        let healthy = self.healthy(limits, &fault, self.flight_seed(unit))?;
        let flight = if self.smallest { least_ramp(&healthy, &fault) } else { healthy.with(&fault) };
        Ok(RampFlight { steps: flight.steps + healthy.flown, ..flight })
    }

    fn findings(&self, limits: &Limits, units: &[RampFlight]) -> Findings {
        let header = [
            "fault",
            "unit",
            "flights",
            "detected",
            "least",
            "quartile",
            "median",
            "quartile",
            "greatest",
            "at the end",
        ];
        let motor = self.scenario.as_ref().map_or("figure 1", |scenario| &scenario.name);
        let (what, name, of_what) = if self.smallest {
            let what = format!("Last value of the smallest ramp over {} s that is detected", self.ramp_s);
            (what, "last value of the smallest ramp, % of the largest", "smallest_ramp")
        } else {
            let what = "Value of a growing fault when it is detected".to_owned();
            (what, "value when detected, % of the value at the end", "value_at_detection")
        };
        let axis = Axis { name, log: true };
        let title = format!("{what}, motor of {motor}");
        let mut table = TextTable::new(&title, header);
        let mut rows = Vec::new();
        let mut ranges = Vec::new();
        for (fault, flights) in self.faults().iter().zip(units.chunks(self.seeds as usize)) {
            let Fault { id, point, kind, amplitude, .. } = fault;
            let unit = fault.unit();
            // A gain or offset below 0 grows downwards: its magnitude is what was reached.
            let values: Vec<f64> = flights.iter().filter_map(|f| f.value).map(f64::abs).collect();
            let spread = Spread::of(values.iter().copied());
            let name = format!("{id} {}", Name::of(*point).words());
            ranges.extend(spread.map(|spread| in_percent(&name, &spread, amplitude.abs())));
            let of = |pick: fn(&Spread) -> f64| shown(spread.as_ref().map(pick));
            table.rows.push(vec![
                name,
                unit.to_owned(),
                flights.len().to_string(),
                values.len().to_string(),
                of(|s| s.min),
                of(|s| s.lower_quartile),
                of(|s| s.median),
                of(|s| s.upper_quartile),
                of(|s| s.max),
                significant(amplitude.abs()),
            ]);
            rows.push(json!({
                "fault": id, "point": point, "kind": kind, "unit": unit,
                "amplitude": amplitude, "ramp_s": self.ramp_s, "known_s": self.known_s, "flights": flights.len(),
                "first_seed": self.flight_seed(0), "early_alarms": flights.iter().filter(|f| f.early).count(),
                "detected": values.len(), of_what: spread, "values": values,
                "thresholds": limits.thresholds,
            }));
        }
        let calibrated = calibration_steps(limits, &self.asked, &self.motor());
        let steps = units.iter().map(|unit| unit.steps).sum::<u64>() + calibrated;
        let detected = units.iter().filter(|unit| unit.value.is_some()).count();
        let summary = format!(
            "{detected} of {} faults detected while they grew to {} times those of {motor}.",
            units.len(),
            self.size
        );
        let caption = format!("{what}: from the least to the greatest, half of the flights, and the median.");
        let figures = vec![Block::Figure { caption, pictures: vec![range_chart(&ranges, axis, None)] }];
        Findings { summary, figures, rows, tables: vec![table], steps }
    }
}

fn in_percent(name: &str, spread: &Spread, full: f64) -> Range {
    let percent = |value: f64| 100.0 * value / full;
    Range {
        name: name.to_owned(),
        ends: (percent(spread.min), percent(spread.max)),
        half: Some((percent(spread.lower_quartile), percent(spread.upper_quartile))),
        middle: percent(spread.median),
    }
}
