//! The sampling timer TIM2 and the free-running clock TIM5, both of 32 bits, both in microseconds.

use stm32f4xx_hal::pac;

use super::clocks::TIMER_HZ;

/// Both count microseconds.
pub const TICKS_PER_SECOND: u32 = 1_000_000;

/// What divides the timers' clock down to it.
const PRESCALER: u16 = (TIMER_HZ / TICKS_PER_SECOND - 1) as u16;

/// A clock that runs freely.
pub struct Clock(pac::TIM5);

impl Clock {
    /// Starts it.
    #[must_use]
    pub fn start(timer: pac::TIM5) -> Self {
        timer.psc().write(|w| w.psc().set(PRESCALER));
        timer.arr().write(|w| w.arr().set(u32::MAX));
        // An update event takes the prescaler over.
        timer.egr().write(|w| w.ug().set_bit());
        timer.cr1().modify(|_, w| w.cen().set_bit());
        Clock(timer)
    }

    /// Microseconds since the start, modulo 2^32.
    #[must_use]
    pub fn now(&self) -> u32 {
        self.0.cnt().read().cnt().bits()
    }
}

/// The sampling timer: an update interrupt at a fixed rate.
pub struct SamplingTimer(pac::TIM2);

impl SamplingTimer {
    /// Ticks in one slot at a rate.
    #[must_use]
    pub const fn period(rate_hz: u32) -> u32 {
        TICKS_PER_SECOND.div_euclid(if rate_hz == 0 { 1 } else { rate_hz })
    }

    /// Starts it.
    #[must_use]
    pub fn start(timer: pac::TIM2, rate_hz: u32) -> Self {
        timer.psc().write(|w| w.psc().set(PRESCALER));
        timer.arr().write(|w| w.arr().set(Self::period(rate_hz) - 1));
        timer.egr().write(|w| w.ug().set_bit());
        timer.sr().modify(|_, w| w.uif().clear());
        timer.dier().modify(|_, w| w.uie().enabled());
        timer.cr1().modify(|_, w| w.cen().set_bit());
        SamplingTimer(timer)
    }

    /// Takes note that the interrupt has come.
    pub fn acknowledge(&mut self) {
        self.0.sr().modify(|_, w| w.uif().clear());
    }
}
