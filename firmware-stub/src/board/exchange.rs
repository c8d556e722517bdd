//! A stream of records from the host, each answered by one.

use super::host::{self, HostFile};
use super::qemu::{Watchdog, high_water_bytes};
use crate::record::{CHUNK, HEADER_WORDS, Header, check_word};

/// A sentence for the host, ending in a zero byte.
pub type Refusal = &'static [u8];

/// An answer of so many words.
pub type Answered<const N: usize> = Result<[u32; N], Refusal>;

/// A main loop that does not come round in this time has stopped, ms of the emulator's clock: a chunk's worth of
/// semihosting on a busy host stays far below.
const WATCHDOG_MS: u32 = 20_000;

/// Lets a board fly what the host sends, and leaves: with the exit code 0 and the depth of the stack, or with a refusal.
pub fn leave_after(fly: impl FnOnce(&mut Watchdog) -> Result<(), Refusal>) -> ! {
    match fly(&mut Watchdog::start(WATCHDOG_MS)) {
        Ok(()) => {
            // For the audit's stack budget.
            defmt::println!("STACK_HIGH_WATER_BYTES={=u32}", high_water_bytes());
            host::leave(true)
        }
        Err(refusal) => {
            host::say(refusal);
            host::leave(false)
        }
    }
}

/// The host's files, behind the header of its stream.
#[derive(Debug)]
pub struct Exchange {
    input: HostFile,
    output: HostFile,
    /// What the host announces.
    pub header: Header,
}

impl Exchange {
    /// Opens `mission.in` and `mission.out`, and reads the header.
    ///
    /// # Errors
    /// A sentence for the host.
    pub fn open() -> Result<Self, Refusal> {
        let input = HostFile::to_read(b"mission.in\0").ok_or(&b"error: mission.in cannot be opened\n\0"[..])?;
        let output = HostFile::to_write(b"mission.out\0").ok_or(&b"error: mission.out cannot be opened\n\0"[..])?;
        let mut header = [0; HEADER_WORDS];
        if input.read(&mut header) != HEADER_WORDS {
            return Err(b"error: the stream ends inside its header\n\0");
        }
        checked(&input, &header)?;
        let header = Header::from_words(header).ok_or(&b"error: the stream is not one of slots or matrices\n\0"[..])?;
        Ok(Exchange { input, output, header })
    }

    /// Answers each record with one. Its buffers are on the stack, and not beside those of another kind of records.
    ///
    /// # Errors
    /// A sentence for the host: its stream is not as announced, or the answer is refused.
    #[inline(never)]
    pub fn answer<const I: usize, const O: usize>(
        &self,
        mut answer: impl FnMut([u32; I]) -> Answered<O>,
    ) -> Result<(), Refusal> {
        let (mut questions, mut answers) = ([[0; I]; CHUNK], [[0; O]; CHUNK]);
        let mut left = self.header.records as usize;
        while left > 0 {
            let wanted = left.min(CHUNK);
            let (Some(questions), Some(answers)) = (questions.get_mut(..wanted), answers.get_mut(..wanted)) else {
                break;
            };
            if self.input.read(questions.as_flattened_mut()) != wanted * I {
                return Err(b"error: the stream ends early\n\0");
            }
            checked(&self.input, questions.as_flattened())?;
            for (question, slot) in questions.iter().zip(answers.iter_mut()) {
                *slot = answer(*question)?;
            }
            if !self.output.write(answers.as_flattened()) {
                return Err(b"error: mission.out cannot be written\n\0");
            }
            left -= wanted;
        }
        Ok(())
    }
}

/// Reads the check word behind `words` and compares.
fn checked(input: &HostFile, words: &[u32]) -> Result<(), Refusal> {
    let mut check = [0];
    if input.read(&mut check) != 1 {
        return Err(b"error: the stream ends before a check word\n\0");
    }
    let [check] = check;
    if check == check_word(words) {
        Ok(())
    } else {
        Err(b"error: the stream is corrupt, a check word does not fit\n\0")
    }
}
