//! The STM32F405RG of VESC-class thruster controllers (reference manual RM0090). **Not tried on silicon**: it runs on
//! QEMU's `netduinoplus2` as far as that models the chip (no clock tree, no pins, no watchdog, converters that count).
//!
//! | pin | is |
//! |---|---|
//! | PB0 | healthy: high while the monitor sees no fault; low, or floating at reset, means stop (wants a pull-down) |
//! | PB1 | fault lamp: high while there is a fault |
//! | PB6, PB7 | encoder of the shaft, channels A and B (TIM4) |
//! | PB10, PB11 | serial line for requests, 115,200 baud (USART3) |
//! | PC0, PC1 | armature current and armature voltage (ADC1, inputs 10 and 11; see [`scale`](crate::scale)) |
//!
//! TIM2 is the sampling interrupt, TIM5 the free-running clock beside it; both count microseconds.
//!
//! Pins and watchdog go through `stm32f4xx-hal`. Clocks, timers, converter and serial line are set by register: the HAL
//! searches for clock settings at run time and panics where there are none, and this image has no panic.

mod clocks;
mod converter;
mod encoder;
mod end;
mod output;
#[cfg(not(feature = "emulated"))]
mod rtt;
mod serial;
mod timer;

pub use clocks::start as start_clocks;
pub use converter::Converter;
pub use encoder::Encoder;
pub use end::{last_reason, stop};
pub use output::FaultOutput;
pub use serial::SerialLine;
pub use timer::{Clock, SamplingTimer, TICKS_PER_SECOND};

#[cfg(feature = "emulated")]
use defmt_semihosting as _; // the transport of `defmt`
