//! QEMU's log of executed instructions.

use std::io::BufRead;

use super::{Detail, Step};

/// Reads steps from the log. A step is handed out when the next begins: QEMU may take it back.
pub(super) struct Log<R> {
    input: R,
    detail: Detail,
    line: Vec<u8>,
    pending: Option<Step>,
    /// What else was written, up to some length.
    pub(super) said: String,
}

/// Longest text of QEMU's own that is kept.
const LONGEST_SAID: usize = 4096;

impl<R: BufRead> Log<R> {
    pub(super) fn new(input: R, detail: Detail) -> Self {
        Log { input, detail, line: Vec::new(), pending: None, said: String::new() }
    }

    /// The next step; none at the end.
    pub(super) fn next_step(&mut self) -> Result<Option<Step>, String> {
        loop {
            self.line.clear();
            let length = self.input.read_until(b'\n', &mut self.line);
            if length.map_err(|error| format!("QEMU's log cannot be read: {error}"))? == 0 {
                return Ok(self.pending.take());
            }
            let line = self.line.trim_ascii_end();
            if line.starts_with(b"Trace ") {
                let pc = address(line).ok_or_else(|| unknown(line))?;
                if let Some(step) = self.pending.replace(Step { pc, ..Step::default() }) {
                    return Ok(Some(step));
                }
            } else if line.starts_with(b"Stopped execution of TB chain") {
                // The instruction was announced, not executed; it will be announced again.
                self.pending = None;
            } else if line.starts_with(b"R") && line.get(3) == Some(&b'=') && self.detail == Detail::Registers {
                let step = self.pending.as_mut().ok_or_else(|| unknown(line))?;
                registers(line, &mut step.registers).ok_or_else(|| unknown(line))?;
            } else if !line.starts_with(b"XPSR=") && self.said.len() < LONGEST_SAID {
                self.said += &String::from_utf8_lossy(line);
                self.said.push('\n');
            }
        }
    }
}

fn unknown(line: &[u8]) -> String {
    format!("a line of QEMU's log is not understood: {}", String::from_utf8_lossy(line))
}

/// The second number in the brackets of `Trace 0: 0x7f49e4000100 [00800408/00000400/00000110/ff000201] name`.
fn address(line: &[u8]) -> Option<u32> {
    let start = line.iter().position(|byte| *byte == b'[')?;
    let number = line.get(start + 1..)?.split(|byte| *byte == b'/').nth(1)?;
    // Some versions print 64 bits.
    number.iter().try_fold(0_u32, |n, digit| Some(n << 4 | char::from(*digit).to_digit(16)?))
}

/// `R04=2001f3f8 R05=2001fcf8 ...`
fn registers(line: &[u8], registers: &mut [u32; 16]) -> Option<()> {
    for word in str::from_utf8(line).ok()?.split_whitespace() {
        let (name, value) = word.split_once('=')?;
        let number: usize = name.strip_prefix('R')?.parse().ok()?;
        *registers.get_mut(number)? = u32::from_str_radix(value, 16).ok()?;
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(text: &str) -> Result<(Vec<Step>, String), String> {
        let mut log = Log::new(text.as_bytes(), Detail::Registers);
        let mut steps = Vec::new();
        while let Some(step) = log.next_step()? {
            steps.push(step);
        }
        Ok((steps, log.said))
    }

    #[test]
    fn an_instruction_that_was_announced_and_not_executed_is_no_step() {
        let text = "Trace 0: 0x7f49 [00800408/00000400/00000110/ff000201] Reset\n\
                    R00=00000001 R01=00000002 R02=00000003 R03=00000004\n\
                    R12=0000000c R13=20000000 R14=ffffffff R15=00000400\nXPSR=81000000 N--- T priv-thread\n\
                    Trace 0: 0x7f4a [00800408/0000000000000402/00000110/ff000201] Reset\n\
                    Stopped execution of TB chain before 0x7f4a [00000402] Reset\n\
                    error: no such file\n\
                    Trace 0: 0x7f4a [00800408/00000402/00000110/ff000201] Reset\n";
        let (steps, said) = steps(text).unwrap();
        assert_eq!(steps.iter().map(|step| step.pc).collect::<Vec<_>>(), [0x400, 0x402]);
        assert_eq!((steps[0].registers[3], steps[0].registers[13]), (4, 0x2000_0000));
        assert_eq!(said, "error: no such file\n");
    }

    #[test]
    fn a_log_of_another_form_is_refused_with_its_line() {
        assert!(steps("Trace 0: 0x7f49 Reset\n").unwrap_err().contains("0x7f49 Reset"));
        assert!(steps("Trace 0: 0x7f49 [0/0/0/0] x\nR00=zz\n").unwrap_err().contains("R00=zz"));
    }
}
