//! A register of a peripheral that has no crate of its own.

/// A 32-bit register at a fixed address.
#[derive(Clone, Copy, Debug)]
pub(super) struct Register(*mut u32);

#[allow(unsafe_code)] // Each board names only registers that it has, and makes this type nowhere else.
impl Register {
    /// The register at `address`, which must be one of the board's.
    pub(super) const fn at(address: usize) -> Self {
        Register(core::ptr::without_provenance_mut(address))
    }

    pub(super) fn read(self) -> u32 {
        // SAFETY: the address is that of a register of the board, aligned and always readable.
        unsafe { self.0.read_volatile() }
    }

    pub(super) fn write(self, value: u32) {
        // SAFETY: as above; what a write does is the matter of the module that names the register.
        unsafe { self.0.write_volatile(value) }
    }
}
