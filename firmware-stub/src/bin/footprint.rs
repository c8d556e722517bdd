//! The core by itself: each of its calls as a function of its own, and the sizes of what it keeps. Nothing runs this
//! image; the audits read from it how much flash, memory and stack the core takes on the target.

#![no_std]
#![no_main]
#![allow(unsafe_code)] // Names that the audits look for are not mangled; each is the only one of its kind.

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use monitor_core::low_pass::{LowPass, LowPassState};
use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::monitor::ConfigError;
use monitor_core::paper::{Baseline, Config, EventLog, Monitor, Verdict};
use monitor_core::sample::Absence;

/// Words in flash that tell the size of a type in bytes.
macro_rules! sizes {
    ($($name:ident: $type:ty;)*) => {
        $(
            #[doc = concat!("Bytes of `", stringify!($type), "`.")]
            #[unsafe(no_mangle)]
            static $name: usize = size_of::<$type>();
        )*

        /// Makes the linker keep them.
        fn keep_sizes() {
            $(black_box(&$name);)*
        }
    };
}

sizes! {
    SIZE_OF_MONITOR: Monitor;
    SIZE_OF_LEARNING_WINDOW: Moments<3>;
    SIZE_OF_BASELINE: Baseline;
    SIZE_OF_FILTER_DESIGN: LowPass;
    SIZE_OF_FILTER_STATE: LowPassState;
    SIZE_OF_VERDICT: Verdict;
    SIZE_OF_CONFIG: Config;
    SIZE_OF_EVENT_LOG_OF_16: EventLog<16>;
}

/// Set-up.
#[unsafe(no_mangle)]
#[inline(never)]
fn core_new(config: &Config, monitor: &mut Option<Monitor>) -> Option<ConfigError> {
    match Monitor::new(config) {
        Ok(made) => {
            *monitor = Some(made);
            None
        }
        Err(error) => Some(error),
    }
}

/// The sampling interrupt's call.
#[unsafe(no_mangle)]
#[inline(never)]
fn core_step(monitor: &mut Monitor, set_point: f32, x: [f32; 3]) -> &Verdict {
    monitor.step_channels(set_point, x)
}

/// The sampling interrupt's call without a sample.
#[unsafe(no_mangle)]
#[inline(never)]
fn core_skip(monitor: &mut Monitor, why: Absence) -> &Verdict {
    monitor.skip(why)
}

/// The end of a learning window, outside the interrupt.
#[unsafe(no_mangle)]
#[inline(never)]
fn core_finish_learning(monitor: &mut Monitor) -> Result<bool, LearnError> {
    monitor.finish_learning()
}

/// What is asked for on demand.
#[unsafe(no_mangle)]
#[inline(never)]
fn core_contributions(monitor: &Monitor, x: [f32; 3]) -> Option<[f32; 3]> {
    monitor.contributions(x)
}

/// Events of a verdict.
#[unsafe(no_mangle)]
#[inline(never)]
fn core_observe(log: &mut EventLog<16>, verdict: &Verdict) {
    log.observe(verdict);
}

/// Calls everything once, so that the linker keeps it.
#[entry]
fn main() -> ! {
    keep_sizes();
    let thresholds = black_box(monitor_core::sample::Bank::from_fn(|_| 1.0));
    let (mut monitor, mut log) = (None, EventLog::default());
    black_box(core_new(&black_box(Config::paper(1000.0, thresholds)), &mut monitor));
    if let Some(monitor) = &mut monitor {
        let x = black_box([1.0; 3]);
        core_observe(&mut log, black_box(core_step(monitor, black_box(1.0), x)));
        black_box(core_skip(monitor, black_box(Absence::Late)));
        let _ = black_box(core_finish_learning(monitor));
        black_box(core_contributions(monitor, x));
    }
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}
