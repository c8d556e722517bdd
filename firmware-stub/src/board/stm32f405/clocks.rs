//! The clock tree: 16 MHz from the internal oscillator, as reset leaves it, or with the feature `pll` 168 MHz.

use stm32f4xx_hal::pac;

/// Clock of the timers on APB1, Hz. QEMU's timers count nanoseconds of its own clock.
pub(super) const TIMER_HZ: u32 = if cfg!(feature = "emulated") {
    1_000_000_000
} else if cfg!(feature = "pll") {
    84_000_000
} else {
    16_000_000
};

/// Clock of the peripherals on APB1, Hz.
pub(super) const APB1_HZ: u32 = if cfg!(feature = "pll") { 42_000_000 } else { 16_000_000 };

/// Starts the clocks of the core, then those of the peripherals that this board uses.
pub fn start(rcc: &pac::RCC, flash: &pac::FLASH) {
    if cfg!(feature = "pll") {
        start_pll(rcc, flash);
    }
    rcc.apb1enr().modify(|_, w| w.tim2en().enabled().tim4en().enabled().tim5en().enabled().usart3en().enabled());
    rcc.apb2enr().modify(|_, w| w.adc1en().enabled());
    rcc.ahb1enr().modify(|_, w| w.gpioben().enabled().gpiocen().enabled());
}

/// 8 MHz crystal / 8 * 336 / 2 = 168 MHz; APB1 a quarter of it, APB2 half (RM0090, 7.2; 3.5.1 for the wait states).
///
/// Waits for the crystal for as long as that takes. Without one the core stays here, its output safe, since pins are set
/// up later and float until then.
fn start_pll(rcc: &pac::RCC, flash: &pac::FLASH) {
    rcc.cr().modify(|_, w| w.hseon().on());
    while rcc.cr().read().hserdy().is_not_ready() {}
    flash.acr().modify(|_, w| w.latency().ws5().icen().enabled().dcen().enabled().prften().enabled());
    rcc.pllcfgr().modify(|_, w| {
        let w = w.pllsrc().hse().pllp().div2();
        // SAFETY: the fields take 2 to 63 and 50 to 432.
        #[allow(unsafe_code)]
        unsafe {
            w.pllm().bits(8).plln().bits(336)
        }
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    while rcc.cr().read().pllrdy().is_not_ready() {}
    rcc.cfgr().modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    while !rcc.cfgr().read().sws().is_pll() {}
}
