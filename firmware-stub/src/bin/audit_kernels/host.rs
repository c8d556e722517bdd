//! The host's files and console, by semihosting (Arm, "Semihosting for AArch32 and AArch64").

#![allow(unsafe_code)] // Semihosting calls: each passes a block of arguments that lives until the call returns.

use cortex_m_semihosting::debug::{self, EXIT_FAILURE};
use cortex_m_semihosting::nr;

/// A file of the host's.
pub(crate) struct HostFile(usize);

impl HostFile {
    /// Modes of SYS_OPEN: "rb" and "wb".
    pub(crate) const READ: usize = 1;
    pub(crate) const WRITE: usize = 5;

    /// `name` ends in a zero byte.
    pub(crate) fn open(name: &'static [u8], mode: usize) -> Option<Self> {
        let arguments = [name.as_ptr() as usize, mode, name.len() - 1];
        // SAFETY: the name is static and its length is right.
        let handle = unsafe { cortex_m_semihosting::syscall(nr::OPEN, &arguments) };
        (handle as isize != -1).then_some(HostFile(handle))
    }

    /// Fills whole records; returns how many came.
    pub(crate) fn read<const N: usize>(&self, records: &mut [[u32; N]]) -> usize {
        let bytes = size_of_val(records);
        let arguments = [self.0, records.as_mut_ptr() as usize, bytes];
        // SAFETY: the host writes at most `bytes` bytes into `records`, for which every bit pattern is a value.
        let missing = unsafe { cortex_m_semihosting::syscall(nr::READ, &arguments) };
        bytes.saturating_sub(missing) / (4 * N)
    }

    /// Writes all records; returns whether that worked.
    pub(crate) fn write<const N: usize>(&self, records: &[[u32; N]]) -> bool {
        let arguments = [self.0, records.as_ptr() as usize, size_of_val(records)];
        // SAFETY: the host reads that many bytes of `records`.
        unsafe { cortex_m_semihosting::syscall(nr::WRITE, &arguments) == 0 }
    }
}

/// Says why on the host's console, and leaves with an exit code that is not zero.
pub(crate) fn leave(reason: &'static [u8]) {
    // SAFETY: the text is static and ends in a zero byte.
    unsafe { cortex_m_semihosting::syscall1(nr::WRITE0, reason.as_ptr() as usize) };
    debug::exit(EXIT_FAILURE);
}

pub(crate) fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
