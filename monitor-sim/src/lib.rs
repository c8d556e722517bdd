//! Simulated thruster motor, recorded-log replay and reports around [`monitor_core`].

// The plant, in the order the data flows.
pub mod noise;
pub mod motor;
pub mod controller;
pub mod fault;
pub mod scenario;
pub mod plant;
// Recorded logs.
pub mod log;
pub mod inject;
pub mod window;
