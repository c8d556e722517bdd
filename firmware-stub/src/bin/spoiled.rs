//! Everything that the firmware must not hold, each in a function of its own: the proof that the audits find it. This
//! image is never flown.

#![no_std]
#![no_main]
// Names that the audits look for are not mangled, an allocator is unsafe by nature, and this file is the place for all
// that is denied elsewhere.
#![allow(unsafe_code, clippy::indexing_slicing)]

extern crate alloc;

use alloc::boxed::Box;
use core::alloc::{GlobalAlloc, Layout};
use core::fmt::Write;
use core::hint::black_box;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicUsize, Ordering};

use cortex_m_rt::entry;
use monitor_core::paper::{Monitor, Verdict};

/// Nothing is wrong with this one: the step that the others spoil.
#[unsafe(no_mangle)]
#[inline(never)]
fn sound(monitor: &mut Monitor, x: [f32; 3]) -> &Verdict {
    monitor.step_channels(300.0, x)
}

/// An index that may be out of bounds.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_panic(monitor: &mut Monitor, x: [f32; 3]) -> f32 {
    let sample = sound(monitor, x).sample();
    x[black_box(sample as usize)]
}

/// Double precision.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_soft_double(monitor: &mut Monitor, x: [f32; 3]) -> f32 {
    let _ = black_box(sound(monitor, x));
    (f64::from(x[0]) * f64::from(x[1]) + f64::from(x[2])) as f32
}

/// A function that calls itself around another one.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_recursion(monitor: &mut Monitor, x: [f32; 3], depth: u32) -> u32 {
    let _ = black_box(sound(monitor, x));
    if depth == 0 { 0 } else { 1 + black_box(again(monitor, x, depth)) }
}

#[unsafe(no_mangle)]
#[inline(never)]
fn again(monitor: &mut Monitor, x: [f32; 3], depth: u32) -> u32 {
    1 + black_box(spoiled_by_recursion(monitor, x, depth - 1))
}

/// A kilobyte more on the stack.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_stack(monitor: &mut Monitor, x: [f32; 3]) -> &Verdict {
    let kilobyte = black_box([0_u8; 1024]);
    let verdict = sound(monitor, x);
    black_box(&kilobyte);
    verdict
}

/// Text formatting.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_formatting(monitor: &mut Monitor, x: [f32; 3]) -> bool {
    let verdict = sound(monitor, x);
    write!(Sink(0), "{}", verdict.sample()).is_ok()
}

/// Memory from a heap.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_heap(monitor: &mut Monitor, x: [f32; 3]) -> Box<Verdict> {
    Box::new(*sound(monitor, x))
}

/// A call of what a pointer holds.
#[unsafe(no_mangle)]
#[inline(never)]
fn spoiled_by_indirect_call(monitor: &mut Monitor, x: [f32; 3]) -> &Verdict {
    let step: fn(&mut Monitor, [f32; 3]) -> &Verdict = black_box(sound);
    step(monitor, x)
}

/// A writer that only counts.
struct Sink(usize);

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        self.0 += black_box(text).len();
        Ok(())
    }
}

/// An allocator that never frees.
struct Bump;

static USED: AtomicUsize = AtomicUsize::new(0);

// SAFETY: nothing runs this image. The addresses it gives are distinct, aligned, and in the RAM of no board.
unsafe impl GlobalAlloc for Bump {
    #[inline(never)]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let size = layout.size().next_multiple_of(16);
        (0x2000_8000 + USED.fetch_add(size, Ordering::Relaxed)) as *mut u8
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static HEAP: Bump = Bump;

/// Calls everything once, so that the linker keeps it.
#[entry]
fn main() -> ! {
    let mut monitor = black_box(None::<Monitor>);
    let x = black_box([1.0; 3]);
    if let Some(monitor) = &mut monitor {
        black_box(spoiled_by_panic(monitor, x));
        black_box(spoiled_by_soft_double(monitor, x));
        black_box(spoiled_by_recursion(monitor, x, black_box(3)));
        black_box(spoiled_by_stack(monitor, x));
        black_box(spoiled_by_formatting(monitor, x));
        black_box(spoiled_by_heap(monitor, x));
        black_box(spoiled_by_indirect_call(monitor, x));
    }
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}
