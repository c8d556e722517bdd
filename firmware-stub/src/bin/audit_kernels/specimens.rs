//! Functions that a test of the audit must catch, and one that it must let pass.

#![allow(unsafe_code)] // Unmangled names, which the host looks for.

use core::hint::black_box;

use firmware_stub::kernels::{self, Kernel, Request};

/// Halves the number until it is small: a branch that depends on data.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_branching(halvings: &mut u32, x: &f32) -> f32 {
    let mut x = *x;
    while x > 1.0 && *halvings < 1000 {
        x = black_box(x * 0.5);
        *halvings += 1;
    }
    x
}

/// Limits the number: a select, which the target does in one path.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_selecting(limit: &f32, x: &f32) -> f32 {
    if *x > *limit { *limit } else { *x }
}

/// Looks up the number's leading bits: an address that depends on data, in one path.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_indexing(table: &[u8; 256], x: &f32) -> u32 {
    let [_, _, _, leading] = x.to_bits().to_le_bytes();
    u32::from(table[usize::from(leading)])
}

/// Waits as long as the number of the call before says: a branch that depends on data by way of what was remembered.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_remembering(memory: &mut f32, x: &f32) -> f32 {
    let mut before = core::mem::replace(memory, *x);
    while before > 1.0 {
        before = black_box(before * 0.5);
    }
    before
}

/// What a specimen remembers between two calls.
#[derive(Default)]
pub(crate) struct Memory(f32);

/// Calls a specimen.
pub(crate) fn call(memory: &mut Memory, request: &Request) -> u32 {
    let [x, ..] = request.numbers();
    match request.kernel {
        Kernel::Remembering => kernels::digest_of_numbers([audit_remembering(&mut memory.0, &x)]),
        Kernel::Branching => kernels::digest_of_numbers([audit_branching(black_box(&mut 0), &x)]),
        Kernel::Selecting => kernels::digest_of_numbers([audit_selecting(black_box(&8.0), &x)]),
        _ => audit_indexing(black_box(&[7; 256]), &x),
    }
}
