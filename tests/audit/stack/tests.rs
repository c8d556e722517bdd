use super::*;
use crate::audit::decode::{Decoder, ItState};

/// Functions at 0x1000, 0x2000, ... from hexadecimal bytes.
fn program(functions: &[&str]) -> Code {
    let mut code = Code::default();
    let decoder = Decoder::new().unwrap();
    for (index, hex) in functions.iter().enumerate() {
        let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
        let byte = |pair: &[u8]| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap();
        let bytes: Vec<u8> = digits.chunks(2).map(byte).collect();
        let start = 0x1000 * (index as u32 + 1);
        let (mut at, mut it) = (0, ItState::default());
        while at < bytes.len() {
            let instruction = decoder.decode(&bytes[at..], start + at as u32, &mut it).unwrap();
            at += instruction.size as usize;
            code.instructions.insert(instruction.address, instruction);
        }
        let name = format!("f{}", index + 1);
        let (linkage_name, end) = (name.clone(), start + bytes.len() as u32);
        code.functions.insert(start, CodeFunction { name, linkage_name, crate_name: String::new(), start, end });
    }
    code.never_return = control_flow::never_returning(&code);
    code
}

fn own_of(hex: &str) -> Result<u64, String> {
    own(&program(&[hex])).remove(&0x1000).unwrap()
}

#[test]
fn a_frame_is_what_is_pushed_and_subtracted() {
    // push {r4, r5, r7, lr}; sub sp, #16; add sp, #16; pop {r4, r5, r7, pc}
    assert_eq!(own_of("b0b5 84b0 04b0 b0bd"), Ok(32));
    // push {r4, lr}; vpush {d8, d9}; sub.w sp, sp, #512; add.w sp, sp, #512; vpop {d8, d9}; pop {r4, pc}
    assert_eq!(own_of("10b5 2ded048b adf5007d 0df5007d bdec048b 10bd"), Ok(8 + 16 + 512));
    // str lr, [sp, #-8]!; ldr pc, [sp], #8
    assert_eq!(own_of("4df808ed 5df808fb"), Ok(8));
    // bx lr
    assert_eq!(own_of("7047"), Ok(0));
}

#[test]
fn a_frame_larger_than_an_immediate_is_followed_through_its_register() {
    // movw r12, #6000; sub.w sp, sp, r12; add.w sp, sp, r12; bx lr
    assert_eq!(own_of("41f2707c adeb0c0d 0deb0c0d 7047"), Ok(6000));
}

#[test]
fn a_stack_that_is_aligned_anew_counts_what_that_may_cost_and_comes_back_by_its_frame_pointer() {
    // push {r4, r6, r7, lr}; add r7, sp, #8; sub sp, #24; mov r4, sp; bfc r4, #0, #4; mov sp, r4;
    // sub.w r4, r7, #8; mov sp, r4; pop {r4, r6, r7, pc}
    assert_eq!(own_of("d0b5 02af 86b0 6c46 6ff30304 a546 a7f10804 a546 d0bd"), Ok(16 + 24 + 15));
}

#[test]
fn a_return_on_a_condition_leaves_the_frame_for_the_other_path() {
    // push {r4, lr}; cmp r0, #0; it eq; popeq {r4, pc}; sub sp, #8; add sp, #8; pop {r4, pc}
    assert_eq!(own_of("10b5 0028 08bf 10bd 82b0 02b0 10bd"), Ok(16));
}

#[test]
fn what_cannot_be_followed_is_an_error() {
    for (hex, reason) in [
        // push {r4, lr}; bx lr
        ("10b5 7047", "not back where it was"),
        // sub.w sp, sp, r0; bx lr
        ("adeb000d 7047", "cannot be followed"),
        // msr msp, r0; bx lr
        ("80f30888 7047", "not back where it was"),
        // add sp, #8; bx lr
        ("02b0 7047", "rises above"),
        // cmp r0, #0; beq +2; push {r4}; bx lr
        ("0028 00d0 10b4 7047", "differs on paths that join"),
        // cmp r0, #0; it ne; subne.w sp, sp, #8; bx lr
        ("0028 18bf adf1080d 7047", "moves on a condition"),
    ] {
        let error = own_of(hex).unwrap_err();
        assert!(error.contains(reason), "{hex}: {error}");
    }
}

fn entered(code: &Code) -> Result<Vec<EntryStack>, String> {
    let calls = code.functions.values().map(|function| (function.start, control_flow::of_function(code, function).0));
    let entry = control_flow::Entry { name: "f1".to_owned(), start: 0x1000, interrupts: false };
    let graph = Graph { code, entries: vec![entry], calls: calls.collect(), unresolved: BTreeMap::new() };
    of_entries(&graph)
}

#[test]
fn a_call_adds_what_its_callee_needs_at_that_place_and_a_tail_call_at_its_own() {
    // push {r4, lr}; bl f2; sub sp, #64; add sp, #64; pop {r4, pc} and: push {r4-r7, lr}; pop {r4-r7, pc}
    let code = program(&["10b5 00f0fdff 90b0 10b0 10bd", "f0b5 f0bd"]);
    let stack = &entered(&code).unwrap()[0];
    // The call is made with 8 bytes held: 8 + 20 is less than 8 + 64.
    assert_eq!((stack.bytes, stack.chain.as_str()), (72, "f1(72)"));
    // push {r4, lr}; pop.w {r4, lr}; b.w f2
    let code = program(&["10b5 bde81040 00f0fbbf", "f0b5 f0bd"]);
    let stack = &entered(&code).unwrap()[0];
    assert_eq!((stack.bytes, stack.chain.as_str()), (20, "f1(0) > f2(20)"));
}

#[test]
fn a_handler_that_begins_a_fresh_stack_counts_from_there_and_must_not_return() {
    // push {r4, lr}; msr msp, r0; bl f2 and: push {r4-r7, lr}; b .
    let code = program(&["10b5 80f30888 00f0fbff", "f0b5 fee7"]);
    assert_eq!(entered(&code).unwrap()[0].bytes, 20);
    // nop; nop; nop; msr msp, r0 ...; b.w f2, which does not return, or does.
    let leaving = "80f30888 00bf 00f0fbbf";
    assert_eq!(entered(&program(&[leaving, "f0b5 fee7"])).unwrap()[0].bytes, 20);
    let error = entered(&program(&[leaving, "f0b5 f0bd"])).unwrap_err();
    assert!(error.contains("not back where it was"), "{error}");
}

#[test]
fn what_stands_behind_a_call_that_never_returns_is_not_followed() {
    // push {r4, lr}; bl f2; nop and: b .
    let code = program(&["10b5 00f0fdff 00bf", "fee7"]);
    assert_eq!(code.never_return, std::collections::BTreeSet::from([0x1000, 0x2000]));
    assert_eq!(entered(&code).unwrap()[0].bytes, 8);
}
