//! The audited functions, each called as the host's file `kernels.in` asks, and nothing else.
//!
//! Each stands behind a function of its own that is neither inlined nor renamed, so that a trace of the emulated
//! processor holds it from call to return. A digest of every result goes to `kernels.out`.

#![no_std]
#![no_main]

mod filters;
mod guard;
mod own;
mod peers;
mod specimens;
mod start_up;
#[allow(dead_code, unreachable_pub)] // One source for the host's benchmark and for this firmware.
#[path = "../../../../tests/textbook.rs"]
mod textbook;

use cortex_m_rt::entry;
use firmware_stub::board::host::{self, HostFile};
use firmware_stub::kernels::{Kernel, REQUEST_WORDS, Request};

use own::Own;
use peers::Peers;
use specimens::Memory;

/// Requests read at once.
const CHUNK: usize = 64;

#[entry]
fn main() -> ! {
    match serve() {
        Ok(()) => host::leave(true),
        Err(reason) => {
            host::say(reason);
            host::leave(false)
        }
    }
}

fn serve() -> Result<(), &'static [u8]> {
    let input = HostFile::to_read(b"kernels.in\0").ok_or(&b"error: kernels.in cannot be opened\n\0"[..])?;
    let output = HostFile::to_write(b"kernels.out\0").ok_or(&b"error: kernels.out cannot be opened\n\0"[..])?;
    let mut count = [0];
    if input.read(&mut count) != 1 {
        return Err(b"error: the stream of requests is empty\n\0");
    }
    let [mut left] = count;
    let mut own = Own::new().ok_or(&b"error: the monitor refuses its settings\n\0"[..])?;
    let mut peers = Peers::new().ok_or(&b"error: a peer refuses its settings\n\0"[..])?;
    let mut memory = Memory::default();
    let (mut requests, mut answers) = ([[0; REQUEST_WORDS]; CHUNK], [0; CHUNK]);
    while left > 0 {
        let wanted = (left as usize).min(CHUNK);
        let (Some(requests), Some(answers)) = (requests.get_mut(..wanted), answers.get_mut(..wanted)) else { break };
        if input.read(requests.as_flattened_mut()) != wanted * REQUEST_WORDS {
            return Err(b"error: the stream of requests ends early\n\0");
        }
        for (request, answer) in requests.iter().zip(answers.iter_mut()) {
            let request = Request::from_words(*request).ok_or(&b"error: a request names no kernel\n\0"[..])?;
            *answer = call(&mut own, &mut peers, &mut memory, &request)
                .ok_or(&b"error: the kernel is not in this firmware\n\0"[..])?;
        }
        if !output.write(answers) {
            return Err(b"error: kernels.out cannot be written\n\0");
        }
        left -= wanted as u32;
    }
    Ok(())
}

/// Calls a kernel; none when this firmware was built without it.
fn call(own: &mut Own, peers: &mut Peers, memory: &mut Memory, request: &Request) -> Option<u32> {
    match request.kernel {
        Kernel::Restart => {
            *own = Own::new()?;
            *peers = Peers::new()?;
            Some(0)
        }
        Kernel::Branching | Kernel::Selecting | Kernel::Indexing | Kernel::Remembering => {
            Some(specimens::call(memory, request))
        }
        kernel if kernel < Kernel::NalgebraEigen2 => Some(own.call(request)),
        _ => peers.call(request),
    }
}
