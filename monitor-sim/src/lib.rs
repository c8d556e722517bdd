//! Simulated thruster motor, recorded-log replay and reports around [`monitor_core`].

// In the order the data flows; the blank lines keep rustfmt from sorting them.
pub mod noise;

pub mod motor;

pub mod controller;

pub mod fault;

pub mod scenario;

pub mod plant;
