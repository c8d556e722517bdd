//! The fault output: PB0 high means healthy, PB1 high means fault.

use stm32f4xx_hal::gpio::{Output, PB0, PB1};
use stm32f4xx_hal::pac;

/// The two lines, as outputs.
pub struct FaultOutput {
    healthy: PB0<Output>,
    lamp: PB1<Output>,
}

impl FaultOutput {
    /// Takes hold of the lines, safe until the first verdict.
    #[must_use]
    pub fn safe(healthy: PB0, lamp: PB1) -> Self {
        make_safe();
        FaultOutput { healthy: healthy.into_push_pull_output(), lamp: lamp.into_push_pull_output() }
    }

    /// Tells the motor controller whether there is a fault.
    pub fn set(&mut self, fault: bool) {
        self.healthy.set_state((!fault).into());
        self.lamp.set_state(fault.into());
    }
}

/// What a handler does first, whoever holds the lines.
pub(super) fn make_safe() {
    // SAFETY: the register sets and resets bits at once, so nobody else's change is lost.
    #[allow(unsafe_code)]
    let port = unsafe { &*pac::GPIOB::ptr() };
    port.bsrr().write(|w| w.br0().reset().bs1().set_());
}
