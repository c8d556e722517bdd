//! What the page of the study pictures.

use super::super::faults::Culprit;
use super::super::flight::Outcome;
use super::super::summary::percent;
use super::super::watch::Name;
use super::{Case, Confusion, Localization, MotorCases, given_names, is_of_group};
use crate::chart::{Grid, GridRow, Share, Swatch, bar_grid, shade_grid};
use crate::page::Block;

/// What became of a flight, in the order of the legend.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Right,
    Group,
    Wrong,
    Untold,
    Missed,
    /// Under an alarm before the fault began: it says nothing of the fault.
    Early,
}

const PARTS: [(Swatch, &str); 5] = [
    (Swatch::Series(2), "right name"),
    (Swatch::Series(0), "one of its group"),
    (Swatch::Series(1), "another fault's name"),
    (Swatch::Series(3), "detected, not told which"),
    (Swatch::Band, "missed"),
];

impl Fate {
    const ALL: [Self; PARTS.len()] = [Self::Right, Self::Group, Self::Wrong, Self::Untold, Self::Missed];

    fn of(culprit: &Culprit, outcome: &Outcome) -> Self {
        match (outcome.early, outcome.detected_s, outcome.named) {
            (true, ..) => Self::Early,
            (_, None, _) => Self::Missed,
            (_, _, None) => Self::Untold,
            (_, _, Some(name)) => Self::of_name(culprit, name),
        }
    }

    fn of_name(culprit: &Culprit, name: Name) -> Self {
        match name {
            Name::Ambiguous | Name::Unknown => Self::Untold,
            _ if name == Name::of(culprit.point) => Self::Right,
            _ if is_of_group(culprit, name) => Self::Group,
            _ => Self::Wrong,
        }
    }

    fn share(self, count: usize, of: usize) -> Option<Share> {
        (count > 0).then(|| Share { part: self as usize, percent: 100.0 * count as f64 / of as f64 })
    }
}

/// What came of all flights, in a sentence.
pub(super) fn summary(study: &Localization, units: &[MotorCases]) -> String {
    let sizes = study.sizes.len();
    let fates = |motor: &MotorCases| {
        let cases = motor.cases.iter().enumerate();
        let culprits = study.faults.culprits();
        cases.filter_map(|(n, case)| Some(Fate::of(culprits.get(n / sizes)?, &case.outcome))).collect::<Vec<_>>()
    };
    let fates: Vec<Fate> = units.iter().flat_map(fates).collect();
    let count = |of: &[Fate]| fates.iter().filter(|fate| of.contains(fate)).count();
    let detected = count(&[Fate::Right, Fate::Group, Fate::Wrong, Fate::Untold]);
    let share = |of: &[Fate]| percent(count(of), detected);
    format!(
        "{detected} of {} faults of {} motors detected; of these {} % were given the right name or one of its group, {} % another \
         fault's, and of {} % it was not told which they are.",
        fates.len(),
        units.len(),
        share(&[Fate::Right, Fate::Group]),
        share(&[Fate::Wrong]),
        share(&[Fate::Untold])
    )
}

pub(super) fn figures(study: &Localization, units: &[MotorCases], confusions: &[(&Culprit, Confusion)]) -> Vec<Block> {
    vec![by_size(study, units), by_name(confusions)]
}

fn by_size(study: &Localization, units: &[MotorCases]) -> Block {
    let columns: Vec<String> = study.sizes.iter().map(f64::to_string).collect();
    let cell = |culprit: &Culprit, cases: &[&Case]| {
        let of = |fate: Fate| cases.iter().filter(|case| Fate::of(culprit, &case.outcome) == fate).count();
        Fate::ALL.into_iter().filter_map(|fate| fate.share(of(fate), cases.len())).collect()
    };
    let row = |(n, culprit): (usize, &Culprit)| GridRow {
        name: Name::of(culprit.point).shown(),
        cells: (0..columns.len()).map(|k| cell(culprit, &study.cases(units, n, k))).collect(),
    };
    let rows: Vec<GridRow> = study.faults.culprits().iter().enumerate().map(row).collect();
    let across = "size, sigmas of one sample";
    let grid = Grid { name: "Share of flights, %", columns: &columns, across, parts: &PARTS };
    let caption = "What became of each fault, by its size: share of flights, %. Faults that move the settled readings in one \
                   direction are a group. What is missing from a whole bar had an alarm before the fault.";
    Block::Figure { caption: caption.to_owned(), pictures: vec![bar_grid(grid, &rows)] }
}

fn by_name(confusions: &[(&Culprit, Confusion)]) -> Block {
    let given = given_names(confusions);
    let early = confusions.iter().any(|(_, confusion)| confusion.early > 0);
    let mut columns: Vec<String> = given.iter().map(|name| name.id().to_owned()).collect();
    columns.extend(["no name", "missed"].map(str::to_owned));
    columns.extend(early.then(|| "alarm before".to_owned()));
    let row = |(culprit, confusion): &(&Culprit, Confusion)| {
        let flights = confusion.flights();
        let named =
            given.iter().map(|name| Fate::of_name(culprit, *name).share(confusion.named[*name as usize], flights));
        let rest = [Fate::Untold.share(confusion.nameless, flights), Fate::Missed.share(confusion.missed, flights)];
        // Nothing but the column tells an alarm before the fault from a miss: neither is a word on the fault.
        let before = early.then(|| Fate::Missed.share(confusion.early, flights));
        let cells = named.chain(rest).chain(before).map(|share| share.into_iter().collect());
        GridRow { name: Name::of(culprit.point).shown(), cells: cells.collect() }
    };
    let rows: Vec<GridRow> = confusions.iter().map(row).collect();
    let grid =
        Grid { name: "Share of flights, %", columns: &columns, across: "name that stood longest", parts: &PARTS };
    let caption = "The name that stood longest, over all sizes: share of the flights of each fault, %. Names that nobody gave have \
                   no column.";
    Block::Figure { caption: caption.to_owned(), pictures: vec![shade_grid(grid, &rows)] }
}
