//! Which images are audited.

use crate::toolchain::Firmware;

/// An image to audit.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Its name in the budgets.
    pub name: &'static str,
    /// How to build it.
    pub firmware: Firmware<'static>,
    /// Functions that are entry points of their own, beside the vector table: calls whose stack has a limit by itself.
    pub entries: &'static [&'static str],
    /// The code that a monitor takes in flash; such an image publishes sizes of types as well.
    pub code: Option<CodeOf>,
    /// Figures by crate and by vector have budgets as well. Of an image that only serves tests the sums are enough.
    pub in_detail: bool,
    /// It flies missions in emulation and tells how much of the stack they used.
    pub flies: bool,
}

/// A monitor whose code is counted.
#[derive(Clone, Copy, Debug)]
pub struct CodeOf {
    /// Its name in the budgets: `flash.NAME`.
    pub name: &'static str,
    /// Its calls, entry points of the image.
    pub calls: &'static [&'static str],
}

/// The calls of the monitor, as functions of the image `footprint`.
const MONITOR: &[&str] = &["core_new", "core_step", "core_skip", "core_finish_learning", "core_contributions"];

/// The same, and the event log beside it.
const CORE: &[&str] =
    &["core_new", "core_step", "core_skip", "core_finish_learning", "core_contributions", "core_observe"];

/// The calls of `guard` mode, as functions of the image `footprint-guard`.
const GUARD: &[&str] = &["guard_new", "guard_step", "guard_skip", "guard_finish_learning", "guard_finding"];

/// All images that are audited. Adding a line here, and budgets for its figures, is all that a further image takes.
pub const IMAGES: &[Plan] = &[
    Plan {
        entries: CORE,
        code: Some(CodeOf { name: "core", calls: MONITOR }),
        ..Plan::of(Firmware::audited("footprint"))
    },
    Plan {
        entries: GUARD,
        code: Some(CodeOf { name: "guard", calls: GUARD }),
        ..Plan::of(Firmware::audited("footprint-guard"))
    },
    Plan { in_detail: true, ..Plan::of(Firmware::thruster("board-stm32f405")) },
    Plan { name: "thruster-paper", in_detail: true, ..Plan::of(Firmware::thruster("board-stm32f405,paper")) },
    Plan { flies: true, ..Plan::of(Firmware::emulated("qemu-mission")) },
    Plan { flies: true, ..Plan::of(Firmware::emulated("qemu-guard")) },
];

impl Plan {
    /// An image by the name of its binary, of which nothing but the sums has budgets.
    const fn of(firmware: Firmware<'static>) -> Self {
        Plan { name: firmware.binary, firmware, entries: &[], code: None, in_detail: false, flies: false }
    }
}
