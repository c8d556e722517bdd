//! Audits of the linked firmware: what is in the image, and what its code can do.
//!
//! In the order the data flows: [`image`] reads the ELF file ([`names`] its symbols' names), [`decode`] one instruction,
//! [`code`] all functions; [`control_flow`] says where execution can go and [`addresses`] who holds whose address; [`stack`]
//! how deep it gets ([`witness`]: and how deep it got), [`forbidden`] what must not be there, [`memory`] where the bytes
//! go. Each makes a [`report`], whose figures the [`budgets`] limit. [`image_audit`] does all of it for one image,
//! [`command`] for all [`images`].

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
pub mod budgets;
pub mod witness;
pub mod images;
pub mod image_audit;
pub mod command;
mod print;
