//! The serial line for requests: USART3 on PB10 and PB11, receiving only; answers go to the log.

use stm32f4xx_hal::pac;

use super::clocks::APB1_HZ;

/// Bits in a second.
const BAUD: u32 = 115_200;

/// The line.
pub struct SerialLine(pac::USART3);

impl SerialLine {
    /// Starts to receive; each byte raises the interrupt.
    #[must_use]
    pub fn start(usart: pac::USART3) -> Self {
        // Sixteenths of the divider (RM0090, 30.3.4), rounded: APB1 over the baud rate. At 16 MHz 139, 0.1 % slow.
        let divider = ((APB1_HZ + BAUD / 2) / BAUD) as u16;
        // SAFETY: any divider of 16 bits is a baud rate.
        #[allow(unsafe_code)]
        usart.brr().write(|w| unsafe { w.bits(divider) });
        usart.cr1().write(|w| w.ue().enabled().re().enabled().rxneie().enabled());
        SerialLine(usart)
    }

    /// The byte that has come, if one has. Reading it also clears an overrun of the line.
    pub fn byte(&mut self) -> Option<u8> {
        let status = self.0.sr().read();
        let byte = self.0.dr().read().dr().bits() as u8;
        status.rxne().bit_is_set().then_some(byte)
    }
}
