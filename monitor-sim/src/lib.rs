//! Simulated thruster motor, recorded-log replay and reports around [`monitor_core`].

// The plant.
pub mod noise;
pub mod motor;
pub mod exponential;
pub mod controller;
pub mod fault;
pub mod scenario;
pub mod plant;
pub mod random_motor;
// Recorded logs.
pub mod log;
pub mod inject;
pub mod window;
// What is kept of a run, and what is made of it.
pub mod intervals;
pub mod envelope;
pub mod record;
pub mod trace;
pub mod score;
pub mod paper;
pub mod tables;
pub mod chart;
pub mod page;
// The commands.
pub mod names;
pub mod settings;
pub mod stored;
pub mod output;
pub mod guardian;
pub mod mission;
pub mod replay;
pub mod tune;
pub mod study;
pub mod bench;
pub mod mission_page;
pub mod replay_page;
