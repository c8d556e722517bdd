//! A linked firmware image: sections, symbols and bytes of a 32-bit Arm ELF file.
//!
//! What it cannot see: code that no symbol names (it is shown as such), and which source line an address came from.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use object::elf::{EM_ARM, PT_LOAD, SHF_ALLOC, SHF_EXECINSTR, SHT_NOBITS};
use object::read::elf::{ElfFile32, ElfSymbol32, FileHeader, ProgramHeader, SectionHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SymbolKind as Kind};

use super::names;

/// A section that takes memory on the target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Name, such as `.text`.
    pub name: String,
    /// Where it is while the program runs.
    pub address: u32,
    /// Where the image holds its contents: elsewhere than [`address`](Self::address) for `.data`, which start-up copies
    /// from flash to RAM. None if the image holds no contents of it (`.bss`).
    pub load_address: Option<u32>,
    /// Bytes.
    pub size: u32,
    /// It holds instructions.
    pub executable: bool,
    /// It is in RAM while the program runs.
    pub in_ram: bool,
    contents: Vec<u8>,
}

impl Section {
    fn contains(&self, address: u32) -> bool {
        (self.address..self.address + self.size).contains(&address)
    }
}

/// What a symbol names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymbolKind {
    /// Instructions.
    Function,
    /// Constants or variables.
    Object,
}

/// A function or an object with a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// The name people read: demangled, without hashes.
    pub name: String,
    /// The linker's name.
    pub linkage_name: String,
    /// Where it is (bit 0, which marks Thumb code, is cleared).
    pub address: u32,
    /// Bytes; zero for an alias of a symbol at the same address, or for assembly that does not say.
    pub size: u32,
    /// Instructions or data.
    pub kind: SymbolKind,
    /// The crate it belongs to: the one that defines the function, else the one whose compilation brought it, else its
    /// section in brackets.
    pub crate_name: String,
}

/// What the bytes from a mapping symbol on are (Arm, "ELF for the Arm Architecture", mapping symbols).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Contents {
    /// `$t`: Thumb instructions.
    Code,
    /// `$d`: constants and jump tables among the code.
    Data,
}

/// A linked firmware image.
#[derive(Clone, Debug)]
pub struct Image {
    /// The file.
    pub path: PathBuf,
    /// Where the processor starts, bit 0 cleared.
    pub entry: u32,
    /// Sections that take memory on the target, by address.
    pub sections: Vec<Section>,
    /// Functions and objects, by address.
    pub symbols: Vec<Symbol>,
    /// Bytes of the section that numbers the texts of `defmt`, if there is one. It is not loaded.
    pub defmt_text: Option<u32>,
    mapping: BTreeMap<u32, Contents>,
    /// What a programmer writes to the chip: load addresses and sizes.
    segments: Vec<(u32, u32)>,
}

impl Image {
    /// Reads an image.
    ///
    /// # Errors
    /// The file cannot be read, is not a linked 32-bit Arm program, or was stripped of its symbols.
    pub fn read(path: &Path) -> Result<Self, String> {
        let shown = path.display();
        let bytes = fs::read(path).map_err(|error| format!("{shown} cannot be read: {error}"))?;
        let wrong = |what: &str| format!("{shown} {what}; give the ELF file that the linker wrote for the board");
        let elf = ElfFile32::<Endianness>::parse(&*bytes).map_err(|_| wrong("is not a 32-bit ELF file"))?;
        if elf.elf_header().e_machine(elf.endian()) != EM_ARM {
            return Err(wrong("is not for an Arm processor"));
        }
        if elf.elf_program_headers().is_empty() {
            return Err(wrong("is not linked"));
        }
        let sections = sections(&elf).map_err(|error| wrong(&format!("is damaged ({error})")))?;
        if !sections.iter().any(|section| section.executable && section.size > 0) {
            return Err(wrong("holds no instructions"));
        }
        let Symbols { symbols, mapping } =
            symbols(&elf, &sections).map_err(|error| wrong(&format!("is damaged ({error})")))?;
        if symbols.is_empty() || mapping.is_empty() {
            return Err(wrong("has no symbols (it was stripped)"));
        }
        let entry = u32::try_from(elf.entry()).unwrap_or_default() & !1;
        let endian = elf.endian();
        let loaded = elf.elf_program_headers().iter().filter(|s| s.p_type(endian) == PT_LOAD && s.p_filesz(endian) > 0);
        let segments = loaded.map(|s| (s.p_paddr(endian), s.p_filesz(endian))).collect();
        let defmt_text = elf.section_by_name(".defmt").map(|section| section.size() as u32);
        Ok(Image { path: path.to_owned(), entry, sections, symbols, defmt_text, mapping, segments })
    }

    /// The size of what a programmer writes to the chip, from the first byte to the last, by the program headers.
    #[must_use]
    pub fn loaded_bytes(&self) -> u64 {
        let first = self.segments.iter().map(|(start, _)| u64::from(*start)).min().unwrap_or(0);
        let last = self.segments.iter().map(|(start, size)| u64::from(*start) + u64::from(*size)).max().unwrap_or(0);
        last - first
    }

    /// The `length` bytes at `address` of the running program, if the image holds them.
    #[must_use]
    pub fn bytes(&self, address: u32, length: usize) -> Option<&[u8]> {
        let section = self.sections.iter().find(|section| section.contains(address))?;
        let start = (address - section.address) as usize;
        section.contents.get(start..start.checked_add(length)?)
    }

    /// The little-endian word at `address`.
    #[must_use]
    pub fn word(&self, address: u32) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes(address, 4)?.try_into().ok()?))
    }

    /// Whether the mapping symbols say that `address` holds instructions.
    #[must_use]
    pub fn is_code(&self, address: u32) -> bool {
        let executable = self.sections.iter().any(|section| section.executable && section.contains(address));
        let marked = self.mapping.range(..=address).next_back();
        executable && marked.is_some_and(|(_, contents)| *contents == Contents::Code)
    }

    /// Where instructions begin again at or behind `address`: the end of a table of data.
    #[must_use]
    pub fn next_code(&self, address: u32) -> Option<u32> {
        self.mapping.range(address..).find(|(_, contents)| **contents == Contents::Code).map(|(start, _)| *start)
    }

    /// The functions by address: one for each address, with the extent that its symbol, or the next one, gives it.
    pub fn functions(&self) -> impl Iterator<Item = Function<'_>> {
        let mut at: BTreeMap<u32, &Symbol> = BTreeMap::new();
        for symbol in self.symbols.iter().filter(|symbol| symbol.kind == SymbolKind::Function) {
            let named = at.entry(symbol.address).or_insert(symbol);
            if named.size < symbol.size {
                *named = symbol;
            }
        }
        let starts: Vec<u32> = at.keys().copied().collect();
        at.into_values().enumerate().filter_map(move |(index, symbol)| {
            let section = self.sections.iter().find(|section| section.contains(symbol.address))?;
            let next = starts.get(index + 1).copied().unwrap_or(u32::MAX).min(section.address + section.size);
            let end = if symbol.size > 0 { symbol.address + symbol.size } else { next };
            Some(Function { symbol, end })
        })
    }

    /// The symbol with a name: the linker's, or the demangled one.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<&Symbol> {
        self.symbols.iter().find(|symbol| symbol.linkage_name == name || symbol.name == name)
    }

    /// The name of the symbol that covers an address, with the distance from its start.
    #[must_use]
    pub fn place(&self, address: u32) -> String {
        let covers = |symbol: &&Symbol| (symbol.address..symbol.address + symbol.size.max(1)).contains(&address);
        match self.symbols.iter().rev().find(covers) {
            Some(symbol) if symbol.address == address => symbol.name.clone(),
            Some(symbol) => format!("{}+{:#x}", symbol.name, address - symbol.address),
            None => format!("{address:#010x}"),
        }
    }
}

/// A function with the addresses it covers.
#[derive(Clone, Copy, Debug)]
pub struct Function<'a> {
    /// Its name and start.
    pub symbol: &'a Symbol,
    /// The first address behind it.
    pub end: u32,
}

fn sections(elf: &ElfFile32) -> object::Result<Vec<Section>> {
    let endian = elf.endian();
    let segments: Vec<_> = elf.elf_program_headers().iter().filter(|s| s.p_type(endian) == PT_LOAD).collect();
    let mut sections = Vec::new();
    for section in elf.sections() {
        let header = section.elf_section_header();
        let flags = header.sh_flags(endian);
        let (address, size) = (header.sh_addr(endian), header.sh_size(endian));
        let (offset, has_contents) = (header.sh_offset(endian), header.sh_type(endian) != SHT_NOBITS);
        if flags & SHF_ALLOC == 0 || size == 0 {
            continue;
        }
        let holds = |start: u32, length: u32, at: u32| {
            at >= start && u64::from(at) + u64::from(size) <= u64::from(start) + u64::from(length)
        };
        let segment = segments.iter().find(|s| holds(s.p_vaddr(endian), s.p_memsz(endian), address));
        let load = |s: &&&_| {
            let s: &object::elf::ProgramHeader32<Endianness> = s;
            let held = has_contents && holds(s.p_offset(endian), s.p_filesz(endian), offset);
            held.then(|| s.p_paddr(endian) + (offset - s.p_offset(endian)))
        };
        sections.push(Section {
            name: section.name()?.to_owned(),
            address,
            load_address: segment.as_ref().and_then(load),
            size,
            executable: flags & SHF_EXECINSTR != 0,
            in_ram: in_ram(address),
            contents: if has_contents { section.data()?.to_vec() } else { Vec::new() },
        });
    }
    sections.sort_by_key(|section| section.address);
    Ok(sections)
}

/// Whether an address is in the SRAM region of the Armv7-M memory map (Arm DDI 0403, B3.1), or in the core-coupled RAM
/// that several STM32 have below it.
fn in_ram(address: u32) -> bool {
    (0x2000_0000..0x4000_0000).contains(&address) || (0x1000_0000..0x1800_0000).contains(&address)
}

struct Symbols {
    symbols: Vec<Symbol>,
    mapping: BTreeMap<u32, Contents>,
}

fn symbols(elf: &ElfFile32, sections: &[Section]) -> object::Result<Symbols> {
    // Local symbols stand behind the name of the compilation that brought them, mapping symbols among them.
    let mut unit = String::new();
    let (mut unit_at, mut mapping, mut found) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
    for symbol in elf.symbols() {
        let (name, address) = (symbol.name()?, symbol.address() as u32);
        match symbol.kind() {
            Kind::File => unit = names::crate_of_unit(name),
            // Texts of `defmt` are symbols of a section that is not loaded.
            Kind::Text | Kind::Data if takes_memory(elf, &symbol)? => {
                found.push((symbol, symbol.is_local().then(|| unit.clone())));
            }
            _ if name.starts_with("$t") || name.starts_with("$d") => {
                let code = name.starts_with("$t");
                mapping.insert(address, if code { Contents::Code } else { Contents::Data });
                unit_at.insert(address, unit.clone());
            }
            _ => {}
        }
    }
    let mut symbols = Vec::new();
    for (symbol, local_unit) in found {
        let linkage_name = symbol.name()?.to_owned();
        let kind = if symbol.kind() == Kind::Text { SymbolKind::Function } else { SymbolKind::Object };
        let address = symbol.address() as u32 & if kind == SymbolKind::Function { !1 } else { !0 };
        let Some(section) = sections.iter().find(|section| section.contains(address)) else { continue };
        let at_address = || unit_at.range(..=address).next_back().map(|(_, unit)| unit.clone());
        let unit = local_unit.or_else(|| (kind == SymbolKind::Function).then(at_address).flatten());
        symbols.push(Symbol {
            name: names::demangled(&linkage_name),
            crate_name: names::crate_of(&linkage_name).or(unit).unwrap_or_else(|| format!("({})", section.name)),
            linkage_name,
            address,
            size: symbol.size() as u32,
            kind,
        });
    }
    symbols.sort_by(|a, b| (a.address, &a.linkage_name).cmp(&(b.address, &b.linkage_name)));
    Ok(Symbols { symbols, mapping })
}

fn takes_memory(elf: &ElfFile32, symbol: &ElfSymbol32<'_, '_>) -> object::Result<bool> {
    let Some(index) = symbol.section_index() else { return Ok(false) };
    Ok(elf.section_by_index(index)?.elf_section_header().sh_flags(elf.endian()) & SHF_ALLOC != 0)
}
