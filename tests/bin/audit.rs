//! `cargo run --release -p tests --bin audit`: see `--help`.

use std::io::{IsTerminal, Write};
use std::process::ExitCode;

use clap::Parser;
use tests::audit::command::{self, Options};

fn main() -> ExitCode {
    let options = Options::parse();
    let shows_progress = std::io::stderr().is_terminal();
    let mut progress = |what: &str| {
        if shows_progress {
            eprintln!("audit: {what}");
        }
    };
    match command::run(&options, &mut progress) {
        Ok((text, passed)) => {
            // A reader that has seen enough is no fault of the audits.
            let _ = std::io::stdout().write_all(text.as_bytes());
            if passed { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
