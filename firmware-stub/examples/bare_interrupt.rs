//! The monitor in a bare interrupt: SysTick samples, a critical section guards what it owns, the main loop does the rest.
//! Runs on the emulated board, and leaves with exit code 0 once the fault is named.
//!
//! The file `stall.in`, if the host has one, holds pairs of words (a slot, and how many microseconds the interrupt is held
//! up in it), so that overruns can be seen.

#![no_std]
#![no_main]

use core::cell::RefCell;

use cortex_m_rt::{entry, exception};
use critical_section::Mutex;
use firmware_stub::background::Background;
use firmware_stub::board::host::{self, HostFile};
use firmware_stub::board::qemu::{Clock, FaultOutput, SamplingTimer, TICKS_PER_SECOND, Watchdog};
use firmware_stub::board::{self};
use firmware_stub::deadline::Deadline;
use firmware_stub::fault::Reason;
use firmware_stub::report::Report;
use firmware_stub::request::Request;
use firmware_stub::sampling::{Notes, Sampling};
use firmware_stub::{Guarded, Shared};
use heapless::spsc::Queue;

mod common;

/// Stalls that the host can ask for.
const STALLS: usize = 8;

/// What the interrupt owns.
struct Interrupt {
    sampling: Sampling<'static, Guarded>,
    deadline: Deadline,
    clock: Clock,
    output: FaultOutput,
    /// The emulated sensor's slot.
    slot: u32,
    stalls: [[u32; 2]; STALLS],
}

static INTERRUPT: Mutex<RefCell<Option<Interrupt>>> = Mutex::new(RefCell::new(None));

#[exception]
fn SysTick() {
    critical_section::with(|cs| {
        if let Ok(Some(own)) = INTERRUPT.borrow(cs).try_borrow_mut().as_deref_mut() {
            own.sample();
        }
    });
}

impl Interrupt {
    fn sample(&mut self) {
        let Interrupt { sampling, deadline, clock, output, .. } = self;
        let slot = deadline.enter(clock.now());
        self.slot += slot.lost + 1;
        let k = self.slot - 1;
        sampling.on_interrupt(slot, common::SET_POINT, || common::reading(k), |fault| output.set(fault));
        if let Some([_, us]) = self.stalls.iter().find(|[slot, _]| *slot == k && *slot > 0) {
            stall(*clock, *us);
        }
        if deadline.overrun(clock.now()) {
            sampling.overran();
        }
    }
}

/// Holds the interrupt up.
fn stall(clock: Clock, us: u32) {
    let begun = clock.now();
    while clock.now().wrapping_sub(begun) < us * (TICKS_PER_SECOND / 1_000_000) {}
}

/// The main loop's access.
struct Locked;

impl Shared<'static, Guarded> for Locked {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'static, Guarded>) -> R) -> R {
        critical_section::with(|cs| match INTERRUPT.borrow(cs).try_borrow_mut().as_deref_mut() {
            Ok(Some(own)) => f(&mut own.sampling),
            _ => board::stop(Reason::Settings),
        })
    }
}

#[entry]
fn main() -> ! {
    let queue = cortex_m::singleton!(: Notes<Guarded> = Queue::new());
    let (Some(core), Some(notes), Ok(monitor)) = (cortex_m::Peripherals::take(), queue, common::guarded()) else {
        board::stop(Reason::Settings)
    };
    let (notes, heard) = notes.split();
    let mut stalls = [[0; 2]; STALLS];
    if let Some(file) = HostFile::to_read(b"stall.in\0") {
        file.read(stalls.as_flattened_mut());
    }
    let period = SamplingTimer::period(common::RATE_HZ);
    let own = Interrupt {
        sampling: Sampling::new(monitor, notes),
        deadline: Deadline::new(period, period / 2),
        clock: Clock::start(),
        output: FaultOutput::safe(),
        slot: 0,
        stalls,
    };
    critical_section::with(|cs| INTERRUPT.borrow(cs).replace(Some(own)));
    let mut background = Background::new(heard);
    let report = Report::<Guarded>::new(common::RATE_HZ);
    let mut watchdog = Watchdog::start(common::WATCHDOG_MS);
    let _timer = SamplingTimer::start(core.SYST, common::RATE_HZ);
    let mut named = false;
    while Locked.with(|sampling| sampling.slots()) < u64::from(common::SLOTS) {
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
        board::wait();
    }
    report.answer(&background.answer(Request::Statistics, &mut Locked));
    host::leave(named)
}
