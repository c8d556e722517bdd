//! What the code of a board must not hold: heap, recursion, panics, text formatting, soft floating point, indirect calls.
//!
//! Each check looks at the linked functions. A finding names the function and the shortest chain of calls to it from an
//! entry point. Functions that are linked and that no call reaches are found as well, with who holds their address.
//!
//! What it cannot see: a function that the compiler has inlined leaves no symbol. A panic cannot vanish so (its handler
//! is never inlined away as long as something can reach it), nor can a soft-float helper; an allocator can, but not what is called
//! where it has nothing left (`handle_alloc_error`). What asks for memory and takes a refusal itself (`try_reserve`) does not lead
//! there, so with an allocator that is inlined it would not be seen.

use std::collections::BTreeMap;

use serde::Serialize;

use super::addresses;
use super::control_flow::{Graph, Unresolved};
use super::image::Image;

mod helpers;

/// What is forbidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Check {
    /// Memory from a heap.
    Heap,
    /// Functions that call themselves, directly or around.
    Recursion,
    /// Panics and what leads to them.
    Panic,
    /// `core::fmt`.
    Formatting,
    /// Double-precision arithmetic, which these processors do in software.
    SoftDouble,
    /// Single-precision arithmetic in software, where the processor has it.
    SoftFloat,
    /// Calls and jumps whose target is not in the code.
    IndirectCall,
}

impl Check {
    /// All of them.
    pub const ALL: [Check; 7] = [
        Check::Heap,
        Check::Recursion,
        Check::Panic,
        Check::Formatting,
        Check::SoftDouble,
        Check::SoftFloat,
        Check::IndirectCall,
    ];

    /// The name in tables and in the budgets file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Check::Heap => "heap",
            Check::Recursion => "recursion",
            Check::Panic => "panic",
            Check::Formatting => "formatting",
            Check::SoftDouble => "soft-double",
            Check::SoftFloat => "soft-float",
            Check::IndirectCall => "indirect-call",
        }
    }

    /// Whether a function is what the check forbids.
    fn finds(self, name: &str, linkage_name: &str) -> bool {
        match self {
            Check::Heap => helpers::is_heap(name),
            Check::Panic => helpers::is_panic(name),
            Check::Formatting => name.contains("core::fmt::"),
            Check::SoftDouble => helpers::is_soft_double(name) || helpers::is_soft_double(linkage_name),
            Check::SoftFloat => helpers::is_soft_float(name) || helpers::is_soft_float(linkage_name),
            Check::Recursion | Check::IndirectCall => false,
        }
    }
}

/// Something forbidden.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Which check found it.
    pub check: Check,
    /// The function.
    pub symbol: String,
    /// The shortest chain of calls from an entry point, or why there is none.
    pub chain: Vec<String>,
    /// No chain of calls alone leads there: a link of it only holds the address of the next one.
    pub held: bool,
    /// What there is to say beside.
    pub note: String,
}

impl Finding {
    /// The finding as a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let note = if self.note.is_empty() { String::new() } else { format!(" ({})", self.note) };
        let chain = match self.chain.as_slice() {
            [] => "nothing calls it".to_owned(),
            chain if self.held => format!("not called, but its address is held: {}", chain.join(" > ")),
            chain => format!("called: {}", chain.join(" > ")),
        };
        format!("{}: {}{note}: {chain}", self.check.name(), self.symbol)
    }
}

/// All findings in an image, of every check.
///
/// With the graph of a few entries only what these reach is looked at ([`Graph::entered_by`]), else also what nothing
/// reaches.
#[must_use]
pub fn findings(image: &Image, graph: &Graph<'_>, whole_image: bool) -> Vec<Finding> {
    let ways = Ways { called: graph.chains(), held: addresses::with_held(image, graph).chains() };
    let mut found = by_name(graph, &ways, whole_image);
    found.extend(indirect(graph, &ways, whole_image));
    found.extend(graph.recursion().iter().map(|cycle| {
        let first = cycle.first().copied().unwrap_or_default();
        let (chain, held) = ways.to(graph, first);
        let note = format!("calls itself: {}", graph.shown(cycle));
        Finding { check: Check::Recursion, symbol: graph.name(first).to_owned(), chain, held, note }
    }));
    found.sort_by(|a, b| (a.check, &a.symbol).cmp(&(b.check, &b.symbol)));
    found
}

/// The shortest chains to each function.
struct Ways {
    /// By calls.
    called: BTreeMap<u32, Vec<u32>>,
    /// By calls and by addresses that are held.
    held: BTreeMap<u32, Vec<u32>>,
}

impl Ways {
    fn reaches(&self, function: u32) -> bool {
        self.called.contains_key(&function) || self.held.contains_key(&function)
    }

    /// The chain to a function, and whether it needs an address.
    fn to(&self, graph: &Graph<'_>, function: u32) -> (Vec<String>, bool) {
        let called = self.called.get(&function);
        let chain = called.or_else(|| self.held.get(&function)).into_iter().flatten();
        (chain.map(|start| graph.name(*start).to_owned()).collect(), called.is_none())
    }
}

fn by_name(graph: &Graph<'_>, ways: &Ways, whole_image: bool) -> Vec<Finding> {
    let mut found = Vec::new();
    let looked_at = graph.code.functions.values().filter(|function| whole_image || ways.reaches(function.start));
    for function in looked_at {
        for check in Check::ALL.into_iter().filter(|check| check.finds(&function.name, &function.linkage_name)) {
            let (chain, held) = ways.to(graph, function.start);
            found.push(Finding { check, symbol: function.name.clone(), chain, held, note: String::new() });
        }
    }
    found
}

fn indirect(graph: &Graph<'_>, ways: &Ways, whole_image: bool) -> Vec<Finding> {
    let looked_at = graph.unresolved.iter().filter(|(start, _)| whole_image || ways.reaches(**start));
    let of_function = |(start, places): (&u32, &Vec<Unresolved>)| {
        let shown: Vec<String> = places
            .iter()
            .map(|place| format!("{} `{}` at {:#010x}", place.what, place.instruction, place.at))
            .collect();
        let (chain, held) = ways.to(graph, *start);
        let (symbol, note) = (graph.name(*start).to_owned(), shown.join(", "));
        Finding { check: Check::IndirectCall, symbol, chain, held, note }
    };
    looked_at.map(of_function).collect()
}
