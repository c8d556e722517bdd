//! The program of an image: every function, every instruction, and where each goes.
//!
//! What it cannot see: code that no symbol covers, and targets that are computed otherwise than by the branch tables
//! `tbb` and `tbh`; those remain [`Flow::IndirectJump`] and whoever walks the code has to refuse them.

use std::collections::{BTreeMap, BTreeSet};

use super::control_flow;
use super::decode::{Decoder, Flow, Instruction, ItState};
use super::image::{Function, Image};

/// A function, decoded.
#[derive(Clone, Debug)]
pub struct CodeFunction {
    /// The name people read.
    pub name: String,
    /// The linker's name.
    pub linkage_name: String,
    /// The crate it belongs to.
    pub crate_name: String,
    /// Its first address.
    pub start: u32,
    /// The first address behind it, its constants included.
    pub end: u32,
}

impl CodeFunction {
    /// Whether an address lies in it.
    #[must_use]
    pub fn contains(&self, address: u32) -> bool {
        (self.start..self.end).contains(&address)
    }
}

/// The decoded program.
#[derive(Clone, Debug, Default)]
pub struct Code {
    /// Functions by their first address.
    pub functions: BTreeMap<u32, CodeFunction>,
    /// Instructions by address.
    pub instructions: BTreeMap<u32, Instruction>,
    /// Targets of each branch table, by the address of its `tbb` or `tbh`.
    pub tables: BTreeMap<u32, Vec<u32>>,
    /// First addresses of the functions that never return to their caller.
    pub never_return: BTreeSet<u32>,
}

impl Code {
    /// Decodes all functions of an image.
    ///
    /// # Errors
    /// Bytes that the mapping symbols call code and the decoder does not know, or a branch table that cannot be read.
    pub fn decode(image: &Image) -> Result<Self, String> {
        let decoder = Decoder::new()?;
        let mut code = Code::default();
        for function in image.functions() {
            code.add(image, &decoder, &function)?;
        }
        code.never_return = control_flow::never_returning(&code);
        Ok(code)
    }

    /// The function that an address lies in.
    #[must_use]
    pub fn function_at(&self, address: u32) -> Option<&CodeFunction> {
        self.functions.range(..=address).next_back().map(|(_, function)| function).filter(|f| f.contains(address))
    }

    /// The function with a name: the linker's, or the one people read.
    #[must_use]
    pub fn function(&self, name: &str) -> Option<&CodeFunction> {
        self.functions.values().find(|function| function.linkage_name == name || function.name == name)
    }

    /// The instructions of a function in the order of their addresses.
    pub fn body(&self, function: &CodeFunction) -> impl Iterator<Item = &Instruction> {
        self.instructions.range(function.start..function.end).map(|(_, instruction)| instruction)
    }

    fn add(&mut self, image: &Image, decoder: &Decoder, function: &Function<'_>) -> Result<(), String> {
        let symbol = function.symbol;
        let (mut at, mut it) = (symbol.address, ItState::default());
        while at < function.end {
            if !image.is_code(at) {
                at = image.next_code(at).unwrap_or(function.end);
                it = ItState::default();
                continue;
            }
            let length = (function.end - at).min(4) as usize;
            let bytes = image.bytes(at, length).ok_or_else(|| format!("{}: no bytes at {at:#010x}", symbol.name))?;
            let decoded = decoder.decode(bytes, at, &mut it).map_err(|error| format!("{}: {error}", symbol.name))?;
            if let Flow::Table { entry } = decoded.flow {
                self.tables.insert(at, table(image, function, &decoded, entry)?);
            }
            at = decoded.end();
            self.instructions.insert(decoded.address, decoded);
        }
        let named = CodeFunction {
            name: symbol.name.clone(),
            linkage_name: symbol.linkage_name.clone(),
            crate_name: symbol.crate_name.clone(),
            start: symbol.address,
            end: function.end,
        };
        self.functions.insert(symbol.address, named);
        Ok(())
    }
}

/// The targets of a branch table: it stands behind its instruction. An entry is half the distance from the table to its
/// target (Arm DDI 0403, A7.7.185). Nothing says where a table ends: filler up to an alignment or constants may follow. But
/// every entry leads to code of its function, so those that do, from the first on, hold the whole table; one too many, which
/// leads there by chance, is safe.
fn table(image: &Image, function: &Function<'_>, branch: &Instruction, entry: u32) -> Result<Vec<u32>, String> {
    let start = branch.end();
    let unreadable = || format!("{}: the branch table at {start:#010x} cannot be read", function.symbol.name);
    let end = image.next_code(start).filter(|end| *end <= function.end && *end > start).ok_or_else(unreadable)?;
    let bytes = image.bytes(start, (end - start) as usize).ok_or_else(unreadable)?;
    let entries =
        bytes.chunks_exact(entry as usize).map(|e| e.iter().rev().fold(0, |n, byte| n << 8 | u32::from(*byte)));
    let mut targets: Vec<u32> = entries.map(|halfwords| start + 2 * halfwords).collect();
    let leads_somewhere = |target: &u32| (end..function.end).contains(target) && image.is_code(*target);
    let entries = targets.iter().position(|target| !leads_somewhere(target)).unwrap_or(targets.len());
    if entries == 0 {
        return Err(unreadable());
    }
    targets.truncate(entries);
    targets.sort_unstable();
    targets.dedup();
    Ok(targets)
}
