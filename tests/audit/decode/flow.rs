//! Where an instruction goes next.

use super::{Memory, Operand, Parts, Register};

/// Where an instruction goes next, when it is executed. If its condition does not hold, the next one in memory follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// To the next instruction in memory.
    Next,
    /// To an address.
    Jump(u32),
    /// To an address or to the next instruction: `b<condition>`, `cbz`, `cbnz`.
    Branch(u32),
    /// Calls a function and comes back.
    Call(u32),
    /// Calls what a register holds.
    IndirectCall,
    /// Back to the caller.
    Return,
    /// To what a register or a memory cell holds.
    IndirectJump,
    /// By a table of branch distances that stands behind the instruction.
    Table {
        /// Bytes of an entry: 1 or 2.
        entry: u32,
    },
    /// Nowhere: an undefined instruction, which faults.
    Stop,
}

pub(super) fn of(parts: &Parts, memory: Option<&Memory>) -> Flow {
    let writes_pc = parts.register(0) == Some(Register::PC);
    let target = || match parts.operands.last() {
        Some(Operand::Immediate(number)) => Some(*number as u32),
        _ => None,
    };
    match parts.mnemonic.as_str() {
        "b" => match (target(), parts.own_condition) {
            (Some(target), Some(_)) => Flow::Branch(target),
            (Some(target), None) => Flow::Jump(target),
            (None, _) => Flow::IndirectJump,
        },
        "cbz" | "cbnz" => target().map_or(Flow::IndirectJump, Flow::Branch),
        "bl" => target().map_or(Flow::IndirectCall, Flow::Call),
        "blx" | "blxns" => Flow::IndirectCall,
        "bx" | "mov"
            if parts.register(usize::from(parts.mnemonic == "mov")) == Some(Register::LR)
                && (parts.mnemonic == "bx" || writes_pc) =>
        {
            Flow::Return
        }
        "bx" | "bxns" => Flow::IndirectJump,
        "tbb" => Flow::Table { entry: 1 },
        "tbh" => Flow::Table { entry: 2 },
        "udf" => Flow::Stop,
        _ => match memory {
            // `pop {.., pc}`, `ldm sp!, {.., pc}`, `ldr pc, [sp], #n`: what the entry of the function pushed.
            Some(m) if m.load && m.registers.contains(&Register::PC) && m.base == Register::SP && m.index.is_none() => {
                Flow::Return
            }
            Some(m) if m.load && m.registers.contains(&Register::PC) => Flow::IndirectJump,
            None if writes_pc && !["cmp", "cmn", "tst", "teq"].contains(&parts.mnemonic.as_str()) => Flow::IndirectJump,
            _ => Flow::Next,
        },
    }
}
