//! The emulated board in `paper` mode: reads a stream of slots from the host's file `mission.in`, takes each through the
//! sampling interrupt, writes every verdict to `mission.out`, and leaves with the exit code 0 when all went well. It decomposes
//! matrices, too.
//!
//! Everything that computes is `monitor-core`; this is wiring.

#![no_std]
#![no_main]

use cortex_m_rt::{entry, exception};
use firmware_stub::Paper;
use firmware_stub::board::exchange::{Answered, Exchange, Refusal, leave_after};
use firmware_stub::board::qemu::{Flight, Interrupt, Watchdog};
use firmware_stub::record::{EIGEN_WORDS, Kind, MATRIX_WORDS, eigen_to_words, verdict_to_words};
use firmware_stub::sampling::Notes;
use heapless::spsc::Queue;
use monitor_core::paper::Monitor;

static INTERRUPT: Interrupt<Paper> = Interrupt::new();

#[entry]
fn main() -> ! {
    leave_after(fly)
}

/// Flies what the host sends.
fn fly(watchdog: &mut Watchdog) -> Result<(), Refusal> {
    let exchange = Exchange::open()?;
    match exchange.header.kind {
        Kind::Mission => {
            let refused = &b"error: the monitor refuses its settings\n\0"[..];
            let config = exchange.header.config;
            let paper = Paper::new(Monitor::new(&config).map_err(|_| refused)?);
            let queue = cortex_m::singleton!(: Notes<Paper> = Queue::new()).ok_or(refused)?;
            let mut flight = Flight::new(&INTERRUPT, paper, queue, config.sample_rate_hz);
            exchange.answer(|words| {
                watchdog.feed();
                flight.turn(words, |paper| verdict_to_words(paper.monitor().verdict()))
            })
        }
        Kind::Matrices => exchange.answer(|words: [u32; MATRIX_WORDS]| -> Answered<EIGEN_WORDS> {
            watchdog.feed();
            Ok(eigen_to_words(words))
        }),
    }
}

#[exception]
fn PendSV() {
    INTERRUPT.sample();
}
