#![doc = include_str!("../NUMERICS.md")]
