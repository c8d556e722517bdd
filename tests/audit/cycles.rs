//! Cycles of a Cortex-M4F for an exact path, by the published timing of its instructions.
//!
//! Arm DDI 0439 (Cortex-M4 Technical Reference Manual), tables 3-1 and 7-1 and the notes under them, with memory that
//! never makes the processor wait. Where the manual leaves a span, three figures keep it:
//! - `best`: loads overlap with what is before them, stores go into the write buffer, a taken branch refills the pipeline
//!   in 1 cycle, `it` is folded, a divide leaves early, and integer instructions run while the floating-point unit divides;
//! - `nominal`: loads and stores overlap only with a load or store before them, a branch refills in 2, no folding;
//! - `worst`: every load and store takes 2 cycles, a branch refills in 3, divides take longest, a constant in flash and an
//!   address that the instruction before has made cost 1 more.
//!
//! This is a model; nothing was measured on silicon. What it cannot see: wait states of flash, prefetch and caches, other
//! masters on the bus, and the entry of an interrupt (12 cycles, and up to 17 more where floating-point registers are
//! stacked at once).

use super::code::Code;
use super::decode::{Flow, Instruction, Register, Registers};

/// Cycles for one path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Instructions executed: exact.
    pub instructions: u64,
    /// Cycles, at best.
    pub best: u64,
    /// Cycles, most likely.
    pub nominal: u64,
    /// Cycles, at worst.
    pub worst: u64,
}

/// Cycles of an instruction, and in what way it depends on its neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    best: u64,
    nominal: u64,
    worst: u64,
    unit: Unit,
}

/// What works on an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    /// Integer arithmetic, moves, branches.
    Integer,
    /// One load: it can overlap with a load or store before it.
    Load,
    /// One store: so can it.
    Store,
    /// Several words.
    Multiple,
    /// Floating-point arithmetic and conversions: a result that is used at once costs a cycle.
    Arithmetic,
    /// Floating-point compares and signs, of which the manual does not say whether they count as arithmetic.
    Compare,
    /// Floating-point division and square root: integer instructions run beside it.
    Divide,
    /// Moves of floating-point registers.
    Move,
}

impl Timing {
    const fn new(unit: Unit, best: u64, nominal: u64, worst: u64) -> Self {
        Timing { best, nominal, worst, unit }
    }

    const fn fixed(unit: Unit, cycles: u64) -> Self {
        Timing::new(unit, cycles, cycles, cycles)
    }

    /// Whether it takes one cycle in any case, and so as long as when an IT block skips it.
    #[must_use]
    pub fn is_single_cycle(self) -> bool {
        self.best == 1 && self.worst == 1
    }

    /// Whether its time depends on the values it works on.
    #[must_use]
    pub fn depends_on_operands(self) -> bool {
        self.unit == Unit::Integer && self.worst > self.best + 1
    }

    fn is_floating(self) -> bool {
        matches!(self.unit, Unit::Arithmetic | Unit::Compare | Unit::Divide | Unit::Move)
    }
}

/// The timing of an instruction by itself, without the refill of a branch.
#[must_use]
pub fn timing(i: &Instruction) -> Timing {
    if let Some(memory) = &i.memory {
        return of_memory(i, memory.registers.len() as u64, memory.load);
    }
    let name = i.mnemonic.as_str();
    match name {
        "it" => Timing::new(Unit::Integer, 0, 1, 1),
        // Table 3-1: 2 to 12, by the number of leading zeros and ones.
        "udiv" | "sdiv" => Timing::new(Unit::Integer, 2, 12, 12),
        "mla" | "mls" => Timing::fixed(Unit::Integer, 2),
        "mrs" | "msr" => Timing::new(Unit::Integer, 1, 2, 2),
        "dmb" | "dsb" | "isb" => Timing::new(Unit::Integer, 1, 4, 4),
        "vdiv" | "vsqrt" => Timing::fixed(Unit::Divide, 14),
        "vmrs" | "vmsr" => Timing::fixed(Unit::Move, 1),
        "vmov" => of_move(i),
        "vabs" | "vneg" | "vcmp" | "vcmpe" => Timing::fixed(Unit::Compare, 1),
        _ if ["vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms"].contains(&name) => {
            Timing::fixed(Unit::Arithmetic, 3)
        }
        _ if name.starts_with('v') => Timing::fixed(Unit::Arithmetic, 1),
        _ => Timing::fixed(Unit::Integer, 1),
    }
}

fn of_memory(i: &Instruction, words: u64, load: bool) -> Timing {
    let name = i.mnemonic.as_str();
    match name {
        "tbb" | "tbh" => Timing::fixed(Unit::Multiple, 2),
        // To the program counter: 2, then the refill.
        "ldr" if i.writes.contains(Register::PC) => Timing::fixed(Unit::Multiple, 2),
        // Double precision is two words on a bus of one.
        "vldr" | "vstr" if words > 1 => {
            Timing::new(if load { Unit::Load } else { Unit::Store }, words, 1 + words, 1 + words)
        }
        "vldr" => Timing::new(Unit::Load, 1, 2, 2),
        "vstr" => Timing::new(Unit::Store, 1, 2, 2),
        "push" | "pop" | "vpush" | "vpop" | "ldrd" | "strd" => Timing::fixed(Unit::Multiple, 1 + words),
        _ if ["ldm", "stm", "vldm", "vstm"].iter().any(|many| name.starts_with(many)) => {
            Timing::fixed(Unit::Multiple, 1 + words)
        }
        _ if load => Timing::new(Unit::Load, 1, 2, 2),
        // Into the write buffer, unless that is full.
        _ => Timing::new(Unit::Store, 1, 1, 2),
    }
}

/// Table 7-1: moves between the register files are 1 for one word and 2 for two. Another vendor's copy of the table has 2
/// for one word as well (TI SWCU192), so that is the worst.
fn of_move(i: &Instruction) -> Timing {
    let core = |set: Registers| set.iter().filter(|register| register.core_number().is_some()).count();
    match core(i.reads) + core(i.writes) {
        0 => Timing::fixed(Unit::Move, 1),
        1 => Timing::new(Unit::Move, 1, 1, 2),
        _ => Timing::fixed(Unit::Move, 2),
    }
}

/// The cost of a path: addresses of instructions, the last of which leaves the function.
///
/// # Errors
/// The image has no instruction at an address of the path.
pub fn cost(code: &Code, path: &[u32]) -> Result<Cost, String> {
    let mut pipeline = Pipeline::default();
    for (place, address) in path.iter().enumerate() {
        let i = code.instructions.get(address).ok_or_else(|| format!("no instruction at {address:#010x}"))?;
        pipeline.take(i, path.get(place + 1) != Some(&i.end()));
    }
    Ok(pipeline.cost)
}

/// What the model remembers of the instruction before.
#[derive(Clone, Copy, Debug, Default)]
struct Pipeline {
    cost: Cost,
    /// Results of floating-point arithmetic, and of compares and signs beside it.
    late: Registers,
    late_perhaps: Registers,
    /// Results of integer instructions and moves.
    made: Registers,
    loaded: Registers,
    /// It was a single load or store.
    single: bool,
    /// Cycles of a division that nothing has waited for yet.
    dividing: u64,
}

impl Pipeline {
    fn take(&mut self, i: &Instruction, taken: bool) {
        let Timing { mut best, mut nominal, mut worst, unit } = timing(i);
        let address = i.memory.as_ref().map_or(Registers::NONE, |memory| {
            Registers::of(&[Some(memory.base), memory.index].into_iter().flatten().collect::<Vec<_>>())
        });
        let uses = |made: Registers| !i.reads.intersection(made).is_empty();
        let addressed_by = |made: Registers| !address.intersection(made).is_empty();
        if matches!(unit, Unit::Load | Unit::Store) && self.single && nominal == 2 && !addressed_by(self.loaded) {
            nominal = 1;
        }
        if i.condition.is_some() && i.in_it_block {
            best = best.min(1); // skipped
        }
        if addressed_by(self.made) {
            (nominal, worst) = (nominal + 1, worst + 1);
        }
        if unit == Unit::Load && i.literal().is_some() {
            worst += 1;
        }
        if uses(self.late) {
            best += 1;
        }
        if uses(self.late.union(self.late_perhaps)) {
            (nominal, worst) = (nominal + 1, worst + 1);
        }
        if taken {
            (best, nominal, worst) = (best + 1, nominal + 2, worst + 3);
        }
        self.overlap(i, unit, &mut best);
        let cost = &mut self.cost;
        cost.instructions += 1;
        (cost.best, cost.nominal, cost.worst) = (cost.best + best, cost.nominal + nominal, cost.worst + worst);
        self.remember(i, unit);
    }

    /// At best, a division costs one cycle and the rest only when the floating-point unit is wanted again.
    fn overlap(&mut self, i: &Instruction, unit: Unit, best: &mut u64) {
        let floating = timing(i).is_floating() || i.mnemonic.starts_with('v');
        if floating {
            *best += self.dividing;
            self.dividing = 0;
        } else {
            self.dividing = self.dividing.saturating_sub(*best);
        }
        if unit == Unit::Divide && *best >= 14 {
            *best -= 13;
            self.dividing = 13;
        }
    }

    fn remember(&mut self, i: &Instruction, unit: Unit) {
        let if_unit = |units: &[Unit]| if units.contains(&unit) { i.writes } else { Registers::NONE };
        self.late = if_unit(&[Unit::Arithmetic, Unit::Divide]);
        self.late_perhaps = if_unit(&[Unit::Compare]);
        self.made = if_unit(&[Unit::Integer, Unit::Move]);
        if matches!(i.flow, Flow::Call(_) | Flow::IndirectCall) {
            self.made = Registers::NONE;
        }
        self.loaded = if_unit(&[Unit::Load, Unit::Multiple]);
        self.single = matches!(unit, Unit::Load | Unit::Store);
    }
}

#[cfg(test)]
mod tests;
