//! `monitor-sim bench`: judges recordings by a protocol, prints the score.

use std::process::ExitCode;

use monitor_sim::bench::protocol::{EXAMPLE, Protocol};
use monitor_sim::bench::{Bench, page};
use monitor_sim::guardian::Alarming;
use monitor_sim::output::OutputDir;
use monitor_sim::study::watch::Mode;

use crate::args::bench::BenchArgs;
use crate::{Failure, json, only_in_guard_mode, print, print_all, progress};

pub(crate) fn run(args: &BenchArgs) -> Result<ExitCode, Failure> {
    if args.example {
        return print_all(EXAMPLE);
    }
    let (Some(name), Some(directory)) = (&args.name, &args.directory) else {
        return Err("give a benchmark and a directory, or --example".into());
    };
    if args.mode == Mode::Paper {
        only_in_guard_mode("--false-alarms-per-hour", args.false_alarms_per_hour.is_some())?;
    }
    let bench = Bench {
        protocol: Protocol::find(name)?,
        directory: directory.clone(),
        mode: args.mode,
        false_alarms_per_hour: args.false_alarms_per_hour.unwrap_or(Alarming::default().false_alarms_per_hour),
    };
    let files = bench.files()?;
    let out = args.out.as_deref().map(OutputDir::prepare).transpose()?;
    // Reading, and judging.
    let bar = progress(Some(2 * files.len() as u64), "steps");
    let report = bench.run(&files, || bar.inc(1));
    bar.finish_and_clear();
    let report = report?;
    let written = match &out {
        Some(out) => Some(out.write("bench.html", &page::page(&report))?),
        None => None,
    };
    print_all(&if args.json { json(&report)? } else { print::bench(&report, written.as_deref()) })
}
