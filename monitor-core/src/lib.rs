#![doc = include_str!("../README.md")]
#![no_std]
// Refusals are written as `!(0.0 < x)`: unlike `x <= 0.0`, that refuses NaN too.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
#![cfg_attr(
    test,
    allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::float_cmp, clippy::expect_used, clippy::panic)
)]

// What both modes are made of, in the order in which the data flows.
pub mod units;
pub mod sample;
pub mod range;
pub mod set_point;
pub mod moments;
mod root;
mod triangle;
pub mod eigen;
pub mod pca;
pub mod hotelling;
pub mod smoother;
pub mod low_pass;
pub mod moving_average;
pub mod ewma;
pub mod quantile;
pub mod limit;
pub mod relay;
pub mod numerics;

// The two modes.
pub mod paper;
pub mod guard;

pub use guard::{Config, Monitor, Verdict};
pub use range::{Range, Ranges};
pub use sample::Sample;
