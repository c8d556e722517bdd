//! The figures of the README that take long to find: found by the commands that a user types, recorded, held by tests.
//!
//! In the order the data flows: [`list`] names the commands, [`fly`] runs them, [`record`] is what is kept of each in
//! `tests/figures/NAME.json`; [`anew`] flies some of a record's units again, so that a change of the monitor or the plant
//! that moves them is seen. [`claims`] says where the README states what, [`passage`] finds such a place and mends its
//! numbers. [`command`] does all of it.

pub mod list;
pub mod record;
pub mod fly;
pub mod anew;
pub mod passage;
pub mod claims;
pub mod command;
