//! Statements on recordings.

use serde_json::Value as Json;

use super::{Claim, Group, Records, claim, no_or};
use crate::figures::passage::Value::{self, About};

pub(super) const GROUPS: &[Group] = &[skab, spindle];

/// F1, false and missed alarms, and the three scores of change points.
fn score(score: &Json) -> Vec<Value> {
    let nab = ["standard", "low_fp", "low_fn"].map(|key| &score["nab"][key]);
    let all = [&score["f1"], &score["far"], &score["mar"]].into_iter().chain(nab);
    all.map(|number| About(number.as_f64())).collect()
}

fn skab(r: &Records) -> Vec<Claim> {
    let [guard, paper] = ["skab-guard", "skab-paper"].map(|name| r.row(name, "benchmark=skab"));
    let of = |key| r.about("skab-guard", "benchmark=skab", key);
    vec![
        claim(
            "`monitor-sim {}` and `monitor-sim {}` score",
            [r.command(&["skab-guard"]), r.command(&["spindle-guard"])],
        ),
        claim(
            "SKAB v0.9, the {} runs of `valve1`: the first {} rows of each are learned from, the {} behind them scored.",
            [of("/runs"), of("/learn_rows"), of("/scored_rows")],
        ),
        claim("| `guard` mode | {} | {} | {} | {}, {}, {} |", score(guard)),
        claim("| `paper` mode | {} | {} | {} | {}, {}, {} |", score(paper)),
        claim("| always alarm | {} | {} | {} | {}, {}, {} |", score(&guard["baselines"][0])),
    ]
}

fn spindle(r: &Records) -> Vec<Claim> {
    let row = |name| r.row(name, "benchmark=cnc-spindle");
    let of = |key| r.about("spindle-guard", "benchmark=cnc-spindle", key);
    let judged = |name, is: fn(&Json) -> bool| {
        let runs = row(name)["judged"].as_array().into_iter().flatten().filter(|run| is(run));
        let mut shares: Vec<f64> = runs.filter_map(|run| Some(100.0 * run["judged_share"].as_f64()?)).collect();
        shares.sort_by(f64::total_cmp);
        [shares.first(), shares.last()].map(|share| About(share.copied()))
    };
    let is_healthy = |run: &Json| run["healthy"] == true;
    vec![
        claim(
            "where a layer is cut: {} of {} drifts of 1.5 sigma found, and the channel named right, after {} s (median), and {} false alarm",
            [
                of("/named_right"),
                About(row("spindle-guard")["drifts"].as_array().map(|cases| cases.len() as f64)),
                of("/median_delay_s"),
                no_or(row("spindle-guard")["false_alarms"].as_u64().unwrap_or(u64::MAX)),
            ],
        ),
        claim(
            "Of the rows in which a layer is cut {} and {} % were judged (with a worn tool {} to {} %; in `paper` mode {} to {} %)",
            [
                judged("spindle-guard", is_healthy),
                judged("spindle-guard", |run| run["healthy"] == false),
                judged("spindle-paper", |_| true),
            ]
            .concat(),
        ),
    ]
}
