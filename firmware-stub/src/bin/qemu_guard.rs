//! The emulated board in `guard` mode: reads a stream of slots from the host's file `mission.in`, judges each, writes what it
//! says to `mission.out`, and logs alarms and names.
//!
//! Slots are taken one after the other, without an interrupt: what is compared with the host is what the monitor says.

#![no_std]
#![no_main]

use cortex_m_rt::entry;
use firmware_stub::board::exchange::{Exchange, Refusal, leave_after};
use firmware_stub::board::qemu::Watchdog;
use firmware_stub::guarded::Guarded;
use firmware_stub::record::{Arrival, Kind};
use firmware_stub::settings::{guard_config, motor_constants};
use monitor_core::guard::Finding;

#[entry]
fn main() -> ! {
    leave_after(fly)
}

fn fly(watchdog: &mut Watchdog) -> Result<(), Refusal> {
    let exchange = Exchange::open()?;
    if exchange.header.kind != Kind::Mission {
        return Err(b"error: the stream is not one of slots\n\0");
    }
    let config = guard_config(exchange.header.config.sample_rate_hz);
    let mut guarded =
        Guarded::new(&config, motor_constants()).map_err(|_| &b"error: the monitor refuses its settings\n\0"[..])?;
    let mut log = Log::default();
    exchange.answer(|words| {
        watchdog.feed();
        let arrival = Arrival::from_words(words).ok_or(&b"error: a record of the stream is not a slot\n\0"[..])?;
        let answer = guarded.turn(&arrival);
        log.slot(&guarded, config.sample_rate_hz);
        Ok(answer)
    })
}

/// What has been logged.
#[derive(Default)]
struct Log {
    alarm: bool,
    named: bool,
}

impl Log {
    /// Logs what has changed with a slot.
    fn slot(&mut self, guarded: &Guarded, rate_hz: f32) {
        let verdict = guarded.guard().verdict();
        let seconds = verdict.sample() as f32 / rate_hz;
        if verdict.alarm() != self.alarm {
            self.alarm = verdict.alarm();
            self.named = false;
            defmt::println!("{=f32} s: alarm {=bool}, {}", seconds, self.alarm, verdict);
        }
        if let (false, Finding::Fault(found)) = (self.named, guarded.found()) {
            self.named = true;
            defmt::println!("{=f32} s: {}", seconds, found);
        }
    }
}
