//! Simulated thruster motor, recorded-log replay and reports around [`monitor_core`].
pub mod controller;
pub mod fault;
pub mod motor;
pub mod noise;
pub mod plant;
pub mod scenario;
