//! Registers and sets of them: core registers, single-precision registers, and each condition flag by itself.

use std::fmt;

/// One register or flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Register(u8);

impl Register {
    /// Stack pointer, r13.
    pub const SP: Register = Register(13);
    /// Link register, r14.
    pub const LR: Register = Register(14);
    /// Program counter, r15.
    pub const PC: Register = Register(15);
    /// Flag "negative" of the APSR.
    pub const N: Register = Register(48);
    /// Flag "zero".
    pub const Z: Register = Register(49);
    /// Flag "carry".
    pub const C: Register = Register(50);
    /// Flag "overflow".
    pub const V: Register = Register(51);
    /// Flag "saturated", which stays set.
    pub const Q: Register = Register(52);
    /// The four flags "greater or equal" of the parallel instructions.
    pub const GE: Register = Register(53);
    /// The comparison flags in the floating-point status.
    pub const FPSCR_FLAGS: Register = Register(54);
    /// The rest of the floating-point status.
    pub const FPSCR: Register = Register(55);

    const COUNT: u8 = 56;
    const NAMES: [&str; 8] = ["N", "Z", "C", "V", "Q", "GE", "fpscr.nzcv", "fpscr"];

    /// Core register r0 to r15.
    ///
    /// # Panics
    /// Above 15.
    #[must_use]
    pub const fn core(number: u8) -> Register {
        assert!(number < 16);
        Register(number)
    }

    /// Single-precision register s0 to s31.
    ///
    /// # Panics
    /// Above 31.
    #[must_use]
    pub const fn single(number: u8) -> Register {
        assert!(number < 32);
        Register(16 + number)
    }

    /// r0 to r15: the number.
    #[must_use]
    pub fn core_number(self) -> Option<u8> {
        (self.0 < 16).then_some(self.0)
    }

    /// s0 to s31: the number.
    #[must_use]
    pub fn single_number(self) -> Option<u8> {
        (16..48).contains(&self.0).then(|| self.0 - 16)
    }

    /// The registers with capstone's name: two for a double-precision register, none for what is not modelled.
    pub(super) fn named(name: &str) -> Vec<Register> {
        let number = |prefix: char, limit: u8| {
            name.strip_prefix(prefix).and_then(|digits| digits.parse::<u8>().ok()).filter(|number| *number < limit)
        };
        if let Some(number) = number('r', 16) {
            return vec![Register::core(number)];
        }
        if let Some(number) = number('s', 32) {
            return vec![Register::single(number)];
        }
        if let Some(number) = number('d', 16) {
            return vec![Register::single(2 * number), Register::single(2 * number + 1)];
        }
        match name {
            "sb" => vec![Register::core(9)],
            "sl" => vec![Register::core(10)],
            "fp" => vec![Register::core(11)],
            "ip" => vec![Register::core(12)],
            "sp" => vec![Register::SP],
            "lr" => vec![Register::LR],
            "pc" => vec![Register::PC],
            "apsr_nzcv" => vec![Register::N, Register::Z, Register::C, Register::V],
            "fpscr" => vec![Register::FPSCR_FLAGS, Register::FPSCR],
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for Register {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Register::SP => write!(f, "sp"),
            Register::LR => write!(f, "lr"),
            Register::PC => write!(f, "pc"),
            Register(number @ 0..16) => write!(f, "r{number}"),
            Register(number @ 16..48) => write!(f, "s{}", number - 16),
            Register(number) => write!(f, "{}", Self::NAMES[usize::from(number) - 48]),
        }
    }
}

/// A set of registers and flags.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Registers(u64);

impl Registers {
    /// None.
    pub const NONE: Registers = Registers(0);
    /// N, Z, C and V.
    pub const FLAGS: Registers = Registers(0b1111 << 48);

    /// These.
    #[must_use]
    pub fn of(list: &[Register]) -> Self {
        Registers(list.iter().fold(0, |set, register| set | 1 << register.0))
    }

    /// Whether it is empty.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether a register is among them.
    #[must_use]
    pub fn contains(self, register: Register) -> bool {
        self.0 >> register.0 & 1 == 1
    }

    /// Those in either set.
    #[must_use]
    pub fn union(self, other: Registers) -> Registers {
        Registers(self.0 | other.0)
    }

    /// Those in both sets.
    #[must_use]
    pub fn intersection(self, other: Registers) -> Registers {
        Registers(self.0 & other.0)
    }

    /// Those that are not in the other set.
    #[must_use]
    pub fn without(self, other: Registers) -> Registers {
        Registers(self.0 & !other.0)
    }

    /// One by one.
    pub fn iter(self) -> impl Iterator<Item = Register> {
        (0..Register::COUNT).map(Register).filter(move |register| self.contains(*register))
    }
}

impl fmt::Debug for Registers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = self.iter().map(|register| register.to_string()).collect();
        write!(f, "{{{}}}", names.join(" "))
    }
}
