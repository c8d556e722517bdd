//! `cargo emulate`: builds the firmware, flies a mission on an emulated board, and prints what the board logs.
//!
//! Exit codes: 0 when the board left well, 1 when it did not, 2 when the command line or the installation is wrong.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fs, io};

use clap::{Parser, ValueEnum};
use firmware_stub::record::{Arrival, Header, Kind};
use monitor_core::units::RadPerSec;
use monitor_sim::mission;
use monitor_sim::plant::Plant;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use tests::stream::{self, Stream};
use tests::toolchain::{Board, Firmware, Run};

/// Flies the mission of figure 1 on an emulated board and prints what the board logs.
#[derive(Parser)]
#[command(name = "emulate", bin_name = "cargo emulate", after_help = EXAMPLES)]
struct Arguments {
    /// Emulated core.
    #[arg(long, value_enum, default_value_t = Core::M4)]
    core: Core,
    /// Mode of the monitor.
    #[arg(long, value_enum, default_value_t = Mode::Guard)]
    mode: Mode,
    /// Seed of the sensors' noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A firmware that is built already, instead of building it.
    #[arg(long, value_name = "ELF", conflicts_with = "mode")]
    firmware: Option<PathBuf>,
    /// Directory that keeps what board and host exchange: mission.in and mission.out.
    #[arg(long, value_name = "DIRECTORY")]
    keep: Option<PathBuf>,
}

const EXAMPLES: &str =
    "Examples:\n  cargo emulate\n  cargo emulate --mode paper --core m7 --seed 7\n  cargo emulate --keep exchanged";

#[derive(Clone, Copy, ValueEnum)]
enum Core {
    /// Cortex-M4F, QEMU's mps2-an386.
    M4,
    /// Cortex-M7, QEMU's mps2-an500.
    M7,
}

#[derive(Clone, Copy, ValueEnum)]
enum Mode {
    /// Limits that set themselves; faults by name and size.
    Guard,
    /// The method of the paper.
    Paper,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let flown = prepare(&arguments).map_err(|error| (error, 2)).and_then(|(elf, desk)| {
        let board = match arguments.core {
            Core::M4 => Board::CortexM4,
            Core::M7 => Board::CortexM7,
        };
        Run::new(board, &elf, desk.path()).log().map_err(|error| (error, 1))
    });
    match flown {
        Ok(lines) => {
            lines.iter().for_each(|line| println!("{line}"));
            ExitCode::SUCCESS
        }
        Err((error, code)) => {
            eprintln!("error: {error}");
            ExitCode::from(code)
        }
    }
}

/// Where host and board meet.
enum Desk {
    Kept(PathBuf),
    Passing(tempfile::TempDir),
}

impl Desk {
    fn path(&self) -> &Path {
        match self {
            Desk::Kept(path) => path,
            Desk::Passing(directory) => directory.path(),
        }
    }
}

/// Builds the firmware and writes the stream.
fn prepare(arguments: &Arguments) -> Result<(PathBuf, Desk), String> {
    let elf = match &arguments.firmware {
        // The emulator runs in another directory.
        Some(elf) => std::path::absolute(elf).map_err(|error| format!("{}: {error}", elf.display()))?,
        None => {
            let binary = match arguments.mode {
                Mode::Guard => "qemu-guard",
                Mode::Paper => "qemu-mission",
            };
            Firmware::emulated(binary).build()?
        }
    };
    let desk = desk(arguments.keep.as_deref()).map_err(|error| format!("the directory cannot be made: {error}"))?;
    let place = desk.path().join("mission.in");
    fs::write(&place, stream::bytes(&mission_stream(arguments.seed)?))
        .map_err(|error| format!("{} cannot be written: {error}", place.display()))?;
    Ok((elf, desk))
}

fn desk(keep: Option<&Path>) -> io::Result<Desk> {
    match keep {
        Some(path) => fs::create_dir_all(path).and_then(|()| std::path::absolute(path)).map(Desk::Kept),
        None => tempfile::tempdir().map(Desk::Passing),
    }
}

/// The mission of figure 1, with the default motor's settings.
fn mission_stream(seed: u64) -> Result<Vec<u32>, String> {
    let settings = PaperSettings::default_motor().map_err(|error| error.to_string())?;
    let config = settings.config(1000.0, 5.0, 15.0, 0.0);
    let slots: Vec<Arrival> = Plant::new(&Scenario::figure_1(), seed)
        .map(|measured| Arrival::sample(RadPerSec(measured.set_point as f32), mission::sample(&measured)))
        .collect();
    let records = u32::try_from(slots.len()).map_err(|_| "the mission is too long for one stream".to_owned())?;
    let mut stream = Stream::new(&Header { kind: Kind::Mission, records, config });
    slots.iter().for_each(|slot| stream.push(&slot.to_words()));
    Ok(stream.finish())
}
