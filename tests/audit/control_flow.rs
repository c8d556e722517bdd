//! Where execution can go: inside a function, from function to function, and from which entry points.
//!
//! A tail call is a jump to the start of another function. A call of a function that never returns goes nowhere else.
//!
//! What it cannot see: handlers that a program installs by writing a vector table in RAM, and what a register or a
//! memory cell holds: those are listed as [`Unresolved`], and [`Graph::resolve`] takes what a person vouches for.

use std::collections::{BTreeMap, BTreeSet};

use super::code::{Code, CodeFunction};
use super::decode::{Flow, Instruction};
use super::image::Image;

/// A call of one function by another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Call {
    /// The instruction that calls.
    pub at: u32,
    /// First address of the function that is called.
    pub callee: u32,
}

/// A place where execution goes somewhere that the machine code does not tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unresolved {
    /// The instruction.
    pub at: u32,
    /// What it is: `indirect call`, `indirect jump`, `runs off its end`, ...
    pub what: &'static str,
    /// As an assembler writes it.
    pub instruction: String,
}

/// Where execution can go next after an instruction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Instructions of the same function.
    pub successors: Vec<u32>,
    /// The function it calls, or continues in.
    pub callee: Option<u32>,
    /// It leaves the function: it returns, or continues in another one.
    pub leaves: bool,
    /// What cannot be told.
    pub unresolved: Option<&'static str>,
}

/// Where execution can go after `instruction` of `function`.
#[must_use]
pub fn step(code: &Code, function: &CodeFunction, instruction: &Instruction) -> Step {
    let mut step = Step::default();
    match instruction.flow {
        Flow::Next | Flow::Stop => {}
        Flow::Return => step.leaves = true,
        Flow::Jump(target) | Flow::Branch(target) => jump(code, function, target, &mut step),
        Flow::Call(target) => {
            step.callee = code.functions.contains_key(&target).then_some(target);
            step.unresolved = step.callee.is_none().then_some("call of what is no function");
        }
        Flow::IndirectCall => step.unresolved = Some("indirect call"),
        Flow::IndirectJump => step.unresolved = Some("indirect jump"),
        Flow::Table { .. } => match code.tables.get(&instruction.address) {
            Some(targets) => step.successors.extend(targets),
            None => step.unresolved = Some("branch table that cannot be read"),
        },
    }
    if instruction.falls_through() {
        fall(code, function, instruction, &mut step);
    }
    step
}

fn jump(code: &Code, function: &CodeFunction, target: u32, step: &mut Step) {
    if function.contains(target) && code.instructions.contains_key(&target) {
        step.successors.push(target);
    } else if code.functions.contains_key(&target) {
        (step.callee, step.leaves) = (Some(target), true);
    } else {
        step.unresolved = Some("jump into the middle of another function");
    }
}

fn fall(code: &Code, function: &CodeFunction, instruction: &Instruction, step: &mut Step) {
    let next = instruction.end();
    let comes_back = match instruction.flow {
        Flow::Call(callee) => instruction.condition.is_some() || !code.never_return.contains(&callee),
        _ => true,
    };
    if !comes_back {
        // Whatever stands behind such a call is filler.
    } else if function.contains(next) && code.instructions.contains_key(&next) {
        step.successors.push(next);
    } else if step.callee.is_none() && code.functions.contains_key(&next) {
        (step.callee, step.leaves) = (Some(next), true);
    } else {
        step.unresolved = Some("runs off its end");
    }
}

/// The functions from which no path leads back to the caller. What cannot be resolved counts as a way back.
#[must_use]
pub fn never_returning(code: &Code) -> BTreeSet<u32> {
    // Every function is suspected until a way back is found; a way back may open one in its callers.
    let mut code = Code { never_return: code.functions.keys().copied().collect(), ..code.clone() };
    loop {
        let suspected = code.never_return.iter().filter_map(|start| code.functions.get(start));
        let cleared: Vec<u32> = suspected.filter(|function| returns(&code, function)).map(|f| f.start).collect();
        if cleared.is_empty() {
            return code.never_return;
        }
        cleared.iter().for_each(|start| {
            code.never_return.remove(start);
        });
    }
}

/// Whether a path leads back to the caller, if those of `never_return` have none.
fn returns(code: &Code, function: &CodeFunction) -> bool {
    reached(code, function).into_iter().any(|at| {
        let instruction = &code.instructions[&at];
        let step = step(code, function, instruction);
        let continues_elsewhere = step.leaves && step.callee.is_some_and(|callee| !code.never_return.contains(&callee));
        instruction.flow == Flow::Return || continues_elsewhere || step.unresolved.is_some()
    })
}

/// What starts by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Name of the function.
    pub name: String,
    /// Its first address.
    pub start: u32,
    /// It interrupts whatever runs; else it is where the processor starts, or a function that was asked for by name.
    pub interrupts: bool,
}

/// Which function calls which.
#[derive(Clone, Debug)]
pub struct Graph<'a> {
    /// The program.
    pub code: &'a Code,
    /// What starts by itself.
    pub entries: Vec<Entry>,
    /// Calls by the first address of the calling function.
    pub calls: BTreeMap<u32, Vec<Call>>,
    /// What cannot be told, by the first address of its function.
    pub unresolved: BTreeMap<u32, Vec<Unresolved>>,
}

impl<'a> Graph<'a> {
    /// The graph of an image, with the entries of its vector table.
    ///
    /// # Errors
    /// No vector table is where the processor starts.
    pub fn new(image: &Image, code: &'a Code) -> Result<Self, String> {
        let mut graph =
            Graph { code, entries: entries(image, code)?, calls: BTreeMap::new(), unresolved: BTreeMap::new() };
        for function in code.functions.values() {
            graph.add(function);
        }
        Ok(graph)
    }

    /// The same program, entered only through the functions with these names.
    ///
    /// # Errors
    /// No function has one of the names.
    pub fn entered_by(&self, names: &[&str]) -> Result<Self, String> {
        let entry = |name: &&str| {
            let function = self
                .code
                .function(name)
                .ok_or_else(|| format!("the image has no function `{name}`; names are those of `nm`, or demangled"))?;
            Ok(Entry { name: function.name.clone(), start: function.start, interrupts: false })
        };
        let entries = names.iter().map(entry).collect::<Result<_, String>>()?;
        Ok(Graph { entries, ..self.clone() })
    }

    /// Takes a person's word for what the unresolved places of a function call. Returns how many there were.
    pub fn resolve(&mut self, function: u32, callees: &[u32]) -> usize {
        let places = self.unresolved.remove(&function).unwrap_or_default();
        let calls = self.calls.entry(function).or_default();
        for place in &places {
            calls.extend(callees.iter().map(|callee| Call { at: place.at, callee: *callee }));
        }
        places.len()
    }

    /// The shortest chain of calls from an entry to each function that is reached from one, the entry first.
    #[must_use]
    pub fn chains(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut chains: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut waiting: Vec<u32> = self.entries.iter().map(|entry| entry.start).collect();
        for start in &waiting {
            chains.insert(*start, vec![*start]);
        }
        // Breadth first, so that the first chain found is a shortest one.
        while !waiting.is_empty() {
            let mut next = Vec::new();
            for caller in waiting {
                for call in self.calls.get(&caller).into_iter().flatten() {
                    if !chains.contains_key(&call.callee) {
                        let chain = chains[&caller].iter().copied().chain([call.callee]).collect();
                        chains.insert(call.callee, chain);
                        next.push(call.callee);
                    }
                }
            }
            waiting = next;
        }
        chains
    }

    /// The name of a function.
    #[must_use]
    pub fn name(&self, start: u32) -> &str {
        self.code.functions.get(&start).map_or("?", |function| &function.name)
    }

    /// A chain of calls for people.
    #[must_use]
    pub fn shown(&self, chain: &[u32]) -> String {
        chain.iter().map(|start| self.name(*start)).collect::<Vec<_>>().join(" > ")
    }

    /// A cycle of calls among the functions reached from the entries, its first function again at the end.
    #[must_use]
    pub fn recursion(&self) -> Vec<Vec<u32>> {
        let mut found = Vec::new();
        let mut done = BTreeSet::new();
        for start in self.chains().into_keys() {
            self.descend(start, &mut Vec::new(), &mut done, &mut found);
        }
        found
    }

    fn descend(&self, at: u32, path: &mut Vec<u32>, done: &mut BTreeSet<u32>, found: &mut Vec<Vec<u32>>) {
        if let Some(first) = path.iter().position(|function| *function == at) {
            found.push(path[first..].iter().copied().chain([at]).collect());
            return;
        }
        if !done.insert(at) {
            return;
        }
        path.push(at);
        let callees: BTreeSet<u32> = self.calls.get(&at).into_iter().flatten().map(|call| call.callee).collect();
        for callee in callees {
            self.descend(callee, path, done, found);
        }
        path.pop();
    }

    fn add(&mut self, function: &CodeFunction) {
        let (calls, unresolved) = of_function(self.code, function);
        self.calls.insert(function.start, calls);
        if !unresolved.is_empty() {
            self.unresolved.insert(function.start, unresolved);
        }
    }
}

/// What a function calls, and what of it cannot be told.
pub(super) fn of_function(code: &Code, function: &CodeFunction) -> (Vec<Call>, Vec<Unresolved>) {
    let (mut calls, mut unresolved) = (Vec::new(), Vec::new());
    for at in reached(code, function) {
        let instruction = &code.instructions[&at];
        let step = step(code, function, instruction);
        calls.extend(step.callee.map(|callee| Call { at, callee }));
        unresolved.extend(step.unresolved.map(|what| Unresolved { at, what, instruction: instruction.to_string() }));
    }
    (calls, unresolved)
}

/// The instructions of a function that can be reached from its start.
#[must_use]
pub fn reached(code: &Code, function: &CodeFunction) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    let mut waiting = vec![function.start];
    while let Some(at) = waiting.pop() {
        let Some(instruction) = code.instructions.get(&at) else { continue };
        if found.insert(at) {
            waiting.extend(step(code, function, instruction).successors);
        }
    }
    found
}

/// Reset, and every handler that the vector table names.
fn entries(image: &Image, code: &Code) -> Result<Vec<Entry>, String> {
    let no_table = || format!("{} has no section .vector_table: it is not linked for a Cortex-M", image.path.display());
    let table = image.sections.iter().find(|section| section.name == ".vector_table").ok_or_else(no_table)?;
    let words = (0..table.size / 4).filter_map(|index| image.word(table.address + 4 * index));
    let mut entries = Vec::new();
    // The first word is the initial stack pointer, the second the reset handler.
    for (index, word) in words.enumerate().skip(1) {
        let start = word & !1;
        if word == 0 || entries.iter().any(|entry: &Entry| entry.start == start) {
            continue;
        }
        let function = code.functions.get(&start).ok_or_else(|| {
            format!("vector {index} of {} leads to {start:#010x}, where no function starts", image.path.display())
        })?;
        entries.push(Entry { name: function.name.clone(), start, interrupts: index > 1 });
    }
    if entries.is_empty() { Err(no_table()) } else { Ok(entries) }
}
