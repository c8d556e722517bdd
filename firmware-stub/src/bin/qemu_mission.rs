//! The emulated board: reads a stream of samples from the host's file `mission.in`, writes every verdict to
//! `mission.out`, and leaves with the exit code 0 when all went well.
//!
//! Everything that computes is `monitor-core`; this is wiring.

#![no_std]
#![no_main]

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, entry, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::nr;
use defmt_semihosting as _; // the transport of `defmt`
use firmware_stub::record::{self, EIGEN_WORDS, HEADER_WORDS, Header, Kind, MATRIX_WORDS, SAMPLE_WORDS, VERDICT_WORDS};
use firmware_stub::{on_sample, report};
use monitor_core::{EventLog, Monitor, Phase};

/// Records read and written at once: a semihosting call costs far more than a step.
const CHUNK: usize = 64;

#[entry]
fn main() -> ! {
    match fly() {
        Ok(()) => debug::exit(EXIT_SUCCESS),
        Err(reason) => leave(reason),
    }
    halt()
}

/// Events between two drains; one sample makes at most nine.
const EVENTS: usize = 16;

/// Flies what the host sends.
fn fly() -> Result<(), &'static [u8]> {
    let input =
        HostFile::open(b"mission.in\0", HostFile::READ).ok_or(&b"error: mission.in cannot be opened\n\0"[..])?;
    let output =
        HostFile::open(b"mission.out\0", HostFile::WRITE).ok_or(&b"error: mission.out cannot be opened\n\0"[..])?;
    let mut words = [[0_u32; HEADER_WORDS]; 1];
    let [header] = &mut words;
    if input.read(core::slice::from_mut(header)) != 1 {
        return Err(b"error: the stream ends inside its header\n\0");
    }
    let header = Header::from_words(*header).ok_or(&b"error: the stream is not one of samples or matrices\n\0"[..])?;
    match header.kind {
        Kind::Mission => {
            let mut monitor =
                Monitor::new(&header.config).map_err(|_| &b"error: the monitor refuses its settings\n\0"[..])?;
            let thresholds = monitor.thresholds();
            let mut events = EventLog::<EVENTS>::default();
            stream(&input, &output, header.records, |words: [u32; SAMPLE_WORDS]| -> [u32; VERDICT_WORDS] {
                let (set_point, sample) = record::sample_from_words(words);
                let verdict = on_sample(&mut monitor, set_point, sample, |_| {});
                events.observe(&verdict);
                while let Some(event) = events.pop() {
                    report::event(event, &verdict, &thresholds);
                }
                if verdict.phase() == Phase::ModelDue {
                    // A refusal stands in the verdicts that follow.
                    let _ = monitor.finish_learning();
                }
                record::verdict_to_words(&verdict)
            })
        }
        Kind::Matrices => stream(&input, &output, header.records, |words: [u32; MATRIX_WORDS]| -> [u32; EIGEN_WORDS] {
            record::eigen_to_words(words)
        }),
    }
}

/// Answers each record of `input` with one to `output`.
fn stream<const I: usize, const O: usize>(
    input: &HostFile,
    output: &HostFile,
    records: u32,
    mut answer: impl FnMut([u32; I]) -> [u32; O],
) -> Result<(), &'static [u8]> {
    let (mut questions, mut answers) = ([[0; I]; CHUNK], [[0; O]; CHUNK]);
    let mut left = records as usize;
    while left > 0 {
        let wanted = left.min(CHUNK);
        let (Some(questions), Some(answers)) = (questions.get_mut(..wanted), answers.get_mut(..wanted)) else { break };
        if input.read(questions) != wanted {
            return Err(b"error: the stream ends early\n\0");
        }
        for (question, slot) in questions.iter().zip(answers.iter_mut()) {
            *slot = answer(*question);
        }
        if !output.write(answers) {
            return Err(b"error: mission.out cannot be written\n\0");
        }
        left -= wanted;
    }
    Ok(())
}

/// A file of the host's, by semihosting (Arm, "Semihosting for AArch32 and AArch64").
struct HostFile(usize);

#[allow(unsafe_code)] // Semihosting calls: each passes a block of arguments that lives until the call returns.
impl HostFile {
    /// Modes of SYS_OPEN: "rb" and "wb".
    const READ: usize = 1;
    const WRITE: usize = 5;

    /// `name` ends in a zero byte.
    fn open(name: &'static [u8], mode: usize) -> Option<Self> {
        let arguments = [name.as_ptr() as usize, mode, name.len() - 1];
        // SAFETY: the name is static and its length is right.
        let handle = unsafe { cortex_m_semihosting::syscall(nr::OPEN, &arguments) };
        (handle as isize != -1).then_some(HostFile(handle))
    }

    /// Fills whole records; returns how many came.
    fn read<const N: usize>(&self, records: &mut [[u32; N]]) -> usize {
        let bytes = size_of_val(records);
        let arguments = [self.0, records.as_mut_ptr() as usize, bytes];
        // SAFETY: the host writes at most `bytes` bytes into `records`, for which every bit pattern is a value.
        let missing = unsafe { cortex_m_semihosting::syscall(nr::READ, &arguments) };
        bytes.saturating_sub(missing) / (4 * N)
    }

    /// Writes all records; returns whether that worked.
    fn write<const N: usize>(&self, records: &[[u32; N]]) -> bool {
        let arguments = [self.0, records.as_ptr() as usize, size_of_val(records)];
        // SAFETY: the host reads that many bytes of `records`.
        unsafe { cortex_m_semihosting::syscall(nr::WRITE, &arguments) == 0 }
    }
}

/// Says why on the host's console, and leaves with an exit code that is not zero.
#[allow(unsafe_code)]
fn leave(reason: &'static [u8]) {
    // SAFETY: the text is static and ends in a zero byte.
    unsafe { cortex_m_semihosting::syscall1(nr::WRITE0, reason.as_ptr() as usize) };
    debug::exit(EXIT_FAILURE);
}

fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

#[allow(unsafe_code)] // The attribute declares the handler unsafe: it runs in a machine that is no longer sound.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    leave(b"error: hard fault\n\0");
    halt()
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    leave(b"error: panic\n\0");
    halt()
}
