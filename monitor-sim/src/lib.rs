//! Simulated thruster motor, recorded-log replay and reports around [`monitor_core`].
pub mod noise;
pub mod motor;
