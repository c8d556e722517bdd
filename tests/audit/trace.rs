//! What the emulated processor executes, instruction by instruction.
//!
//! QEMU runs the firmware `audit-kernels` one instruction at a time and logs each; nothing has to be compiled or installed
//! for that. An instruction that an IT block skips is logged like any other, so a path holds everything that is fetched.
//! The log is read from a pipe as it comes: no file grows, and a firmware that hangs or faults for ever is stopped.
//!
//! What it cannot see: time, and what the emulation of an instruction does inside.

mod log;

use std::collections::HashMap;
use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use firmware_stub::kernels::{Kernel, Request};

use super::code::Code;
use super::decode::Flow;
use crate::toolchain::{Board, Run};
use log::Log;

/// The state of the processor before an instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Address of the instruction.
    pub pc: u32,
    /// r0 to r15, if they were asked for; else zeros.
    pub registers: [u32; 16],
}

/// How much of each step is logged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Addresses only.
    Path,
    /// Addresses and registers; five times slower.
    Registers,
}

/// When to give up.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Instructions executed.
    pub instructions: u64,
    /// Wall clock.
    pub time: Duration,
}

impl Limits {
    /// Ten times what an audit takes.
    pub const DEFAULT: Limits = Limits { instructions: 100_000_000, time: Duration::from_secs(300) };
}

/// Runs the firmware on requests and hands every step to `take`. Returns the firmware's answer to each request.
///
/// # Errors
/// What is missing, what the board said, or that it was stopped.
pub fn run(
    elf: &Path,
    requests: &[Request],
    detail: Detail,
    limits: Limits,
    mut take: impl FnMut(&Step) -> Result<(), String>,
) -> Result<Vec<u32>, String> {
    let desk = tempfile::tempdir().map_err(|error| format!("no directory for the emulation: {error}"))?;
    let count = [requests.len() as u32];
    let words = count.into_iter().chain(requests.iter().flat_map(Request::to_words));
    let bytes: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
    let failed = |error: std::io::Error| format!("the requests cannot be handed over: {error}");
    std::fs::write(desk.path().join("kernels.in"), bytes).map_err(failed)?;

    let nameless = desk.path().join("kernels.elf");
    std::fs::write(&nameless, without_names(elf)?).map_err(failed)?;
    let logged = if detail == Detail::Path { "exec,nochain" } else { "exec,cpu,nochain" };
    let emulation = Run::new(Board::CortexM4, &nameless, desk.path()).with(one_by_one()?).with(&["-d", logged]);
    let mut emulator = Emulator::start(&mut emulation.command(), limits.time)?;
    let mut log = Log::new(BufReader::with_capacity(1 << 20, emulator.log.take().ok_or("QEMU gives no log")?), detail);
    let mut left = limits.instructions;
    let read = loop {
        match log.next_step() {
            Ok(Some(_)) if left == 0 => break Err(endless(limits.instructions)),
            Ok(Some(step)) => {
                left -= 1;
                if let Err(error) = take(&step) {
                    break Err(error);
                }
            }
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    if read.is_err() {
        emulator.stop();
    }
    let ended = emulator.end(&log.said);
    read.and(ended)?;
    let answers = std::fs::read(desk.path().join("kernels.out")).map_err(|error| format!("no answers: {error}"))?;
    Ok(answers.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect())
}

/// The image without its table of sections, and so without symbols: QEMU would write the name of a function, which may be
/// hundreds of letters, behind every instruction.
fn without_names(elf: &Path) -> Result<Vec<u8>, String> {
    let mut bytes = std::fs::read(elf).map_err(|error| format!("{} cannot be read: {error}", elf.display()))?;
    // Of the 32-bit header: where the table is; how many entries it has, and which of them holds the names.
    for field in [0x20..0x24, 0x30..0x34] {
        let field = bytes.get_mut(field).ok_or_else(|| format!("{} is not an ELF file", elf.display()))?;
        field.fill(0);
    }
    Ok(bytes)
}

fn endless(instructions: u64) -> String {
    format!("the firmware was stopped after {instructions} instructions: it hangs, or a fault handler runs for ever")
}

/// The option that makes QEMU execute one instruction at a time: it has another name from version 8.1 on.
fn one_by_one() -> Result<&'static [&'static str], String> {
    let missing = "cannot run qemu-system-arm; install it with: apt-get install qemu-system-arm";
    let output = Command::new("qemu-system-arm").arg("--version").output().map_err(|_| missing)?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let number = text.split_whitespace().skip_while(|word| *word != "version").nth(1).unwrap_or_default();
    let mut parts = number.split(|c: char| !c.is_ascii_digit()).map_while(|part| part.parse::<u32>().ok());
    let version = (parts.next(), parts.next());
    if version.0.is_none() {
        return Err(format!("qemu-system-arm does not say its version: {text}"));
    }
    Ok(if version < (Some(8), Some(1)) { &["-singlestep"] } else { &["-accel", "tcg,one-insn-per-tb=on"] })
}

/// A running emulator, and the clock that stops it.
struct Emulator {
    child: Arc<Mutex<Child>>,
    log: Option<std::process::ChildStderr>,
    console: Option<std::process::ChildStdout>,
    clock: Option<std::thread::JoinHandle<bool>>,
    ended: mpsc::Sender<()>,
    time: Duration,
}

impl Emulator {
    fn start(command: &mut Command, time: Duration) -> Result<Self, String> {
        let started = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let mut child = started.map_err(|e| {
            format!("cannot run qemu-system-arm: {e}; install it with: apt-get install qemu-system-arm")
        })?;
        let (log, console) = (child.stderr.take(), child.stdout.take());
        let child = Arc::new(Mutex::new(child));
        let (ended, wait) = mpsc::channel();
        let watched = Arc::clone(&child);
        let clock = std::thread::spawn(move || {
            let late = wait.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
            if late {
                kill(&watched);
            }
            late
        });
        Ok(Emulator { child, log, console, clock: Some(clock), ended, time })
    }

    fn stop(&self) {
        kill(&self.child);
    }

    /// Waits for the end; `log` is what QEMU wrote between the steps.
    fn end(mut self, log: &str) -> Result<(), String> {
        let mut said = String::new();
        if let Some(console) = &mut self.console {
            // Bytes that are no text do not matter: the exit code decides.
            let _ = console.read_to_string(&mut said);
        }
        let status = self.child.lock().unwrap_or_else(PoisonError::into_inner).wait().map_err(|e| e.to_string())?;
        // The clock is gone only if it has struck.
        let _ = self.ended.send(());
        if self.clock.take().and_then(|clock| clock.join().ok()) == Some(true) {
            return Err(format!("the firmware was stopped after {} s: it hangs", self.time.as_secs()));
        }
        if status.success() { Ok(()) } else { Err(format!("the board left with {status}: {said}{log}")) }
    }
}

fn kill(child: &Mutex<Child>) {
    // An emulator that has ended by itself needs no end.
    let _ = child.lock().unwrap_or_else(PoisonError::into_inner).kill();
}

/// A call of an audited function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// The function.
    pub kernel: Kernel,
    /// Its path, a place in [`Calls::paths`].
    pub path: usize,
}

/// The calls of a run, each with its exact path from the first instruction of the function to its return.
#[derive(Clone, Debug, Default)]
pub struct Calls {
    /// In the order in which they were made.
    pub calls: Vec<Call>,
    /// Different paths: addresses of instructions.
    pub paths: Vec<Vec<u32>>,
    /// The firmware's answer to each request.
    pub answers: Vec<u32>,
}

/// Runs the firmware on requests and gathers the path of every call.
///
/// # Errors
/// See [`run`]; or a function is entered otherwise than by a call.
pub fn calls(elf: &Path, code: &Code, requests: &[Request]) -> Result<Calls, String> {
    let mut gather = Gather::new(code);
    let answers = run(elf, requests, Detail::Path, Limits::DEFAULT, |step| gather.take(step.pc))?;
    let wanted = requests.iter().filter(|request| !request.kernel.symbol().is_empty()).count();
    if gather.calls.len() != wanted {
        return Err(format!("{wanted} calls were asked for and {} were seen", gather.calls.len()));
    }
    Ok(Calls { calls: gather.calls, paths: gather.paths, answers })
}

/// Entry addresses of the audited functions in an image.
#[must_use]
pub fn entries(code: &Code) -> HashMap<u32, Kernel> {
    let named = Kernel::ALL.iter().filter(|kernel| !kernel.symbol().is_empty());
    named.filter_map(|kernel| Some((code.function(kernel.symbol())?.start, *kernel))).collect()
}

struct Gather<'a> {
    code: &'a Code,
    entries: HashMap<u32, Kernel>,
    before: u32,
    open: Option<(Kernel, u32)>,
    path: Vec<u32>,
    known: HashMap<Vec<u32>, usize>,
    paths: Vec<Vec<u32>>,
    calls: Vec<Call>,
}

impl<'a> Gather<'a> {
    fn new(code: &'a Code) -> Self {
        Gather {
            code,
            entries: entries(code),
            before: 0,
            open: None,
            path: Vec::new(),
            known: HashMap::new(),
            paths: Vec::new(),
            calls: Vec::new(),
        }
    }

    fn take(&mut self, pc: u32) -> Result<(), String> {
        if let Some((kernel, back)) = self.open
            && pc == back
        {
            self.close(kernel);
        }
        if self.open.is_some() {
            self.path.push(pc);
        } else if let Some(kernel) = self.entries.get(&pc) {
            self.open = Some((*kernel, return_address(self.code, self.before, *kernel)?));
            self.path.push(pc);
        }
        self.before = pc;
        Ok(())
    }

    fn close(&mut self, kernel: Kernel) {
        self.open = None;
        let path = match self.known.get(&self.path) {
            Some(known) => *known,
            None => {
                self.known.insert(self.path.clone(), self.paths.len());
                self.paths.push(self.path.clone());
                self.paths.len() - 1
            }
        };
        self.path.clear();
        self.calls.push(Call { kernel, path });
    }
}

/// Where a call that was made by the instruction at `caller` returns to.
///
/// # Errors
/// It is no call.
pub fn return_address(code: &Code, caller: u32, kernel: Kernel) -> Result<u32, String> {
    let calls = code.instructions.get(&caller).filter(|i| matches!(i.flow, Flow::Call(_) | Flow::IndirectCall));
    calls.map(super::decode::Instruction::end).ok_or_else(|| {
        format!("{} is entered from {caller:#010x}, where no call stands: its end cannot be seen", kernel.symbol())
    })
}
