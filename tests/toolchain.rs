//! Builds the firmware and runs it in emulation, with what a machine happens to have.
//!
//! A developer's rustup has the target installed; a bare Debian machine can build `core` from the sources its own
//! packages bring. [`Firmware::build`] tries in that order and says what is missing when neither works. Nothing is
//! downloaded.

mod emulator;
mod firmware;

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub use emulator::{Board, Run, decoded, emulate};
pub use firmware::{Firmware, Unit};

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
    Firmware::emulated(binary).build()
}

/// The compiler that builds firmware, as it names itself.
///
/// # Errors
/// No toolchain can build for the target.
pub fn compiler() -> Result<String, String> {
    let rustc = find(TARGET)?.rustc;
    printed(&rustc, &["--version"]).ok_or_else(|| format!("{} does not say its version", rustc.display()))
}

/// The first toolchain that can build for a target.
fn find(target: &str) -> Result<Toolchain, String> {
    let active = ("cargo", "rustc");
    for (cargo, rustc) in [active, DEBIAN] {
        let (cargo, rustc) = (PathBuf::from(cargo), PathBuf::from(rustc));
        let build_std = !has_core(&rustc, target);
        if build_std && !has_source(&rustc) {
            continue;
        }
        if let Some(linker) = linker() {
            return Ok(Toolchain { cargo, rustc, build_std, linker });
        }
    }
    Err(format!(
        "no toolchain here can build for {target}: run `rustup target add {target}`, or on Debian \
         `apt-get install rustc-web cargo-web rust-web-src lld-19`"
    ))
}

fn has_core(rustc: &Path, target: &str) -> bool {
    let library = printed(rustc, &["--print", "target-libdir", "--target", target]);
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
