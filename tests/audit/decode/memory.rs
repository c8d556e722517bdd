//! The memory operand of a load or store.

use super::{Operand, Parts, Register};

/// What a load or store touches: [`size`](Self::size) bytes from
/// `base + (index << shift) + offset` on; then [`writeback`](Self::writeback) is added to the base.
///
/// Relative to the program counter the base is `(address + 4)` rounded down to a word; of `tbb` and `tbh` it is not
/// rounded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Register of the base.
    pub base: Register,
    /// Register that is added, shifted left.
    pub index: Option<Register>,
    /// By how many bits.
    pub shift: u32,
    /// From the base to the lowest byte touched.
    pub offset: i32,
    /// What is added to the base afterwards; zero if it stays.
    pub writeback: i32,
    /// Memory is read; else written.
    pub load: bool,
    /// Bytes touched.
    pub size: u32,
    /// What is loaded or stored, from the lowest address on. Empty for the entry that `tbb` and `tbh` read.
    pub registers: Vec<Register>,
}

/// The memory operand of an instruction; prefetches touch nothing.
pub(super) fn of(parts: &Parts) -> Option<Memory> {
    let name = parts.mnemonic.as_str();
    match name {
        "push" | "vpush" | "pop" | "vpop" => {
            Some(list(parts, Some(Register::SP), name.ends_with("pop"), name.ends_with("push")))
        }
        "ldm" | "ldmdb" | "vldmia" | "vldmdb" => Some(list(parts, None, true, name.ends_with("db"))),
        "stm" | "stmdb" | "vstmia" | "vstmdb" => Some(list(parts, None, false, name.ends_with("db"))),
        _ if name.starts_with("pl") => None,
        _ => single(parts),
    }
}

/// Multiple loads and stores. `base` is the implied one, else it is the first operand.
fn list(parts: &Parts, base: Option<Register>, load: bool, down: bool) -> Memory {
    let skipped = usize::from(base.is_none());
    let registers = registers(parts, skipped, parts.operands.len());
    let size = 4 * registers.len() as u32;
    let writeback = if base.is_some() || parts.writeback { size as i32 } else { 0 };
    Memory {
        base: base.or_else(|| parts.register(0)).unwrap_or(Register::PC),
        index: None,
        shift: 0,
        offset: if down { -(size as i32) } else { 0 },
        writeback: if down { -writeback } else { writeback },
        load,
        size,
        registers,
    }
}

/// Loads and stores with an address operand.
fn single(parts: &Parts) -> Option<Memory> {
    let place = parts.operands.iter().position(|operand| matches!(operand, Operand::Memory { .. }))?;
    let Operand::Memory { base, index, shift, displacement } = parts.operands[place].clone() else { return None };
    let name = parts.mnemonic.as_str();
    // `strex` has the register of its success before what it stores.
    let first = usize::from(name.starts_with("strex"));
    let registers = registers(parts, first, place);
    let behind = match parts.operands.get(place + 1) {
        Some(Operand::Immediate(number)) => Some(*number as i32),
        _ => None,
    };
    let writeback = if parts.writeback { behind.unwrap_or(displacement) } else { 0 };
    let load = !name.starts_with("st") && !name.starts_with("vst");
    let size = width(name).unwrap_or(4 * registers.len() as u32);
    let registers = if name.starts_with("tb") { Vec::new() } else { registers };
    Some(Memory { base, index, shift, offset: displacement, writeback, load, size, registers })
}

fn registers(parts: &Parts, from: usize, to: usize) -> Vec<Register> {
    let operands = parts.operands.get(from..to).unwrap_or_default();
    let lists = operands.iter().filter_map(|operand| match operand {
        Operand::Registers(_, list, _) => Some(list.as_slice()),
        _ => None,
    });
    lists.flatten().copied().collect()
}

/// Bytes of an access that is not of whole words.
fn width(name: &str) -> Option<u32> {
    match name {
        "tbb" | "ldrb" | "ldrsb" | "strb" | "ldrbt" | "ldrsbt" | "strbt" | "ldrexb" | "strexb" => Some(1),
        "tbh" | "ldrh" | "ldrsh" | "strh" | "ldrht" | "ldrsht" | "strht" | "ldrexh" | "strexh" => Some(2),
        _ => None,
    }
}
