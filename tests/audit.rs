//! Audits of the linked firmware: what is in the image, and what its code can do.
//!
//! In the order the data flows: [`image`] reads the ELF file, [`decode`] its instructions, [`code`] all its functions.

pub mod image;
pub mod names;
pub mod decode;
pub mod code;
