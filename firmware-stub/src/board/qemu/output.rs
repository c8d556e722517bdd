//! The fault output: the first user LED of the board's FPGA. Lit means fault, which is safe.

use crate::board::register::Register;

/// FPGAIO_LED0 (DAI 0386, 4.4): bit 0 is the first user LED.
const LEDS: Register = Register::at(0x4002_8000);

/// The fault output.
#[derive(Debug)]
pub struct FaultOutput(());

impl FaultOutput {
    /// Takes hold of the output, safe until the first verdict.
    #[must_use]
    pub fn safe() -> Self {
        make_safe();
        FaultOutput(())
    }

    /// Tells the motor controller whether there is a fault.
    pub fn set(&mut self, fault: bool) {
        LEDS.write(u32::from(fault));
    }
}

/// What a handler does first, whoever holds the output.
pub(super) fn make_safe() {
    LEDS.write(1);
}

/// Whether the output really stands at safe.
pub(super) fn is_safe() -> bool {
    LEDS.read() & 1 == 1
}
