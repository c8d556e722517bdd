//! `guard` mode by itself: each of its calls as a function of its own, and the sizes of what it keeps. Nothing runs this
//! image; the audits read from it how much flash, memory and stack that mode takes on the target.

#![no_std]
#![no_main]
#![allow(unsafe_code)] // Names that the audits look for are not mangled; each is the only one of its kind.

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use firmware_stub::kernels::guard::directions;
use monitor_core::guard::{Config, ConfigError, Directions, Finding, Model, Monitor, Verdict, Window};
use monitor_core::moments::LearnError;
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
    SIZE_OF_GUARD: Monitor;
    SIZE_OF_GUARD_WINDOW: Window;
    SIZE_OF_GUARD_MODEL: Model;
    SIZE_OF_GUARD_VERDICT: Verdict;
    SIZE_OF_GUARD_CONFIG: Config;
    SIZE_OF_GUARD_DIRECTIONS: Directions;
}

/// Set-up.
#[unsafe(no_mangle)]
#[inline(never)]
fn guard_new(config: &Config, guard: &mut Option<Monitor>) -> Option<ConfigError> {
    match Monitor::new(config) {
        Ok(made) => {
            *guard = Some(made);
            None
        }
        Err(error) => Some(error),
    }
}

/// The sampling interrupt's call.
#[unsafe(no_mangle)]
#[inline(never)]
fn guard_step(guard: &mut Monitor, set_point: f32, x: [f32; 3]) -> &Verdict {
    guard.step_channels(set_point, x)
}

/// The sampling interrupt's call without a sample.
#[unsafe(no_mangle)]
#[inline(never)]
fn guard_skip(guard: &mut Monitor, why: Absence) -> &Verdict {
    guard.skip(why)
}

/// The end of a learning window, outside the interrupt.
#[unsafe(no_mangle)]
#[inline(never)]
fn guard_finish_learning(guard: &mut Monitor) -> Result<bool, LearnError> {
    guard.finish_learning()
}

/// What is asked for on demand.
#[unsafe(no_mangle)]
#[inline(never)]
fn guard_finding(guard: &Monitor, directions: &Directions) -> Finding {
    guard.finding(directions)
}

/// Calls everything once, so that the linker keeps it.
#[entry]
fn main() -> ! {
    keep_sizes();
    let mut guard = None;
    black_box(guard_new(&black_box(Config::at_rate(1000.0)), &mut guard));
    if let Some(guard) = &mut guard {
        black_box(guard_step(guard, black_box(1.0), black_box([1.0; 3])));
        black_box(guard_skip(guard, black_box(Absence::Late)));
        let _ = black_box(guard_finish_learning(guard));
        black_box(guard_finding(guard, &black_box(directions())));
    }
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}
