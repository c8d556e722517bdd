//! How a run can end: the reason, kept across a reset or told to the emulator's host. The fault output is made safe first.

/// Why the firmware stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// The processor met an instruction or address it cannot.
    HardFault,
    /// The stack has grown beyond the start of RAM; `flip-link` has put nothing there that could be overwritten.
    StackOverflow,
    /// Main loop or sampling interrupt stopped answering.
    Watchdog,
    /// A panic. Nothing in the monitor can; a dependency might.
    Panic,
    /// The monitor refused its settings.
    Settings,
}

impl Reason {
    /// All of them.
    pub const ALL: [Reason; 5] =
        [Reason::HardFault, Reason::StackOverflow, Reason::Watchdog, Reason::Panic, Reason::Settings];

    /// A line for a console, ending in a zero byte.
    #[must_use]
    pub const fn line(self) -> &'static [u8] {
        match self {
            Reason::HardFault => b"error: hard fault; fault output safe\n\0",
            Reason::StackOverflow => b"error: stack overflow; fault output safe\n\0",
            Reason::Watchdog => b"error: watchdog: the loop stopped answering; fault output safe\n\0",
            Reason::Panic => b"error: panic; fault output safe\n\0",
            Reason::Settings => b"error: the monitor refuses its settings; fault output safe\n\0",
        }
    }

    /// A word that memory does not hold by chance, to be kept across a reset.
    #[must_use]
    pub const fn to_word(self) -> u32 {
        // "TF" in the upper half; the lower half is its complement apart from the code.
        0x5446_0000 | !0x5446_u16 as u32 & 0xff00 | self as u32
    }

    /// Reads such a word; none when it is not one.
    #[must_use]
    pub fn from_word(word: u32) -> Option<Reason> {
        Reason::ALL.into_iter().find(|reason| reason.to_word() == word)
    }

    /// Tells a stack overflow from other hard faults: the stack pointer at the fault, and where the stack ends.
    ///
    /// A handler's frame has not been stacked when stacking it failed, so the pointer lies at or below the end, or less
    /// than a frame (104 bytes with floating point) above it.
    #[must_use]
    pub const fn of_hard_fault(stack_pointer: u32, stack_end: u32) -> Reason {
        const FRAME: u32 = 104;
        if stack_pointer < stack_end.wrapping_add(FRAME) { Reason::StackOverflow } else { Reason::HardFault }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_is_read_back_from_its_word_and_other_memory_is_none() {
        for reason in Reason::ALL {
            assert_eq!(Reason::from_word(reason.to_word()), Some(reason));
            assert_eq!(Reason::from_word(reason.to_word() ^ 1 << 31), None);
        }
        for word in [0, u32::MAX, 0xcccc_cccc] {
            assert_eq!(Reason::from_word(word), None);
        }
    }

    #[test]
    fn a_stack_pointer_at_or_below_the_end_of_the_stack_tells_an_overflow() {
        for (pointer, reason) in [
            (0x1fff_ff80, Reason::StackOverflow),
            (0x2000_0000, Reason::StackOverflow),
            (0x2000_0060, Reason::StackOverflow),
            (0x2001_0000, Reason::HardFault),
        ] {
            assert_eq!(Reason::of_hard_fault(pointer, 0x2000_0000), reason, "{pointer:#x}");
        }
    }
}
