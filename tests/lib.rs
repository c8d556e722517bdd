//! Promises across crates, one file each; the peer they are measured against; how firmware is built and emulated.

pub mod stream;
pub mod textbook;
pub mod toolchain;
