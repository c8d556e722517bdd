//! Audits of the linked firmware: what is in the image, and what its code can do.
//!
//! In the order the data flows: [`image`] reads the ELF file, [`decode`] one instruction, [`code`] all functions;
//! [`control_flow`] says where execution can go, [`stack`] how deep, [`forbidden`] what must not be there.

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
