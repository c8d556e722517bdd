//! What ends a run: the output is made safe, the reason said, the exit code is not zero.

use cortex_m_rt::exception;

use super::output;
use crate::board::host;
use crate::fault::Reason;

/// Ends the run: output to safe, reason on the host's console, an exit code that is not zero.
pub fn stop(reason: Reason) -> ! {
    cortex_m::interrupt::disable();
    output::make_safe();
    host::say(if output::is_safe() { reason.line() } else { b"error: the fault output does not obey\n\0" });
    host::leave(false)
}

/// The watchdog's first time-out.
#[allow(unsafe_code)] // The attribute declares the handler unsafe: it may interrupt anything.
#[exception]
unsafe fn NonMaskableInt() {
    stop(Reason::Watchdog)
}
