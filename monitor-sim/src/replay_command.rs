//! `monitor-sim replay`: judges a recorded log; several are a fleet.

use std::path::Path;
use std::process::ExitCode;

use monitor_core::guard::MotorConstants;
use monitor_sim::log::{ColumnRef, LogOptions};
use monitor_sim::models::{Place, SAVE_MODELS};
use monitor_sim::names::ChannelNames;
use monitor_sim::output::{OutputDir, PendingFile, spares};
use monitor_sim::replay::guard::Learn;
use monitor_sim::replay::paper::{Limits, MARGIN, Replay};
use monitor_sim::replay::{Source, guard, paper};
use monitor_sim::replay_page;
use monitor_sim::settings::PaperSettings;
use monitor_sim::trace::TraceWriter;

use crate::args::{LogArgs, Mode, ReplayArgs};
use crate::{
    Failure, fleet_command, json, only_in_guard_mode, only_in_paper_mode, parsed, print, print_all, progress, settings,
};

/// Replays a log, or several.
pub(crate) fn run(args: &ReplayArgs) -> Result<ExitCode, Failure> {
    match (args.logs.as_slice(), args.mode) {
        ([log], _) if log.is_dir() => fleet_command::run(args),
        ([log], Mode::Guard) => guard(log, args),
        ([log], Mode::Paper) => paper(log, args),
        _ => fleet_command::run(args),
    }
}

/// What guard mode is asked for, of the log at `path`.
pub(crate) fn guard_replay_of(path: &Path, args: &ReplayArgs) -> Result<guard::Replay, Failure> {
    if args.baseline.is_some() {
        return Err("a stored baseline is the paper's: in guard mode give --models FILE, or add --mode paper".into());
    }
    only_in_paper_mode("--margin", args.margin.is_some())?;
    only_in_paper_mode("--limits", args.limits.is_some())?;
    only_in_paper_mode("--cutoff-hz", args.cutoff_hz.is_some())?;
    only_in_paper_mode("--relearn", args.relearn.is_some() && args.models.is_none())?;
    let learn = match &args.models {
        Some(models) => Learn::Stored { place: Place::at(models), relearn_s: args.relearn },
        None => Learn::Window(args.how.learn.ok_or("give --learn A..B or --models FILE")?),
    };
    guard_replay(path, &args.how, learn)
}

fn guard(log: &Path, args: &ReplayArgs) -> Result<ExitCode, Failure> {
    let replay = guard_replay_of(log, args)?;
    let out = OutputDir::prepare(&args.out)?;
    out.spares(log, &["replay.csv", "replay.html"])?;
    let save = args.save_models.as_deref().map(|path| Place::at(path).of(log));
    let save = save.map(|path| spares(log, &path, SAVE_MODELS).and_then(|()| PendingFile::create(&path, SAVE_MODELS)));
    let save = save.transpose()?;
    let bar = progress(replay.source.bytes(), "bytes");
    let replayed = replay.run(
        |names| (!args.no_trace).then(|| TraceWriter::create(&out, "replay.csv", names)).transpose(),
        |bytes| bar.set_position(bytes),
    );
    bar.finish_and_clear();
    let mut replayed = replayed?;
    if let Some(file) = save {
        let (written, relearn_s) = (replayed.report.known.write(file)?, replay.relearn_s()?);
        replayed.report.notes.push(format!(
            "another log is judged by what is known of this one with `--models {} --relearn {relearn_s}` in place of --learn",
            written.display()
        ));
        replayed.report.files.push(written);
    }
    let page = replay_page::guard::page(&replay, &replayed);
    replayed.report.files.insert(0, out.write("replay.html", &page)?);
    print_all(&if args.json { json(&replayed.report)? } else { print::guard::replay(&replayed) })?;
    Ok(ExitCode::from(replayed.report.exit))
}

/// A replay in guard mode of the log at `path`.
pub(crate) fn guard_replay(path: &Path, how: &LogArgs, learn: Learn) -> Result<guard::Replay, Failure> {
    if how.resistance.is_some() && how.speed.is_none() {
        return Err("--resistance is a motor's: name its channels by --speed, --current and --voltage".into());
    }
    Ok(guard::Replay {
        source: source(path, how)?,
        learn,
        alarming: how.alarming.alarming(),
        settle_s: how.settle,
        set_point_tolerance: how.set_point_tolerance,
        motor: motor(how),
    })
}

/// The motor's constants, if they were given.
fn motor(how: &LogArgs) -> Option<MotorConstants> {
    Some(MotorConstants {
        resistance_ohm: how.resistance? as f32,
        torque_constant_nm_per_a: how.torque_constant? as f32,
        load_slope_nm_s: how.load_slope? as f32,
    })
}

/// What paper mode is asked for, of the log at `path`.
pub(crate) fn paper_replay_of(path: &Path, args: &ReplayArgs) -> Result<Replay, Failure> {
    only_in_guard_mode("--models", args.models.is_some())?;
    only_in_guard_mode(SAVE_MODELS, args.save_models.is_some())?;
    let learn = match (&args.how.learn, &args.baseline) {
        (Some(window), _) => paper::Learn::Window(*window),
        (None, Some(path)) => paper::Learn::Stored(Box::new(parsed(path, "baseline")?)),
        (None, None) => return Err("give --learn A..B or --baseline FILE".into()),
    };
    let replay = paper_replay(path, &args.how, learn, args.limits.as_deref())?;
    Ok(Replay {
        recall: args.recall,
        relearn_s: args.relearn,
        cutoff_hz: replay.cutoff_hz.or(args.cutoff_hz),
        // With a file of thresholds there is no margin.
        limits: args.margin.map_or(replay.limits, |margin| Limits::FromLearning { margin }),
        ..replay
    })
}

/// A replay in paper mode of the log at `path`, with the thresholds of a file if there is one.
pub(crate) fn paper_replay(
    path: &Path,
    how: &LogArgs,
    learn: paper::Learn,
    limits: Option<&Path>,
) -> Result<Replay, Failure> {
    how.alarming.only_in_guard_mode()?;
    only_in_guard_mode("--resistance", how.resistance.is_some())?;
    let fixed = limits.map(|path| settings(Some(path))).transpose()?;
    let PaperSettings { hysteresis, explained_share, .. } = match &fixed {
        Some(fixed) => fixed.clone(),
        None => PaperSettings::default_motor()?,
    };
    Ok(Replay {
        source: source(path, how)?,
        learn,
        recall: false,
        settle_s: how.settle,
        relearn_s: None,
        set_point_tolerance: how.set_point_tolerance,
        cutoff_hz: fixed.as_ref().map(|fixed| fixed.cutoff_hz),
        hysteresis,
        explained_share,
        limits: fixed.map_or(Limits::FromLearning { margin: MARGIN }, |fixed| Limits::Fixed(fixed.thresholds)),
    })
}

fn paper(log: &Path, args: &ReplayArgs) -> Result<ExitCode, Failure> {
    let replay = paper_replay_of(log, args)?;
    let out = OutputDir::prepare(&args.out)?;
    out.spares(log, &["replay.csv", "replay.html", "baseline.toml"])?;
    let bar = progress(replay.source.bytes(), "bytes");
    let replayed = replay.run(
        |names| (!args.no_trace).then(|| TraceWriter::create(&out, "replay.csv", names)).transpose(),
        |bytes| bar.set_position(bytes),
    );
    bar.finish_and_clear();
    let mut replayed = replayed?;
    let page = replay_page::paper::page(&replay, &replayed);
    replayed.report.files.insert(0, out.write("replay.html", &page)?);
    if args.baseline.is_none() {
        replayed.report.files.push(out.write("baseline.toml", &replayed.baseline.to_toml()?)?);
    }
    print_all(&if args.json { json(&replayed.report)? } else { print::replay(&replayed) })?;
    Ok(ExitCode::from(replayed.report.exit))
}

/// The log, as it was said to be.
fn source(path: &Path, how: &LogArgs) -> Result<Source, Failure> {
    Ok(Source {
        path: path.to_owned(),
        channels: channels(how)?,
        set_point: how.set_point.clone(),
        log: LogOptions { delimiter: how.delimiter },
        rate_hz: how.rate_hz.ok_or("give the log's rows per second with --rate-hz")?,
        injections: how.inject.clone(),
    })
}

/// The three channels: those of the motor, or three of the user's own.
fn channels(how: &LogArgs) -> Result<[(String, ColumnRef); 3], Failure> {
    if let (Some(speed), Some(current), Some(voltage)) = (&how.speed, &how.current, &how.voltage) {
        let [a, b, c] = ChannelNames::motor().0;
        return Ok([(a, speed.clone()), (b, current.clone()), (c, voltage.clone())]);
    }
    let given = how.channel.len();
    let channels: [(String, ColumnRef); 3] = how.channel.clone().try_into().map_err(|_| {
        format!(
            "three channels are needed, {given} given: repeat --channel NAME=COL, or use --speed, --current, --voltage"
        )
    })?;
    let [(a, _), (b, _), (c, _)] = &channels;
    if a == b || b == c || a == c {
        return Err("two channels have the same name: give each --channel a name of its own".into());
    }
    Ok(channels)
}
