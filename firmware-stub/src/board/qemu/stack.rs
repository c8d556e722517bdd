//! The stack's high-water mark: `cortex-m-rt` paints the stack before the program starts, and what is still painted was
//! never used.

use cortex_m_rt::STACK_PAINT_VALUE;

#[allow(unsafe_code)]
unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes of stack used at most since the start, interrupts included. A word that was written with the paint's own value
/// counts as unused, so this is a lower bound.
#[must_use]
#[allow(unsafe_code)]
pub fn high_water_bytes() -> u32 {
    let (top, mut at) = (&raw const _stack_start, &raw const _stack_end);
    // SAFETY: every word from the end of the stack up to its start lies in RAM; volatile, since others write there too.
    while at < top && unsafe { at.read_volatile() } == STACK_PAINT_VALUE {
        // SAFETY: not beyond the start of the stack.
        at = unsafe { at.add(1) };
    }
    (top as u32).saturating_sub(at as u32)
}
