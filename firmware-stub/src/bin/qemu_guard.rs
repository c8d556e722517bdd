//! The emulated board in `guard` mode: reads a stream of slots from the host's file `mission.in`, takes each through the
//! sampling interrupt, and writes what the monitor then knows to `mission.out`.
//!
//! Everything that computes is `monitor-core`; this is wiring.

#![no_std]
#![no_main]

use cortex_m_rt::{entry, exception};
use firmware_stub::Guarded;
use firmware_stub::board::exchange::{Exchange, Refusal, leave_after};
use firmware_stub::board::qemu::{Flight, Interrupt, Watchdog};
use firmware_stub::record::{Kind, guarded_to_words};
use firmware_stub::sampling::Notes;
use firmware_stub::settings::{guard_config, motor_constants};
use heapless::spsc::Queue;
use monitor_core::guard::Monitor;

static INTERRUPT: Interrupt<Guarded> = Interrupt::new();

#[entry]
fn main() -> ! {
    leave_after(fly)
}

/// Flies what the host sends.
fn fly(watchdog: &mut Watchdog) -> Result<(), Refusal> {
    let exchange = Exchange::open()?;
    if exchange.header.kind != Kind::Mission {
        return Err(b"error: the stream is not one of slots\n\0");
    }
    let refused = &b"error: the monitor refuses its settings\n\0"[..];
    let rate_hz = exchange.header.config.sample_rate_hz;
    let monitor = Monitor::new(&guard_config(rate_hz)).map_err(|_| refused)?;
    let queue = cortex_m::singleton!(: Notes<Guarded> = Queue::new()).ok_or(refused)?;
    let mut flight = Flight::new(&INTERRUPT, Guarded::new(monitor, motor_constants()), queue, rate_hz);
    exchange.answer(|words| {
        watchdog.feed();
        flight.turn(words, guarded_to_words)
    })
}

#[exception]
fn PendSV() {
    INTERRUPT.sample();
}
