//! Statements on missions of figure 1.

use serde_json::Value as Json;

use super::{Claim, Group, Records, Table, claim, no_or};
use crate::figures::passage::Value::{About, AtLeast, AtMost, Words};

pub(super) const TABLES: &[Table] = &[
    Table { begins: "largest fault-free threshold", figure: "tune" },
    Table { begins: "margin false alarms per hour", figure: "tune" },
];

pub(super) const GROUPS: &[Group] = &[seeds, turbulent, turbulent_in_paper_mode];

fn seeds(r: &Records) -> Vec<Claim> {
    let rows = r.rows("missions");
    let seeds = rows.len().to_string();
    let loads = ["faults", "speed_dependent_load"];
    let scores: Vec<&Json> = rows.iter().flat_map(|row| loads.iter().flat_map(|load| of(row, load))).collect();
    let false_alarms: u64 = rows.iter().filter_map(|row| row["false_alarms"].as_u64()).sum();
    vec![claim(
        "- Over {} seeds (`--seed 1` to `{}`, `--json`), with either load: detected after {} s at most, cleared within {} s in \
         all and {} s behind the loop, the right name from {} s at the latest and for {} % of the time at least; {} false alarm",
        [
            Words(seeds.clone()),
            Words(seeds),
            AtMost(latest(&scores, "detected_s", "start_s")),
            AtMost(latest(&scores, "cleared_s", "end_s")),
            AtMost(latest(&scores, "cleared_s", "recovered_s")),
            AtMost(latest(&scores, "located_s", "start_s")),
            AtLeast(100.0 * least_share(&scores)),
            no_or(false_alarms),
        ],
    )]
}

fn turbulent(r: &Records) -> Vec<Claim> {
    let name = "mission-turbulent";
    let scores: Vec<&Json> = r.rows(name).iter().flat_map(|row| of(row, "faults")).collect();
    let right = scores.iter().filter(|score| score["located"] == score["id"]).count();
    let share = least_share(&scores);
    let all = |is: bool, otherwise: String| Words(if is { "all".to_owned() } else { otherwise });
    vec![claim(
        "- In moving water (`{}`) {} three are named right too, F1 after {} s, and for {} of the time.",
        [
            Words(r.command_of(name).trim_end_matches(" --json").to_owned()),
            all(right == 3, format!("{right} of the")),
            About(scores.first().map(|score| number(score, "detected_s") - number(score, "start_s"))),
            all(share == 1.0, format!("{:.1} %", 100.0 * share)),
        ],
    )]
}

fn turbulent_in_paper_mode(r: &Records) -> Vec<Claim> {
    let name = "mission-turbulent-paper";
    let of_mission = |pointer: &str| r.number(name, "seed=1", pointer);
    // How much larger a fault gets before it is seen than without turbulence.
    let worse = |fault: usize| {
        let pointer = format!("/ramp/{fault}/value_at_detection");
        let calm = r.number("mission-paper", "seed=1", &pointer);
        About(of_mission(&pointer).zip(calm).map(|(turbulent, calm)| turbulent / calm))
    };
    let located: Vec<&Json> = r.rows(name).iter().flat_map(|row| of(row, "faults")).collect();
    let right = located.iter().filter(|score| score["located"] == score["id"]).count();
    let in_words = |pointer: &str| {
        let count = of_mission(pointer).map_or(0, |count| count as usize);
        Words(["", "one", "two", "three"].get(count).map_or("", |word| word).to_owned())
    };
    vec![
        claim(
            "the first component explains {} %, {} are kept, and {} is enough for speed and current.",
            [
                About(of_mission("/explained/full/0").map(|share| 100.0 * share)),
                in_words("/retained/full"),
                in_words("/retained/speed_current"),
            ],
        ),
        claim(
            "that mission is located right too ({} of {}, {} false alarm, F1 cleared at {} s), but growing faults must get {} (F2) \
             to {} times (F3) as large before they are seen",
            [
                About(Some(right as f64)),
                About(Some(located.len() as f64)),
                no_or(of_mission("/false_alarms").map_or(u64::MAX, |count| count as u64)),
                About(located.first().and_then(|score| score["cleared_s"].as_f64())),
                worse(1),
                worse(2),
            ],
        ),
    ]
}

fn of<'a>(row: &'a Json, load: &str) -> impl Iterator<Item = &'a Json> {
    row[load].as_array().into_iter().flatten()
}

/// The longest time of all faults. One that is missing is of a fault that was missed.
fn latest(scores: &[&Json], key: &str, since: &str) -> f64 {
    scores.iter().map(|score| number(score, key) - number(score, since)).fold(0.0, f64::max)
}

/// The least share of the time over which the right name stood.
fn least_share(scores: &[&Json]) -> f64 {
    scores.iter().map(|score| score["located_share"].as_f64().unwrap_or(0.0)).fold(1.0, f64::min)
}

fn number(score: &Json, key: &str) -> f64 {
    score[key].as_f64().unwrap_or(f64::INFINITY)
}
