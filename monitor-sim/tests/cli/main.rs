//! The command line, driven as its users drive it: a process in a directory of its own.

mod bad_logs;
mod bad_options;
mod bad_outputs;
mod bench;
mod browser;
mod desk;
#[cfg(feature = "parquet")]
mod fleet;
mod guard_mission;
mod guard_replay;
mod mission;
mod models;
mod readme;
mod replay;
mod study;
#[cfg(target_os = "linux")]
mod terminal;
mod tune;
mod watch;
mod writings;
