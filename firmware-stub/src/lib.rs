//! Wiring of [`monitor_core`] for a thruster controller board.
//!
//! **A placeholder.** It compiles for a host and holds the one function that every board calls; it does not flash.
//! Boards (an emulated Cortex-M4F, an STM32F405), the queue to the main loop, `defmt` and the fault handlers are still
//! to come; `memory.x` in the workspace root is already the map of the STM32F405 they will be linked for.

#![no_std]

use monitor_core::units::RadPerSec;
use monitor_core::{Monitor, Sample, Verdict};

/// What the sampling interrupt does with one sample: judge it, and drive the fault output.
///
/// `drive_fault_output` is given `true` while any relay is up.
pub fn on_sample(
    monitor: &mut Monitor,
    set_point: RadPerSec,
    sample: Sample,
    drive_fault_output: impl FnOnce(bool),
) -> Verdict {
    let verdict = monitor.step(set_point, sample);
    drive_fault_output(verdict.relays.any());
    verdict
}
