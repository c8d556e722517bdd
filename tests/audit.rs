//! Audits of the linked firmware: what is in the image, what its code can do, and how long it takes.
//!
//! In the order the data flows: [`image`] reads the ELF file ([`names`] its symbols' names), [`decode`] one instruction,
//! [`code`] all functions; [`control_flow`] says where execution can go and [`addresses`] who holds whose address; [`stack`]
//! how deep it gets ([`witness`]: and how deep it got), [`forbidden`] what must not be there, [`memory`] where the bytes
//! go. [`trace`] is what an emulated processor executes when it is asked [`inputs`], [`cycles`] how long that takes,
//! [`taint`] the proof that it depends on no sample; [`cycle_audit`] does all three. Each makes a [`report`], whose
//! figures the [`budgets`] limit. [`image_audit`] does all of it for one image, [`command`] for all [`images`].

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
pub mod witness;
pub mod images;
pub mod image_audit;
pub mod command;
mod print;
