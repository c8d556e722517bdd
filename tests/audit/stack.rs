//! The deepest stack that each entry point can need, from the machine code.
//!
//! The stack pointer is followed along every path of every function: pushes, pops, additions, frame pointers and
//! re-alignment. Calls add what the callee needs at that place. Whatever cannot be followed (an indirect call, recursion,
//! a stack pointer that depends on data) is an error, never a zero. Each exception adds the frame that the hardware
//! stacks.
//!
//! Compared once with what LLVM says of its own frames (`-Zemit-stack-sizes`, the emulated mission's image): equal for 75
//! of 75 functions, and three more that LLVM says nothing of.
//!
//! What it cannot see: that two handlers may have the same priority and so never nest (it counts every handler once on top
//! of the main program, which is safe), and stack that inline assembly moves by means it does not know (an error).

use std::collections::BTreeMap;

use super::code::{Code, CodeFunction};
use super::control_flow::{self, Graph};
use super::decode::{Instruction, Register};

mod frame;
#[cfg(test)]
mod tests;

/// What the hardware stacks for an exception (Arm DDI 0403, B1.5.7): eight words, with floating point 18 more, and one
/// word where the stack pointer was not aligned to eight bytes.
const FRAME: u64 = 8 * 4;
const FLOAT_FRAME: u64 = FRAME + 18 * 4;
const ALIGNMENT: u64 = 4;

/// The stack that a function needs at most.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Depth {
    /// Bytes, its callees included.
    pub bytes: u64,
    /// The deepest chain: each function with the bytes it holds when it calls the next.
    pub chain: Vec<(u32, u64)>,
}

/// The stack that an entry point needs at most.
#[derive(Clone, Debug)]
pub struct EntryStack {
    /// Name of the function.
    pub name: String,
    /// Bytes of its functions.
    pub bytes: u64,
    /// Bytes that the hardware stacks for it.
    pub frame: u64,
    /// The deepest chain for people: `main(48) > step(96)`.
    pub chain: String,
}

/// The stack of every entry point of a graph.
///
/// # Errors
/// What cannot be followed, with the chain of calls that leads there.
pub fn of_entries(graph: &Graph<'_>) -> Result<Vec<EntryStack>, String> {
    let mut known = BTreeMap::new();
    let frame = if uses_floats(graph.code) { FLOAT_FRAME } else { FRAME } + ALIGNMENT;
    let of = |entry: &control_flow::Entry| {
        let depth = depth(graph, entry.start, &mut Vec::new(), &mut known)?;
        let links: Vec<String> = depth.chain.iter().map(|(at, held)| format!("{}({held})", graph.name(*at))).collect();
        Ok(EntryStack {
            name: entry.name.clone(),
            bytes: depth.bytes,
            frame: if entry.interrupts { frame } else { 0 },
            chain: links.join(" > "),
        })
    };
    graph.entries.iter().map(of).collect()
}

/// The main program with every handler nested once on top of it.
#[must_use]
pub fn nested(entries: &[EntryStack]) -> u64 {
    entries.iter().map(|entry| entry.bytes + entry.frame).sum()
}

/// Whether floating-point instructions are executed, so that frames hold their registers.
fn uses_floats(code: &Code) -> bool {
    let float = |instruction: &Instruction| {
        instruction.reads.union(instruction.writes).iter().any(|register| register.single_number().is_some())
    };
    code.instructions.values().any(float)
}

/// The stack of a function and its callees. `path` is the chain of callers.
fn depth(
    graph: &Graph<'_>,
    start: u32,
    path: &mut Vec<u32>,
    known: &mut BTreeMap<u32, Depth>,
) -> Result<Depth, String> {
    if let Some(depth) = known.get(&start) {
        return Ok(depth.clone());
    }
    path.push(start);
    if path[..path.len() - 1].contains(&start) {
        return Err(format!("no bound on the stack: recursion, {}", graph.shown(path)));
    }
    let refused = |what: &str, path: &[u32]| Err(format!("no bound on the stack: {what}, {}", graph.shown(path)));
    if let Some(places) = graph.unresolved.get(&start) {
        let places: Vec<String> = places
            .iter()
            .map(|place| format!("{} `{}` at {:#010x}", place.what, place.instruction, place.at))
            .collect();
        return refused(&places.join(", "), path);
    }
    let Some(function) = graph.code.functions.get(&start) else { return refused("no function here", path) };
    let held = match held(graph.code, function) {
        Ok(held) => held,
        Err(what) => return refused(&what, path),
    };
    let own = held.values().map(|at| at.deepest).max().unwrap_or(0);
    let mut deepest = Depth { bytes: own, chain: vec![(start, own)] };
    for call in graph.calls.get(&start).into_iter().flatten() {
        let callee = depth(graph, call.callee, path, known)?;
        let here = held.get(&call.at).map_or(own, |at| at.calling);
        if here + callee.bytes > deepest.bytes {
            let chain = [(start, here)].into_iter().chain(callee.chain).collect();
            deepest = Depth { bytes: here + callee.bytes, chain };
        }
    }
    path.pop();
    known.insert(start, deepest.clone());
    Ok(deepest)
}

/// Bytes on the stack around one instruction, counted from the entry of its function.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// While a function that it calls runs.
    calling: u64,
    /// At most, before or behind it.
    deepest: u64,
}

/// Follows the stack pointer through a function.
fn held(code: &Code, function: &CodeFunction) -> Result<BTreeMap<u32, Held>, String> {
    let mut before: BTreeMap<u32, frame::State> = BTreeMap::from([(function.start, frame::State::at_entry())]);
    let mut waiting = vec![function.start];
    let mut held = BTreeMap::new();
    while let Some(at) = waiting.pop() {
        let Some(instruction) = code.instructions.get(&at) else { continue };
        let (state, step) = (before[&at].clone(), control_flow::step(code, function, instruction));
        let lost = |what: &str| format!("{what} at {at:#010x} (`{instruction}`)");
        let after = state.after(instruction).map_err(lost)?;
        let stays = step.callee.is_some_and(|callee| code.never_return.contains(&callee));
        if step.leaves && !after.is_back() && !(after.is_fresh() && stays) {
            return Err(lost("leaves with a stack pointer that is not back where it was"));
        }
        held.insert(at, Held { calling: state.depth(), deepest: state.depth().max(after.depth()) });
        // A return on a condition pops nothing where the condition does not hold.
        let passed = if step.leaves && instruction.condition.is_some() { state } else { after };
        for next in step.successors {
            let joined = match before.get(&next) {
                None => passed.clone(),
                Some(known) => {
                    known.joined(&passed).ok_or_else(|| lost("the stack pointer differs on paths that join"))?
                }
            };
            if before.get(&next) != Some(&joined) {
                before.insert(next, joined);
                waiting.push(next);
            }
        }
    }
    Ok(held)
}

/// The stack of each function by itself, without its callees; an error for those that cannot be followed. For
/// comparison with what a compiler says.
#[must_use]
pub fn own(code: &Code) -> BTreeMap<u32, Result<u64, String>> {
    let of = |function: &CodeFunction| {
        held(code, function).map(|held| held.values().map(|at| at.deepest).max().unwrap_or(0))
    };
    code.functions.values().map(|function| (function.start, of(function))).collect()
}

/// The stack pointer, for its readers.
const SP: Register = Register::SP;
