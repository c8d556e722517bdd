//! Where the stack pointer is before and behind an instruction, and which registers hold a place on the stack.

use super::SP;
use crate::audit::decode::{Flow, Instruction, Register};

/// What is known of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    /// Nothing.
    Unknown,
    /// The stack pointer at the entry of the function, less so many bytes (more after a re-alignment is impossible, so
    /// this is the lowest it can be).
    Below(i64),
    /// A number.
    Number(i64),
}

/// What is known of the core registers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct State {
    registers: [Value; 16],
    /// The stack pointer was set to a fresh stack: there is no way back.
    fresh: bool,
}

impl State {
    pub(super) fn at_entry() -> Self {
        let mut state = State { registers: [Value::Unknown; 16], fresh: false };
        state.set(SP, Value::Below(0));
        state
    }

    /// Bytes held on the stack.
    pub(super) fn depth(&self) -> u64 {
        match self.get(SP) {
            Value::Below(bytes) => u64::try_from(bytes).unwrap_or(0),
            _ => 0,
        }
    }

    /// The stack pointer is where it was at the entry.
    pub(super) fn is_back(&self) -> bool {
        !self.fresh && self.get(SP) == Value::Below(0)
    }

    /// A fault handler has abandoned what was on the stack and begun a fresh one (`msr msp`): what it needs counts from
    /// there, as if it came on top of the old one.
    pub(super) fn is_fresh(&self) -> bool {
        self.fresh
    }

    /// What is known where two paths meet; none if the stack pointer is not the same on both.
    pub(super) fn joined(&self, other: &State) -> Option<State> {
        let mut joined = self.clone();
        for (mine, theirs) in joined.registers.iter_mut().zip(other.registers) {
            if *mine != theirs {
                *mine = Value::Unknown;
            }
        }
        (joined.get(SP) != Value::Unknown && self.fresh == other.fresh).then_some(joined)
    }

    /// What is known behind an instruction. Of a conditional one both outcomes are possible.
    pub(super) fn after(&self, instruction: &Instruction) -> Result<State, &'static str> {
        let moved = self.executed(instruction);
        let leaves = matches!(instruction.flow, Flow::Return);
        let after = if instruction.in_it_block && !leaves {
            self.joined(&moved).ok_or("the stack pointer moves on a condition")?
        } else {
            moved
        };
        match after.get(SP) {
            Value::Below(bytes) if bytes >= 0 => Ok(after),
            Value::Below(_) => Err("the stack pointer rises above where the function was entered"),
            _ => Err("the stack pointer becomes something that cannot be followed"),
        }
    }

    fn executed(&self, instruction: &Instruction) -> State {
        let mut after = self.clone();
        for register in instruction.writes.iter().filter(|register| register.core_number().is_some()) {
            after.set(register, Value::Unknown);
        }
        if matches!(instruction.flow, Flow::Call(_) | Flow::IndirectCall) {
            // The callee keeps r4 to r11 and the stack pointer (Arm IHI 0042, 6.1.1).
            (0..4).chain([12]).for_each(|scratch| after.set(Register::core(scratch), Value::Unknown));
        }
        if let Some(memory) = &instruction.memory {
            if memory.writeback != 0 && !(memory.load && memory.registers.contains(&memory.base)) {
                after.set(memory.base, added(self.get(memory.base), i64::from(memory.writeback)));
            }
        } else if let Some((target, value)) = self.computed(instruction) {
            after.set(target, value);
        }
        if instruction.mnemonic == "msr" && instruction.writes.contains(SP) {
            after.set(SP, Value::Below(0));
            after.fresh = true;
        }
        after
    }

    /// The register that an instruction without memory operand sets, and to what, if that can be told.
    fn computed(&self, instruction: &Instruction) -> Option<(Register, Value)> {
        let mut written = instruction.writes.iter().filter(|register| register.core_number().is_some());
        let (target, None) = (written.next()?, written.next()) else { return None };
        let words: Vec<&str> = instruction.operands.split(", ").collect();
        // `add sp, #8` stands for `add sp, sp, #8`.
        let sources = if words.len() > 2 || instruction.mnemonic.starts_with("mov") { &words[1..] } else { &words[..] };
        let first = self.named(sources.first()?);
        let second = sources.get(1).map_or(Value::Unknown, |word| self.named(word));
        let value = match (instruction.mnemonic.as_str(), sources.len()) {
            ("mov", 1) => first,
            ("movt", 1) => match (self.get(target), first) {
                (Value::Number(low), Value::Number(high)) => Value::Number(low & 0xFFFF | high << 16),
                _ => Value::Unknown,
            },
            ("add", 2) => match (first, second) {
                (place, Value::Number(number)) | (Value::Number(number), place) => added(place, number),
                _ => Value::Unknown,
            },
            ("sub", 2) => match second {
                Value::Number(number) => added(first, -number),
                _ => Value::Unknown,
            },
            // Clearing the low bits aligns a stack pointer: it can go down by as much as the bits can say.
            ("bfc", _) => self.aligned(target, &words),
            _ => Value::Unknown,
        };
        Some((target, value))
    }

    fn aligned(&self, target: Register, words: &[&str]) -> Value {
        let number = |place: usize| words.get(place).and_then(|word| parsed(word));
        match (self.get(target), number(1), number(2)) {
            (Value::Below(bytes), Some(0), Some(bits @ 0..8)) => Value::Below(bytes + (1 << bits) - 1),
            _ => Value::Unknown,
        }
    }

    /// The value of an operand.
    fn named(&self, word: &str) -> Value {
        match parsed(word) {
            Some(number) => Value::Number(number),
            None => {
                let named = (0..16).map(Register::core).find(|r| r.to_string() == word || alias(*r) == Some(word));
                named.map_or(Value::Unknown, |register| self.get(register))
            }
        }
    }

    fn get(&self, register: Register) -> Value {
        register.core_number().map_or(Value::Unknown, |number| self.registers[usize::from(number)])
    }

    fn set(&mut self, register: Register, value: Value) {
        if let Some(number) = register.core_number() {
            self.registers[usize::from(number)] = value;
        }
    }
}

/// Capstone's other names of r9 to r12.
fn alias(register: Register) -> Option<&'static str> {
    ["sb", "sl", "fp", "ip"].get(usize::from(register.core_number()?).checked_sub(9)?).copied()
}

fn added(value: Value, number: i64) -> Value {
    match value {
        Value::Below(bytes) => Value::Below(bytes - number),
        Value::Number(known) => Value::Number(known + number),
        Value::Unknown => Value::Unknown,
    }
}

/// Reads `#12`, `#-0x10`.
fn parsed(word: &str) -> Option<i64> {
    let digits = word.strip_prefix('#')?;
    let (sign, digits) = digits.strip_prefix('-').map_or((1, digits), |digits| (-1, digits));
    let number = match digits.strip_prefix("0x") {
        Some(hex) => i64::from_str_radix(hex, 16),
        None => digits.parse(),
    };
    number.ok().map(|number| sign * number)
}
