//! The shaft's encoder on TIM4: the timer counts edges, forwards and backwards (RM0090, 18.3.12).

use monitor_core::units::RadPerSec;
use stm32f4xx_hal::pac;

use crate::scale;

/// Edges are not divided. QEMU's timer has no encoder mode and counts its own clock instead, 10^9 in a second; divided
/// by 65,536 that is 15 "edges" in a millisecond, a plausible speed of 23 rad/s.
const PRESCALER: u16 = if cfg!(feature = "emulated") { u16::MAX } else { 0 };

/// Counts the edges of the encoder.
pub struct Encoder {
    timer: pac::TIM4,
    before: u16,
    rate_hz: f32,
}

impl Encoder {
    /// Starts counting, to be read `rate_hz` times a second.
    #[must_use]
    pub fn start(timer: pac::TIM4, rate_hz: u32) -> Self {
        // Both channels are inputs, and each edge of both counts.
        timer.ccmr1_input().write(|w| w.cc1s().ti1().cc2s().ti2());
        timer.smcr().write(|w| w.sms().encoder_mode_3());
        timer.psc().write(|w| w.psc().set(PRESCALER));
        timer.arr().write(|w| w.arr().set(u16::MAX));
        timer.egr().write(|w| w.ug().set_bit());
        timer.cr1().modify(|_, w| w.cen().set_bit());
        Encoder { timer, before: 0, rate_hz: rate_hz as f32 }
    }

    /// Speed over the slot that ends now.
    pub fn speed(&mut self) -> RadPerSec {
        let now = self.timer.cnt().read().cnt().bits() as u16;
        let edges = now.wrapping_sub(self.before).cast_signed();
        self.before = now;
        scale::speed(edges, self.rate_hz)
    }
}
