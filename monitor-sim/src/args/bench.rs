//! `monitor-sim bench`: what can be asked for.

use std::path::PathBuf;

use clap::Args;

use monitor_sim::study::watch::Mode;

use super::positive;

pub(crate) const EXAMPLES: &str = "\
Examples:
  monitor-sim bench skab SKAB/data                 the Skoltech Anomaly Benchmark, by its protocol
  monitor-sim bench skab SKAB/data/valve1          a part of it
  monitor-sim bench skab SKAB/data --mode paper --json | jq '{f1, far, mar, nab}'
  monitor-sim bench cnc-spindle tool-wear --out DIR    a page with every run over time
  monitor-sim bench --example > my.toml            a description of recordings of your own
  monitor-sim bench my.toml recordings

The recordings are not part of this program; where to get them is said when they are not there.
Settings are those that a replay would choose, and nothing is chosen by looking at labels.
Exit codes: 0 done, 2 the recordings or the command line were wrong.";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct BenchArgs {
    /// skab, cnc-spindle, or a description (.toml)
    #[arg(value_name = "NAME", required_unless_present = "example")]
    pub(crate) name: Option<String>,
    /// Directory with the recordings; every .csv file below it is a run
    #[arg(value_name = "DIR", required_unless_present = "example")]
    pub(crate) directory: Option<PathBuf>,
    /// Print a description to start from
    #[arg(long, exclusive = true)]
    pub(crate) example: bool,
    /// Which monitor is scored
    #[arg(long, value_enum, default_value_t = Mode::Guard)]
    pub(crate) mode: Mode,
    /// In guard mode: false alarms that are tolerable per hour; 0.01 if none
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) false_alarms_per_hour: Option<f64>,
    /// Write a page, bench.html, to this directory
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON document instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}
