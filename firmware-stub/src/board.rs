//! The boards. Each brings the same few things: a clock for the [deadline](crate::deadline), a fault output, a watchdog,
//! an end that leaves the output safe, and a transport for `defmt`.

mod handlers;
#[cfg(any(feature = "board-qemu", feature = "emulated"))]
pub mod host;
#[cfg(feature = "board-qemu")]
pub mod exchange;
#[cfg(feature = "board-qemu")]
pub mod qemu;
#[cfg(feature = "board-qemu")]
mod register;
#[cfg(feature = "board-stm32f405")]
pub mod stm32f405;

#[cfg(feature = "board-qemu")]
pub use qemu::stop;
#[cfg(feature = "board-stm32f405")]
pub use stm32f405::stop;

/// Waits for the next interrupt. In emulation it returns at once: QEMU's instruction-counting clock jumps over every other
/// slot when the core sleeps.
pub fn wait() {
    if cfg!(any(feature = "board-qemu", feature = "emulated")) {
        core::hint::spin_loop();
    } else {
        cortex_m::asm::wfi();
    }
}
