//! What is built of `firmware-stub`, for which board, and how it is linked.

use std::env;
use std::fs::{self, File};
use std::iter;
use std::path::{Path, PathBuf};

use super::{TARGET, Toolchain, clean, find, run, workspace};

/// Profile of cargo, of what is emulated as of what is flashed: what is counted of the one holds for the other.
const PROFILE: &str = "firmware";

/// What a compiled unit is to cargo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A binary.
    Binary,
    /// An example.
    Example,
    /// The libraries of a package (named in place of a binary): compiled, not linked.
    Library,
}

/// What to build of `firmware-stub`, and for which processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Firmware<'a> {
    /// The binary or example.
    pub binary: &'a str,
    /// Which of the two it is.
    pub unit: Unit,
    /// Cargo features, separated by commas.
    pub features: &'a str,
    /// Target triple.
    pub target: &'a str,
    /// Processor whose instructions are scheduled for.
    pub cpu: &'a str,
    /// Arguments of the linker.
    pub link: &'a [&'a str],
    /// Whether `flip-link` puts the stack below everything else in RAM, so that an overflow faults.
    pub guarded: bool,
}

impl<'a> Firmware<'a> {
    /// A binary for the emulated board.
    #[must_use]
    pub const fn emulated(binary: &'a str) -> Self {
        let link: &[&str] = &["-Tlink.x", "-Tdefmt.x", "--defsym=_board_qemu=1"];
        let unit = Unit::Binary;
        Firmware { binary, unit, features: "board-qemu", target: TARGET, cpu: "cortex-m4", link, guarded: true }
    }

    /// An example for the emulated board.
    #[must_use]
    pub const fn example(binary: &'a str, features: &'a str) -> Self {
        Firmware { unit: Unit::Example, features, ..Self::emulated(binary) }
    }

    /// The firmware of the STM32F405 board; `extra` features choose between silicon and emulator.
    #[must_use]
    pub const fn thruster(features: &'a str) -> Self {
        Firmware { features, link: &["-Tlink.x", "-Tdefmt.x"], ..Self::emulated("thruster") }
    }

    /// A binary that is made for audits: the core by itself, without a board and without `defmt`.
    #[must_use]
    pub const fn audited(binary: &'a str) -> Self {
        let link: &[&str] = &["-Tlink.x", "--defsym=_board_qemu=1"];
        Firmware { features: "audit", link, guarded: false, ..Self::emulated(binary) }
    }

    /// Builds it; returns the ELF file, which no build with other features writes to.
    ///
    /// # Errors
    /// What is missing or went wrong, and what helps.
    pub fn build(&self) -> Result<PathBuf, String> {
        let toolchain = find(self.target)?;
        let linker = if self.guarded { flip_link(&toolchain)? } else { toolchain.linker.clone() };
        let script = self.link.iter().map(|argument| format!("-Clink-arg={argument}"));
        let link: Vec<String> = iter::once(format!("-Clinker={}", linker.display())).chain(script).collect();
        // Cargo links a binary to one path whatever its features are, so the next build of it waits until this one is copied.
        let _turn = turn()?;
        self.cargo(&toolchain, "rustc", &link)?;
        let linked = directory().join(self.target).join(PROFILE);
        match self.unit {
            Unit::Binary => self.copied(&linked.join(self.binary)),
            Unit::Example => self.copied(&linked.join("examples").join(self.binary)),
            Unit::Library => Ok(linked),
        }
    }

    /// Copies what was linked to a path that carries its features.
    fn copied(&self, elf: &Path) -> Result<PathBuf, String> {
        let place = directory().join("images").join(self.target).join(PROFILE);
        let name = format!("{}+{}", self.binary, self.features.replace(',', "+"));
        let (copy, growing) = (place.join(&name), place.join(name + ".part"));
        // Renamed when it is whole: a test may be reading the one before.
        let copied = fs::create_dir_all(&place).and_then(|()| fs::copy(elf, &growing));
        let copied = copied.and_then(|_| fs::rename(&growing, &copy));
        copied.map_err(|error| format!("{} cannot be copied to {}: {error}", elf.display(), copy.display()))?;
        Ok(copy)
    }

    /// Lints it, warnings denied.
    ///
    /// # Errors
    /// What is missing, or what the linter finds.
    pub fn lint(&self) -> Result<(), String> {
        self.cargo(&find(self.target)?, "clippy", &["-Dwarnings".to_owned()])
    }

    /// Runs a command of cargo on it, with arguments for the last call of the compiler.
    fn cargo(&self, toolchain: &Toolchain, verb: &str, last: &[String]) -> Result<(), String> {
        // Called by its own name: cargo would find the linter of another toolchain first.
        let program =
            if verb == "clippy" { toolchain.cargo.with_file_name("cargo-clippy") } else { toolchain.cargo.clone() };
        let mut command = clean(&program);
        command
            .current_dir(workspace())
            .env("CARGO", &toolchain.cargo)
            .env("RUSTC", &toolchain.rustc)
            .env("RUSTFLAGS", format!("-Ctarget-cpu={}", self.cpu))
            // The workspace's own settings for the target are those of the real board.
            .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", &toolchain.linker)
            .env("DEFMT_LOG", "info")
            .env("PATH", path_with(&linkers()))
            .args([verb, "--profile", PROFILE, "--locked", "--target", self.target, "--target-dir"])
            .arg(directory());
        match self.unit {
            Unit::Binary => command.args(["-p", "firmware-stub", "--bin", self.binary]),
            Unit::Example => command.args(["-p", "firmware-stub", "--example", self.binary]),
            Unit::Library => command.args(["-p", self.binary, "--lib"]),
        };
        if !self.features.is_empty() {
            command.args(["--features", self.features]);
        }
        if toolchain.build_std {
            // Building `core` is a nightly feature of cargo; the bootstrap switch is how a distribution's compiler
            // allows it. `alloc` is for the image that proves that the audits find a heap.
            command.env("RUSTC_BOOTSTRAP", "1").arg("-Zbuild-std=core,alloc");
        }
        // Only the last link takes the linker's arguments, so that all images share what is compiled before it.
        let output = run(command.arg("--").args(last))?;
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        Err(format!("cargo {verb} fails for {} ({}):\n{said}", self.binary, self.features))
    }
}

/// A directory of its own: the outer cargo holds the lock of the other one.
fn directory() -> PathBuf {
    workspace().join("target/firmware")
}

/// Waits for the turn to build, of all threads and processes; it ends when the file is dropped.
fn turn() -> Result<File, String> {
    let place = directory().join("build.lock");
    let taken = fs::create_dir_all(directory()).and_then(|()| File::create(&place));
    let taken = taken.and_then(|file| file.lock().map(|()| file));
    taken.map_err(|error| format!("{} cannot be locked: {error}", place.display()))
}

/// Where `flip-link` finds the linker by the one name it knows.
fn linkers() -> PathBuf {
    directory().join("linker")
}

/// The path of commands, with a directory before all others.
fn path_with(first: &Path) -> std::ffi::OsString {
    let old = env::var_os("PATH").unwrap_or_default();
    let all = iter::once(first.to_owned()).chain(env::split_paths(&old));
    env::join_paths(all).unwrap_or(old)
}

/// `flip-link`, from the path of commands or where cargo installs to, with the linker it calls made known to it.
fn flip_link(toolchain: &Toolchain) -> Result<PathBuf, String> {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| env::home_dir().map(|home| home.join(".cargo")));
    let on_path = env::var_os("PATH").into_iter().flat_map(|path| env::split_paths(&path).collect::<Vec<_>>());
    let found = on_path.chain(home.map(|home| home.join("bin"))).map(|place| place.join("flip-link"));
    let found = found.into_iter().find(|path| path.is_file());
    let found = found.ok_or(
        "flip-link is missing, which puts the stack where an overflow faults: run `cargo install flip-link --locked`",
    )?;
    let link = linkers().join("rust-lld");
    fs::create_dir_all(linkers()).map_err(|error| error.to_string())?;
    if fs::read_link(&link).ok().as_deref() != Some(toolchain.linker.as_path()) {
        // Two tests may get here at once; either leaves the same link.
        let _ = fs::remove_file(&link);
        let _ = std::os::unix::fs::symlink(&toolchain.linker, &link);
    }
    Ok(found)
}
