//! Wiring of [`monitor_core`] for a thruster controller board.
//!
//! **Not yet a product.** What stands: the call that every board's sampling interrupt makes ([`on_sample`]), the records
//! that a host and an emulated board exchange ([`record`]), and a firmware for QEMU's Cortex-M4F (feature `board-qemu`)
//! that flies whole missions and logs by `defmt`, so that host and target can be compared bit for bit. Still to come: the
//! sampling interrupt with its queue, the fault handlers, and the STM32F405 board.

#![no_std]

pub mod kernels;
pub mod record;
#[cfg(feature = "defmt")]
pub mod report;

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
    drive_fault_output(verdict.relays().any());
    verdict
}
