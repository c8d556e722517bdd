//! wiring
#![no_std]
