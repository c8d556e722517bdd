//! The emulator's host: files, and leaving, by semihosting (Arm, "Semihosting for AArch32 and AArch64").

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::nr;

/// A file of the host's.
#[derive(Debug)]
pub struct HostFile(usize);

#[allow(unsafe_code)] // Semihosting calls: each passes a block of arguments that lives until the call returns.
impl HostFile {
    /// Opens a file to read; `name` ends in a zero byte.
    #[must_use]
    pub fn to_read(name: &'static [u8]) -> Option<Self> {
        Self::open(name, 1) // "rb"
    }

    /// Makes a file to write; `name` ends in a zero byte.
    #[must_use]
    pub fn to_write(name: &'static [u8]) -> Option<Self> {
        Self::open(name, 5) // "wb"
    }

    fn open(name: &'static [u8], mode: usize) -> Option<Self> {
        let arguments = [name.as_ptr() as usize, mode, name.len().saturating_sub(1)];
        // SAFETY: the name is static and its length is right.
        let handle = unsafe { cortex_m_semihosting::syscall(nr::OPEN, &arguments) };
        (handle as isize != -1).then_some(HostFile(handle))
    }

    /// Fills words; returns how many came whole.
    pub fn read(&self, words: &mut [u32]) -> usize {
        let bytes = size_of_val(words);
        let arguments = [self.0, words.as_mut_ptr() as usize, bytes];
        // SAFETY: the host writes at most `bytes` bytes into `words`, for which every bit pattern is a value.
        let missing = unsafe { cortex_m_semihosting::syscall(nr::READ, &arguments) };
        bytes.saturating_sub(missing) / size_of::<u32>()
    }

    /// Writes all words; returns whether that worked.
    #[must_use]
    pub fn write(&self, words: &[u32]) -> bool {
        let arguments = [self.0, words.as_ptr() as usize, size_of_val(words)];
        // SAFETY: the host reads that many bytes of `words`.
        unsafe { cortex_m_semihosting::syscall(nr::WRITE, &arguments) == 0 }
    }
}

/// Says a line on the host's console; it ends in a zero byte.
#[allow(unsafe_code)]
pub fn say(line: &'static [u8]) {
    // SAFETY: the text is static, and every caller ends it in a zero byte.
    unsafe { cortex_m_semihosting::syscall1(nr::WRITE0, line.as_ptr() as usize) };
}

/// Leaves the emulator with an exit code of zero, or one that is not.
pub fn leave(well: bool) -> ! {
    debug::exit(if well { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}
