//! `cargo run --release -p tests --bin figures`: see `--help`.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use tests::figures::command::{self, Options};

fn main() -> ExitCode {
    match command::run(&Options::parse(), &mut |what| eprintln!("{what}")) {
        Ok((text, holds)) => {
            // A reader that has seen enough is no fault of the figures.
            let _ = std::io::stdout().write_all(text.as_bytes());
            if holds { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
