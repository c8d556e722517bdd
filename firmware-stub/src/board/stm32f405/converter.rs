//! The converter ADC1: armature current and armature voltage, one after the other (RM0090, 13).

use monitor_core::units::{Amperes, Volts};
use stm32f4xx_hal::pac;

use crate::scale;

/// Inputs 10 and 11: PC0 and PC1.
const CURRENT: u8 = 10;
const VOLTAGE: u8 = 11;

/// Looks at the end-of-conversion flag before the converter counts as dead. A conversion takes 15 + 12 cycles of at
/// most 1/8 us, so 3.4 us; each look takes several cycles of the core, so even at 168 MHz this is more.
const LOOKS: u32 = 1000;

/// The converter.
pub struct Converter(pac::ADC1);

impl Converter {
    /// Switches it on: clock APB2 / 4, 12 bits, 15 cycles of sampling time. It wants 3 us before the first conversion,
    /// which the first slot of the sampling timer gives.
    #[must_use]
    pub fn start(converter: pac::ADC1, common: &pac::ADC_COMMON) -> Self {
        common.ccr().modify(|_, w| w.adcpre().div4());
        converter.smpr1().modify(|_, w| w.smp10().cycles15().smp11().cycles15());
        converter.cr2().modify(|_, w| w.adon().enabled());
        Converter(converter)
    }

    /// Armature current and voltage; none when the converter does not answer.
    pub fn read(&mut self) -> Option<(Amperes, Volts)> {
        let (current, voltage) = (self.code(CURRENT)?, self.code(VOLTAGE)?);
        Some((scale::current(current), scale::voltage(voltage)))
    }

    fn code(&mut self, input: u8) -> Option<u16> {
        // SAFETY: inputs 0 to 18 exist.
        #[allow(unsafe_code)]
        self.0.sqr3().write(|w| unsafe { w.sq1().bits(input) });
        self.0.cr2().modify(|_, w| w.swstart().start());
        // QEMU's converter has no such flag: its code is there at once.
        let done = || cfg!(feature = "emulated") || self.0.sr().read().eoc().is_complete();
        (0..LOOKS).any(|_| done()).then(|| self.0.dr().read().data().bits())
    }
}
