//! Two timers of the CMSDK (DDI 0479, 4.3): a sampling timer, the core's own SysTick, and a free-running clock beside it.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

use crate::board::register::Register;

/// Both count the system clock: 25 MHz on these boards.
pub const TICKS_PER_SECOND: u32 = 25_000_000;

const CTRL: Register = Register::at(0x4000_1000);
const VALUE: Register = Register::at(0x4000_1004);
const RELOAD: Register = Register::at(0x4000_1008);

/// A clock that runs freely: timer 1, which counts down through all 32 bits.
#[derive(Clone, Copy, Debug)]
pub struct Clock(());

impl Clock {
    /// Starts it.
    #[must_use]
    pub fn start() -> Self {
        RELOAD.write(u32::MAX);
        VALUE.write(u32::MAX);
        CTRL.write(1);
        Clock(())
    }

    /// Ticks since the start, modulo 2^32.
    #[must_use]
    pub fn now(self) -> u32 {
        u32::MAX - VALUE.read()
    }
}

/// The sampling timer: SysTick's exception at a fixed rate.
#[derive(Debug)]
pub struct SamplingTimer(());

impl SamplingTimer {
    /// Ticks in one slot at a rate; SysTick counts at most 2^24.
    #[must_use]
    pub const fn period(rate_hz: u32) -> u32 {
        let period = TICKS_PER_SECOND.div_euclid(if rate_hz == 0 { 1 } else { rate_hz });
        if period > 1 << 24 { 1 << 24 } else { period }
    }

    /// Starts it.
    pub fn start(mut systick: SYST, rate_hz: u32) -> Self {
        systick.set_clock_source(SystClkSource::Core);
        systick.set_reload(Self::period(rate_hz) - 1);
        systick.clear_current();
        systick.enable_interrupt();
        systick.enable_counter();
        SamplingTimer(())
    }
}
