//! Who holds the address of a function: code that puts it into a register, and constants that code leads to.
//!
//! This is for messages: it tells how a function got into an image that no call reaches.
//!
//! What it cannot see: addresses that are computed, and halves that are put together across branches.

use std::collections::{BTreeMap, BTreeSet};

use super::code::{Code, CodeFunction};
use super::control_flow::{Call, Graph};
use super::decode::Register;
use super::image::{Image, SymbolKind};

/// A graph in which holding the address of a function counts as calling it.
#[must_use]
pub fn with_held<'a>(image: &Image, graph: &Graph<'a>) -> Graph<'a> {
    let mut held = graph.clone();
    for function in graph.code.functions.values() {
        let mut functions = BTreeSet::new();
        for (at, value) in numbers(image, graph.code, function) {
            follow(image, graph.code, value, &mut BTreeSet::new(), &mut functions);
            let calls = held.calls.entry(function.start).or_default();
            calls.extend(functions.iter().map(|callee| Call { at, callee: *callee }));
            functions.clear();
        }
    }
    held
}

/// The functions that a number leads to: it is the address of one, or of a constant that holds such numbers.
fn follow(image: &Image, code: &Code, value: u32, seen: &mut BTreeSet<u32>, functions: &mut BTreeSet<u32>) {
    // Addresses of Thumb code are odd.
    if value & 1 == 1 && code.functions.contains_key(&(value & !1)) {
        functions.insert(value & !1);
        return;
    }
    // The vector table is no constant that code leads to; where it stands at address zero, small numbers would.
    let table = image.sections.iter().find(|section| section.name == ".vector_table");
    let in_table =
        |address: u32| table.is_some_and(|table| (table.address..table.address + table.size).contains(&address));
    if in_table(value) {
        return;
    }
    let objects = image.symbols.iter().filter(|symbol| symbol.kind == SymbolKind::Object);
    for object in objects.filter(|object| (object.address..object.address + object.size).contains(&value)) {
        if seen.insert(object.address) {
            let words = (object.address.next_multiple_of(4)..object.address + object.size).step_by(4);
            words.filter_map(|at| image.word(at)).for_each(|word| follow(image, code, word, seen, functions));
        }
    }
}

/// The numbers that a function puts into registers: from its constants, or by halves. With the place of each.
fn numbers(image: &Image, code: &Code, function: &CodeFunction) -> Vec<(u32, u32)> {
    let mut low: BTreeMap<Register, u32> = BTreeMap::new();
    let mut found = Vec::new();
    for instruction in code.body(function) {
        if let Some(word) = instruction.literal().and_then(|at| image.word(at)) {
            found.push((instruction.address, word));
        }
        let target = instruction.writes.iter().find(|register| register.core_number().is_some());
        let (Some(target), Some(number)) = (target, instruction.immediate) else { continue };
        match instruction.full_mnemonic.as_str() {
            "movw" => {
                low.insert(target, number as u32);
            }
            "movt" => {
                let half = low.get(&target).copied().unwrap_or(0);
                found.push((instruction.address, half | (number as u32) << 16));
            }
            _ => {}
        }
    }
    found
}
