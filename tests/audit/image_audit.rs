//! The static audits of one image, one after the other.

use super::budgets::{Budgets, Indirect};
use super::code::Code;
use super::control_flow::Graph;
use super::forbidden::{self, Check, Finding};
use super::image::{Image, SymbolKind};
use super::images::{CodeOf, Plan};
use super::memory;
use super::report::{Figure, Report, Table};
use super::stack;

/// What the stack audit cannot see.
const STACK_BLIND_SPOTS: [&str; 2] = [
    "priorities: every handler of the vector table is counted once, nested on top of the main program",
    "exceptions that share one handler are counted as one; a default handler that never returns is the last of its chain",
];

/// What the audit of forbidden code cannot see.
const FORBIDDEN_BLIND_SPOTS: [&str; 2] = [
    "an inlined function has no symbol; an allocator could hide so, which is why linking the crate `alloc` counts as a heap",
    "handlers that a program installs in a vector table of its own in RAM",
];

/// Prefix of the words by which an image publishes the sizes of its types.
const SIZE_PREFIX: &str = "SIZE_OF_";

/// What the stack audit does with the vector table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vectors {
    /// A figure for each handler, and for all nested.
    InDetail,
    /// A figure for all nested.
    Summed,
    /// Only functions that are named are looked at.
    LeftOut,
}

/// The row of constants.
const CONSTANTS: &str = "constants";
/// The crate of the compiler's own helpers.
const RUN_TIME: &str = "compiler_builtins";

/// An image, read and decoded.
pub struct Audited {
    /// Its name in reports and budgets.
    pub name: String,
    /// The image.
    pub image: Image,
    /// Its program.
    pub code: Code,
}

impl Audited {
    /// Reads and decodes an image.
    ///
    /// # Errors
    /// It is no linked image, or its code cannot be decoded.
    pub fn read(name: &str, path: &std::path::Path) -> Result<Self, String> {
        let image = Image::read(path)?;
        let code = Code::decode(&image).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Audited { name: name.to_owned(), image, code })
    }

    /// The memory of the image; figures by crate only if wanted.
    ///
    /// # Errors
    /// Its sections do not add up.
    pub fn memory(&self, largest: usize, by_crate: bool) -> Result<Report, String> {
        memory::report(&self.name, &self.image, largest, by_crate)
    }

    /// The stack of its vectors with what they call, and of further functions by themselves. Figures of each vector only
    /// if wanted; of all of them nested always.
    ///
    /// # Errors
    /// The image has no vector table, or not the functions.
    pub fn stack(&self, budgets: Option<&Budgets>, vectors: Vectors, entries: &[&str]) -> Result<Report, String> {
        let mut report = Report {
            title: format!("stack of {}", self.name),
            blind_spots: STACK_BLIND_SPOTS.into(),
            ..Report::default()
        };
        let mut table =
            Table::new("Deepest stack by entry point, bytes", &["", "code", "exception frame", "deepest chain"]);
        let mut graph = Graph::new(&self.image, &self.code)?;
        // What there is to say of indirect calls stands in the report of forbidden code.
        self.resolve(&mut graph, budgets, &mut Report::default());
        if vectors != Vectors::LeftOut {
            self.vectors(&graph, vectors == Vectors::InDetail, &mut report, &mut table);
        }
        for name in entries {
            match stack::of_entries(&graph.entered_by(&[name])?) {
                Ok(found) => {
                    for entry in found {
                        report.figures.push(Figure::bytes(format!("stack.{}.{}", self.name, entry.name), entry.bytes));
                        table.row([entry.name, entry.bytes.to_string(), String::new(), entry.chain]);
                    }
                }
                Err(error) => report.faults.push(format!("{}: {error}", self.name)),
            }
        }
        report.tables.push(table);
        Ok(report)
    }

    fn vectors(&self, graph: &Graph<'_>, in_detail: bool, report: &mut Report, table: &mut Table) {
        match stack::of_entries(graph) {
            Ok(vectors) => {
                for entry in &vectors {
                    if in_detail {
                        report.figures.push(Figure::bytes(format!("stack.{}.{}", self.name, entry.name), entry.bytes));
                    }
                    table.row([
                        entry.name.clone(),
                        entry.bytes.to_string(),
                        entry.frame.to_string(),
                        entry.chain.clone(),
                    ]);
                }
                let all = stack::nested(&vectors);
                table.row(["all nested".to_owned(), all.to_string(), String::new(), String::new()]);
                report.figures.push(Figure::bytes(format!("stack.{}", self.name), all));
            }
            Err(error) => report.faults.push(format!("{}: {error}", self.name)),
        }
    }

    /// What must not be in the image. With `entries` only what they reach.
    ///
    /// # Errors
    /// The image has no vector table, or not the functions.
    pub fn forbidden(&self, budgets: Option<&Budgets>, entries: &[&str]) -> Result<Report, String> {
        let mut report = Report {
            title: format!("forbidden code in {}", self.name),
            blind_spots: FORBIDDEN_BLIND_SPOTS.into(),
            ..Report::default()
        };
        let mut graph = Graph::new(&self.image, &self.code)?;
        if !entries.is_empty() {
            graph = graph.entered_by(entries)?;
        }
        self.resolve(&mut graph, budgets, &mut report);
        let findings = forbidden::findings(&self.image, &graph, entries.is_empty());
        let (refused, idle) = match budgets {
            Some(budgets) => budgets.sift(&self.name, &findings),
            None => (findings.clone(), Vec::new()),
        };
        report.tables.push(counted(&findings, &refused));
        report.faults.extend(refused.iter().map(|finding| format!("{}: {}", self.name, finding.sentence())));
        report.faults.extend(idle.iter().map(|allowance| {
            let (check, through) = (&allowance.check, &allowance.through);
            format!("{}: nothing needs the allowance for {check} through `{through}` any more: take it out", self.name)
        }));
        Ok(report)
    }

    /// The sizes of types that the image publishes.
    ///
    /// # Errors
    /// It publishes none.
    pub fn sizes(&self) -> Result<Report, String> {
        let mut report = Report { title: format!("sizes of types in {}", self.name), ..Report::default() };
        let mut table = Table::new("Size of a value, bytes", &["", "bytes"]);
        for symbol in self.image.symbols.iter().filter(|symbol| symbol.kind == SymbolKind::Object) {
            let Some(of) = symbol.linkage_name.strip_prefix(SIZE_PREFIX) else { continue };
            let unreadable = || format!("{}: the word {} cannot be read", self.name, symbol.linkage_name);
            let bytes = self.image.word(symbol.address).ok_or_else(unreadable)?;
            let of = of.to_lowercase();
            table.row([of.replace('_', " "), bytes.to_string()]);
            report.figures.push(Figure::bytes(format!("size.{of}"), u64::from(bytes)));
        }
        if table.rows.is_empty() {
            return Err(format!("{} publishes no sizes (no symbol begins with {SIZE_PREFIX})", self.name));
        }
        table.rows.sort();
        report.tables.push(table);
        Ok(report)
    }

    /// The flash that the monitor's calls take: every function they reach, and all constants of the image but the published
    /// sizes. Copying and clearing memory is the compiler's, shared with whatever else is in an image: it is shown and not
    /// counted.
    ///
    /// # Errors
    /// The image has not the functions.
    pub fn code_of(&self, monitor: &CodeOf) -> Result<Report, String> {
        let CodeOf { name: of, calls } = monitor;
        let mut report = Report { title: format!("code of the monitor, {of}"), ..Report::default() };
        report.blind_spots = vec!["constants count whole, though some may be of the image's own start-up code"];
        let graph = Graph::new(&self.image, &self.code)?.entered_by(calls)?;
        let reached = graph.chains();
        let functions = reached.keys().filter_map(|start| self.code.functions.get(start));
        let mut crates: std::collections::BTreeMap<&str, u64> = std::collections::BTreeMap::new();
        functions.for_each(|function| {
            *crates.entry(&function.crate_name).or_default() += u64::from(function.end - function.start)
        });
        let constants = self.image.sections.iter().filter(|section| section.name == ".rodata");
        let published = self.image.symbols.iter().filter(|symbol| symbol.linkage_name.starts_with(SIZE_PREFIX));
        let published: u64 = published.map(|symbol| u64::from(symbol.size)).sum();
        let constants = constants.map(|section| u64::from(section.size)).sum::<u64>().saturating_sub(published);
        let mut table = Table::new("Code that the monitor's calls reach, bytes", &["", "bytes"]);
        *crates.entry(CONSTANTS).or_default() += constants;
        for (name, bytes) in &crates {
            table.row([(*name).to_owned(), bytes.to_string()]);
            report.figures.push(Figure::bytes(format!("flash.{of}.{name}"), *bytes));
        }
        let all: u64 = crates.iter().filter(|(name, _)| **name != RUN_TIME).map(|(_, bytes)| bytes).sum();
        table.row([format!("sum without {RUN_TIME}"), all.to_string()]);
        report.tables.push(table);
        report.figures.push(Figure::bytes(format!("flash.{of}"), all));
        Ok(report)
    }

    /// Takes the budgets file's word for indirect calls. Each is a sentence to note, or a fault where the word does not fit
    /// the image.
    fn resolve(&self, graph: &mut Graph<'_>, budgets: Option<&Budgets>, report: &mut Report) {
        for known in budgets.iter().flat_map(|budgets| &budgets.indirect).filter(|known| known.image == self.name) {
            let Indirect { function, calls, reason, .. } = known;
            let start = |name: &String| self.code.function(name).map(|function| function.start);
            let callees: Option<Vec<u32>> = calls.iter().map(start).collect();
            let resolved = match (start(function), callees) {
                (Some(function), Some(callees)) => graph.resolve(function, &callees),
                _ => 0,
            };
            let calls = calls.join(", ");
            if resolved > 0 {
                report.notes.push(format!("{}: `{function}` calls {calls} indirectly: {reason}", self.name));
            } else {
                report.faults.push(format!(
                    "{}: there is no indirect call by `{function}` of {calls}: take it out of the budgets file",
                    self.name
                ));
            }
        }
    }
}

fn counted(findings: &[Finding], refused: &[Finding]) -> Table {
    let mut table = Table::new("Forbidden code, functions found", &["", "refused", "allowed"]);
    for check in Check::ALL {
        let count = |list: &[Finding]| list.iter().filter(|finding| finding.check == check).count();
        let (all, refused) = (count(findings), count(refused));
        table.row([check.name().to_owned(), refused.to_string(), (all - refused).to_string()]);
    }
    table
}

/// All static audits of a planned image.
///
/// # Errors
/// The image cannot be audited.
pub fn all(plan: &Plan, audited: &Audited, budgets: &Budgets, largest: usize) -> Result<Vec<Report>, String> {
    let mut reports = vec![audited.memory(largest, plan.in_detail)?];
    if let Some(monitor) = &plan.code {
        reports.extend([audited.sizes()?, audited.code_of(monitor)?]);
    }
    let vectors = if plan.in_detail { Vectors::InDetail } else { Vectors::Summed };
    reports.push(audited.stack(Some(budgets), vectors, plan.entries)?);
    reports.push(audited.forbidden(Some(budgets), &[])?);
    Ok(reports)
}
