//! Statements on studies.

use serde_json::Value as Json;

use super::{Claim, Group, Records, Table, claim, in_words, one_of};
use crate::figures::passage::Value::{self, About, Words};

pub(super) const TABLES: &[Table] = &[
    Table { begins: "fault unit flights detected", figure: "ramp-paper" },
    Table { begins: "named load torque speed sensor", figure: "localization-all-paper" },
];

/// The faults that the README compares.
const FAULTS: [&str; 3] = ["F1", "F2", "F3"];

pub(super) const GROUPS: &[Group] = &[
    often,
    rarely,
    bullets,
    trouble,
    delays,
    white,
    ramps,
    smallest_ramps,
    names,
    many_names,
    few_alarms,
    fewest_alarms,
    short_windows,
    changing,
    limits,
];

/// The rate of false alarms with the ends of its interval.
const RATE: [&str; 3] = ["/alarms_per_hour", "/alarms_per_hour_low_95", "/alarms_per_hour_high_95"];

fn rate(r: &Records, name: &str) -> Vec<Value> {
    RATE.map(|key| r.about(name, "row=total", key)).to_vec()
}

fn often(r: &Records) -> Vec<Claim> {
    let name = "false-alarms-paper";
    let of = |key| r.about(name, "row=total", key);
    vec![claim(
        "`study {}`: {} alarms in {} hours over random motors, {} an hour (95 %: {} to {}) where {} was asked for;",
        [vec![r.command(&[name]), of("/alarms"), of("/hours")], rate(r, name), vec![of("/asked_per_hour")]].concat(),
    )]
}

fn rarely(r: &Records) -> Vec<Claim> {
    let name = "false-alarms-rare-paper";
    vec![claim(
        "was asked for; with `{}` it is {} ({} to {}): limits",
        [vec![Words(options(r, name))], rate(r, name)].concat(),
    )]
}

fn bullets(r: &Records) -> Vec<Claim> {
    let name = "delay-sizes-paper";
    let ratio = |shift: &str| r.about(name, &format!("shift_sigmas={shift}"), "/lorden_ratio");
    vec![
        claim(
            "- `study {}`: detecting and clearing …; and in white noise {} (at 1 sigma) to {} times (at 4) the delay of",
            [r.command(&[name]), ratio("1.0"), ratio("4.0")],
        ),
        claim("- `study {}`: the name that stood longest", [r.command(&["localization-all-paper"])]),
    ]
}

fn trouble(r: &Records) -> Vec<Claim> {
    let name = "robustness-paper";
    let under = |disturbance| alarms_under(r, name, disturbance);
    let stuck = |key| r.about(name, "row=stuck point=voltage_sensor", key);
    let missing_or_late = [MISSING, "disturbance=late_by_up_to level=100.0_%"].map(under);
    vec![claim(
        "- `study {}`: outliers, … One reading in ten thousand off by 20 sigma makes {} of false alarms an hour; half of the \
         samples missing, or all of them late by up to a period, makes {}; a voltage sensor that sticks is found in {} \
         motors of {}.",
        [
            r.command(&[name]),
            in_words(under(OUTLIERS)),
            in_words(missing_or_late[0] + missing_or_late[1]),
            stuck("/detected"),
            stuck("/flights"),
        ],
    )]
}

/// Disturbances by their rows.
const OUTLIERS: &str = "disturbance=outliers_of_20_sigma level=0.01000_%";
const MISSING: &str = "disturbance=missing_samples level=50.00_%";
const COARSE: &str = "disturbance=ADC_step level=16_sigma";

/// The options of a recorded command but for its mode.
fn options(r: &Records, name: &str) -> String {
    let options = r.command_of(name).split_whitespace().skip_while(|word| !word.starts_with("--"));
    options.collect::<Vec<_>>().join(" ").replace(" --mode paper", "")
}

fn alarms_under(r: &Records, name: &str, disturbance: &str) -> f64 {
    r.number(name, disturbance, "/alarms_per_hour").unwrap_or(f64::NAN)
}

/// Medians of the faults that are compared.
fn medians(r: &Records, name: &str, key: &str) -> Vec<f64> {
    let pointer = format!("/{key}/median");
    FAULTS.iter().map(|fault| r.number(name, &format!("fault={fault}"), &pointer).unwrap_or(f64::NAN)).collect()
}

fn numbers(numbers: impl IntoIterator<Item = f64>) -> Vec<Value> {
    numbers.into_iter().map(|x| About(Some(x))).collect()
}

fn least_and_greatest(numbers: &[f64]) -> [f64; 2] {
    [numbers.iter().copied().fold(f64::INFINITY, f64::min), numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

fn delays(r: &Records) -> Vec<Claim> {
    let modes = ["delay-paper", "delay-guard"];
    let cleared = modes.map(|mode| least_and_greatest(&medians(r, mode, "cleared_s")));
    let behind = modes.map(|mode| least_and_greatest(&medians(r, mode, "cleared_behind_recovery_s"))[1]);
    vec![
        claim(
            "| step faults of the default size (F1, F2, F3): detected after, s | {}, {}, {} | {}, {}, {} | `{}` |",
            [numbers(modes.iter().flat_map(|mode| medians(r, mode, "delay_s"))), vec![r.command(&modes)]].concat(),
        ),
        claim(
            "| cleared after, s, in total; behind the loop's own recovery | {} to {}; about {} | {} to {}; {} | the same |",
            numbers([cleared[0][0], cleared[0][1], behind[0], cleared[1][0], cleared[1][1], behind[1]]),
        ),
    ]
}

fn white(r: &Records) -> Vec<Claim> {
    let modes = ["delay-100-paper", "delay-100-guard"];
    let ratio = |mode, shift| r.about(mode, &format!("shift_sigmas={shift}"), "/lorden_ratio");
    let ratios = modes.map(|mode| ["0.25", "0.5", "1.0", "2.0"].map(|shift| ratio(mode, shift)));
    vec![claim(
        "| delay in white noise over Lorden's bound (0.25, 0.5, 1, 2 sigma) | {}, {}, {}, {} | {}, {}, {}, {} | `{}` |",
        [ratios.concat(), vec![r.command(&modes)]].concat(),
    )]
}

fn ramps(r: &Records) -> Vec<Claim> {
    let (short, long) = (["ramp-100-paper", "ramp-100-guard"], ["ramp-1000-paper", "ramp-1000-guard"]);
    let of = |modes: [&str; 2]| modes.map(|mode| medians(r, mode, "value_at_detection"));
    let (in_100, in_1000) = (of(short), of(long));
    let fault = |n: usize| numbers(in_100.iter().map(|mode| mode[n]));
    let share = |[paper, guard]: &[Vec<f64>; 2]| {
        let mut shares: Vec<f64> = guard.iter().zip(paper).map(|(guard, paper)| guard / paper).collect();
        shares.sort_by(f64::total_cmp);
        one_of(shares[1])
    };
    vec![
        claim(
            "| ramp over 100 s after ten minutes of watching, value when detected: F1, N m | {} | {} | `{}` |",
            [fault(0), vec![r.command(&short)]].concat(),
        ),
        claim("| the same: F2, rad/s | {} | {} | the same |", fault(1)),
        claim("| the same: F3, A | {} | {} | the same |", fault(2)),
        claim(
            "| ramp over 1,000 s, F1, F2, F3 | {}, {}, {} | {}, {}, {} | `{}` |",
            [numbers(in_1000.concat()), vec![r.command(&long)]].concat(),
        ),
        claim(
            "ramps are found at a {} of what `paper` mode needs (over 100 s) to a {} (over 1000 s)",
            [share(&in_100), share(&in_1000)],
        ),
    ]
}

fn smallest_ramps(r: &Records) -> Vec<Claim> {
    let modes = ["ramp-smallest-paper", "ramp-smallest-guard"];
    let in_moving_water = ["ramp-turbulent-paper", "ramp-turbulent-guard"];
    let of = |modes: [&str; 2]| modes.map(|mode| medians(r, mode, "smallest_ramp"));
    let (still, moving) = (of(modes), of(in_moving_water));
    let ratios = |[paper, guard]: &[Vec<f64>; 2]| -> Vec<f64> { paper.iter().zip(guard).map(|(p, g)| p / g).collect() };
    vec![
        claim(
            "| smallest ramp over 100 s that is detected before it ends, after an hour of watching, F1, F2, F3 | {}, {}, {} | {}, {}, {} | \
             `{}` |",
            [numbers(still.concat()), vec![r.command(&modes)]].concat(),
        ),
        claim(
            "| the same in moving water | {}, {}, {} | {}, {}, {} | `{}` |",
            [numbers(moving.concat()), vec![r.command(&in_moving_water)]].concat(),
        ),
        claim(
            "The smallest ramps that are found at all are {}, {} and {} times smaller than in `paper` mode (in moving water {}, {} and {})",
            numbers([ratios(&still), ratios(&moving)].concat()),
        ),
    ]
}

/// Share of the cases of a kind that were named right, %.
fn right(r: &Records, name: &str, by: &str) -> Value {
    let row = format!("row=isolable faults=F1,_F2,_F3 by={by}");
    let count = |key: &str| r.number(name, &row, key);
    About(count("/right_group").zip(count("/cases")).map(|(right, cases)| 100.0 * right / cases))
}

/// Flights with the name of another fault, and all flights.
fn wrong(r: &Records, name: &str) -> [Value; 2] {
    let (mut wrong, mut flights) = (0, 0);
    for row in r.rows(name).iter().filter(|row| row["row"] == "confusion") {
        flights += row["flights"].as_u64().unwrap_or_default();
        let named = row["named"].as_object().into_iter().flatten();
        let others = named.filter(|(name, _)| row["point"] != **name && *name != "unknown" && *name != "ambiguous");
        wrong += others.filter_map(|(_, count)| count.as_u64()).sum::<u64>();
    }
    [wrong, flights].map(|count| About(Some(count as f64)))
}

fn names(r: &Records) -> Vec<Claim> {
    let modes = ["localization-paper", "localization-guard"];
    let of = |mode| [vec![right(r, mode, "apart")], wrong(r, mode).to_vec()].concat();
    vec![claim(
        "| the right name, of faults with a sigma that looks like no other; a wrong name | {} %; {} of {} | {} %; {} of {} | `{}` |",
        [of(modes[0]), of(modes[1]), vec![r.command(&modes)]].concat(),
    )]
}

fn many_names(r: &Records) -> Vec<Claim> {
    let name = "localization-1000";
    let right = ["apart", "foretold"].map(|by| right(r, name, by));
    vec![claim(
        "| the same over 1,000 other motors, … | | {} %, {} %; {} of {} | `{}` |",
        [right.to_vec(), wrong(r, name).to_vec(), vec![r.command(&[name])]].concat(),
    )]
}

fn few_alarms(r: &Records) -> Vec<Claim> {
    let modes = ["false-alarms-paper", "false-alarms-guard"];
    vec![claim(
        "| false alarms an hour where 0.1 were asked for (95 %) | {} ({} to {}) | {} ({} to {}) | `{}` |",
        [rate(r, modes[0]), rate(r, modes[1]), vec![r.command(&modes)]].concat(),
    )]
}

fn fewest_alarms(r: &Records) -> Vec<Claim> {
    let name = "false-alarms-rare-guard";
    vec![claim(
        "| the same over 1,000 hours and motors, where 0.01 were asked for | | {} ({} to {}) | `{}` |",
        [rate(r, name), vec![r.command(&[name])]].concat(),
    )]
}

fn short_windows(r: &Records) -> Vec<Claim> {
    let name = "false-alarms-short";
    let of = |key| r.about(name, "row=total", key);
    vec![claim(
        "`study {}` is one: over {} random motors that learn for two seconds, {} false alarms in {} hours, where",
        [r.command(&[name]), of("/motors"), of("/alarms"), of("/hours")],
    )]
}

fn changing(r: &Records) -> Vec<Claim> {
    let name = "false-alarms-changing";
    let share = r.number(name, "row=total", "/judged_share").map(|share| 100.0 * share);
    vec![claim(
        "| missions that change their speed every 30 s: judged for, and false alarms an hour of that where 0.1 were asked for | | {} %; {} \
         ({} to {}) | `{}` |",
        [vec![About(share)], rate(r, name), vec![r.command(&[name])]].concat(),
    )]
}

/// What `guard` mode does not reach.
fn limits(r: &Records) -> Vec<Claim> {
    let name = "robustness-guard";
    let faults = r.row(name, COARSE)["faults"].as_array().cloned().unwrap_or_default();
    let sum = |key: &str| faults.iter().filter_map(|fault: &Json| fault[key].as_f64()).sum::<f64>();
    let no = |rate: f64| Words(if rate == 0.0 { "no".to_owned() } else { rate.to_string() });
    vec![
        claim(
            "readings off by 20 sigma, one in ten thousand, make {} an hour, as in `paper` mode",
            [in_words(alarms_under(r, name, OUTLIERS))],
        ),
        claim(
            "A converter step of 16 sigma that the monitor is told of makes {} false alarm …, but of faults of 8 sigma a {} is then \
             missed (`{}`); half of the samples missing makes {}.",
            [
                no(alarms_under(r, name, COARSE)),
                one_of(1.0 - sum("detected") / sum("flights")),
                r.command(&[name]),
                in_words(alarms_under(r, name, MISSING)),
            ],
        ),
    ]
}
