//! `paper` mode: the method of the paper, as it was published.
//!
#![doc = include_str!("../PAPER.md")]

pub mod baseline;
pub mod localize;
mod detector;
pub mod verdict;
pub mod monitor;
pub mod event;

pub use baseline::Baseline;
pub use event::EventLog;
pub use localize::{Diagnosis, Fault};
pub use monitor::{Config, Monitor};
pub use verdict::{Phase, Verdict};
