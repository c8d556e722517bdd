//! Promises across crates, one file each; the peer they are measured against; how firmware is built, emulated and
//! audited.

pub mod audit;
pub mod figures;
pub mod stream;
pub mod textbook;
pub mod toolchain;
