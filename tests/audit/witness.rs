//! The second witness of the stack: how much of it an emulated mission has used, beside the bound from the machine code.
//!
//! Start-up paints the stack; what is still painted at the end of the mission was never used. A high-water mark above the
//! bound would prove the bound wrong. One below it proves nothing: it is what one mission needed, not the most.

use std::path::Path;

use firmware_stub::record::{Arrival, Header, Kind};
use firmware_stub::request::Request;
use monitor_core::units::RadPerSec;
use monitor_sim::mission;
use monitor_sim::plant::Plant;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;

use super::report::{Report, Table};
use crate::stream::{self, Stream};
use crate::toolchain::{Board, Run};

/// The line by which the firmware tells.
const KEY: &str = "STACK_HIGH_WATER_BYTES=";

/// What this witness cannot see.
const BLIND_SPOTS: [&str; 2] = [
    "the painted mark is what one mission used, not the most that any could",
    "a word that happens to hold the paint's own value counts as unused",
];

/// Flies the mission of figure 1 on the emulated board, its faults and every kind of request included, and returns the bytes
/// of stack it used at most.
///
/// # Errors
/// The emulator is missing, the board did not end well, or it did not tell.
pub fn high_water(elf: &Path) -> Result<u64, String> {
    let desk = tempfile::tempdir().map_err(|error| format!("no directory for the mission: {error}"))?;
    let stream = mission_stream()?;
    std::fs::write(desk.path().join("mission.in"), stream::bytes(&stream))
        .map_err(|error| format!("the mission cannot be written: {error}"))?;
    let log = Run::new(Board::CortexM4, elf, desk.path()).log()?;
    marked(&log).ok_or_else(|| format!("{} does not tell how much stack it used ({KEY})", elf.display()))
}

/// The mark among the lines of a log.
fn marked(log: &[String]) -> Option<u64> {
    log.iter().find_map(|line| line.strip_prefix(KEY)?.parse().ok())
}

fn mission_stream() -> Result<Vec<u32>, String> {
    let settings = PaperSettings::default_motor().map_err(|error| error.to_string())?;
    let mut slots: Vec<Arrival> = Plant::new(&Scenario::figure_1(), 1)
        .map(|measured| Arrival::sample(RadPerSec(measured.set_point as f32), mission::sample(&measured)))
        .collect();
    let requests = [Request::ByChannel, Request::Statistics, Request::Verdict].into_iter().cycle();
    for (slot, request) in slots.iter_mut().skip(10_000).step_by(5_000).zip(requests) {
        slot.request = Some(request);
    }
    let config = settings.config(1000.0, 5.0, 15.0, 0.0);
    let mut stream = Stream::new(&Header { kind: Kind::Mission, records: slots.len() as u32, config });
    slots.iter().for_each(|slot| stream.push(&slot.to_words()));
    Ok(stream.finish())
}

/// The mark beside the bound.
#[must_use]
pub fn report(name: &str, bound: u64, used: u64) -> Report {
    let mut report =
        Report { title: format!("stack of {name}, painted"), blind_spots: BLIND_SPOTS.into(), ..Report::default() };
    let mut table = Table::new("Stack of a whole emulated mission, bytes", &["", "bytes"]);
    table.row(["bound, all handlers nested".to_owned(), bound.to_string()]);
    table.row(["high-water mark of the mission".to_owned(), used.to_string()]);
    report.tables.push(table);
    if used > bound {
        report.faults.push(format!(
            "{name}: the mission used {used} bytes of stack, above the bound of {bound}: the bound is wrong"
        ));
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mission_that_used_more_than_the_bound_proves_the_bound_wrong() {
        assert!(report("a", 100, 100).faults.is_empty());
        assert!(report("a", 100, 101).faults[0].contains("the bound is wrong"));
    }

    #[test]
    fn the_mark_is_read_from_the_log_and_missed_if_it_is_not_there() {
        let log = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>();
        assert_eq!(marked(&log(&["sample 0: settling", "STACK_HIGH_WATER_BYTES=1234"])), Some(1234));
        assert_eq!(marked(&log(&["STACK_HIGH_WATER_BYTES=many"])), None);
    }
}
