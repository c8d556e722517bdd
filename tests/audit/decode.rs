//! One Thumb instruction: what it reads, what it writes, where it goes next.
//!
//! Capstone does the decoding; three things it gets wrong or leaves out are put right here, and each is pinned by a test:
//! the condition inside an IT block (capstone is given the block's header with every instruction, so it cannot lose
//! it), the registers of multiple loads and stores, and the flags. An encoding that capstone does not know is an error.
//!
//! What it cannot see: the values. Also the cumulative exception bits that VFP arithmetic leaves in FPSCR: only
//! `vmrs rN, fpscr` could read them, and it is marked as reading [`Register::FPSCR`], which arithmetic is not marked as
//! writing.

mod access;
mod flow;
mod memory;
mod register;
#[cfg(test)]
mod tests;

use std::fmt;

use capstone::arch::arm::{ArchExtraMode, ArchMode, ArmInsnDetail, ArmOperand, ArmOperandType};
use capstone::prelude::*;

pub use flow::Flow;
pub use memory::Memory;
pub use register::{Register, Registers};

/// When an instruction is executed (Arm DDI 0403, table A7-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Condition(u8);

impl Condition {
    const ALWAYS: u8 = 14;
    const NAMES: [&str; 14] = ["eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];

    /// None for "always".
    fn new(code: u8) -> Option<Self> {
        (code < Self::ALWAYS).then_some(Condition(code))
    }

    /// The suffix in assembly.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES[usize::from(self.0)]
    }

    /// The flags it looks at.
    #[must_use]
    pub fn flags(self) -> Registers {
        use Register as R;
        Registers::of(match self.0 >> 1 {
            0 => &[R::Z],
            1 => &[R::C],
            2 => &[R::N],
            3 => &[R::V],
            4 => &[R::C, R::Z],
            5 => &[R::N, R::V],
            _ => &[R::N, R::Z, R::V],
        })
    }
}

/// Where in an IT block the decoder is: the ITSTATE of the architecture (Arm DDI 0403, A7.3.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ItState(u8);

impl ItState {
    /// The condition code of the next instruction; none outside a block.
    fn condition(self) -> Option<u8> {
        (self.0 & 0xF != 0).then_some(self.0 >> 4)
    }

    fn advance(self) -> Self {
        ItState(if self.0 & 7 == 0 { 0 } else { self.0 & 0xE0 | self.0 << 1 & 0x1F })
    }
}

/// One instruction.
#[derive(Clone, Debug)]
pub struct Instruction {
    /// Where it is.
    pub address: u32,
    /// Bytes: 2 or 4.
    pub size: u32,
    /// What it does, without condition, width, type and flag suffixes: `add`, `vadd`, `ldr`, `b`.
    pub mnemonic: String,
    /// The mnemonic with its suffixes, as an assembler writes it.
    pub full_mnemonic: String,
    /// The operands, as an assembler writes them.
    pub operands: String,
    /// When it is executed, if not always: of a conditional branch, or inside an IT block.
    pub condition: Option<Condition>,
    /// It stands inside an IT block.
    pub in_it_block: bool,
    /// It sets condition flags of the APSR.
    pub sets_flags: bool,
    /// What its result depends on: registers, flags, and the base and index of a memory operand. A write that leaves
    /// part of its register as it was reads it too. Not the flags of [`condition`](Self::condition).
    pub reads: Registers,
    /// What it may change.
    pub writes: Registers,
    /// Of [`writes`](Self::writes), flags that may stay as they were: the carry of a logical instruction.
    pub keeps: Registers,
    /// The memory it touches.
    pub memory: Option<Memory>,
    /// The last number among its operands.
    pub immediate: Option<i64>,
    /// Where it goes next.
    pub flow: Flow,
}

impl Instruction {
    /// The address behind it.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.address + self.size
    }

    /// Whether the next instruction in memory may follow it.
    #[must_use]
    pub fn falls_through(&self) -> bool {
        self.condition.is_some()
            || matches!(self.flow, Flow::Next | Flow::Branch(_) | Flow::Call(_) | Flow::IndirectCall)
    }

    /// The address of a constant that it loads relative to the program counter.
    #[must_use]
    pub fn literal(&self) -> Option<u32> {
        let memory = self.memory.as_ref().filter(|m| m.load && m.base == Register::PC && m.index.is_none())?;
        // The base is the program counter, two instructions ahead, rounded down to a word (Arm DDI 0403, A5.1.2).
        Some(((self.address + 4) & !3).wrapping_add_signed(memory.offset))
    }
}

impl fmt::Display for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.full_mnemonic, self.operands)
    }
}

/// Decodes Thumb-2 with the single-precision floating-point extension (Armv7E-M; Armv6-M is a subset).
pub struct Decoder {
    capstone: Capstone,
}

impl Decoder {
    /// # Errors
    /// Capstone was built without Arm.
    pub fn new() -> Result<Self, String> {
        let thumb = Capstone::new().arm().mode(ArchMode::Thumb);
        let capstone = thumb.extra_mode([ArchExtraMode::MClass].into_iter()).detail(true).build();
        Ok(Decoder { capstone: capstone.map_err(|error| format!("the disassembler does not start: {error}"))? })
    }

    /// Decodes the instruction at the start of `bytes`, which stands at `address`. `it` carries the IT block from one
    /// instruction to the next; it starts as [`ItState::default`].
    ///
    /// # Errors
    /// The bytes are no instruction that the decoder knows.
    pub fn decode(&self, bytes: &[u8], address: u32, it: &mut ItState) -> Result<Instruction, String> {
        let unknown =
            || format!("no known instruction at {address:#010x}: bytes {:02x?}", bytes.get(..4).unwrap_or(bytes));
        let size = if bytes.get(1).ok_or_else(unknown)? >> 3 >= 0b11101 { 4 } else { 2 };
        let encoded = bytes.get(..size).ok_or_else(unknown)?;
        let block = it.condition();
        // Inside a block capstone gets a header of one instruction before it: `it <condition>`.
        let header = block.map_or(Vec::new(), |condition| vec![condition << 4 | 8, 0xBF]);
        let start = u64::from(address).wrapping_sub(header.len() as u64);
        let code: Vec<u8> = header.iter().chain(encoded).copied().collect();
        let wanted = 1 + usize::from(block.is_some());
        let decoded = self.capstone.disasm_count(&code, start, wanted).map_err(|_| unknown())?;
        let found = decoded.get(wanted - 1).filter(|found| found.len() == size).ok_or_else(unknown)?;
        let detail = self.capstone.insn_detail(found).map_err(|_| unknown())?;
        let arch = detail.arch_detail();
        let parts = Parts::new(&self.capstone, found, arch.arm().ok_or_else(unknown)?, encoded);
        *it = it.advance();
        if parts.mnemonic == "it" {
            *it = ItState(encoded[0]);
        }
        Ok(parts.instruction(address, block))
    }
}

/// An operand, with the registers of capstone replaced by ours.
#[derive(Clone, Debug)]
enum Operand {
    Registers(Registers, Vec<Register>, Access),
    Memory { base: Register, index: Option<Register>, shift: u32, displacement: i32 },
    Immediate(i64),
    Other,
}

/// How an operand is used; unknown is treated as whatever is safe at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Access {
    read: bool,
    written: bool,
}

/// What capstone says of one instruction.
struct Parts {
    mnemonic: String,
    full_mnemonic: String,
    text: String,
    operands: Vec<Operand>,
    writeback: bool,
    size: u32,
    /// The condition in the encoding of a branch.
    own_condition: Option<Condition>,
}

impl Parts {
    fn new(capstone: &Capstone, found: &capstone::Insn<'_>, detail: &ArmInsnDetail<'_>, encoded: &[u8]) -> Self {
        let full_mnemonic = found.mnemonic().unwrap_or_default().to_owned();
        let mnemonic = match capstone.insn_name(found.id()).unwrap_or_default().as_str() {
            "fconsts" | "fconstd" => "vmov".to_owned(),
            "fmstat" => "vmrs".to_owned(),
            // `nop`, `wfi`, `wfe`, `sev` and `yield` under one name.
            "hint" => full_mnemonic.trim().split('.').next().unwrap_or_default().to_owned(),
            "vldm" => "vldmia".to_owned(),
            "vstm" => "vstmia".to_owned(),
            other => other.to_owned(),
        };
        let operands = detail.operands().enumerate().map(|(place, operand)| ours(capstone, place, &operand)).collect();
        Parts {
            own_condition: branch_condition(encoded),
            mnemonic,
            full_mnemonic,
            text: found.op_str().unwrap_or_default().to_owned(),
            operands,
            writeback: detail.writeback(),
            size: encoded.len() as u32,
        }
    }

    fn instruction(self, address: u32, block: Option<u8>) -> Instruction {
        let condition = block.map_or(self.own_condition, Condition::new);
        let memory = memory::of(&self);
        let flow = flow::of(&self, memory.as_ref());
        let effects = access::of(&self, memory.as_ref(), &flow);
        let number = |operand: &Operand| if let Operand::Immediate(number) = operand { Some(*number) } else { None };
        Instruction {
            address,
            size: self.size,
            condition,
            in_it_block: block.is_some(),
            sets_flags: access::sets_flags(&self),
            reads: effects.reads,
            writes: effects.writes,
            keeps: effects.keeps,
            memory,
            immediate: self.operands.iter().rev().find_map(number),
            flow,
            mnemonic: self.mnemonic,
            full_mnemonic: self.full_mnemonic,
            operands: self.text,
        }
    }

    /// The register that an operand is, if it is one.
    fn register(&self, place: usize) -> Option<Register> {
        match self.operands.get(place) {
            Some(Operand::Registers(_, list, _)) => list.first().copied(),
            _ => None,
        }
    }
}

/// The condition in the encoding of `b<condition>` (Arm DDI 0403, A7.7.12, encodings T1 and T3).
fn branch_condition(encoded: &[u8]) -> Option<Condition> {
    match *encoded {
        [_, high] if high >> 4 == 0b1101 => Condition::new(high & 0xF),
        [low, high, _, second] if high >> 3 == 0b11110 && second & 0xD0 == 0x80 => {
            Condition::new((high & 3) << 2 | low >> 6)
        }
        _ => None,
    }
}

fn ours(capstone: &Capstone, place: usize, operand: &ArmOperand) -> Operand {
    let named = |id| Register::named(&capstone.reg_name(id).unwrap_or_default());
    match &operand.op_type {
        ArmOperandType::Reg(id) => {
            let list = named(*id);
            let shifted_by = match operand.shift {
                capstone::arch::arm::ArmShift::AsrReg(id)
                | capstone::arch::arm::ArmShift::LslReg(id)
                | capstone::arch::arm::ArmShift::LsrReg(id)
                | capstone::arch::arm::ArmShift::RorReg(id) => named(id),
                _ => Vec::new(),
            };
            let access = match operand.access {
                Some(access) => Access { read: access.is_readable(), written: access.is_writable() },
                // Capstone leaves some out: sources of saturation and packing. A first operand may be a target.
                None => Access { read: true, written: place == 0 },
            };
            Operand::Registers(Registers::of(&shifted_by), list, access)
        }
        ArmOperandType::Mem(memory) => Operand::Memory {
            base: named(memory.base()).first().copied().unwrap_or(Register::PC),
            index: named(memory.index()).first().copied(),
            shift: if let capstone::arch::arm::ArmShift::Lsl(shift) = operand.shift { shift } else { 0 },
            displacement: memory.disp(),
        },
        ArmOperandType::Imm(number) => Operand::Immediate(i64::from(*number)),
        _ => Operand::Other,
    }
}
