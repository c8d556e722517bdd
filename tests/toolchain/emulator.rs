//! The emulated boards: a firmware runs, its log is decoded, and what it says when it fails is passed on.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::clean;

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// QEMU's `mps2-an386`: Cortex-M4F.
    CortexM4,
    /// QEMU's `mps2-an500`: Cortex-M7; same memory map, same firmware, another core.
    CortexM7,
    /// QEMU's `netduinoplus2`: the STM32F405, without its clocks and pins.
    Stm32F405,
}

impl Board {
    const fn machine(self) -> (&'static str, &'static str) {
        match self {
            Board::CortexM4 => ("mps2-an386", "cortex-m4"),
            Board::CortexM7 => ("mps2-an500", "cortex-m7"),
            Board::Stm32F405 => ("netduinoplus2", "cortex-m4"),
        }
    }
}

/// How long a run may last before it counts as hung: a mission takes seconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// One run of a firmware.
#[derive(Clone, Debug)]
pub struct Run {
    board: Board,
    elf: PathBuf,
    directory: PathBuf,
    patience: Duration,
    /// More arguments of the emulator.
    extra: Vec<String>,
}

impl Run {
    /// An ELF file on a board, its files in `directory`.
    #[must_use]
    pub fn new(board: Board, elf: &Path, directory: &Path) -> Self {
        let (elf, directory) = (elf.to_owned(), directory.to_owned());
        Run { board, elf, directory, patience: PATIENCE, extra: Vec::new() }
    }

    /// With time that counts instructions, 64 ns each, instead of the host's: what happens when then is the same in every
    /// run. A millisecond has 15,625 instructions, about what a core at 16 MHz executes.
    #[must_use]
    pub fn counting_instructions(self) -> Self {
        self.with(&["-icount", "shift=6"])
    }

    /// With more arguments of the emulator.
    #[must_use]
    pub fn with(mut self, arguments: &[&str]) -> Self {
        self.extra.extend(arguments.iter().map(|argument| (*argument).to_owned()));
        self
    }

    /// With another limit to how long it may last.
    #[must_use]
    pub fn within(self, patience: Duration) -> Self {
        Run { patience, ..self }
    }

    /// The command that does it.
    #[must_use]
    pub fn command(&self) -> Command {
        let (machine, core) = self.board.machine();
        let mut command = clean(Path::new("qemu-system-arm"));
        command
            .current_dir(&self.directory)
            .args(["-machine", machine, "-cpu", core, "-nographic", "-monitor", "none"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(&self.elf)
            .args(&self.extra);
        if !self.extra.iter().any(|argument| argument == "-serial") {
            command.args(["-serial", "none"]);
        }
        command
    }

    fn spawn(&self) -> Result<Child, String> {
        is_firmware(&self.elf)?;
        self.command().stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(|error| {
            format!("cannot run qemu-system-arm: {error}; install it with: apt-get install qemu-system-arm")
        })
    }

    /// Runs, and shows the lines logged so far to `enough` again and again, until it is content; then stops the board,
    /// which would not end by itself. Returns the lines.
    ///
    /// # Errors
    /// What is missing, or the log when the board ended or time was up before it held enough.
    pub fn watch(&self, mut enough: impl FnMut(&[String]) -> bool) -> Result<Vec<String>, String> {
        let mut child = self.spawn()?;
        let (said, complained) = (Arc::new(Mutex::new(Vec::new())), collect(child.stderr.take()));
        let reader = child.stdout.take().map(|stream| gather(stream, Arc::clone(&said)));
        let begun = Instant::now();
        let lines = loop {
            thread::sleep(Duration::from_millis(50));
            let ended = child.try_wait().map_err(|error| error.to_string())?.is_some();
            let lines = decoded(&self.elf, &said.lock().unwrap_or_else(PoisonError::into_inner))?;
            if enough(&lines) {
                break Ok(lines);
            }
            if ended || begun.elapsed() > self.patience {
                let tail = lines.iter().rev().take(20).rev().cloned().collect::<Vec<_>>().join("\n");
                break Err(format!("the board did not log what was waited for; it ended with:\n{tail}"));
            }
        };
        // It may have ended already.
        let _ = child.kill();
        child.wait().map_err(|error| error.to_string())?;
        reader.into_iter().for_each(|reader| drop(reader.join()));
        let complaints = complained.join().unwrap_or_default();
        lines.map_err(|error| format!("{error}\n{}", text(&complaints)))
    }

    /// Runs to its end; returns the `defmt` frames it logged.
    ///
    /// # Errors
    /// What is missing, what the board said when its exit code was not zero, or that it hung.
    pub fn frames(&self) -> Result<Vec<u8>, String> {
        let mut child = self.spawn()?;
        let (said, complained) = (collect(child.stdout.take()), collect(child.stderr.take()));
        let ended = self.wait(&mut child)?;
        let [frames, complaints] = [said, complained].map(|thread| thread.join().unwrap_or_default());
        match ended {
            Some(status) if status.success() => Ok(frames),
            Some(status) => Err(format!("the board left with {status}: {}{}", text(&frames), text(&complaints))),
            None => Err(format!(
                "the board did not end within {} s and was stopped; it said: {}{}",
                self.patience.as_secs_f32(),
                text(&frames),
                text(&complaints)
            )),
        }
    }

    /// Waits for the end; none when there was none in time and the emulator was stopped.
    fn wait(&self, child: &mut Child) -> Result<Option<ExitStatus>, String> {
        let begun = Instant::now();
        loop {
            match child.try_wait() {
                Ok(Some(status)) => return Ok(Some(status)),
                Ok(None) if begun.elapsed() < self.patience => thread::sleep(Duration::from_millis(5)),
                Ok(None) => {
                    child.kill().and_then(|()| child.wait()).map_err(|error| error.to_string())?;
                    return Ok(None);
                }
                Err(error) => return Err(error.to_string()),
            }
        }
    }

    /// Runs to its end; returns the lines it logged.
    ///
    /// # Errors
    /// See [`Run::frames`] and [`decoded`].
    pub fn log(&self) -> Result<Vec<String>, String> {
        decoded(&self.elf, &self.frames()?)
    }
}

/// Refuses a file that no such board can run.
fn is_firmware(elf: &Path) -> Result<(), String> {
    /// Magic number of ELF with 32 bits, little endian; and the machine, two bytes at byte 18: 40 is Arm.
    const ELF: &[u8] = b"\x7fELF\x01\x01";
    let bytes =
        std::fs::read(elf).map_err(|error| format!("the firmware {} cannot be read: {error}", elf.display()))?;
    if bytes.starts_with(ELF) && bytes.get(18..20) == Some(&[40, 0]) {
        return Ok(());
    }
    Err(format!("{} is not a firmware: it is no ELF file for Arm; build one with `cargo emulate`", elf.display()))
}

/// Reads a stream to its end into a buffer that others look at meanwhile.
fn gather(mut stream: impl Read + Send + 'static, into: Arc<Mutex<Vec<u8>>>) -> JoinHandle<()> {
    thread::spawn(move || {
        let mut chunk = [0; 4096];
        while let Ok(count @ 1..) = stream.read(&mut chunk) {
            into.lock().unwrap_or_else(PoisonError::into_inner).extend(chunk.iter().take(count));
        }
    })
}

/// Reads a stream to its end beside the child that writes it: a full pipe would stop the board.
fn collect(stream: Option<impl Read + Send + 'static>) -> JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            // What came before an error is worth more than the error.
            let _ = stream.read_to_end(&mut bytes);
        }
        bytes
    })
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs an ELF file on an emulated board, its files in `directory`. Returns the `defmt` frames it logged.
///
/// # Errors
/// See [`Run::frames`].
pub fn emulate(board: Board, elf: &Path, directory: &Path) -> Result<Vec<u8>, String> {
    Run::new(board, elf, directory).frames()
}

/// The lines that `defmt` frames of a firmware say.
///
/// # Errors
/// When the ELF file has no `defmt` table or the frames are not its own.
pub fn decoded(elf: &Path, frames: &[u8]) -> Result<Vec<String>, String> {
    let bytes = std::fs::read(elf).map_err(|error| format!("{}: {error}", elf.display()))?;
    let table = defmt_decoder::Table::parse(&bytes).map_err(|error| error.to_string())?;
    let table = table.ok_or("the firmware has no defmt table")?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(frames);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(frame.display_message().to_string()),
            Err(defmt_decoder::DecodeError::UnexpectedEof) => return Ok(lines),
            Err(error) => return Err(error.to_string()),
        }
    }
}
