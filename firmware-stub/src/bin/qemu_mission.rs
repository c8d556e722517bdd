//! The emulated board: reads a stream of slots from the host's file `mission.in`, takes each through the sampling
//! interrupt, writes every verdict to `mission.out`, and leaves with the exit code 0 when all went well.
//!
//! Everything that computes is `monitor-core`; this is wiring. The sampling interrupt is PendSV, pended once for each
//! record of the stream; it judges at once, since its priority is above the main loop's.

#![no_std]
#![no_main]

use core::cell::{Cell, RefCell};

use cortex_m::peripheral::SCB;
use cortex_m_rt::{entry, exception};
use critical_section::Mutex;
use firmware_stub::background::{Background, Shared};
use firmware_stub::board;
use firmware_stub::board::exchange::{Answered, Exchange, Refusal, leave_after};
use firmware_stub::board::qemu::{FaultOutput, Watchdog};
use firmware_stub::deadline::Slot;
use firmware_stub::fault::Reason;
use firmware_stub::record::{
    Arrival, EIGEN_WORDS, Kind, MATRIX_WORDS, SLOT_WORDS, VERDICT_WORDS, eigen_to_words, verdict_to_words,
};
use firmware_stub::report::Report;
use firmware_stub::sampling::{Notes, Sampling};
use monitor_core::paper::{Config, Monitor, Verdict};

/// What the interrupt owns: its state, and the output it drives.
static INTERRUPT: Mutex<RefCell<Option<(Sampling<'static>, FaultOutput)>>> = Mutex::new(RefCell::new(None));
/// What the host sent for the slot that is due.
static ARRIVAL: Mutex<Cell<Option<Arrival>>> = Mutex::new(Cell::new(None));
/// What the interrupt made of it.
static VERDICT: Mutex<Cell<Option<Verdict>>> = Mutex::new(Cell::new(None));

#[entry]
fn main() -> ! {
    leave_after(fly)
}

/// Flies what the host sends.
fn fly(watchdog: &mut Watchdog) -> Result<(), Refusal> {
    let exchange = Exchange::open()?;
    match exchange.header.kind {
        Kind::Mission => {
            let mut loop_ = MainLoop::new(&exchange.header.config)?;
            exchange.answer(|words: [u32; SLOT_WORDS]| {
                watchdog.feed();
                loop_.turn(words)
            })
        }
        Kind::Matrices => exchange.answer(|words: [u32; MATRIX_WORDS]| -> Answered<EIGEN_WORDS> {
            watchdog.feed();
            Ok(eigen_to_words(words))
        }),
    }
}

/// The main loop of a mission.
struct MainLoop {
    background: Background<'static>,
    report: Report,
}

impl MainLoop {
    fn new(config: &Config) -> Result<Self, Refusal> {
        let refused = &b"error: the monitor refuses its settings\n\0"[..];
        let monitor = Monitor::new(config).map_err(|_| refused)?;
        let queue = cortex_m::singleton!(: Notes = Notes::new()).ok_or(refused)?;
        let (notes, heard) = queue.split();
        let owned = (Sampling::new(monitor, notes), FaultOutput::safe());
        critical_section::with(|cs| INTERRUPT.borrow(cs).replace(Some(owned)));
        Ok(MainLoop { background: Background::new(heard, config.explained_share), report: Report::new(config) })
    }

    /// One slot: the interrupt judges it, the rest is done at leisure.
    fn turn(&mut self, words: [u32; SLOT_WORDS]) -> Answered<VERDICT_WORDS> {
        let arrival = Arrival::from_words(words).ok_or(&b"error: a record of the stream is not a slot\n\0"[..])?;
        critical_section::with(|cs| ARRIVAL.borrow(cs).set(Some(arrival)));
        SCB::set_pendsv();
        cortex_m::asm::isb();
        let verdict = critical_section::with(|cs| VERDICT.borrow(cs).take());
        let verdict = verdict.ok_or(&b"error: the sampling interrupt did not come\n\0"[..])?;
        if let Some(learned) = self.background.learn(&mut Locked) {
            self.report.learned(learned, self.background.in_vain());
        }
        while let Some(note) = self.background.next_note() {
            self.report.note(note);
        }
        if let Some(request) = arrival.request {
            self.report.answer(self.background.answer(request, &mut Locked));
        }
        Ok(verdict_to_words(&verdict))
    }
}

/// The interrupt's state, with the interrupt held off.
struct Locked;

impl Shared<'static> for Locked {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'static>) -> R) -> R {
        critical_section::with(|cs| match INTERRUPT.borrow(cs).try_borrow_mut().as_deref_mut() {
            Ok(Some((sampling, _))) => f(sampling),
            _ => board::stop(Reason::Settings),
        })
    }
}

/// The sampling interrupt.
#[exception]
fn PendSV() {
    critical_section::with(|cs| {
        let (Ok(mut owned), Some(arrival)) = (INTERRUPT.borrow(cs).try_borrow_mut(), ARRIVAL.borrow(cs).take()) else {
            return;
        };
        let Some((sampling, output)) = owned.as_mut() else { return };
        let read = || arrival.reading;
        let verdict = sampling.on_interrupt(Slot::default(), arrival.set_point, read, |fault| output.set(fault));
        VERDICT.borrow(cs).set(Some(*verdict));
    });
}
