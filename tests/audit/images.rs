//! Which images are audited.

use crate::toolchain::Firmware;

/// An image to audit.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// How to build it. Its binary's name is its name in the budgets.
    pub firmware: Firmware<'static>,
    /// Functions that are entry points of their own, beside the vector table: calls whose stack has a limit by itself.
    pub entries: &'static [&'static str],
    /// Of these, the ones whose code is what the monitor takes in flash; such an image publishes sizes of types as well.
    pub core: &'static [&'static str],
    /// Figures by crate and by vector have budgets as well. Of an image that only serves tests the sums are enough.
    pub in_detail: bool,
    /// It flies missions in emulation and tells how much of the stack they used.
    pub flies: bool,
}

/// The calls of the monitor, as functions of the image `footprint`.
const MONITOR: &[&str] = &["core_new", "core_step", "core_skip", "core_finish_learning", "core_contributions"];

/// The same, and the event log beside it.
const CORE: &[&str] =
    &["core_new", "core_step", "core_skip", "core_finish_learning", "core_contributions", "core_observe"];

/// All images that are audited. Adding a line here, and budgets for its figures, is all that a further image takes.
pub const IMAGES: &[Plan] = &[
    Plan {
        firmware: Firmware { profile: "firmware", ..Firmware::audited("footprint") },
        entries: CORE,
        core: MONITOR,
        in_detail: false,
        flies: false,
    },
    Plan { firmware: Firmware::thruster("board-stm32f405"), entries: &[], core: &[], in_detail: true, flies: false },
    Plan { firmware: Firmware::emulated("qemu-mission"), entries: &[], core: &[], in_detail: false, flies: true },
];
