//! Promise: no input, however mad, makes the core or the log reader panic, or say what is no number.
//!
//! Each target draws inputs for two seconds, new ones in every run; what it finds, it prints with the seed
//! that brings it back (`BOLERO_RANDOM_SEED`). Longer, here ten minutes a target:
//!
//! `BOLERO_RANDOM_TEST_TIME_MS=600000 cargo test --release -p tests --test fuzz -- --nocapture`

mod fuzz {
    mod eigen;
    mod filter;
    mod log;
    mod moments;
    mod number;
    mod step;

    /// How long each target runs. The machine's speed changes how many inputs are tried, not how long it takes.
    const TEST_TIME: std::time::Duration = std::time::Duration::from_secs(2);
}
