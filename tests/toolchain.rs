//! Builds the firmware and runs it in emulation, with what a machine happens to have.
//!
//! A developer's rustup has the target installed; a bare Debian machine can build `core` from the sources its own
//! packages bring. [`build`] tries in that order and says what is missing when neither works. Nothing is downloaded.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The target of the firmware: Cortex-M4F with hardware floating point.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Where Debian's packages put their compiler, beside rustup's.
const DEBIAN: (&str, &str) = ("/usr/bin/cargo", "/usr/bin/rustc");

/// Linkers that understand `memory.x`, by the names packages give them.
const LINKERS: [&str; 4] = ["rust-lld", "ld.lld", "ld.lld-19", "ld.lld-22"];

/// A way to build for the target.
#[derive(Clone, Debug)]
struct Toolchain {
    cargo: PathBuf,
    rustc: PathBuf,
    /// `core` is not installed for the target and is built from source.
    build_std: bool,
    linker: PathBuf,
}

/// The workspace this crate stands in.
#[must_use]
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// Builds a binary of `firmware-stub` for the emulated board; returns the ELF file.
///
/// # Errors
/// What is missing or went wrong, and what helps.
pub fn build(binary: &str) -> Result<PathBuf, String> {
    build_with(binary, "board-qemu", &[])
}

/// The same with other features, and with object files that the linker takes in.
///
/// # Errors
/// See [`build`].
pub fn build_with(binary: &str, features: &str, objects: &[PathBuf]) -> Result<PathBuf, String> {
    let toolchain = find()?;
    // A directory of its own: the outer cargo holds the lock of the other one.
    let directory = workspace().join("target/firmware");
    let linker = toolchain.linker.display();
    let flags = format!(
        "-Clink-arg=-Tlink.x -Clink-arg=-Tdefmt.x -Clink-arg=--defsym=_board_qemu=1 -Clinker={linker} -Ctarget-cpu=cortex-m4"
    );
    let mut command = clean(&toolchain.cargo);
    command
        .current_dir(workspace())
        .env("RUSTC", &toolchain.rustc)
        .env("RUSTFLAGS", flags)
        .env("DEFMT_LOG", "info")
        .args(["rustc", "--release", "--locked", "-p", "firmware-stub", "--features", features, "--bin", binary])
        .args(["--target", TARGET, "--target-dir"])
        .arg(&directory);
    if toolchain.build_std {
        // Building `core` is a nightly feature of cargo; the bootstrap switch is how a distribution's compiler allows it.
        command.env("RUSTC_BOOTSTRAP", "1").arg("-Zbuild-std=core");
    }
    // Of the binary alone: a flag for all crates would build every one of them again.
    command.arg("--").args(objects.iter().map(|object| format!("-Clink-arg={}", object.display())));
    let output = run(&mut command)?;
    if !output.status.success() {
        return Err(format!("the firmware does not build:\n{}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(directory.join(TARGET).join("release").join(binary))
}

/// An emulated board: same memory map, same firmware, another core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// QEMU's `mps2-an386`: Cortex-M4F.
    CortexM4,
    /// QEMU's `mps2-an500`: Cortex-M7.
    CortexM7,
}

/// Runs an ELF file on an emulated board, its files in `directory`. Returns the `defmt` frames it logged.
///
/// # Errors
/// What is missing, or what the board said when its exit code was not zero.
pub fn emulate(board: Board, elf: &Path, directory: &Path) -> Result<Vec<u8>, String> {
    let mut command = emulator(board, elf, directory);
    let output =
        run(&mut command).map_err(|error| format!("{error}; install it with: apt-get install qemu-system-arm"))?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let said = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat();
    Err(format!("the board left with {}: {said}", output.status))
}

/// The command that runs an ELF file on an emulated board, its files in `directory`.
#[must_use]
pub fn emulator(board: Board, elf: &Path, directory: &Path) -> Command {
    let (machine, core) = match board {
        Board::CortexM4 => ("mps2-an386", "cortex-m4"),
        Board::CortexM7 => ("mps2-an500", "cortex-m7"),
    };
    let mut command = clean(Path::new("qemu-system-arm"));
    command
        .current_dir(directory)
        .args(["-machine", machine, "-cpu", core, "-nographic", "-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf);
    command
}

/// Compiles a file of C for the target; none when the compiler is not installed.
///
/// # Errors
/// What the compiler says.
pub fn compile_c(source: &Path) -> Result<Option<PathBuf>, String> {
    let object = workspace().join("target/firmware").join(source.file_name().unwrap_or_default()).with_extension("o");
    std::fs::create_dir_all(workspace().join("target/firmware")).map_err(|error| error.to_string())?;
    let mut command = clean(Path::new("arm-none-eabi-gcc"));
    command
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-ffreestanding", "-O3"])
        .args(["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "-c", "-o"])
        .args([&object, source]);
    let Ok(output) = command.output() else { return Ok(None) };
    if !output.status.success() {
        return Err(format!("{} does not compile:\n{}", source.display(), String::from_utf8_lossy(&output.stderr)));
    }
    Ok(Some(object))
}

/// The lines that `defmt` frames of a firmware say.
///
/// # Errors
/// When the ELF file has no `defmt` table or the frames are not its own.
pub fn decoded(elf: &Path, frames: &[u8]) -> Result<Vec<String>, String> {
    let bytes = std::fs::read(elf).map_err(|error| error.to_string())?;
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

/// The first toolchain that can build for the target.
fn find() -> Result<Toolchain, String> {
    let active = ("cargo", "rustc");
    for (cargo, rustc) in [active, DEBIAN] {
        let (cargo, rustc) = (PathBuf::from(cargo), PathBuf::from(rustc));
        let build_std = !has_core(&rustc);
        if build_std && !has_source(&rustc) {
            continue;
        }
        if let Some(linker) = linker() {
            return Ok(Toolchain { cargo, rustc, build_std, linker });
        }
    }
    Err(format!(
        "no toolchain here can build for {TARGET}: run `rustup target add {TARGET}`, or on Debian \
         `apt-get install rustc-web cargo-web rust-web-src lld-19`"
    ))
}

fn has_core(rustc: &Path) -> bool {
    let library = printed(rustc, &["--print", "target-libdir", "--target", TARGET]);
    let entries = library.and_then(|directory| std::fs::read_dir(directory).ok());
    entries.is_some_and(|entries| {
        entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
    })
}

fn has_source(rustc: &Path) -> bool {
    let root = printed(rustc, &["--print", "sysroot"]);
    root.is_some_and(|root| Path::new(&root).join("lib/rustlib/src/rust/library/core/Cargo.toml").exists())
}

/// The linker that comes with the active toolchain, or one on the path.
fn linker() -> Option<PathBuf> {
    let rustc = Path::new("rustc");
    let bundled = printed(rustc, &["--print", "sysroot"]).zip(printed(rustc, &["--print", "host-tuple"]));
    let bundled = bundled.map(|(root, host)| Path::new(&root).join("lib/rustlib").join(host).join("bin/rust-lld"));
    let on_path = env::var_os("PATH").into_iter().flat_map(|path| env::split_paths(&path).collect::<Vec<_>>());
    let on_path = on_path.flat_map(|directory| LINKERS.map(|name| directory.join(name)));
    bundled.into_iter().chain(on_path).find(|path| path.is_file())
}

fn printed(rustc: &Path, arguments: &[&str]) -> Option<String> {
    let output = clean(rustc).args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn run(command: &mut Command) -> Result<Output, String> {
    let program = command.get_program().to_string_lossy().into_owned();
    command.output().map_err(|error| format!("cannot run {program}: {error}"))
}

/// A command without what the outer cargo has set for itself: a nested cargo would build with it.
fn clean(program: &Path) -> Command {
    let mut command = Command::new(program);
    for (name, _) in env::vars_os() {
        let name = name.to_string_lossy();
        let of_cargo = name.starts_with("CARGO") && name != "CARGO_HOME";
        if of_cargo || ["RUSTC", "RUSTFLAGS", "RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH"].contains(&&*name) {
            command.env_remove(&*name);
        }
    }
    command
}
