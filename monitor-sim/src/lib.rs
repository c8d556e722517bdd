//! Simulated thruster motor, recorded-log replay and reports around [`monitor_core`].

pub mod inject;
pub mod log;
pub mod window;
