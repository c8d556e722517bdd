//! The commands whose figures the README states.

/// A command and what is kept of what it finds.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Of its file.
    pub name: &'static str,
    /// As a user types it behind `monitor-sim`.
    pub command: &'static str,
    /// How it is run.
    pub kind: Kind,
}

/// How a command is run, and what is kept.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// `study`: the rows of these kinds, all if there are none, and its tables as lines if the README shows them.
    Study(&'static [&'static str], Printed),
    /// `tune`: its tables as lines.
    Tune,
    /// The mission once for each seed from 1 to this one, which stands for `N` in the command.
    Missions(u64),
    /// The mission with the thresholds that this `tune` writes to `limits.toml`.
    Tuned(&'static str),
    /// `bench`: `DIR` in the command is this directory of the recordings.
    Bench(&'static str),
}

/// Whether the README shows the tables themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Printed {
    /// It does not.
    No,
    /// It does.
    Yes,
}

use Kind::{Bench, Missions, Study, Tune, Tuned};

const TOTAL: Kind = Study(&["total"], Printed::No);
const RAMP: Kind = Study(&[], Printed::No);
const LOOP_AND_WHITE: Kind = Study(&["loop", "white"], Printed::No);
const WHITE: Kind = Study(&["white"], Printed::No);
const NAMES: Kind = Study(&["confusion", "isolable"], Printed::No);
const TROUBLE: Kind = Study(&["disturbance", "stuck"], Printed::No);

const fn figure(name: &'static str, command: &'static str, kind: Kind) -> Figure {
    Figure { name, command, kind }
}

/// All of them, the quick ones first.
pub const FIGURES: &[Figure] = &[
    figure("missions", "--seed N --json", Missions(40)),
    figure("mission-turbulent", "--scenario monitor-sim/scenarios/turbulent.toml --json", Missions(1)),
    figure("mission-paper", "--mode paper --json", Missions(1)),
    figure(
        "mission-turbulent-paper",
        "--scenario monitor-sim/scenarios/turbulent.toml --mode paper --limits limits.toml --json",
        Tuned("tune --scenario monitor-sim/scenarios/turbulent.toml --runs 64 --borderline 0.5 --out limits.toml"),
    ),
    figure("tune", "tune --runs 64", Tune),
    figure("ramp-paper", "study ramp --mode paper", Study(&[], Printed::Yes)),
    figure("ramp-100-paper", "study ramp --ramp 100 --size 0.05 --known 600 --mode paper", RAMP),
    figure("ramp-100-guard", "study ramp --ramp 100 --size 0.05 --known 600 --mode guard", RAMP),
    figure("ramp-1000-paper", "study ramp --ramp 1000 --size 0.05 --known 600 --seeds 6 --mode paper", RAMP),
    figure("ramp-1000-guard", "study ramp --ramp 1000 --size 0.05 --known 600 --seeds 6 --mode guard", RAMP),
    figure("ramp-smallest-paper", "study ramp --ramp 100 --size 0.05 --known 3600 --smallest --mode paper", RAMP),
    figure("ramp-smallest-guard", "study ramp --ramp 100 --size 0.05 --known 3600 --smallest --mode guard", RAMP),
    figure(
        "ramp-turbulent-paper",
        "study ramp --scenario monitor-sim/scenarios/turbulent.toml --ramp 100 --known 3600 --smallest --mode paper",
        RAMP,
    ),
    figure(
        "ramp-turbulent-guard",
        "study ramp --scenario monitor-sim/scenarios/turbulent.toml --ramp 100 --known 3600 --smallest --mode guard",
        RAMP,
    ),
    figure("delay-sizes-paper", "study delay --mode paper --asked 3.6", WHITE),
    figure("delay-paper", "study delay --asked 3.6 --sizes 1 --mode paper", LOOP_AND_WHITE),
    figure("delay-guard", "study delay --asked 3.6 --sizes 1 --mode guard", LOOP_AND_WHITE),
    figure("robustness-paper", "study robustness --mode paper", TROUBLE),
    figure("robustness-guard", "study robustness", TROUBLE),
    figure("localization-paper", "study localization --motors 150 --faults paper --mode paper", NAMES),
    figure("localization-guard", "study localization --motors 150 --faults paper --mode guard", NAMES),
    figure(
        "localization-all-paper",
        "study localization --mode paper --motors 300",
        Study(&["confusion"], Printed::Yes),
    ),
    figure("delay-100-paper", "study delay --asked 3.6 --sizes 1 --seeds 100 --mode paper", WHITE),
    figure("delay-100-guard", "study delay --asked 3.6 --sizes 1 --seeds 100 --mode guard", WHITE),
    figure("false-alarms-paper", "study false-alarms --motors 200 --hours 100 --mode paper", TOTAL),
    figure("false-alarms-guard", "study false-alarms --motors 200 --hours 100 --mode guard", TOTAL),
    figure("false-alarms-changing", "study false-alarms --motors 200 --hours 100 --change 30", TOTAL),
    figure("false-alarms-rare-paper", "study false-alarms --motors 150 --hours 150 --asked 0.01 --mode paper", TOTAL),
    figure("false-alarms-short", "study false-alarms --learn 2 --motors 300 --hours 100", TOTAL),
    figure("localization-1000", "study localization --motors 1000 --seed 5 --faults paper", NAMES),
    figure("false-alarms-rare-guard", "study false-alarms --motors 1000 --hours 1000 --asked 0.01", TOTAL),
    figure("skab-guard", "bench skab DIR", Bench("skab")),
    figure("skab-paper", "bench skab DIR --mode paper", Bench("skab")),
    figure("spindle-guard", "bench cnc-spindle DIR", Bench("cnc_spindle")),
    figure("spindle-paper", "bench cnc-spindle DIR --mode paper", Bench("cnc_spindle")),
];
