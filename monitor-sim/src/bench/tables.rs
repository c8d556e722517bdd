//! Results of benchmarks as tables of text, for the terminal and for the page alike.

use super::BenchReport;
use super::drifts::{DriftCase, DriftReport, JudgedRun, LearnedRun};
use super::labelled::{LabelledReport, RunReport, Score};
use super::nab::Nab;
use super::protocol::Published;
use crate::study::watch::Mode;
use crate::tables::{TextTable, shown};

/// The name of a monitor in a table.
const fn ours(mode: Mode) -> &'static str {
    match mode {
        Mode::Guard => "this monitor, guard mode",
        Mode::Paper => "this monitor, paper mode",
    }
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

/// F1, FAR, MAR and the three NAB scores of a detector.
fn score_cells(name: &str, [f1, far, mar]: [Option<f64>; 3], nab: Option<[f64; 3]>) -> [String; 7] {
    let [standard, low_fp, low_fn] = [0, 1, 2].map(|k| number(nab.map(|nab| nab[k]), 2));
    [name.to_owned(), number(f1, 3), number(far, 2), number(mar, 2), standard, low_fp, low_fn]
}

fn score_row(name: &str, score: &Score) -> [String; 7] {
    let nab = score.nab.map(|Nab { standard, low_fp, low_fn, .. }| [standard, low_fp, low_fn]);
    score_cells(name, [score.f1, score.far, score.mar], nab)
}

fn published_row(published: &Published) -> [String; 7] {
    let Published { name, f1, far, mar, nab } = published;
    let mut cells = score_cells(&format!("published: {name}"), [*f1, *far, *mar], *nab);
    // As printed: two digits.
    cells[1] = number(*f1, 2);
    cells
}

/// The tables of a labelled set: scores, then change points, then runs.
pub(super) fn of_labelled(report: &LabelledReport) -> Vec<TextTable> {
    let mode = report.about.settings.mode;
    let header = ["", "F1", "FAR, %", "MAR, %", "NAB standard", "NAB low FP", "NAB low FN"];
    let baselines = report.baselines.iter().map(|baseline| score_row(baseline.name, &baseline.score));
    let rows = std::iter::once(score_row(ours(mode), &report.score)).chain(baselines);
    let caption = format!("Score over {} runs", report.about.runs);
    let scores = TextTable::new(caption, header).with_rows(rows.chain(report.published.iter().map(published_row)));
    let runs = TextTable::new(
        "Runs",
        ["", "rows scored", "anomalous", "FAR, %", "MAR, %", "change points missed", "detections in no window"],
    );
    vec![scores, runs.with_rows(report.per_run.iter().map(run_row))]
}

fn run_row(run: &RunReport) -> [String; 7] {
    let counts = &run.score.counts;
    let of =
        |count: fn(&Nab) -> u64| run.score.nab.as_ref().map_or_else(|| "-".to_owned(), |nab| count(nab).to_string());
    let points = run.score.nab.map_or_else(String::new, |nab| format!(" of {}", nab.change_points));
    [
        if run.refused.is_some() { format!("{} (refused)", run.run) } else { run.run.clone() },
        run.scored_rows.to_string(),
        (counts.true_alarms + counts.missed).to_string(),
        number(run.score.far, 2),
        number(run.score.mar, 2),
        format!("{}{points}", of(|nab| nab.missed)),
        of(|nab| nab.false_positives),
    ]
}

pub(super) fn summary_of_labelled(report: &LabelledReport) -> String {
    let always = report.baselines.first().and_then(|baseline| baseline.score.f1);
    format!(
        "F1 {}, false alarms over {} % of the normal rows, {} % of the anomalous rows missed ({}). Whoever always alarms has \
         F1 {}.",
        number(report.score.f1, 3),
        number(report.score.far, 2),
        number(report.score.mar, 2),
        ours(report.about.settings.mode),
        number(always, 3),
    )
}

/// The tables of a set with drifts: totals, drifts, healthy runs, the others, what was learned.
pub(super) fn of_drifts(report: &DriftReport) -> Vec<TextTable> {
    let [a, b, c] = report.about.settings.names().each_ref().map(|name| format!("sigma of {name}"));
    let header = ["", "from row", "rows", &a, &b, &c];
    let learned = TextTable::new("Learned", header).with_rows(report.learned.iter().map(learned_row));
    let judged = |caption: &str, healthy: bool| {
        let runs = report.judged.iter().filter(|judged| judged.healthy == healthy);
        let header = ["", "rows", "count", "judged, %", "alarms", "rows under alarm", "of those that count, %"];
        TextTable::new(caption, header).with_rows(runs.map(judged_row))
    };
    let drifts = TextTable::new(
        "Drifts from the middle of a healthy run on",
        ["", "channel", "sigmas", "amount", "found", "after, s", "named", "share, %"],
    );
    let tables = [
        totals(report),
        drifts.with_rows(report.drifts.iter().map(drift_row)),
        judged("Healthy runs as they are: each alarm is a false one", true),
        judged("The other runs as they are: what alarms is counted, and neither right nor wrong", false),
        learned,
    ];
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn totals(report: &DriftReport) -> TextTable {
    let totals = &report.totals;
    let row = [
        ours(report.about.settings.mode).to_owned(),
        totals.healthy_pairs.to_string(),
        totals.refused_pairs.to_string(),
        totals.false_alarms.to_string(),
        format!("{:.3}", totals.healthy_hours),
        format!("{} of {}", totals.found, totals.injected),
        format!("{} of {}", totals.named_right, totals.found),
        number(totals.median_delay_s, 1),
    ];
    let header = [
        "",
        "healthy pairs",
        "refused",
        "false alarms",
        "healthy hours",
        "drifts found",
        "channel named right",
        "median delay, s",
    ];
    TextTable::new("Totals", header).with_rows([row])
}

fn pair(learned: &str, judged: &str) -> String {
    format!("{learned} judges {judged}")
}

fn learned_row(run: &LearnedRun) -> [String; 6] {
    let name = if run.refused.is_some() { format!("{} (refused)", run.run) } else { run.run.clone() };
    let [a, b, c] = [0, 1, 2].map(|k| shown(run.sigma.map(|sigma| sigma[k])));
    [name, run.first_row.to_string(), run.rows.to_string(), a, b, c]
}

fn judged_row(run: &JudgedRun) -> [String; 7] {
    let count = |count: Option<usize>| count.map_or_else(|| "refused".to_owned(), |count| count.to_string());
    let share = run.alarm_rows.map(|rows| 100.0 * rows as f64 / run.rows.max(1) as f64);
    [
        pair(&run.learned, &run.judged),
        run.recorded_rows.to_string(),
        run.rows.to_string(),
        number(run.judged_share.map(|share| 100.0 * share), 1),
        count(run.alarms),
        count(run.alarm_rows),
        number(share, 1),
    ]
}

fn drift_row(case: &DriftCase) -> [String; 8] {
    [
        pair(&case.learned, &case.judged),
        case.channel.clone(),
        format!("{:+}", case.sigmas),
        shown(case.amount),
        if case.found { "yes" } else { "no" }.to_owned(),
        number(case.delay_s, 1),
        case.named.clone().unwrap_or_else(|| "-".to_owned()),
        number(case.share.map(|share| 100.0 * share), 0),
    ]
}

pub(super) fn summary_of_drifts(report: &DriftReport) -> String {
    let totals = &report.totals;
    format!(
        "{} false alarms in {} healthy runs judged by another; {} of {} drifts found, the channel right in {} ({}).",
        totals.false_alarms,
        totals.healthy_pairs - totals.refused_pairs,
        totals.found,
        totals.injected,
        totals.named_right,
        ours(report.about.settings.mode),
    )
}

/// What a person must know to read the tables, a sentence each.
pub(super) fn remarks(report: &BenchReport) -> Vec<String> {
    let about = report.about();
    let channels: Vec<String> = about.channels.iter().map(|c| format!("{} ({})", c.name, c.column)).collect();
    let because = about.channels_because.as_ref().map_or_else(String::new, |why| format!(": {why}"));
    let settings = &about.settings;
    let asked = match settings.mode {
        Mode::Guard => format!(
            "Settings: guard mode at {} Hz with {} false alarms an hour asked for, as a replay would choose them; nothing was \
             chosen with labels in view.",
            settings.rate_hz,
            settings.false_alarms_per_hour.unwrap_or_default()
        ),
        Mode::Paper => format!(
            "Settings: paper mode at {} Hz, residuals smoothed at {} Hz, thresholds {} times the largest of the rows learned \
             from; nothing was chosen with labels in view.",
            settings.rate_hz,
            settings.cutoff_hz.unwrap_or_default(),
            settings.margin.unwrap_or_default()
        ),
    };
    let mut remarks = vec![format!("Channels: {}{because}.", channels.join(", ")), asked];
    remarks.extend(counts(report));
    remarks.extend(about.notes.iter().cloned());
    remarks.extend(about.published_because.iter().map(|from| format!("Published: {from}.")));
    remarks.extend(refused(report).into_iter().map(|(run, why)| format!("{run} was refused: {why}.")));
    remarks
}

fn counts(report: &BenchReport) -> Vec<String> {
    let BenchReport::Labelled(report) = report else { return Vec::new() };
    let mut sentences = vec![format!(
        "The first {} rows of each of {} runs are learned from; of the {} behind them, {} are anomalous.",
        report.learn_rows, report.about.runs, report.scored_rows, report.anomalous_rows
    )];
    if let Some(nab) = &report.score.nab {
        sentences.push(format!(
            "NAB: {} of {} change points missed in the {} s behind each, {} detections in no window; 0 is detecting nothing, \
             100 everything at once.",
            nab.missed, nab.change_points, report.window_s, nab.false_positives
        ));
    }
    sentences.push(match report.refused_runs {
        0 => "Every run was learned.".to_owned(),
        n => format!("{n} runs were refused when they were learned; all their rows count as rows without an alarm."),
    });
    sentences
}

fn refused(report: &BenchReport) -> Vec<(&String, &String)> {
    match report {
        BenchReport::Labelled(report) => {
            report.per_run.iter().filter_map(|run| run.refused.as_ref().map(|why| (&run.run, why))).collect()
        }
        BenchReport::Drifts(report) => {
            report.learned.iter().filter_map(|run| run.refused.as_ref().map(|why| (&run.run, why))).collect()
        }
    }
}
