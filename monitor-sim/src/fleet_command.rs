//! `monitor-sim replay` with several logs: each judged as it would be alone, and a summary of all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use monitor_sim::fleet::row::Row;
use monitor_sim::fleet::{Fleet, How, Outcome, inputs, summary};
use monitor_sim::models::{Place, SAVE_MODELS};
use monitor_sim::output::OutputDir;
use serde::Serialize;

use crate::args::{Mode, ReplayArgs};
use crate::replay_command::{guard_replay_of, paper_replay_of};
use crate::{Failure, json, print, print_all, progress};

/// The result, as machines read it.
#[derive(Serialize)]
struct FleetReport<'a> {
    logs: &'a [Row],
    outcome: Outcome,
    files: &'a [PathBuf],
    exit: u8,
}

/// Replays the logs.
pub(crate) fn run(args: &ReplayArgs) -> Result<ExitCode, Failure> {
    let how = match args.mode {
        // Every log takes its place in turn.
        Mode::Guard => How::Guard(guard_replay_of(Path::new(""), args)?),
        Mode::Paper => How::Paper(paper_replay_of(Path::new(""), args)?),
    };
    let ours = args.out.canonicalize().ok();
    let files = inputs::logs(&args.logs, |path| is_ours(path, ours.as_deref()))?;
    let out = OutputDir::prepare(&args.out)?;
    files.iter().try_for_each(|file| out.spares(file, &summary::FILES))?;
    if let Some(directory) = &args.save_models {
        OutputDir::prepare_for(directory, SAVE_MODELS)?;
        own_places(&files, &Place::Directory(directory.clone()))?;
    }
    let fleet = Fleet { files, how, save_models: args.save_models.clone() };
    let bar = progress(Some(fleet.bytes()), "bytes");
    let rows = fleet.run(|bytes| bar.inc(bytes));
    bar.finish_and_clear();
    let rows = rows?;
    let written = summary::write(&rows, &out)?;
    let outcome = Outcome::of(&rows);
    let report = FleetReport { logs: &rows, outcome, files: &written, exit: outcome.exit() };
    print_all(&if args.json { json(&report)? } else { print::fleet::summary(&rows, outcome, &written) })?;
    Ok(ExitCode::from(outcome.exit()))
}

/// Refuses logs of which one would overwrite what was learned of another.
fn own_places(logs: &[PathBuf], place: &Place) -> Result<(), Failure> {
    let mut taken = BTreeMap::new();
    for log in logs {
        if let Some(other) = taken.insert(place.of(log), log) {
            return Err(format!(
                "what is known of '{}' and of '{}' would have one file, named as they are: rename one, or judge them apart",
                other.display(),
                log.display()
            )
            .into());
        }
    }
    Ok(())
}

/// Results of an earlier run that lie below a directory of logs: all of another directory, our own files of the same.
fn is_ours(path: &Path, ours: Option<&Path>) -> bool {
    let Some(ours) = ours else { return false };
    path.canonicalize().is_ok_and(|path| path == ours || summary::FILES.iter().any(|name| path == ours.join(name)))
}
