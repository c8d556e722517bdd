//! Promises across crates, one file each, and the peer they are measured against.

pub mod textbook;
