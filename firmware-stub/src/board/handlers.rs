//! Hard fault and panic, the same for every board: find the reason, and [`stop`].

use core::arch::naked_asm;
use core::panic::PanicInfo;

use super::stop;
use crate::fault::Reason;

#[allow(unsafe_code)]
unsafe extern "C" {
    /// End of the stack: where RAM begins, as `flip-link` lays it out.
    static _stack_end: u32;
}

/// The hard fault's first instructions, in assembly: after a stack overflow there is no stack to enter a function with.
/// The stack pointer at the fault becomes the argument, and the stack begins afresh at its top; what stood there is lost,
/// which a run that is over can bear.
#[allow(unsafe_code, non_snake_case)]
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!("mrs r0, msp", "ldr r1, =_stack_start", "msr msp, r1", "isb", "b {}", sym hard_fault)
}

extern "C" fn hard_fault(stack_pointer: u32) -> ! {
    // The address of a symbol of the linker; nothing is read.
    let stack_end = &raw const _stack_end as u32;
    stop(Reason::of_hard_fault(stack_pointer, stack_end))
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    stop(Reason::Panic)
}
