//! What `watch` can be asked for.

use std::path::PathBuf;

use clap::Args;
use monitor_sim::watch::Pace;

use super::{LogArgs, Mode};

pub(crate) const EXAMPLES: &str = "\
Examples:
  monitor-sim watch                             the paper's mission in real time
  monitor-sim watch --pace 10 --seed 7          ten times as fast, other noise
  monitor-sim watch --scenario my.toml          a mission of your own
  monitor-sim watch log.csv --speed rpm --current amps --voltage volts \\
      --rate-hz 50 --learn 5s..20s --pace max   a recorded log, as fast as it can be judged
  monitor-sim watch --models motor.models       by what another flight learned (--save-models)
  monitor-sim watch --print-at 30               one frame as text, without a terminal

Keys: space pause, + and - pace, arrows and PageUp back in time, ? help, q quit.
Exit codes: 0 done, 2 wrong input or no terminal.";

#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    /// A recorded log to be replayed; without it a mission is flown
    #[arg(value_name = "LOG", requires_all = ["rate_hz", "known"])]
    pub(crate) log: Option<PathBuf>,
    /// How many times as fast as real time, or `max`
    #[arg(long, value_name = "X", default_value = "1", allow_negative_numbers = true)]
    pub(crate) pace: Pace,
    /// Mission: scenario file (TOML); the paper's figure 1 if none
    #[arg(long, value_name = "FILE", conflicts_with = "log")]
    pub(crate) scenario: Option<PathBuf>,
    /// Mission: seed of the sensor noise; 1 if none
    #[arg(long, allow_negative_numbers = true, conflicts_with = "log")]
    pub(crate) seed: Option<u64>,
    /// Thresholds file for --mode paper, as `tune` writes it; if none, those of the default motor for a mission, and of a log 1.5
    /// times the largest residual of --learn
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// In guard mode: judge by what was learned before (--save-models of a mission or a replay, or a dump of a board's flash)
    /// instead of learning
    #[arg(long, value_name = "FILE")]
    pub(crate) models: Option<PathBuf>,
    /// With --models, of a log: learning time at a set point that is not known, s; as `replay` has it
    #[arg(long, value_name = "S", allow_negative_numbers = true, requires_all = ["models", "log"])]
    pub(crate) relearn: Option<f64>,
    /// Which monitor judges
    #[arg(long, value_enum, default_value_t = Mode::Guard)]
    pub(crate) mode: Mode,
    /// Print the frame of this second as text, as fast as it can be reached, and be done; may be repeated, in order of time
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = super::not_negative)]
    pub(crate) print_at: Vec<f64>,
    /// Size of a frame of --print-at: columns x rows
    #[arg(long, value_name = "WxH", default_value = "80x24", requires = "print_at", value_parser = size)]
    pub(crate) size: (u16, u16),
    #[command(flatten)]
    pub(crate) how: LogArgs,
}

/// Largest frame that is printed; a terminal is far smaller.
const LARGEST: u16 = 1000;

fn size(text: &str) -> Result<(u16, u16), String> {
    let sides = text.split_once('x').map(|(width, height)| (width.trim().parse(), height.trim().parse()));
    match sides {
        Some((Ok(width), Ok(height))) if (1..=LARGEST).contains(&width) && (1..=LARGEST).contains(&height) => {
            Ok((width, height))
        }
        _ => Err(format!("write columns x rows, each from 1 to {LARGEST}, for example 80x24")),
    }
}
