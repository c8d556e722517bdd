//! Audits of the linked firmware: what is in the image, what its code can do, and how long it takes.
//!
//! In the order the data flows: [`image`] reads the ELF file, [`decode`] one instruction, [`code`] all functions;
//! [`control_flow`] says where execution can go, [`stack`] how deep, [`forbidden`] what must not be there.
//! [`trace`] is what an emulated processor really executes, [`cycles`] how long that takes, [`taint`] the proof that it
//! depends on no sample.

pub mod image;
pub mod names;
pub mod decode;
pub mod code;
pub mod control_flow;
pub mod addresses;
pub mod stack;
pub mod forbidden;
pub mod memory;
pub mod report;
pub mod trace;
pub mod cycles;
pub mod taint;
pub mod inputs;
pub mod cycle_audit;
pub mod budgets;
pub mod images;
pub mod image_audit;
pub mod command;
mod print;
