//! Where the bytes of flash and RAM go: by section, by crate, by symbol, to the last byte.
//!
//! Every byte of a section belongs to the symbol that covers it; what none covers is a row of its own, and so is what lies
//! between sections. So rows add up to the image, and the sum is checked against the segments that a programmer would
//! write to the chip.
//!
//! What it cannot see: of which crate an inlined function was. It counts for the one it was inlined into.

use std::collections::BTreeMap;

use super::image::{Image, Section, Symbol};
use super::report::{Figure, Report, Table};

/// The row of bytes that no symbol covers: padding, and constants that the linker merged.
pub const UNNAMED: &str = "(no symbol)";
/// The row of bytes between sections.
pub const BETWEEN: &str = "(between sections)";

/// What the memory audit cannot see.
pub const BLIND_SPOTS: [&str; 2] = [
    "an inlined function counts for the crate it was inlined into",
    "RAM is what is static; the stack comes beside it, and a DMA controller or a boot loader may use more",
];

/// Bytes of one symbol in one section.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The section.
    pub section: String,
    /// The crate.
    pub crate_name: String,
    /// The symbol.
    pub symbol: String,
    /// Bytes.
    pub bytes: u64,
}

/// All bytes of an image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// What is written to the chip.
    pub flash: Vec<Piece>,
    /// What is taken of RAM, the stack left out.
    pub ram: Vec<Piece>,
}

impl Usage {
    /// Accounts for every byte of an image.
    ///
    /// # Errors
    /// The sections do not add up to the segments.
    pub fn of(image: &Image) -> Result<Self, String> {
        let mut usage = Usage::default();
        for section in &image.sections {
            let pieces = pieces(image, section);
            if section.in_ram {
                usage.ram.extend(pieces.iter().cloned());
            }
            if section.load_address.is_some() {
                usage.flash.extend(pieces);
            }
        }
        let loaded = |section: &Section| Some((section.load_address?, section.size));
        usage.flash.extend(between(image.sections.iter().filter_map(loaded)));
        let in_ram = image.sections.iter().filter(|section| section.in_ram);
        usage.ram.extend(between(in_ram.map(|section| (section.address, section.size))));
        let (found, written) = (total(&usage.flash), image.loaded_bytes());
        if found != written {
            return Err(format!("sections add up to {found} bytes of flash, segments to {written}"));
        }
        Ok(usage)
    }
}

/// The sum of pieces.
#[must_use]
pub fn total(pieces: &[Piece]) -> u64 {
    pieces.iter().map(|piece| piece.bytes).sum()
}

/// The bytes of a section by symbol, the largest first.
fn pieces(image: &Image, section: &Section) -> Vec<Piece> {
    let end = section.address + section.size;
    let inside = |symbol: &&Symbol| symbol.size > 0 && (section.address..end).contains(&symbol.address);
    let mut symbols: Vec<&Symbol> = image.symbols.iter().filter(inside).collect();
    // Where two cover a byte it is the one with a name of its own; the compiler's labels take what is left.
    symbols.sort_by_key(|symbol| (symbol.linkage_name.starts_with(".L"), symbol.address));
    let mut owners: Vec<Option<usize>> = vec![None; section.size as usize];
    for (index, symbol) in symbols.iter().enumerate() {
        let start = (symbol.address - section.address) as usize;
        let covered = owners.iter_mut().skip(start).take(symbol.size as usize);
        covered.filter(|owner| owner.is_none()).for_each(|owner| *owner = Some(index));
    }
    let mut bytes: BTreeMap<Option<usize>, u64> = BTreeMap::new();
    owners.iter().for_each(|owner| *bytes.entry(*owner).or_default() += 1);
    let piece = |(owner, bytes): (Option<usize>, u64)| {
        let symbol = owner.and_then(|index| symbols.get(index));
        Piece {
            section: section.name.clone(),
            crate_name: symbol.map_or(UNNAMED, |symbol| &symbol.crate_name).to_owned(),
            symbol: symbol.map_or(UNNAMED, |symbol| &symbol.name).to_owned(),
            bytes,
        }
    };
    let mut pieces: Vec<Piece> = bytes.into_iter().map(piece).collect();
    pieces.sort_by_key(|piece| std::cmp::Reverse(piece.bytes));
    pieces
}

/// What lies between sections that follow each other, given as (address, size).
fn between(sections: impl Iterator<Item = (u32, u32)>) -> Option<Piece> {
    let mut sections: Vec<(u32, u32)> = sections.collect();
    sections.sort_unstable();
    let gap = |pair: &[(u32, u32)]| match pair {
        [(start, size), (next, _)] => u64::from(next.saturating_sub(start + size)),
        _ => 0,
    };
    let bytes = sections.windows(2).map(gap).sum();
    let named = |name: &str| name.to_owned();
    (bytes > 0).then(|| Piece { section: named(BETWEEN), crate_name: named(BETWEEN), symbol: named(BETWEEN), bytes })
}

/// Sums by a property, the largest first.
fn summed(pieces: &[Piece], by: impl Fn(&Piece) -> &str) -> Vec<(String, u64)> {
    let mut sums: BTreeMap<&str, u64> = BTreeMap::new();
    pieces.iter().for_each(|piece| *sums.entry(by(piece)).or_default() += piece.bytes);
    let mut sums: Vec<(String, u64)> = sums.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect();
    sums.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    sums
}

/// The memory of an image: by section, by crate, and its largest symbols. Figures by crate only if wanted.
///
/// # Errors
/// The sections do not add up to the segments.
pub fn report(name: &str, image: &Image, largest: usize, by_crate: bool) -> Result<Report, String> {
    let usage = Usage::of(image)?;
    let mut report =
        Report { title: format!("memory of {name}"), blind_spots: BLIND_SPOTS.into(), ..Report::default() };
    for (memory, pieces) in [("flash", &usage.flash), ("ram", &usage.ram)] {
        let crates = if by_crate { summed(pieces, |piece| &piece.crate_name) } else { Vec::new() };
        report.figures.push(Figure::bytes(format!("{memory}.{name}"), total(pieces)));
        report.figures.extend(crates.iter().map(|(of, bytes)| Figure::bytes(format!("{memory}.{name}.{of}"), *bytes)));
    }
    report.tables.push(sums("By section, bytes", &usage, |piece| &piece.section));
    report.tables.push(sums("By crate, bytes", &usage, |piece| &piece.crate_name));
    report.tables.push(symbols(&usage, largest));
    if let Some(text) = image.defmt_text {
        report.notes.push(format!("{} bytes of section .defmt number the texts of `defmt`; they are not loaded", text));
    }
    Ok(report)
}

fn sums(caption: &str, usage: &Usage, by: impl Fn(&Piece) -> &str) -> Table {
    let mut table = Table::new(caption, &["", "flash", "RAM"]);
    let (flash, ram) = (summed(&usage.flash, &by), summed(&usage.ram, &by));
    let in_ram = |name: &str| ram.iter().find(|(other, _)| other == name).map_or(0, |(_, bytes)| *bytes);
    for (name, bytes) in &flash {
        table.row([name.clone(), bytes.to_string(), in_ram(name).to_string()]);
    }
    for (name, bytes) in ram.iter().filter(|(name, _)| !flash.iter().any(|(other, _)| other == name)) {
        table.row([name.clone(), "0".to_owned(), bytes.to_string()]);
    }
    table.row(["sum".to_owned(), total(&usage.flash).to_string(), total(&usage.ram).to_string()]);
    table
}

fn symbols(usage: &Usage, largest: usize) -> Table {
    let mut table = Table::new("Largest symbols, bytes", &["", "bytes", "memory", "crate"]);
    let flash = usage.flash.iter().map(|piece| ("flash", piece));
    let mut pieces: Vec<(&str, &Piece)> = flash.chain(usage.ram.iter().map(|piece| ("RAM", piece))).collect();
    pieces.sort_by_key(|(_, piece)| std::cmp::Reverse(piece.bytes));
    for (memory, piece) in pieces.into_iter().take(largest) {
        table.row([piece.symbol.clone(), piece.bytes.to_string(), memory.to_owned(), piece.crate_name.clone()]);
    }
    table
}
