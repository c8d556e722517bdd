//! Results that cannot be written: what is said names what was asked for, and nothing is left behind.

use std::fs;
use std::process::Command;

use crate::desk::{Desk, GUARD, SHORT};

/// As quick as a study gets.
const STUDY: &str = "study ramp --seeds 1";

/// The desk refuses the arguments with all the `words`, and says nothing of a file that nobody asked for.
fn refused(desk: &Desk, arguments: &str, words: &[&str]) {
    desk.refuses(arguments, words);
    let error = String::from_utf8(desk.run(arguments).get_output().stderr.clone()).unwrap();
    assert!(!error.contains(".tmp"), "{error}");
}

#[test]
fn a_directory_that_is_not_there_or_is_a_file_is_told_by_the_path_that_was_given() {
    let desk = Desk::with("short.toml", SHORT);
    refused(&desk, &format!("{STUDY} --page gone/p.html"), &["cannot write 'gone/p.html': No such file", "--page"]);
    refused(&desk, &format!("{STUDY} --out short.toml/r.json"), &["'short.toml/r.json': Not a directory", "--out"]);
    refused(&desk, &format!("{STUDY} --page ."), &["cannot write '.'", "directory", "--page"]);
    refused(&desk, "tune --runs 1 --page gone/p.html", &["cannot write 'gone/p.html': No such file", "--page"]);
    refused(&desk, "--scenario short.toml --out short.toml/o", &["directory 'short.toml/o': Not a directory", "--out"]);
    refused(&desk, "--save-models gone/m", &["cannot write 'gone/m': No such file", "--save-models"]);
}

#[cfg(unix)]
#[test]
fn a_directory_that_takes_no_files_is_told_by_the_path_that_was_given() {
    use std::os::unix::fs::PermissionsExt as _;
    let desk = Desk::new();
    fs::create_dir(desk.path("locked")).unwrap();
    fs::set_permissions(desk.path("locked"), fs::Permissions::from_mode(0o555)).unwrap();
    // Root may write everywhere, but not there.
    let locked = if fs::write(desk.path("locked/tried"), "").is_ok() { "/proc" } else { "locked" };
    refused(
        &desk,
        &format!("{STUDY} --page {locked}/p.html"),
        &[&format!("cannot write '{locked}/p.html': "), "--page"],
    );
    refused(&desk, &format!("--out {locked}"), &[&format!("cannot write to directory '{locked}': "), "--out"]);
}

#[cfg(target_os = "linux")]
#[test]
fn what_is_no_file_is_written_to_and_a_full_one_is_told() {
    let desk = Desk::new();
    refused(&desk, &format!("{STUDY} --page /dev/full"), &["cannot write '/dev/full': No space left", "--page"]);
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
    let program = assert_cmd::cargo::cargo_bin!("monitor-sim");
    let piped = format!("mkfifo pipe; {} {STUDY} --out pipe & cat pipe > got; wait $!", program.display());
    let done = Command::new("sh").args(["-c", &piped]).current_dir(desk.path(".")).status().unwrap();
    assert!(done.success() && desk.read("got").contains("\"study\": \"ramp\""));
}

/// The program where no file may grow beyond 16 KB: what a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn where_a_file_has_no_room_it_is_told_and_what_was_there_is_as_it_was() {
    let desk = Desk::with_sample();
    desk.write("monitor-out/replay.html", "an earlier page");
    let program = assert_cmd::cargo::cargo_bin!("monitor-sim");
    for (arguments, file) in [
        (format!("{STUDY} --page p.html"), "p.html"),
        (format!("replay log.csv {GUARD}"), "monitor-out/replay.csv"),
        (format!("replay log.csv {GUARD} --no-trace"), "monitor-out/replay.html"),
    ] {
        let before = desk.files();
        let limited = format!("trap '' XFSZ; ulimit -f 32; exec {} {arguments}", program.display());
        let output = Command::new("sh").args(["-c", &limited]).current_dir(desk.path(".")).output().unwrap();
        desk.refused(&arguments, &output, &[&format!("cannot write '{file}': File too large (os error 27);")], &before);
    }
}
