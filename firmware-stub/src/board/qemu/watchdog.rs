//! The CMSDK's watchdog (DDI 0479, 4.5), a timer apart from the core: its first time-out is the non-maskable interrupt.

use crate::board::qemu::timer::TICKS_PER_SECOND;
use crate::board::register::Register;

const LOAD: Register = Register::at(0x4000_8000);
const CONTROL: Register = Register::at(0x4000_8008);
const INT_CLEAR: Register = Register::at(0x4000_800c);
const LOCK: Register = Register::at(0x4000_8c00);

/// Opens the lock; any other value closes it.
const KEY: u32 = 0x1acc_e551;

/// The watchdog, once it runs.
#[derive(Debug)]
pub struct Watchdog(());

impl Watchdog {
    /// Starts it: fed more rarely than every `ms` milliseconds, it stops the run.
    #[must_use]
    pub fn start(ms: u32) -> Self {
        LOCK.write(KEY);
        LOAD.write(TICKS_PER_SECOND / 1000 * ms);
        CONTROL.write(0b11); // interrupt and reset
        LOCK.write(0);
        Watchdog(())
    }

    /// Starts the time over.
    pub fn feed(&mut self) {
        LOCK.write(KEY);
        INT_CLEAR.write(1);
        LOCK.write(0);
    }
}
