//! What an instruction reads and writes.

use super::{Flow, Memory, Operand, Parts, Register, Registers};

/// Compares: they have no target but the flags.
const COMPARES: [&str; 4] = ["cmp", "cmn", "tst", "teq"];

/// Writes that leave part of their target as it was, which capstone does not say of them.
const MERGES: [&str; 8] = ["smlal", "umlal", "umaal", "smlsld", "vcvtb", "vcvtt", "movt", "bfi"];

/// What an instruction does to registers and flags.
#[derive(Clone, Copy, Default)]
pub(super) struct Effects {
    /// What its results depend on.
    pub(super) reads: Registers,
    /// What it may change.
    pub(super) writes: Registers,
    /// Of these, what may stay as it was.
    pub(super) keeps: Registers,
}

pub(super) fn of(parts: &Parts, memory: Option<&Memory>, flow: &Flow) -> Effects {
    let (reads, mut writes) = if let Some(memory) = memory { of_memory(parts, memory) } else { of_operands(parts) };
    let flags = flags(parts);
    let reads = reads.union(flags.reads);
    writes = writes.union(flags.writes);
    if parts.mnemonic == "msr" && parts.text.starts_with("msp") {
        writes = writes.union(Registers::of(&[Register::SP]));
    }
    match flow {
        Flow::Call(_) | Flow::IndirectCall => writes = writes.union(Registers::of(&[Register::LR, Register::PC])),
        Flow::Next => {}
        _ => writes = writes.union(Registers::of(&[Register::PC])),
    }
    Effects { reads, writes, keeps: flags.keeps }
}

/// Whether it sets condition flags: an `s` behind the plain mnemonic, or a compare.
pub(super) fn sets_flags(parts: &Parts) -> bool {
    let plain = parts.full_mnemonic.split('.').next().unwrap_or_default();
    let suffixed = plain.strip_prefix(parts.mnemonic.as_str()).is_some_and(|suffix| suffix.starts_with('s'));
    let moved = parts.mnemonic == "vmrs" && parts.text.starts_with("apsr");
    COMPARES.contains(&parts.mnemonic.as_str()) || suffixed || moved || writes_status(parts)
}

fn writes_status(parts: &Parts) -> bool {
    parts.mnemonic == "msr" && parts.text.contains("psr")
}

fn of_memory(parts: &Parts, memory: &Memory) -> (Registers, Registers) {
    let moved = Registers::of(&memory.registers);
    let base = Registers::of(&[memory.base]);
    let address = memory.index.map_or(base, |index| base.union(Registers::of(&[index])));
    let (mut reads, mut writes) = if memory.load { (address, moved) } else { (address.union(moved), Registers::NONE) };
    if memory.writeback != 0 {
        writes = writes.union(base);
    }
    if parts.mnemonic.starts_with("strex") {
        // Whether the store was done stands in the first operand.
        writes = writes.union(Registers::of(&parts.register(0).into_iter().collect::<Vec<_>>()));
    }
    if parts.mnemonic.starts_with("tb") {
        reads = reads.union(Registers::of(&[Register::PC]));
    }
    (reads, writes)
}

fn of_operands(parts: &Parts) -> (Registers, Registers) {
    let name = parts.mnemonic.as_str();
    let merges = MERGES.iter().any(|merge| name.starts_with(merge));
    let (mut reads, mut writes) = (Registers::NONE, Registers::NONE);
    for operand in &parts.operands {
        let Operand::Registers(shifted_by, list, access) = operand else { continue };
        let registers = Registers::of(list);
        reads = reads.union(*shifted_by);
        if access.read || merges {
            reads = reads.union(registers);
        }
        if access.written && !COMPARES.contains(&name) {
            writes = writes.union(registers);
        }
    }
    match name {
        "vmrs" => of_status(parts, false),
        "vmsr" => of_status(parts, true),
        "vcmp" | "vcmpe" => (reads, writes.union(Registers::of(&[Register::FPSCR_FLAGS]))),
        _ => (reads, writes),
    }
}

/// Moves between a register and the floating-point status.
fn of_status(parts: &Parts, to_status: bool) -> (Registers, Registers) {
    let other = usize::from(to_status);
    let of = |place: usize| match parts.operands.get(place) {
        Some(Operand::Registers(_, list, _)) => Registers::of(list),
        _ => Registers::NONE,
    };
    let status = Registers::of(&[Register::FPSCR_FLAGS, Register::FPSCR]);
    if parts.text.starts_with("apsr") {
        return (Registers::of(&[Register::FPSCR_FLAGS]), Registers::FLAGS);
    }
    if to_status { (of(other), status) } else { (status, of(other)) }
}

/// The flags, beside those of a condition.
fn flags(parts: &Parts) -> Effects {
    use Register as R;
    let name = parts.mnemonic.as_str();
    let mut flags = Effects::default();
    let mut add = |reads: &[R], writes: Registers, keeps: &[R]| {
        flags.reads = flags.reads.union(Registers::of(reads));
        flags.writes = flags.writes.union(writes);
        flags.keeps = flags.keeps.union(Registers::of(keeps));
    };
    if sets_flags(parts) && name != "vmrs" {
        match name {
            "mul" => add(&[], Registers::of(&[R::N, R::Z]), &[]),
            // The carry of a logical instruction or a shift comes from its shifter, which may leave it as it was.
            "and" | "orr" | "eor" | "bic" | "orn" | "mvn" | "mov" | "tst" | "teq" | "lsl" | "lsr" | "asr" | "ror"
            | "rrx" => add(&[], Registers::of(&[R::N, R::Z, R::C]), &[R::C]),
            _ => add(&[], Registers::FLAGS, &[]),
        }
    }
    match name {
        "adc" | "sbc" | "rrx" => add(&[R::C], Registers::NONE, &[]),
        "sel" => add(&[R::GE], Registers::NONE, &[]),
        "mrs" if parts.text.contains("psr") => add(&[R::N, R::Z, R::C, R::V, R::Q, R::GE], Registers::NONE, &[]),
        "msr" if writes_status(parts) => add(&[], Registers::of(&[R::Q, R::GE]), &[R::Q, R::GE]),
        _ if is_parallel(name) => add(&[], Registers::of(&[R::GE]), &[]),
        // The flag stays set once it is.
        _ if saturates(name) => add(&[], Registers::of(&[R::Q]), &[R::Q]),
        _ => {}
    }
    flags
}

/// `sadd8`, `uasx` and their kind.
fn is_parallel(name: &str) -> bool {
    let body = name.strip_prefix('s').or_else(|| name.strip_prefix('u'));
    body.is_some_and(|body| ["add8", "add16", "sub8", "sub16", "asx", "sax"].contains(&body))
}

/// Instructions that may set Q.
fn saturates(name: &str) -> bool {
    let long = name.starts_with("smlal") || name.starts_with("smlsld");
    ["qadd", "qsub", "qdadd", "qdsub", "ssat", "usat", "ssat16", "usat16"].contains(&name)
        || !long && ["smla", "smlsd", "smuad"].iter().any(|prefix| name.starts_with(prefix))
}
