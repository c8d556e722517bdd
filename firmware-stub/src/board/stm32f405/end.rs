//! What ends a run: the output is made safe, the reason kept across the reset that follows, and logged by the next run.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use stm32f4xx_hal::pac;

use super::output;
use crate::fault::Reason;

/// A word of RAM that start-up leaves as it is.
struct Kept(UnsafeCell<MaybeUninit<u32>>);

// SAFETY: written only when interrupts are off for good, read only before they are on.
#[allow(unsafe_code)]
unsafe impl Sync for Kept {}

#[allow(unsafe_code)] // The section is one that start-up does not touch (cortex-m-rt, "uninitialized static variables").
#[unsafe(link_section = ".uninit.REASON")]
static REASON: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

/// Ends the run: output to safe, then a reset. In emulation: the reason on the host's console, and an exit code that is
/// not zero.
pub fn stop(reason: Reason) -> ! {
    cortex_m::interrupt::disable();
    output::make_safe();
    keep(reason.to_word());
    #[cfg(feature = "emulated")]
    {
        crate::board::host::say(reason.line());
        crate::board::host::leave(false)
    }
    #[cfg(not(feature = "emulated"))]
    cortex_m::peripheral::SCB::sys_reset()
}

/// Why the last run ended, if it did not end with the power: a handler's reason, or the watchdog's. Asked once, it is
/// forgotten.
pub fn last_reason(rcc: &pac::RCC) -> Option<Reason> {
    let watchdog = rcc.csr().read().wdgrstf().is_reset();
    rcc.csr().modify(|_, w| w.rmvf().clear());
    // SAFETY: any bits are a number, and volatile keeps the compiler from deciding which.
    #[allow(unsafe_code)]
    let word = unsafe { REASON.0.get().cast::<u32>().read_volatile() };
    keep(0);
    Reason::from_word(word).or(watchdog.then_some(Reason::Watchdog))
}

fn keep(word: u32) {
    // SAFETY: nothing else runs, see `Kept`.
    #[allow(unsafe_code)]
    unsafe {
        REASON.0.get().cast::<u32>().write_volatile(word);
    }
}
