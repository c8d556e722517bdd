//! The transport of `defmt` on the real board: SEGGER's RTT, a ring in RAM that the debug probe empties.
//!
//! Own code where `defmt-rtt` exists, because that one holds interrupts off for a whole frame, waits for a host that asks
//! it to, and panics when it is entered twice. Here a frame is written beside the sampling interrupt, a frame that does
//! not fit is dropped whole, and so is one begun while another is written (by a handler; nothing else logs but the main
//! loop).

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering};

/// Bytes of the ring; a power of two. A line takes 10 to 30.
const RING: usize = 1024;

/// The control block that a probe looks for in RAM, by the layout that SEGGER published.
#[repr(C)]
struct ControlBlock {
    id: [u8; 16],
    up_channels: u32,
    down_channels: u32,
    name: *const u8,
    ring: *const UnsafeCell<[u8; RING]>,
    size: u32,
    write: AtomicU32,
    read: AtomicU32,
    /// Mode: 1 drops what does not fit. A probe may ask for another; this transport never waits.
    flags: AtomicU32,
}

/// What an unfinished frame needs.
struct Frame {
    encoder: defmt::Encoder,
    /// Where the next byte goes; the probe sees it once the frame is whole.
    at: u32,
    fits: bool,
}

struct Shared<T>(UnsafeCell<T>);

// SAFETY: touched only between `acquire` and `release` at depth one, which one context at a time can be in.
#[allow(unsafe_code)]
unsafe impl<T> Sync for Shared<T> {}

// SAFETY: the pointers are to statics; the counters are atomic.
#[allow(unsafe_code)]
unsafe impl Sync for ControlBlock {}

static FRAME: Shared<Frame> = Shared(UnsafeCell::new(Frame { encoder: defmt::Encoder::new(), at: 0, fits: false }));
static BYTES: Shared<[u8; RING]> = Shared(UnsafeCell::new([0; RING]));
/// How many frames are begun: handlers nest, so only the first of them is written.
static DEPTH: AtomicU32 = AtomicU32::new(0);

#[allow(unsafe_code)] // A name that probes know.
#[unsafe(no_mangle)]
static _SEGGER_RTT: ControlBlock = ControlBlock {
    id: *b"SEGGER RTT\0\0\0\0\0\0",
    up_channels: 1,
    down_channels: 0,
    name: c"defmt".as_ptr().cast(),
    ring: &raw const BYTES.0,
    size: RING as u32,
    write: AtomicU32::new(0),
    read: AtomicU32::new(0),
    flags: AtomicU32::new(1),
};

#[defmt::global_logger]
struct Logger;

// SAFETY: `acquire` and `release` come in pairs and nest like the interrupts they are called in; all but the outermost
// pair do nothing.
#[allow(unsafe_code)]
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        if enter() {
            with_frame(|frame| {
                (frame.at, frame.fits) = (_SEGGER_RTT.write.load(Ordering::Relaxed), true);
                let Frame { encoder, at, fits } = frame;
                encoder.start_frame(|bytes| stage(at, fits, bytes));
            });
        }
    }

    unsafe fn flush() {}

    unsafe fn write(bytes: &[u8]) {
        if DEPTH.load(Ordering::Relaxed) == 1 {
            with_frame(|Frame { encoder, at, fits }| encoder.write(bytes, |bytes| stage(at, fits, bytes)));
        }
    }

    unsafe fn release() {
        if DEPTH.load(Ordering::Relaxed) == 1 {
            with_frame(|Frame { encoder, at, fits }| {
                encoder.end_frame(|bytes| stage(at, fits, bytes));
                if *fits {
                    _SEGGER_RTT.write.store(*at, Ordering::Release);
                }
            });
        }
        // A handler that came between left the depth as it found it.
        DEPTH.store(DEPTH.load(Ordering::Relaxed).wrapping_sub(1), Ordering::Relaxed);
    }
}

/// Begins a frame; whether it is the only one.
fn enter() -> bool {
    let depth = DEPTH.load(Ordering::Relaxed);
    DEPTH.store(depth.wrapping_add(1), Ordering::Relaxed);
    depth == 0
}

#[allow(unsafe_code)]
fn with_frame(f: impl FnOnce(&mut Frame)) {
    // SAFETY: only the outermost frame gets here.
    f(unsafe { &mut *FRAME.0.get() })
}

/// Puts bytes behind what is staged, if there is room. One place stays free: equal counters mean an empty ring.
#[allow(unsafe_code)]
fn stage(at: &mut u32, fits: &mut bool, bytes: &[u8]) {
    let ring = BYTES.0.get().cast::<u8>();
    for byte in bytes {
        let next = (*at + 1) % RING as u32;
        *fits = *fits && next != _SEGGER_RTT.read.load(Ordering::Acquire);
        if *fits {
            // SAFETY: `at` is below the ring's length, and the probe does not read there before the frame is whole.
            unsafe { ring.add(*at as usize % RING).write_volatile(*byte) };
            *at = next;
        }
    }
}
