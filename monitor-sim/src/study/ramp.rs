//! `study ramp`: the value that a growing fault has reached when it is detected, over seeds, in the motor of figure 1.

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::calibrate::Asked;
use super::false_alarms::{calibration_steps, limits_of};
use super::faults::{Culprit, figure_1_motor};
use super::flight::{Episode, fly};
use super::summary::{Spread, shown};
use super::watch::{Known, Limits, Mode, Name};
use super::{Findings, Study, StudyError, purpose, seed_of};
use crate::chart::{Axis, Range, range_chart};
use crate::fault::FaultProfile;
use crate::page::Block;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::tables::{TextTable, significant};

/// When the first ramp may begin, s: learning ends at 15.5 s.
const BEGIN_S: f64 = 20.0;

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
    /// Last value of each ramp, as a share of [`Culprit::figure_1_amplitude`].
    pub size: f64,
    /// How long a ramp takes to its last value, s.
    pub ramp_s: f64,
    /// How long the monitor has watched the healthy motor before, s.
    pub known_s: f64,
}

/// One flight.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RampFlight {
    early: bool,
    /// The fault's value when the alarm came, in its unit.
    value: Option<f64>,
    steps: u64,
}

impl Ramp {
    fn culprit(&self, unit: u64) -> &'static Culprit {
        &Culprit::ALL[(unit / self.seeds) as usize]
    }

    /// Beginning and end of the ramp, s.
    fn interval_s(&self) -> [f64; 2] {
        let start_s = BEGIN_S + self.known_s;
        [start_s, start_s + self.ramp_s]
    }

    fn motor(&self) -> Scenario {
        let [_, end_s] = self.interval_s();
        figure_1_motor(end_s)
    }

    fn flight_seed(&self, unit: u64) -> u64 {
        seed_of(self.seed, purpose::FLIGHT, unit % self.seeds)
    }
}

impl Study for Ramp {
    type Shared = Limits;
    type Unit = RampFlight;
    const NAME: &'static str = "ramp";

    fn units(&self) -> u64 {
        Culprit::ALL.len() as u64 * self.seeds
    }

    fn prepare(&self) -> Result<Limits, StudyError> {
        limits_of(self.mode, &self.asked, &self.motor(), self.seed)
    }

    fn unit(&self, limits: &Limits, unit: u64) -> Result<RampFlight, StudyError> {
        let culprit = self.culprit(unit);
        let [start_s, end_s] = self.interval_s();
        let fault = culprit.fault(self.size * culprit.figure_1_amplitude(), FaultProfile::Ramp, start_s, end_s);
        let scenario = Scenario { faults: vec![fault.clone()], ..self.motor() };
        scenario.validate()?;
        let mut watch = self.mode.watch(&Known::of(&scenario), limits)?;
        let mut episode = Episode::new(Name::of(culprit.point), start_s, end_s, scenario.rate_hz());
        let plant = Plant::exponential(&scenario, self.flight_seed(unit));
        let steps = fly(plant, watch.as_mut(), |index, _, said| episode.push(index, said));
        let outcome = episode.outcome();
        Ok(RampFlight { early: outcome.early, value: outcome.detected_s.map(|t_s| fault.value(start_s + t_s)), steps })
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
        let mut table = TextTable::new("Value of a growing fault when it is detected, motor of figure 1", header);
        let mut rows = Vec::new();
        let mut ranges = Vec::new();
        for (n, flights) in units.chunks(self.seeds as usize).enumerate() {
            let culprit = &Culprit::ALL[n];
            let amplitude = self.size * culprit.figure_1_amplitude();
            let unit = culprit.fault(amplitude, FaultProfile::Ramp, 0.0, 1.0).unit();
            // A gain or offset below 0 grows downwards: its magnitude is what was reached.
            let values: Vec<f64> = flights.iter().filter_map(|f| f.value).map(f64::abs).collect();
            let spread = Spread::of(values.iter().copied());
            let name = format!("{} {}", culprit.id, Name::of(culprit.point).words());
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
                "fault": culprit.id, "point": culprit.point, "kind": culprit.kind, "unit": unit,
                "amplitude": amplitude, "ramp_s": self.ramp_s, "known_s": self.known_s, "flights": flights.len(),
                "first_seed": self.flight_seed(0), "early_alarms": flights.iter().filter(|f| f.early).count(),
                "detected": values.len(), "value_at_detection": spread, "values": values,
                "thresholds": limits.thresholds,
            }));
        }
        let calibrated = calibration_steps(limits, &self.asked, &self.motor());
        let steps = units.iter().map(|unit| unit.steps).sum::<u64>() + calibrated;
        let detected = units.iter().filter(|unit| unit.value.is_some()).count();
        let summary = format!(
            "{detected} of {} faults detected while they grew to {} times those of figure 1.",
            units.len(),
            self.size
        );
        let axis = Axis { name: "value when detected, % of the value at the end", log: true };
        let caption = "Value of a growing fault when it is detected: from the least to the greatest, half of the flights, and \
                       the median.";
        let figures =
            vec![Block::Figure { caption: caption.to_owned(), pictures: vec![range_chart(&ranges, axis, None)] }];
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
