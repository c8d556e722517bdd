//! `watch` in a terminal: util-linux's `script` is one, and `stty` tells how it was left.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::desk::{Desk, GUARD, SAMPLE};

/// Watches in a terminal of 80x24, with keys pressed from the beginning on; returns what was shown and, behind it, the state
/// of the terminal and the exit code.
fn watched(desk: &Desk, arguments: &str, keys: &str) -> (String, String) {
    let program = assert_cmd::cargo::cargo_bin!("monitor-sim").display();
    let line = format!(
        "stty rows 24 cols 80; timeout --foreground 60 '{program}' watch {arguments}; echo behind: code=$?; stty -a"
    );
    let mut command = Command::new("script");
    command.args(["--quiet", "--command", &line, "/dev/null"]).current_dir(desk.path("."));
    let mut script = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = script.stdin.take().unwrap();
    stdin.write_all(keys.as_bytes()).unwrap();
    // The end of its input would end the terminal, and the run with it.
    let done = script.wait_with_output().unwrap();
    drop(stdin);
    let text = String::from_utf8_lossy(&done.stdout).into_owned();
    let (shown, behind) = text.split_once("behind: ").unwrap_or_else(|| panic!("{text}"));
    (shown.to_owned(), behind.to_owned())
}

fn assert_restored(shown: &str, behind: &str) {
    let (entered, left) = (shown.rfind("\x1b[?1049h"), shown.rfind("\x1b[?1049l"));
    assert!(entered.is_some() && entered < left, "{shown:?}");
    assert!(shown.rfind("\x1b[?25l") < shown.rfind("\x1b[?25h"), "the cursor: {shown:?}");
    for setting in ["icanon", "echo", "isig", "opost"] {
        assert!(behind.split_whitespace().any(|word| word == setting), "{setting}: {behind}");
    }
}

#[test]
fn the_terminal_is_as_it_was_after_the_viewer_has_left() {
    let (shown, behind) = watched(&Desk::with_short(), "--scenario short.toml --pace max", " +q");
    assert!(shown.contains("\x1b[1;1Hshort,") && behind.starts_with("code=0"), "{shown}\n{behind}");
    assert_restored(&shown, &behind);
}

#[test]
fn the_terminal_is_as_it_was_after_an_error_which_is_told_behind_the_picture() {
    let desk = Desk::with("broken.csv", &(SAMPLE.to_owned() + "noon,300,299,abc,9\n60.02,300,299,2,9\n"));
    let (shown, behind) = watched(&desk, &format!("broken.csv {GUARD} --pace max"), "");
    assert!(behind.starts_with("code=2"), "{shown}\n{behind}");
    assert_restored(&shown, &behind);
    let error = shown.rsplit("\x1b[?1049l").next().unwrap_or_default();
    assert!(error.contains("error: row 3000") && error.contains("`abc`"), "{error}");
}
