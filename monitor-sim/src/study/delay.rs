//! `study delay`: how long detecting and clearing take, against the size of each fault.
//!
//! In the motor of figure 1, and in white noise beside Lorden's bound. A loop needs time to recover from a fault by
//! itself: `recovered_s` is the last sample beyond the one-sample limit of the learned baseline
//! ([`RawBaseline`](super::raw::RawBaseline)), and a monitor is charged with what comes after it.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::calibrate::Asked;
use super::false_alarms::{calibration_steps, limits_of};
use super::faults::{Culprit, figure_1_motor};
use super::flight::{Episode, Outcome, fly};
use super::raw::Moments;
use super::summary::{Spread, percent};
use super::watch::{Known, Limits, Mode, Name};
use super::white::{self, WhiteNoise, lorden_samples};
use super::{Findings, Study, StudyError, purpose, seed_of};
use crate::chart::{Axis, Line, line_chart};
use crate::fault::FaultProfile;
use crate::page::Block;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::tables::{TextTable, shown, significant};

/// When the fault stands, and the flight's length, s. Ten seconds are two settling times of the loop's integral.
const FAULT_S: [f64; 2] = [20.0, 30.0];
const FLIGHT_S: f64 = 45.0;

/// The same in white noise, which is about what can be seen at all: the monitor has watched it for half an hour.
const WHITE_FAULT_S: [f64; 2] = [1800.0, 1820.0];

/// The last seconds of the fault, over which its settled effect is measured, s.
const SETTLED_S: f64 = 2.0;

/// Shifts in white noise, sigmas of one channel.
const SHIFTS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// Longest stretch behind the fault in which the loop may still be recovering, s: a stray sample beyond a limit of one
/// in a million much later is no sign of it.
const RECOVERY_S: f64 = 5.0;

/// The study's settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Delay {
    /// Which monitor.
    pub mode: Mode,
    /// Seed of everything.
    pub seed: u64,
    /// What the limits are for.
    pub asked: Asked,
    /// Flights of each fault and size.
    pub seeds: u64,
    /// Sizes, as shares of the amplitudes of [`Culprit::figure_1_amplitude`].
    pub sizes: Vec<f64>,
}

/// Limits for both kinds of flight.
#[derive(Debug)]
pub struct DelayLimits {
    motor: Limits,
    white: Limits,
}

/// One flight.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DelayFlight {
    outcome: Outcome,
    /// After the fault's end, s; 0 if no sample was beyond the limit.
    recovered_s: f64,
    /// The settled shift, in sigmas of one sample.
    length: f64,
    steps: u64,
}

enum Unit {
    Loop(Culprit, f64),
    White(f64),
}

impl Delay {
    /// What a unit flies.
    fn case(&self, unit: u64) -> Unit {
        let case = (unit / self.seeds) as usize;
        match Culprit::ALL.get(case / self.sizes.len()) {
            Some(culprit) => Unit::Loop(*culprit, self.sizes[case % self.sizes.len()]),
            None => Unit::White(SHIFTS[case - Culprit::ALL.len() * self.sizes.len()]),
        }
    }

    /// Flight `n` of every case has the same noise, so that sizes are compared on equal terms.
    fn flight_seed(&self, unit: u64) -> u64 {
        seed_of(self.seed, purpose::FLIGHT, unit % self.seeds)
    }

    fn in_loop(&self, culprit: &Culprit, size: f64, limits: &Limits, seed: u64) -> Result<DelayFlight, StudyError> {
        let amplitude = size * culprit.figure_1_amplitude();
        let [start_s, end_s] = FAULT_S;
        let faults = vec![culprit.fault(amplitude, FaultProfile::Step, start_s, end_s)];
        let scenario = Scenario { faults, ..figure_1_motor(FLIGHT_S) };
        scenario.validate()?;
        let known = Known::of(&scenario);
        self.flight(&known, limits, Name::of(culprit.point), FAULT_S, Plant::exponential(&scenario, seed))
    }

    fn flight(
        &self,
        known: &Known,
        limits: &Limits,
        right: Name,
        [start_s, end_s]: [f64; 2],
        samples: impl Iterator<Item = crate::plant::PlantSample>,
    ) -> Result<DelayFlight, StudyError> {
        let mut watch = self.mode.watch(known, limits)?;
        let mut episode = Episode::new(right, start_s, end_s, known.rate_hz);
        let (mut learning, mut settled) = (Moments::default(), Moments::default());
        let mut behind = Vec::new();
        let learn_s = known.settle_s..known.settle_s + known.learn_s;
        let steps = fly(samples, watch.as_mut(), |index, measured, said| {
            episode.push(index, said);
            let t_s = measured.t_s;
            if learn_s.contains(&t_s) {
                learning.push(measured.channels());
            } else if (end_s - SETTLED_S..end_s).contains(&t_s) {
                settled.push(measured.channels());
            } else if (end_s..end_s + RECOVERY_S).contains(&t_s) {
                behind.push(measured.channels());
            }
        });
        let baseline = learning.baseline().ok_or(StudyError::NothingLearned(watch.refused()))?;
        let last_beyond = behind.iter().rposition(|x| baseline.is_beyond(*x));
        let shifted = settled.mean();
        let healthy = baseline.mean();
        Ok(DelayFlight {
            outcome: episode.outcome(),
            recovered_s: last_beyond.map_or(0.0, |index| (index + 1) as f64 / known.rate_hz),
            length: baseline.length(std::array::from_fn(|n| shifted[n] - healthy[n])),
            steps,
        })
    }
}

impl Study for Delay {
    type Shared = DelayLimits;
    type Unit = DelayFlight;
    const NAME: &'static str = "delay";

    fn units(&self) -> u64 {
        (Culprit::ALL.len() * self.sizes.len() + SHIFTS.len()) as u64 * self.seeds
    }

    fn prepare(&self) -> Result<DelayLimits, StudyError> {
        let motor = figure_1_motor(FLIGHT_S);
        let Known { settle_s, learn_s, .. } = Known::of(&motor);
        let known = white::known(settle_s, learn_s);
        let seed = |run| seed_of(self.seed, purpose::CALIBRATION, run);
        let duration_s = self.asked.run_s(&known);
        Ok(DelayLimits {
            motor: limits_of(self.mode, &self.asked, &motor, self.seed)?,
            white: self
                .mode
                .limits(&known, &self.asked, |run| WhiteNoise::new(seed(run), duration_s, 0.0, [0.0; 2]))?,
        })
    }

    fn unit(&self, limits: &DelayLimits, unit: u64) -> Result<DelayFlight, StudyError> {
        let seed = self.flight_seed(unit);
        match self.case(unit) {
            Unit::Loop(culprit, size) => self.in_loop(&culprit, size, &limits.motor, seed),
            Unit::White(shift) => {
                let Known { settle_s, learn_s, .. } = Known::of(&figure_1_motor(FLIGHT_S));
                let [_, end_s] = WHITE_FAULT_S;
                let noise = WhiteNoise::new(seed, end_s + SETTLED_S, shift, WHITE_FAULT_S);
                self.flight(&white::known(settle_s, learn_s), &limits.white, Name::SpeedSensor, WHITE_FAULT_S, noise)
            }
        }
    }

    fn findings(&self, limits: &DelayLimits, units: &[DelayFlight]) -> Findings {
        let mut in_loop = TextTable::new(
            "Motor of figure 1: medians over seeds, s. Clearing counts from the end of the fault, and behind the loop's recovery",
            [
                "fault",
                "size",
                "sigmas",
                "detected, %",
                "delay",
                "longest",
                "loop recovered",
                "cleared",
                "behind it",
                "named right, %",
                "of the time, %",
            ],
        );
        let mut white = TextTable::new(
            format!(
                "White noise, first channel shifted: mean delay against Lorden's bound for a false alarm in {:.3e} samples",
                self.arl0()
            ),
            ["shift, sigmas", "detected, %", "delay, samples", "bound, samples", "ratio"],
        );
        let mut rows = Vec::new();
        let mut delays: Vec<Line> = Culprit::ALL.iter().map(|c| line(Name::of(c.point).shown())).collect();
        let (mut seen, mut bound) =
            (line("mean over seeds".to_owned()), Line { bound: true, ..line("Lorden's bound".to_owned()) });
        for (case, flights) in units.chunks(self.seeds as usize).enumerate() {
            match self.case(case as u64 * self.seeds) {
                Unit::Loop(culprit, size) => {
                    let row = LoopRow::of(&culprit, flights);
                    let delay = row.delay_s.filter(|_| row.detected == row.flights);
                    delays[case / self.sizes.len()].points.extend(delay.map(|delay| (size, delay.median)));
                    rows.push(row.json(&culprit, size, self));
                    in_loop.rows.push(row.cells(&culprit, size));
                }
                Unit::White(shift) => {
                    let (row, cells) = self.white_row(shift, flights);
                    bound.points.push((shift, lorden_samples(self.arl0(), shift)));
                    let every = row["detected"] == row["flights"];
                    seen.points.extend(row["mean_delay_samples"].as_f64().filter(|_| every).map(|mean| (shift, mean)));
                    rows.push(row);
                    white.rows.push(cells);
                }
            }
        }
        let calibrated = calibration_steps(&limits.motor, &self.asked, &figure_1_motor(FLIGHT_S));
        let steps = units.iter().map(|unit| unit.steps).sum::<u64>() + 2 * calibrated;
        Findings {
            summary: self.summary(&seen),
            figures: self.figures(delays, vec![seen, bound]),
            rows,
            tables: vec![in_loop, white],
            steps,
        }
    }
}

impl Delay {
    /// Samples between false alarms that are asked for.
    fn arl0(&self) -> f64 {
        white::RATE_HZ * 3600.0 / self.asked.false_alarms_per_hour
    }

    fn summary(&self, seen: &Line) -> String {
        let sigma = seen.points.iter().find(|(shift, _)| *shift == 1.0);
        let ratio = |(shift, mean): &(f64, f64)| mean / lorden_samples(self.arl0(), *shift);
        sigma.map_or_else(String::new, |point| {
            format!(
                "A shift of one sigma of white noise is detected after {} samples in the mean: {} times Lorden's bound for a \
                 false alarm in {:.2e} samples.",
                significant(point.1),
                significant(ratio(point)),
                self.arl0()
            )
        })
    }

    /// Delay against size in the loop, the paper's faults and the others, and in white noise beside the bound.
    fn figures(&self, mut delays: Vec<Line>, white: Vec<Line>) -> Vec<Block> {
        let others = delays.split_off(Culprit::papers().len());
        let size = Axis { name: "size, share of the fault of figure 1", log: true };
        let (median, mean) =
            (Axis { name: "median delay, s", log: true }, Axis { name: "mean delay, samples", log: true });
        let figure = |caption: &str, lines: &[Line], x, y| Block::Figure {
            caption: format!(
                "{caption} Points at the lower edge are of the fault's first sample; sizes at which a flight missed it have none."
            ),
            pictures: vec![line_chart(lines, x, y)],
        };
        let shift = Axis { name: "shift, sigmas", log: true };
        vec![
            figure("White noise: delay against the shift of one channel, beside Lorden's bound.", &white, shift, mean),
            figure("Motor of figure 1: delay against the size of the paper's faults.", &delays, size, median),
            figure("Motor of figure 1: delay against the size of other faults.", &others, size, median),
        ]
    }

    fn white_row(&self, shift: f64, flights: &[DelayFlight]) -> (Value, Vec<String>) {
        let samples: Vec<f64> =
            flights.iter().filter_map(|f| f.outcome.detected_s).map(|delay_s| delay_s * white::RATE_HZ + 1.0).collect();
        let mean = (!samples.is_empty()).then(|| samples.iter().sum::<f64>() / samples.len() as f64);
        let bound = lorden_samples(self.arl0(), shift);
        let ratio = mean.filter(|_| samples.len() == flights.len()).map(|mean| mean / bound);
        let row = json!({
            "row": "white", "shift_sigmas": shift, "flights": flights.len(), "first_seed": self.flight_seed(0),
            "detected": samples.len(), "mean_delay_samples": mean, "lorden_samples": bound, "lorden_ratio": ratio,
            "arl0_samples": self.arl0(),
        });
        let detected = percent(samples.len(), flights.len());
        (row, vec![significant(shift), detected, shown(mean), significant(bound), shown(ratio)])
    }
}

fn line(name: String) -> Line {
    Line { name, points: Vec::new(), bound: false, ringed: None }
}

/// One fault at one size.
struct LoopRow {
    flights: usize,
    early: usize,
    detected: usize,
    right: usize,
    right_share: Option<f64>,
    delay_s: Option<Spread>,
    recovered_s: Option<Spread>,
    cleared_s: Option<Spread>,
    cleared_behind_s: Option<Spread>,
    never_cleared: usize,
    sigmas: Option<Spread>,
}

impl LoopRow {
    fn of(culprit: &Culprit, flights: &[DelayFlight]) -> Self {
        let found = || flights.iter().filter(|f| f.outcome.detected_s.is_some());
        let shares: Vec<f64> = found().filter_map(|f| f.outcome.right_share).collect();
        let behind = |f: &DelayFlight| f.outcome.cleared_s.map(|cleared| (cleared - f.recovered_s).max(0.0));
        Self {
            flights: flights.len(),
            early: flights.iter().filter(|f| f.outcome.early).count(),
            detected: found().count(),
            right: found().filter(|f| f.outcome.named == Some(Name::of(culprit.point))).count(),
            right_share: (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64),
            delay_s: Spread::of(found().filter_map(|f| f.outcome.detected_s)),
            recovered_s: Spread::of(found().map(|f| f.recovered_s)),
            cleared_s: Spread::of(found().filter_map(|f| f.outcome.cleared_s)),
            cleared_behind_s: Spread::of(found().filter_map(behind)),
            never_cleared: found().filter(|f| f.outcome.cleared_s.is_none()).count(),
            sigmas: Spread::of(flights.iter().map(|f| f.length)),
        }
    }

    fn json(&self, culprit: &Culprit, size: f64, study: &Delay) -> Value {
        let amplitude = size * culprit.figure_1_amplitude();
        json!({
            "row": "loop", "fault": culprit.id, "point": culprit.point, "kind": culprit.kind, "size": size,
            "amplitude": amplitude, "unit": culprit.fault(amplitude, FaultProfile::Step, 0.0, 1.0).unit(),
            "flights": self.flights, "first_seed": study.flight_seed(0), "early_alarms": self.early,
            "detected": self.detected, "delay_s": self.delay_s, "recovered_s": self.recovered_s,
            "cleared_s": self.cleared_s, "cleared_behind_recovery_s": self.cleared_behind_s,
            "never_cleared": self.never_cleared, "named_right": self.right, "right_share": self.right_share,
            "settled_shift_sigmas": self.sigmas,
        })
    }

    fn cells(&self, culprit: &Culprit, size: f64) -> Vec<String> {
        let median = |spread: Option<Spread>| shown(spread.map(|s| s.median));
        vec![
            culprit.id.to_owned(),
            significant(size),
            median(self.sigmas),
            percent(self.detected, self.flights),
            median(self.delay_s),
            shown(self.delay_s.map(|s| s.max)),
            median(self.recovered_s),
            if self.never_cleared > 0 { format!("{} never", self.never_cleared) } else { median(self.cleared_s) },
            median(self.cleared_behind_s),
            percent(self.right, self.detected),
            self.right_share.map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share)),
        ]
    }
}
