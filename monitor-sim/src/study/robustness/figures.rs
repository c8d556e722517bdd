//! What the page of the study pictures.

use super::super::faults::Culprit;
use super::super::flight::Outcome;
use super::super::watch::Name;
use super::{
    Coarse, DISTURBANCES, Disturbance, Jitter, Missing, Outliers, Robustness, SENSORS, TrialRow, WrongConstants,
};
use crate::chart::{Axis, Grid, GridRow, Range, Share, Swatch, bar_grid, range_chart};
use crate::page::Block;
use crate::tables::significant;

const PARTS: [(Swatch, &str); 3] = [
    (Swatch::Series(2), "detected and named right"),
    (Swatch::Series(1), "detected, named otherwise or not"),
    (Swatch::Band, "missed"),
];

/// What became of some flights with a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) flights: usize,
    pub(super) detected: usize,
    pub(super) right: usize,
    /// Under an alarm before the fault began: it says nothing of the fault.
    pub(super) early: usize,
}

impl Found {
    pub(super) fn of<'a>(outcomes: impl Iterator<Item = &'a Outcome>, right: Name) -> Self {
        outcomes.fold(Self::default(), |all, outcome| {
            let detected = outcome.detected_s.is_some();
            Self {
                flights: all.flights + 1,
                detected: all.detected + usize::from(detected),
                right: all.right + usize::from(detected && outcome.named == Some(right)),
                early: all.early + usize::from(outcome.early),
            }
        })
    }

    fn shares(self) -> Vec<Share> {
        let counts = [self.right, self.detected - self.right, self.flights - self.detected - self.early];
        let share = |(part, count)| Share { part, percent: 100.0 * count as f64 / self.flights as f64 };
        counts.into_iter().enumerate().filter(|(_, count)| *count > 0).map(share).collect()
    }
}

impl Disturbance {
    /// With its level, short enough to stand beside a picture.
    fn label(&self) -> String {
        let percent = |share: f64| format!("{} %", 100.0 * share);
        match *self {
            Self::None => "undisturbed".to_owned(),
            Outliers(share) => format!("outliers {}", percent(share)),
            Missing(share) => format!("missing {}", percent(share)),
            Coarse(sigmas) => format!("ADC step {sigmas} sigma"),
            WrongConstants(share) => format!("constants {} off", percent(share)),
            Jitter(share) => format!("late to {}", percent(share)),
        }
    }
}

/// What came of it all, in a sentence.
pub(super) fn summary(trials: &[TrialRow]) -> String {
    let judged = || DISTURBANCES.iter().zip(trials).filter_map(|(d, row)| Some((d, row, row.rate()?)));
    let undisturbed = judged().next().map(|(_, row, [_, low, high])| {
        format!(
            "{} false alarms in {} undisturbed hours (95 %: {} to {} an hour). ",
            row.alarms,
            significant(row.hours),
            significant(low),
            significant(high)
        )
    });
    let most = judged().max_by(|(.., [a, ..]), (.., [b, ..])| a.total_cmp(b));
    let most = most.filter(|(_, row, _)| row.alarms > 0).map(|(disturbance, _, [rate, ..])| {
        format!(
            "Most come of {}: {} an hour. ",
            disturbance.words().join(", ").trim_end_matches(", "),
            significant(rate)
        )
    });
    let faults = || trials.iter().flat_map(|row| &row.faults);
    let (detected, flights) = (faults().map(|f| f.detected).sum::<usize>(), faults().map(|f| f.flights).sum::<usize>());
    let detected = format!("{detected} of {flights} faults detected, under all disturbances.");
    undisturbed.unwrap_or_default() + &most.unwrap_or_default() + &detected
}

pub(super) fn figures(study: &Robustness, trials: &[TrialRow], stuck: &[Found]) -> Vec<Block> {
    vec![alarms(study, trials), faults(study, trials), sensors(stuck)]
}

fn alarms(study: &Robustness, trials: &[TrialRow]) -> Block {
    let range = |(disturbance, row): (&Disturbance, &TrialRow)| {
        let [rate, low, high] = row.rate()?;
        Some(Range { name: disturbance.label(), ends: (low, high), half: None, middle: rate })
    };
    let ranges: Vec<Range> = DISTURBANCES.iter().zip(trials).filter_map(range).collect();
    let axis = Axis { name: "false alarms an hour", log: true };
    let caption = "False alarms an hour of the motors without a fault, with the exact Poisson interval of 95 %. A ring at the left edge: \
                   there was none, and the line ends where the interval does. Where nothing was judged there is no line. Outliers \
                   are readings off by 20 sigma; late are samples, by up to a share of the period.";
    let asked = Some(("asked for", study.asked.false_alarms_per_hour));
    Block::Figure { caption: caption.to_owned(), pictures: vec![range_chart(&ranges, axis, asked)] }
}

fn faults(study: &Robustness, trials: &[TrialRow]) -> Block {
    let columns: Vec<String> = Culprit::papers().iter().map(|culprit| Name::of(culprit.point).shown()).collect();
    let row = |(disturbance, row): (&Disturbance, &TrialRow)| GridRow {
        name: disturbance.label(),
        cells: row.faults.iter().map(|found| found.shares()).collect(),
    };
    let rows: Vec<GridRow> = DISTURBANCES.iter().zip(trials).map(row).collect();
    let caption = format!(
        "What became of faults of {} sigma under each disturbance: share of flights, %. What is missing from a whole bar had an \
         alarm before the fault.",
        significant(study.size)
    );
    Block::Figure { caption, pictures: vec![bar_grid(grid(&columns, "fault"), &rows)] }
}

fn sensors(stuck: &[Found]) -> Block {
    let row = |(point, found): (&_, &Found)| GridRow {
        name: Name::of(*point).words().to_owned(),
        cells: vec![found.shares()],
    };
    let rows: Vec<GridRow> = SENSORS.iter().zip(stuck).map(row).collect();
    let columns = ["all motors".to_owned()];
    let caption = "What became of a sensor that sticks: share of flights, %. The right name is a loss of the sensor.";
    Block::Figure { caption: caption.to_owned(), pictures: vec![bar_grid(grid(&columns, "sensor that sticks"), &rows)] }
}

fn grid<'a>(columns: &'a [String], across: &'a str) -> Grid<'a> {
    Grid { name: "Share of flights, %", columns, across, parts: &PARTS }
}
