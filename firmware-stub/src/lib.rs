//! Wiring of [`monitor_core`] for a thruster controller board. Everything that computes is in the core.
//!
//! In the order in which a sample passes: which [slot](deadline) of the sampling clock the interrupt belongs to, what the
//! [interrupt](sampling) does with it, what a monitor in either [mode] says of it, what the [main loop](background) does at
//! leisure, what can be [asked](request) of it, how it is reported (`report`, with the feature `defmt`), and
//! [how a run can end](fault). Beside them stand the [records](record) that a host and an emulated board exchange, the
//! [kernels] that an audit calls one by one, and the boards, of which a build has at most one.

#![no_std]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(all(feature = "board-qemu", feature = "board-stm32f405"))]
compile_error!("a firmware is for one board: choose either the feature board-qemu or the feature board-stm32f405");
#[cfg(all(feature = "emulated", not(feature = "board-stm32f405")))]
compile_error!("the feature emulated belongs to the feature board-stm32f405; board-qemu is emulated anyway");
#[cfg(all(feature = "pll", feature = "emulated"))]
compile_error!("the emulator has no clock tree: choose either the feature pll or the feature emulated");
#[cfg(all(feature = "board", not(any(feature = "board-qemu", feature = "board-stm32f405"))))]
compile_error!("no board is chosen: enable the feature board-qemu or the feature board-stm32f405");

pub mod deadline;
pub mod sampling;
pub mod mode;
pub mod background;
pub mod request;
#[cfg(feature = "defmt")]
pub mod report;
pub mod fault;
pub mod record;
pub mod kernels;
pub mod settings;
pub mod scale;
#[cfg(feature = "board")]
pub mod board;

pub use background::{Background, Shared};
pub use mode::{Guarded, Mode, Paper};
pub use sampling::{Reading, Sampling};
