//! Promise: the audits find what must not be there, say where it is, and hold every figure to its budget.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tests::audit::control_flow::Graph;
use tests::audit::forbidden::{self, Check, Finding};
use tests::audit::image_audit::Audited;
use tests::audit::memory::{self, Usage};
use tests::audit::stack;
use tests::toolchain::Firmware;

/// The promise for the stack of a step, bytes.
const STEP_STACK: u64 = 256;

/// The image with everything that must not be, built once.
fn spoiled() -> &'static Audited {
    static SPOILED: OnceLock<Audited> = OnceLock::new();
    SPOILED.get_or_init(|| {
        let elf = Firmware::audited("spoiled").build().unwrap_or_else(|error| panic!("{error}"));
        Audited::read("spoiled", &elf).unwrap()
    })
}

/// What one function of it reaches.
fn findings(entry: &str) -> Vec<Finding> {
    let graph = Graph::new(&spoiled().image, &spoiled().code).unwrap().entered_by(&[entry]).unwrap();
    forbidden::findings(&spoiled().image, &graph, false)
}

fn stack_of(entry: &str) -> Result<u64, String> {
    let graph = Graph::new(&spoiled().image, &spoiled().code).unwrap().entered_by(&[entry]).unwrap();
    Ok(stack::of_entries(&graph)?[0].bytes)
}

fn audit(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_audit")).args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat()
}

#[test]
fn a_step_by_itself_reaches_nothing_that_is_forbidden_and_keeps_its_stack() {
    assert_eq!(findings("sound"), []);
    assert!(stack_of("sound").unwrap() <= STEP_STACK);
}

#[test]
fn what_spoils_a_step_is_found_by_its_check_with_the_chain_that_leads_there() {
    for (entry, check, symbol) in [
        ("spoiled_by_panic", Check::Panic, "core::panicking::panic_bounds_check"),
        ("spoiled_by_soft_double", Check::SoftDouble, "__aeabi_dmul"),
        ("spoiled_by_recursion", Check::Recursion, "again"),
        ("spoiled_by_formatting", Check::Formatting, "core::fmt::"),
        ("spoiled_by_heap", Check::Heap, "GlobalAlloc"),
        ("spoiled_by_indirect_call", Check::IndirectCall, "spoiled_by_indirect_call"),
    ] {
        let found = findings(entry);
        let hits: Vec<&Finding> = found.iter().filter(|finding| finding.check == check).collect();
        let named = hits.iter().find(|finding| finding.sentence().contains(symbol));
        let named = named.unwrap_or_else(|| panic!("{entry}: {symbol} is not among {hits:#?}"));
        assert_eq!(named.chain.first().map(String::as_str), Some(entry), "{}", named.sentence());
        assert_eq!(named.chain.last(), Some(&named.symbol));
    }
}

#[test]
fn a_check_finds_nothing_in_what_another_one_is_for() {
    for (entry, checks) in [
        ("spoiled_by_soft_double", &[Check::SoftDouble][..]),
        ("spoiled_by_stack", &[]),
        ("spoiled_by_recursion", &[Check::Recursion]),
        ("spoiled_by_indirect_call", &[Check::IndirectCall]),
    ] {
        let found = findings(entry);
        assert!(found.iter().all(|finding| checks.contains(&finding.check)), "{entry}: {found:#?}");
    }
}

#[test]
fn what_nothing_calls_is_found_by_who_holds_its_address() {
    let found = findings("spoiled_by_formatting");
    let held = found.iter().find(|finding| finding.symbol == "<u64 as core::fmt::Display>::fmt");
    let held = held.unwrap_or_else(|| panic!("{found:#?}"));
    assert!(held.held && held.sentence().contains("not called, but its address is held"), "{}", held.sentence());
    assert_eq!(held.chain, ["spoiled_by_formatting", &held.symbol]);
    // What it holds leads to text formatting, and not to the rest of the image.
    let kinds = [Check::Formatting, Check::IndirectCall];
    assert!(found.iter().all(|finding| kinds.contains(&finding.check)), "{found:#?}");
}

#[test]
fn a_kilobyte_more_on_the_stack_shows_to_the_byte_and_breaks_the_promise() {
    let (sound, spoiled) = (stack_of("sound").unwrap(), stack_of("spoiled_by_stack").unwrap());
    assert!(spoiled >= sound + 1024, "{spoiled} bytes, {sound} without the kilobyte");
    // The spoiled function has a frame of its own beside the kilobyte: registers, and the verdict it passes on.
    assert!(spoiled <= sound + 1024 + 128, "{spoiled} bytes, {sound} without the kilobyte");
    assert!(spoiled > STEP_STACK);
}

#[test]
fn a_stack_that_cannot_be_bounded_is_an_error_that_says_why() {
    let recursion = stack_of("spoiled_by_recursion").unwrap_err();
    assert!(recursion.contains("recursion, ") && recursion.contains("again > spoiled_by_recursion"), "{recursion}");
    let indirect = stack_of("spoiled_by_indirect_call").unwrap_err();
    assert!(indirect.contains("indirect call `blx"), "{indirect}");
}

#[test]
fn an_indirect_call_is_bounded_once_somebody_says_what_it_calls() {
    let (image, code) = (&spoiled().image, &spoiled().code);
    let mut graph = Graph::new(image, code).unwrap().entered_by(&["spoiled_by_indirect_call"]).unwrap();
    let at = |name: &str| code.function(name).unwrap().start;
    assert_eq!(graph.resolve(at("spoiled_by_indirect_call"), &[at("sound")]), 1);
    let bytes = stack::of_entries(&graph).unwrap()[0].bytes;
    assert!(bytes > stack_of("sound").unwrap() && bytes <= stack_of("sound").unwrap() + 128, "{bytes}");
    assert!(!forbidden::findings(image, &graph, false).iter().any(|finding| finding.check == Check::IndirectCall));
}

#[test]
fn every_byte_of_an_image_has_one_row_and_the_rows_add_up() {
    let usage = Usage::of(&spoiled().image).unwrap();
    assert_eq!(memory::total(&usage.flash), spoiled().image.loaded_bytes());
    // By another way: the bytes that a debugger would load from the file.
    let path = &spoiled().image.path;
    let file = std::fs::read(path).unwrap();
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    let (table, entry_size) = (word(28) as usize, 32);
    let count = usize::from(u16::from_le_bytes(file[44..46].try_into().unwrap()));
    let segments = (0..count).map(|index| table + index * entry_size).filter(|at| word(*at) == 1 && word(at + 16) > 0);
    let spans: Vec<(u32, u32)> = segments.map(|at| (word(at + 12), word(at + 12) + word(at + 16))).collect();
    let (start, end) = (spans.iter().map(|s| s.0).min().unwrap(), spans.iter().map(|s| s.1).max().unwrap());
    assert_eq!(memory::total(&usage.flash), u64::from(end - start));
    let of_core = |symbol: &str| usage.flash.iter().find(|piece| piece.symbol.contains(symbol)).unwrap();
    assert_eq!(of_core("compiler_builtins::float::mul::__muldf3").crate_name, "compiler_builtins");
}

#[test]
fn all_images_keep_their_budgets_and_hold_nothing_forbidden() {
    let output = audit(&[]);
    assert!(output.status.success(), "{}", said(&output));
}

#[test]
fn any_image_can_be_audited_and_what_is_forbidden_in_it_makes_the_command_fail() {
    let elf = spoiled().image.path.to_str().unwrap();
    let whole = audit(&["--elf", elf]);
    assert_eq!(whole.status.code(), Some(1));
    for sentence in
        ["heap: alloc::alloc::handle_alloc_error", "recursion: ", "soft-double: __aeabi_dmul", "do not pass"]
    {
        assert!(said(&whole).contains(sentence), "{sentence} is missing:\n{}", said(&whole));
    }
    let sound = audit(&["--elf", elf, "--entry", "sound"]);
    assert_eq!(sound.status.code(), Some(0), "{}", said(&sound));
    let json = audit(&["--elf", elf, "--entry", "spoiled_by_panic", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((json.status.code(), &document["passed"]), (Some(1), &serde_json::Value::Bool(false)));
    let faults = document["reports"].as_array().unwrap().iter().flat_map(|report| report["faults"].as_array().unwrap());
    assert!(faults.into_iter().any(|fault| fault.as_str().unwrap().contains("panic_bounds_check")));
}

#[test]
fn what_is_no_image_of_a_board_is_refused_with_a_sentence_and_exit_code_two() {
    let desk = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| -> PathBuf {
        let path = desk.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let image = std::fs::read(&spoiled().image.path).unwrap();
    let absent = desk.path().join("absent");
    let files: [(&Path, &str); 5] = [
        (&absent, "cannot be read"),
        (&write("text", b"not an image"), "is not a 32-bit ELF file; give the ELF file that the linker wrote"),
        (Path::new(env!("CARGO_BIN_EXE_audit")), "is not a 32-bit ELF file"),
        (&write("cut", &image[..image.len() / 2]), "is not a 32-bit ELF file"),
        (&write("other", &[&image[..18], &[243, 0], &image[20..]].concat()), "is not for an Arm processor"),
    ];
    for (file, sentence) in files {
        let refused = audit(&["--elf", file.to_str().unwrap()]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(said(&refused).starts_with("error: ") && said(&refused).contains(sentence), "{}", said(&refused));
    }
    let elf = spoiled().image.path.to_str().unwrap();
    let unknown = audit(&["--elf", elf, "--entry", "nobody"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(said(&unknown).contains("the image has no function `nobody`"), "{}", said(&unknown));
}
