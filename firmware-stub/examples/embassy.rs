//! The monitor under embassy: SysTick samples and signals, an async task waits for the signal and does the rest. No chip
//! HAL, so that it runs on the emulated board; leaves with exit code 0 once the fault is named.

#![no_std]
#![no_main]
#![allow(unsafe_code)] // What `embassy_executor::main` writes has some.

use core::cell::RefCell;

use cortex_m_rt::exception;
use embassy_executor::Spawner;
use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embassy_sync::signal::Signal;
use firmware_stub::background::Background;
use firmware_stub::board::qemu::{Clock, FaultOutput, SamplingTimer, Watchdog};
use firmware_stub::board::{self, host};
use firmware_stub::deadline::Deadline;
use firmware_stub::fault::Reason;
use firmware_stub::report::Report;
use firmware_stub::sampling::{Notes, Sampling};
use firmware_stub::{Guarded, Shared};
use heapless::spsc::Queue;

mod common;

/// What the interrupt owns.
struct Interrupt {
    sampling: Sampling<'static, Guarded>,
    deadline: Deadline,
    clock: Clock,
    output: FaultOutput,
    /// The emulated sensor's slot.
    slot: u32,
}

static INTERRUPT: Mutex<CriticalSectionRawMutex, RefCell<Option<Interrupt>>> = Mutex::new(RefCell::new(None));
/// Raised in every slot.
static SAMPLED: Signal<CriticalSectionRawMutex, ()> = Signal::new();

#[exception]
fn SysTick() {
    INTERRUPT.lock(|own| {
        if let Ok(Some(own)) = own.try_borrow_mut().as_deref_mut() {
            own.sample();
        }
    });
    SAMPLED.signal(());
}

impl Interrupt {
    fn sample(&mut self) {
        let Interrupt { sampling, deadline, clock, output, slot: k } = self;
        let slot = deadline.enter(clock.now());
        sampling.on_interrupt(slot, common::SET_POINT, || common::reading(*k), |fault| output.set(fault));
        *k += slot.lost + 1;
        if deadline.overrun(clock.now()) {
            sampling.overran();
        }
    }
}

/// The task's access.
struct Locked;

impl Shared<'static, Guarded> for Locked {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'static, Guarded>) -> R) -> R {
        INTERRUPT.lock(|own| match own.try_borrow_mut().as_deref_mut() {
            Ok(Some(own)) => f(&mut own.sampling),
            _ => board::stop(Reason::Settings),
        })
    }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let queue = cortex_m::singleton!(: Notes<Guarded> = Queue::new());
    let (Some(core), Some(notes), Ok(monitor)) = (cortex_m::Peripherals::take(), queue, common::guarded()) else {
        board::stop(Reason::Settings)
    };
    let (notes, heard) = notes.split();
    let period = SamplingTimer::period(common::RATE_HZ);
    let own = Interrupt {
        sampling: Sampling::new(monitor, notes),
        deadline: Deadline::new(period, period / 2),
        clock: Clock::start(),
        output: FaultOutput::safe(),
        slot: 0,
    };
    INTERRUPT.lock(|place| place.replace(Some(own)));
    let mut background = Background::new(heard);
    let report = Report::<Guarded>::new(common::RATE_HZ);
    let mut watchdog = Watchdog::start(common::WATCHDOG_MS);
    let _timer = SamplingTimer::start(core.SYST, common::RATE_HZ);
    let mut named = false;
    while Locked.with(|sampling| sampling.slots()) < u64::from(common::SLOTS) {
        SAMPLED.wait().await;
        background.learn(&mut Locked);
        while let Some(note) = background.next_note() {
            report.note(note);
        }
        if let Some(name) = background.name(&mut Locked) {
            named |= common::is_the_fault(&name);
            report.named(&name);
        }
        if background.sampling_is_alive(&mut Locked) {
            watchdog.feed();
        }
    }
    host::leave(named)
}
