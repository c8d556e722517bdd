//! QEMU's `mps2-an386` (Cortex-M4F) and `mps2-an500` (Cortex-M7): peripherals of Arm's CMSDK (DDI 0479) and of the MPS2
//! board (DAI 0386, DAI 0400), as far as QEMU models them.

mod flight;
mod handlers;
mod output;
mod stack;
mod timer;
mod watchdog;

pub use flight::{Flight, Interrupt};
pub use handlers::stop;
pub use output::FaultOutput;
pub use stack::high_water_bytes;
pub use timer::{Clock, SamplingTimer, TICKS_PER_SECOND};
pub use watchdog::Watchdog;

use defmt_semihosting as _; // the transport of `defmt`
