//! Promise: no input, however mad, makes the core or the log reader panic, or say what is no number.
//!
//! Each target draws inputs for two seconds, new ones in every run; what it finds, it prints with the seed
//! that brings it back (`BOLERO_RANDOM_SEED`). Longer, here ten minutes a target:
//!
//! `BOLERO_RANDOM_TEST_TIME_MS=600000 cargo test --release -p tests --test fuzz -- --nocapture`
//!
//! Guided by coverage (libFuzzer), one target at a time, after `cargo install cargo-bolero --locked`. The stable compiler is
//! enough. The first run builds the whole crate with its commands, some minutes; the address sanitizer must stay on,
//! because its run-time library has the counters that those commands are linked against:
//!
//! `cargo bolero test -p tests --rustc-bootstrap -T 10min fuzz::step::a_monitor_keeps_its_promises_whatever_it_is_fed`
//!
//! Inputs that reach new code, and what fails, are kept below `tests/fuzz/__fuzz__`, from where the tests above try them
//! again before they draw.

mod fuzz {
    mod eigen;
    mod filter;
    mod guard;
    mod log;
    mod moments;
    mod number;
    mod step;

    /// How long each target runs. The machine's speed changes how many inputs are tried, not how long it takes.
    const TEST_TIME: std::time::Duration = std::time::Duration::from_secs(2);
}
