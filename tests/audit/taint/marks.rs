//! What is marked, in registers, flags and memory.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use super::super::decode::{Register, Registers};

/// Where RAM begins in the memory map of Armv7-M: below are instructions and constants.
const RAM: u32 = 0x2000_0000;

/// What a value depends on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Mark {
    /// On a sample.
    pub(super) data: bool,
    /// On these bytes, as they were when the call began.
    pub(super) state: BTreeSet<u32>,
}

impl Mark {
    /// Depends on what either does.
    pub(super) fn and(mut self, other: &Mark) -> Mark {
        self.data |= other.data;
        self.state.extend(&other.state);
        self
    }
}

/// The marks of the whole machine.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    registers: HashMap<Register, Mark>,
    /// Bytes that depend on data.
    data: HashSet<u32>,
    /// Bytes written in the call that is being followed, and the state they depend on.
    written: Option<HashMap<u32, BTreeSet<u32>>>,
}

impl Marks {
    /// A call begins: what memory holds now is its state.
    pub(super) fn enter(&mut self) {
        self.written = Some(HashMap::new());
    }

    /// The call has ended.
    pub(super) fn leave(&mut self) {
        self.written = None;
        self.registers.values_mut().for_each(|mark| mark.state.clear());
    }

    /// Marks bytes as data.
    pub(super) fn mark_data(&mut self, bytes: Range<u32>) {
        self.data.extend(bytes);
    }

    /// What the values of registers depend on.
    pub(super) fn of(&self, registers: Registers) -> Mark {
        let marks = registers.iter().filter_map(|register| self.registers.get(&register));
        marks.fold(Mark::default(), Mark::and)
    }

    /// What bytes of memory depend on.
    pub(super) fn of_memory(&self, start: u32, size: u32) -> Mark {
        let mut mark = Mark::default();
        for byte in start..start.saturating_add(size) {
            mark.data |= self.data.contains(&byte);
            let Some(written) = &self.written else { continue };
            match written.get(&byte) {
                Some(state) => mark.state.extend(state),
                None if byte >= RAM => {
                    mark.state.insert(byte);
                }
                None => {}
            }
        }
        mark
    }

    /// A register is written; with `keep` its old value may have stayed.
    pub(super) fn set(&mut self, register: Register, mark: Mark, keep: bool) {
        let old = self.registers.entry(register).or_default();
        *old = if keep { mark.and(old) } else { mark };
    }

    /// Bytes are written; with `keep` their old value may have stayed.
    pub(super) fn store(&mut self, bytes: Range<u32>, mark: &Mark, keep: bool) {
        for byte in bytes {
            let mark = if keep { self.of_memory(byte, 1).and(mark) } else { mark.clone() };
            if mark.data {
                self.data.insert(byte);
            } else {
                self.data.remove(&byte);
            }
            if let Some(written) = &mut self.written {
                written.insert(byte, mark.state);
            }
        }
    }
}
