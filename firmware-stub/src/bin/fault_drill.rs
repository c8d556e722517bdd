//! Fault drills on the emulated board: the file `drill.in` says what is to go wrong, and the run must end with that
//! reason, the fault output safe, and an exit code that is not zero. Exit code 0 means that the fault went unnoticed.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use firmware_stub::board::host::{self, HostFile};
use firmware_stub::board::qemu::{FaultOutput, Watchdog};

#[entry]
fn main() -> ! {
    let mut drill = [0];
    let input = HostFile::to_read(b"drill.in\0");
    let read = input.is_some_and(|input| input.read(&mut drill) == 1);
    let mut output = FaultOutput::safe();
    output.set(false);
    match drill {
        _ if !read => refuse(b"error: drill.in cannot be read\n\0"),
        [1] => hard_fault(),
        [2] => {
            black_box(overflow(1, [0; 64]));
        }
        [3] => hang(),
        [4] => give_up(),
        _ => refuse(b"error: there is no such drill\n\0"),
    }
    // Still here: the fault went unnoticed.
    host::leave(true)
}

fn refuse(why: &'static [u8]) {
    host::say(why);
    host::leave(false)
}

/// Reads where there is nothing.
#[allow(unsafe_code)]
fn hard_fault() {
    // SAFETY: there is none; the address is in no memory of the board, which is the drill.
    black_box(unsafe { core::ptr::without_provenance::<u32>(0xdead_0000).read_volatile() });
}

/// Calls itself until the stack ends.
#[allow(unconditional_recursion)]
fn overflow(depth: u32, room: [u32; 64]) -> u32 {
    let room = black_box(room.map(|word| word ^ depth));
    overflow(depth.wrapping_add(1), room) + room.iter().fold(0, |sum, word| sum ^ word)
}

/// A main loop that stops answering.
fn hang() {
    let _watchdog = Watchdog::start(50);
    loop {
        black_box(());
    }
}

/// A panic, which the monitor has none of.
#[allow(clippy::panic)]
fn give_up() {
    panic!("drill");
}
