//! The model against published timings, and against sequences counted by hand.

use super::super::decode::{Decoder, ItState};
use super::*;

/// Decodes `arm-none-eabi-as` output and runs over it once, or `times`.
fn run(hex: &str, times: usize) -> Cost {
    let bytes: Vec<u8> =
        hex.split_whitespace().flat_map(|half| u16::from_str_radix(half, 16).unwrap().to_le_bytes()).collect();
    let decoder = Decoder::new().unwrap();
    let mut code = Code::default();
    let (mut at, mut it, mut path) = (0, ItState::default(), Vec::new());
    while (at as usize) < bytes.len() {
        let decoded = decoder.decode(&bytes[at as usize..], at, &mut it).unwrap();
        path.push(at);
        at = decoded.end();
        code.instructions.insert(decoded.address, decoded);
    }
    // Behind the last instruction stands another one, so that it is not taken for a branch.
    path.push(at);
    code.instructions.insert(at, decoder.decode(&[0x00, 0xbf], at, &mut it).unwrap());
    let one: Vec<u32> = path[..path.len() - 1].repeat(times);
    let all: Vec<u32> = one.into_iter().chain([at]).collect();
    // Without the last one and its branch away.
    let mut cost = cost(&code, &all).unwrap();
    (cost.instructions, cost.best, cost.nominal, cost.worst) =
        (cost.instructions - 1, cost.best - 2, cost.nominal - 3, cost.worst - 4);
    cost
}

fn cycles(hex: &str) -> (u64, u64, u64) {
    let Cost { best, nominal, worst, .. } = run(hex, 1);
    (best, nominal, worst)
}

#[test]
fn chained_arithmetic_takes_what_was_measured_on_an_stm32f407() {
    // Published for a chain in which each result is used at once: multiply 2.00, add 2.00, divide 15.00 cycles.
    const N: usize = 1000;
    for (hex, per_operation) in [("ee20 0a20", 2.0), ("ee30 0a20", 2.0), ("ee80 0a20", 15.0)] {
        // `N` copies one behind the other: a branch back would add its own cycles.
        let chain = format!("{hex} ").repeat(N);
        let cost = run(&chain, 1);
        for cycles in [cost.best, cost.nominal, cost.worst] {
            let measured = cycles as f64 / N as f64;
            assert!((measured - per_operation).abs() < 0.02, "{hex}: {measured}");
        }
    }
}

#[test]
fn sequences_take_what_the_manual_says() {
    for (hex, expected, what) in [
        ("ee00 0a81", (3, 3, 3), "vmla s0, s1, s2"),
        ("ee20 0a81 ee31 1a82", (2, 2, 2), "vmul s0; vadd s2 of others"),
        ("6808", (1, 2, 2), "ldr"),
        ("6808 681a", (2, 3, 4), "two loads overlap"),
        ("6808 6802", (2, 4, 4), "a load from a loaded address does not overlap"),
        ("4408 6802", (2, 4, 4), "an address made by the instruction before"),
        ("6008", (1, 1, 2), "str goes into the write buffer"),
        ("b530", (4, 4, 4), "push of three"),
        ("ecb0 0a04", (5, 5, 5), "vldmia of four"),
        ("ed90 0b00", (2, 3, 3), "vldr of a double"),
        ("e9d2 0100", (3, 3, 3), "ldrd"),
        ("bf08 eeb0 0a60", (1, 2, 2), "it; vmoveq"),
        ("fbb1 f0f2", (2, 12, 12), "udiv"),
        ("fb01 3002", (2, 2, 2), "mla"),
        ("ee10 0a10", (1, 1, 2), "vmov r0, s0"),
        ("ec51 0a11", (2, 2, 2), "vmov r0, r1, s2, s3"),
        ("eeb4 0a60 eef1 fa10", (2, 3, 3), "vcmp; vmrs at once"),
        ("d002", (1, 1, 1), "a branch that is not taken"),
        ("ee80 0a20 4408 4408", (3, 16, 16), "integers run beside a divide, at best"),
        ("ee80 0a20 4408 4408 ee31 1a82", (15, 17, 17), "which the next floating-point instruction waits for"),
    ] {
        assert_eq!(cycles(hex), expected, "{what}");
    }
}

#[test]
fn a_taken_branch_refills_the_pipeline_in_one_to_three_cycles() {
    // `bx lr` once more after itself: the first is taken.
    let Cost { best, nominal, worst, instructions } = run("4770", 2);
    assert_eq!((instructions, best, nominal, worst), (2, 3, 4, 5));
}

#[test]
fn a_path_through_nowhere_is_refused() {
    let code = Code::default();
    assert!(cost(&code, &[0x1234]).unwrap_err().contains("0x00001234"));
}
