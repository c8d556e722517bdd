//! The proof that a path does not depend on data.
//!
//! A thousand equal paths prove nothing of the next input. This does: the firmware runs once, every number that a kernel
//! is given is marked as data when the call begins, and the marks spread with every instruction that is executed, in the
//! kernels and between them: from what an instruction reads to what it writes, through registers, each flag and each byte
//! of memory. A conditional instruction adds the marks of its condition and takes none away. Registers before each
//! instruction come from the emulator, so every address is the real one.
//!
//! Inside a kernel these decisions must not be marked: the condition of a branch, the target of an indirect one, an
//! address, the operands of a divide (the only instruction of this processor whose time depends on its operands: VDIV and
//! VSQRT take 14 cycles always), and the condition of an IT block unless all it does is to choose: an instruction of one
//! cycle, which takes one cycle as well when it is skipped (Arm DDI 0439, 3.3).
//!
//! # Why that is a proof
//! Take a second run that differs in the data alone, and suppose it has executed the same instructions so far. What is not
//! marked has the same value in both, because it was made by the same instructions from values that are not marked (that is
//! how marks spread; an instruction whose effect on memory is not known ends the proof). The next address is decided
//! by values that are not marked, so it is the same too. By induction both runs have one path; and with it one sequence of
//! addresses and one bound of cycles. The proof is for the image as linked, whatever compiler made it.
//!
//! # What is data, and what is control
//! Samples are data; so is all that was ever computed from them, across calls: means, models, filters, relays. The set
//! point, the settings, counters of slots and the phase are control: a path depends on them, and the proof says on how many
//! bytes of state it does ([`Proof::control`]). Between calls, the end of learning decides by data whether a window is
//! accepted; that is the phase. So that nothing else comes in that way, whatever the end of learning writes, marked or not,
//! may decide nothing inside a kernel but the phase ([`PHASE_BYTES`]).
//!
//! What it cannot see: time that depends on addresses (flash, caches, the bus), and a second kind of path that the run never
//! took because its control never came: each phase needs calls of its own.

mod marks;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use firmware_stub::kernels::{Kernel, Request};

use super::code::Code;
use super::cycles::{self, Timing};
use super::decode::{Flow, Instruction, Memory, Register, Registers};
use super::image::Image;
use super::trace::{self, Detail, Limits, Step};
use marks::{Mark, Marks};

/// Bytes that say which phase a monitor is in: the tag of an enumeration is at most a word.
pub const PHASE_BYTES: usize = 4;

/// What the proof found for calls of one label.
#[derive(Clone, Debug, Default)]
pub struct Proof {
    /// Calls followed.
    pub calls: u64,
    /// Instructions followed in them.
    pub instructions: u64,
    /// Instructions that choose between values by data, in one path: by address.
    pub selects: BTreeSet<u32>,
    /// Decisions by data: a sentence for each, by address.
    pub violations: BTreeMap<u32, String>,
    /// Bytes of state that decide the path, as distances from the state's start.
    pub control: BTreeSet<u32>,
    /// Of these, what the end of learning has written.
    pub phase: BTreeSet<u32>,
}

impl Proof {
    /// Whether every input takes the same path.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.calls > 0 && self.violations.is_empty() && self.phase.len() <= PHASE_BYTES
    }

    /// Why it does not hold.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults: Vec<String> = self.violations.values().cloned().collect();
        if self.phase.len() > PHASE_BYTES {
            faults.push(format!("{} bytes that the end of learning writes decide the path", self.phase.len()));
        }
        if self.calls == 0 {
            faults.push("no call was followed".to_owned());
        }
        faults
    }
}

/// Follows the marks through a run of the firmware. Each request comes with the label its call is counted under.
///
/// # Errors
/// The run fails, or an instruction of a kernel has effects that are not known.
pub fn prove(
    elf: &Path,
    image: &Image,
    code: &Code,
    requests: &[(Request, &'static str)],
) -> Result<BTreeMap<&'static str, Proof>, String> {
    let plain: Vec<Request> = requests.iter().map(|(request, _)| *request).collect();
    let mut prover = Prover {
        image,
        code,
        entries: trace::entries(code),
        labels: requests.iter().filter(|(request, _)| !request.kernel.symbol().is_empty()).map(|(_, l)| *l).collect(),
        followed: 0,
        before: 0,
        open: None,
        marks: Marks::default(),
        learned: BTreeSet::new(),
        proofs: BTreeMap::new(),
    };
    trace::run(elf, &plain, Detail::Registers, Limits::DEFAULT, |step| prover.take(step))?;
    Ok(prover.proofs)
}

/// A call that is being followed.
#[derive(Clone, Copy, Debug)]
struct Open {
    kernel: Kernel,
    label: &'static str,
    back: u32,
    /// Where the kernel's state begins.
    state: u32,
}

struct Prover<'a> {
    image: &'a Image,
    code: &'a Code,
    entries: std::collections::HashMap<u32, Kernel>,
    labels: Vec<&'static str>,
    followed: usize,
    before: u32,
    open: Option<Open>,
    marks: Marks,
    /// Addresses that the end of learning has written.
    learned: BTreeSet<u32>,
    proofs: BTreeMap<&'static str, Proof>,
}

/// Bytes of the data that a kernel is given, at the address in r1; a step has its readings in registers.
fn data_bytes(kernel: Kernel) -> u32 {
    match kernel {
        Kernel::Restart | Kernel::ClearWindow | Kernel::FinishLearning | Kernel::WindowEnd | Kernel::Step => 0,
        Kernel::GuardStep | Kernel::GuardFinishLearning | Kernel::GuardFinding => 0,
        Kernel::GuardCopy | Kernel::GuardInstall => 0,
        Kernel::UpperNormal | Kernel::UpperChiSquare | Kernel::UpperF | Kernel::T2Limit => 0,
        Kernel::FilteredLimit | Kernel::SmoothedLimit => 0,
        Kernel::FirstOrder | Kernel::CompensatedFilter | Kernel::CompensatedFirstOrder | Kernel::MovingAverage => 4,
        Kernel::Filter | Kernel::Biquad | Kernel::CBiquad => 4,
        Kernel::Branching | Kernel::Selecting | Kernel::Indexing | Kernel::Remembering => 4,
        Kernel::Eigen2 | Kernel::Correlation2 | Kernel::NalgebraEigen2 => 4 * 4,
        Kernel::Eigen3 | Kernel::Correlation3 | Kernel::NalgebraEigen3 => 9 * 4,
        Kernel::Push | Kernel::T2 | Kernel::Ewma | Kernel::NalgebraT2 | Kernel::Textbook => 3 * 4,
        Kernel::CMatrixT2 | Kernel::CTriangleT2 => 3 * 4,
    }
}

impl Prover<'_> {
    fn take(&mut self, step: &Step) -> Result<(), String> {
        if self.open.is_some_and(|open| open.back == step.pc) {
            self.open = None;
            self.marks.leave();
        }
        if self.open.is_none()
            && let Some(kernel) = self.entries.get(&step.pc).copied()
        {
            self.enter(kernel, step)?;
        }
        self.before = step.pc;
        let Some(i) = self.code.instructions.get(&step.pc) else {
            return Err(format!("{:#010x} is executed, and no instruction is known there", step.pc));
        };
        if let Some(open) = self.open {
            self.judge(i, step, open)?;
        }
        self.spread(i, step);
        Ok(())
    }

    fn enter(&mut self, kernel: Kernel, step: &Step) -> Result<(), String> {
        let label = *self.labels.get(self.followed).ok_or("more calls were made than were asked for")?;
        self.followed += 1;
        let back = trace::return_address(self.code, self.before, kernel)?;
        self.open = Some(Open { kernel, label, back, state: step.registers[0] });
        self.marks.enter();
        if matches!(kernel, Kernel::Step | Kernel::GuardStep) {
            // The set point is in s0; the three readings follow it.
            for reading in [1, 2, 3].map(Register::single) {
                self.marks.set(reading, Mark { data: true, ..Mark::default() }, false);
            }
        }
        let data = step.registers[1];
        self.marks.mark_data(data..data + data_bytes(kernel));
        self.proofs.entry(label).or_default().calls += 1;
        Ok(())
    }

    /// Looks for decisions by data.
    fn judge(&mut self, i: &Instruction, step: &Step, open: Open) -> Result<(), String> {
        if ["bkpt", "svc", "wfi", "wfe", "hint"].contains(&i.mnemonic.as_str()) || i.flow == Flow::Stop {
            return Err(format!("{}: the effects of `{i}` are not known", self.image.place(i.address)));
        }
        if matches!(open.kernel, Kernel::FinishLearning | Kernel::GuardFinishLearning)
            && let Some(memory) = i.memory.as_ref().filter(|memory| !memory.load)
        {
            let start = address(i, memory, step);
            self.learned.extend(start..start + memory.size);
        }
        let timing = cycles::timing(i);
        let chooses = i.condition.is_some() && i.flow == Flow::Next && i.memory.is_none() && timing.is_single_cycle();
        let decisions = self.decisions(i, step, timing, chooses);
        let selects = chooses && self.condition(i).data;
        let proof = self.proofs.entry(open.label).or_default();
        proof.instructions += 1;
        if selects {
            proof.selects.insert(i.address);
        }
        for (what, mark) in decisions {
            if mark.data {
                let place = self.image.place(i.address);
                proof.violations.entry(i.address).or_insert_with(|| format!("{place}: `{i}`: {what} depends on data"));
            }
            for byte in mark.state {
                let offset = byte.wrapping_sub(open.state);
                proof.control.insert(offset);
                if self.learned.contains(&byte) {
                    proof.phase.insert(offset);
                }
            }
        }
        Ok(())
    }

    /// What an instruction decides, and by what.
    fn decisions(&self, i: &Instruction, step: &Step, timing: Timing, chooses: bool) -> Vec<(&'static str, Mark)> {
        let mut decisions = Vec::new();
        if !chooses {
            decisions.push(("its condition", self.condition(i)));
        }
        if !matches!(i.flow, Flow::Next | Flow::Jump(_) | Flow::Call(_) | Flow::Stop) {
            decisions.push(("where it goes", self.target(i, step)));
        }
        if let Some(memory) = &i.memory {
            decisions.push(("its address", self.marks.of(address_registers(memory))));
        }
        if timing.depends_on_operands() {
            decisions.push(("its time", self.marks.of(i.reads)));
        }
        decisions
    }

    /// The mark of the condition under which an instruction is executed.
    fn condition(&self, i: &Instruction) -> Mark {
        self.marks.of(i.condition.map_or(Registers::NONE, |condition| condition.flags()))
    }

    /// The mark of where an instruction goes.
    fn target(&self, i: &Instruction, step: &Step) -> Mark {
        let Some(memory) = &i.memory else {
            return self.marks.of(i.reads.without(Registers::of(&[Register::PC])));
        };
        let start = address(i, memory, step);
        match memory.registers.iter().position(|register| *register == Register::PC) {
            Some(place) => self.marks.of_memory(start + 4 * place as u32, 4),
            None => self.marks.of_memory(start, memory.size),
        }
    }

    /// Carries the marks from what an instruction reads to what it writes.
    fn spread(&mut self, i: &Instruction, step: &Step) {
        let condition = self.condition(i);
        let conditional = i.condition.is_some();
        let mut mark = self.marks.of(i.reads).and(&condition);
        // The exception bits that arithmetic leaves in the status depend on every number there ever was.
        mark.data |= i.reads.contains(Register::FPSCR);
        let Some(memory) = &i.memory else {
            for register in i.writes.iter().filter(|register| *register != Register::PC) {
                self.marks.set(register, mark.clone(), conditional || i.keeps.contains(register));
            }
            return;
        };
        let start = address(i, memory, step);
        let by_address = self.marks.of(address_registers(memory)).and(&condition);
        let share = memory.size / (memory.registers.len() as u32).max(1);
        let parts = memory.registers.iter().zip((start..).step_by(share.max(1) as usize));
        if memory.load {
            let loaded: Vec<_> =
                parts.map(|(register, at)| (*register, self.marks.of_memory(at, share).and(&by_address))).collect();
            for (register, mark) in loaded.into_iter().filter(|(register, _)| *register != Register::PC) {
                self.marks.set(register, mark, conditional);
            }
        } else {
            for (register, at) in parts {
                let mark = self.marks.of(Registers::of(&[*register])).and(&by_address);
                self.marks.store(at..at + share, &mark, conditional);
            }
        }
        // What else it writes: a base that moves, the success of an exclusive store.
        let rest = i.writes.without(Registers::of(&memory.registers)).without(Registers::of(&[Register::PC]));
        let rest = if memory.load { rest } else { i.writes };
        for register in rest.iter() {
            let mark = if register == memory.base { by_address.clone() } else { mark.clone() };
            self.marks.set(register, mark, conditional);
        }
    }
}

fn address_registers(memory: &Memory) -> Registers {
    let all = [Some(memory.base), memory.index];
    Registers::of(&all.into_iter().flatten().filter(|register| *register != Register::PC).collect::<Vec<_>>())
}

/// The lowest byte that a load or store touches.
fn address(i: &Instruction, memory: &Memory, step: &Step) -> u32 {
    let value = |register: Register| {
        let number = usize::from(register.core_number().unwrap_or_default());
        step.registers.get(number).copied().unwrap_or_default()
    };
    let table = matches!(i.flow, Flow::Table { .. });
    let base = match memory.base {
        Register::PC if table => i.address + 4,
        Register::PC => (i.address + 4) & !3,
        base => value(base),
    };
    let index = memory.index.map_or(0, |index| value(index) << memory.shift);
    base.wrapping_add(index).wrapping_add_signed(memory.offset)
}
