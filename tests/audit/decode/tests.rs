use super::*;

/// Decodes a run of instructions given as hexadecimal bytes.
fn decoded(hex: &str) -> Vec<Instruction> {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    let bytes: Vec<u8> =
        digits.chunks(2).map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap()).collect();
    let decoder = Decoder::new().unwrap();
    let (mut at, mut it, mut found) = (0, ItState::default(), Vec::new());
    while at < bytes.len() {
        let instruction = decoder.decode(&bytes[at..], 0x1000 + at as u32, &mut it).unwrap();
        at += instruction.size as usize;
        found.push(instruction);
    }
    found
}

/// An instruction on one line: text, condition, reads, writes, memory, flow.
fn line(i: &Instruction) -> String {
    let mut text = format!("{i}: {:?} -> {:?}", i.reads, i.writes);
    if let Some(m) = &i.memory {
        let registers: Vec<String> = m.registers.iter().map(|register| register.to_string()).collect();
        let index = m.index.map_or(String::new(), |index| format!("+{index}<<{}", m.shift));
        let way = if m.load { "load" } else { "store" };
        text += &format!(
            " | {way} {}{index}{:+} of {}, base {:+}: {}",
            m.base,
            m.offset,
            m.size,
            m.writeback,
            registers.join(" ")
        );
    }
    if !i.keeps.is_empty() {
        text += &format!(" | may keep {:?}", i.keeps);
    }
    if let Some(condition) = i.condition {
        text += &format!(" | if {}", condition.name());
    }
    if i.flow != Flow::Next {
        text += &format!(" | {:?}", i.flow);
    }
    text
}

/// Encodings of `arm-none-eabi-as`, each with what the architecture manual says of it. The first stands at 0x1000.
const KNOWN: &[(&str, &str)] = &[
    ("0530", "adds r0, #5: {r0} -> {r0 N Z C V}"),
    ("4044", "add r0, r8: {r0 r8} -> {r0}"),
    ("b0eb810f", "cmp.w r0, r1, lsl #2: {r0 r1} -> {N Z C V}"),
    ("0420", "movs r0, #4: {} -> {r0 N Z C} | may keep {C}"),
    ("4ff48050", "mov.w r0, #0x1000: {} -> {r0}"),
    ("c0f20500", "movt r0, #5: {r0} -> {r0}"),
    ("8840", "lsls r0, r1: {r0 r1} -> {r0 N Z C} | may keep {C}"),
    ("4843", "muls r0, r1, r0: {r0 r1} -> {r0 N Z}"),
    ("c2fb0301", "smlal r0, r1, r2, r3: {r0 r1 r2 r3} -> {r0 r1}"),
    ("61f3c600", "bfi r0, r1, #3, #4: {r0 r1} -> {r0}"),
    ("b1fbf2f0", "udiv r0, r1, r2: {r1 r2} -> {r0}"),
    ("51f8040d", "ldr r0, [r1, #-0x4]!: {r1} -> {r0 r1} | load r1-4 of 4, base -4: r0"),
    ("51f80409", "ldr r0, [r1], #-4: {r1} -> {r0 r1} | load r1+0 of 4, base -4: r0"),
    ("51f82200", "ldr.w r0, [r1, r2, lsl #2]: {r1 r2} -> {r0} | load r1+r2<<2+0 of 4, base +0: r0"),
    ("0248", "ldr r0, [pc, #8]: {pc} -> {r0} | load pc+8 of 4, base +0: r0"),
    ("b1f90200", "ldrsh.w r0, [r1, #2]: {r1} -> {r0} | load r1+2 of 2, base +0: r0"),
    ("f2e80201", "ldrd r0, r1, [r2], #8: {r2} -> {r0 r1 r2} | load r2+0 of 8, base +8: r0 r1"),
    ("6de90201", "strd r0, r1, [sp, #-0x8]!: {r0 r1 sp} -> {sp} | store sp-8 of 8, base -8: r0 r1"),
    ("21f8020b", "strh r0, [r1], #2: {r0 r1} -> {r1} | store r1+0 of 2, base +2: r0"),
    ("5df804fb", "ldr pc, [sp], #4: {sp} -> {sp pc} | load sp+0 of 4, base +4: pc | Return"),
    ("30b5", "push {r4, r5, lr}: {r4 r5 sp lr} -> {sp} | store sp-12 of 12, base -12: r4 r5 lr"),
    ("30bd", "pop {r4, r5, pc}: {sp} -> {r4 r5 sp pc} | load sp+0 of 12, base +12: r4 r5 pc | Return"),
    ("06c8", "ldm r0!, {r1, r2}: {r0} -> {r0 r1 r2} | load r0+0 of 8, base +8: r1 r2"),
    ("10e90600", "ldmdb r0, {r1, r2}: {r0} -> {r1 r2} | load r0-8 of 8, base +0: r1 r2"),
    ("11ed020b", "vldr d0, [r1, #-8]: {r1} -> {s0 s1} | load r1-8 of 8, base +0: s0 s1"),
    ("81ed000a", "vstr s0, [r1]: {r1 s0} -> {} | store r1+0 of 4, base +0: s0"),
    ("b0ec040a", "vldmia r0!, {s0, s1, s2, s3}: {r0} -> {r0 s0 s1 s2 s3} | load r0+0 of 16, base +16: s0 s1 s2 s3"),
    ("90ec040b", "vldmia r0, {d0, d1}: {r0} -> {s0 s1 s2 s3} | load r0+0 of 16, base +0: s0 s1 s2 s3"),
    ("2ded048b", "vpush {d8, d9}: {sp s16 s17 s18 s19} -> {sp} | store sp-16 of 16, base -16: s16 s17 s18 s19"),
    ("bdec028b", "vpop {d8}: {sp} -> {sp s16 s17} | load sp+0 of 8, base +8: s16 s17"),
    ("30ee810a", "vadd.f32 s0, s1, s2: {s1 s2} -> {s0}"),
    ("00ee810a", "vmla.f32 s0, s1, s2: {s0 s1 s2} -> {s0}"),
    ("b1eee00a", "vsqrt.f32 s0, s1: {s1} -> {s0}"),
    ("b5ee400a", "vcmp.f32 s0, #0: {s0} -> {fpscr.nzcv}"),
    ("f1ee10fa", "vmrs apsr_nzcv, fpscr: {fpscr.nzcv} -> {N Z C V}"),
    ("f1ee100a", "vmrs r0, fpscr: {fpscr.nzcv fpscr} -> {r0}"),
    ("e1ee100a", "vmsr fpscr, r0: {r0} -> {fpscr.nzcv fpscr}"),
    ("00ee101a", "vmov s0, r1: {r1} -> {s0}"),
    ("51ec100b", "vmov r0, r1, d0: {s0 s1} -> {r0 r1}"),
    ("b7ee000a", "vmov.f32 s0, #1.000000e+00: {} -> {s0}"),
    ("02e0", "b #0x1008: {} -> {pc} | Jump(4104)"),
    ("02d0", "beq #0x1008: {} -> {pc} | if eq | Branch(4104)"),
    ("00f0f281", "beq.w #0x13e8: {} -> {pc} | if eq | Branch(5096)"),
    ("10b1", "cbz r0, #0x1008: {r0} -> {pc} | Branch(4104)"),
    ("00f030f8", "bl #0x1064: {} -> {lr pc} | Call(4196)"),
    ("9847", "blx r3: {r3} -> {lr pc} | IndirectCall"),
    ("7047", "bx lr: {lr} -> {pc} | Return"),
    ("1847", "bx r3: {r3} -> {pc} | IndirectJump"),
    ("dfe800f0", "tbb [pc, r0]: {r0 pc} -> {pc} | load pc+r0<<0+0 of 1, base +0:  | Table { entry: 1 }"),
    ("dfe810f0", "tbh [pc, r0, lsl #1]: {r0 pc} -> {pc} | load pc+r0<<1+0 of 2, base +0:  | Table { entry: 2 }"),
    ("00de", "udf #0: {} -> {pc} | Stop"),
    ("eff30080", "mrs r0, apsr: {N Z C V Q GE} -> {r0}"),
    ("80f30888", "msr msp, r0: {r0} -> {sp}"),
    ("41e80020", "strex r0, r2, [r1]: {r1 r2} -> {r0} | store r1+0 of 4, base +0: r2"),
    ("41eb0200", "adc.w r0, r1, r2: {r1 r2 C} -> {r0}"),
    ("8841", "sbcs r0, r1: {r0 r1 C} -> {r0 N Z C V}"),
    ("01f30400", "ssat r0, #5, r1: {r1} -> {r0 Q} | may keep {Q}"),
    ("a1fa82f0", "sel r0, r1, r2: {r1 r2 GE} -> {r0}"),
    ("0842", "tst r0, r1: {r0 r1} -> {N Z C} | may keep {C}"),
    ("f746", "mov pc, lr: {lr} -> {pc} | Return"),
    ("9f46", "mov pc, r3: {r3} -> {pc} | IndirectJump"),
    ("51f822f0", "ldr.w pc, [r1, r2, lsl #2]: {r1 r2} -> {pc} | load r1+r2<<2+0 of 4, base +0: pc | IndirectJump"),
    ("90f800f0", "pld [r0]: {} -> {}"),
    ("bd44", "add sp, r7: {r7 sp} -> {sp}"),
    ("81fa42f0", "uadd8 r0, r1, r2: {r1 r2} -> {r0 GE}"),
    ("11fb0230", "smlabb r0, r1, r2, r3: {r1 r2 r3} -> {r0 Q} | may keep {Q}"),
];

#[test]
fn an_instruction_reads_and_writes_what_the_manual_says() {
    for (hex, expected) in KNOWN {
        assert_eq!(line(&decoded(hex)[0]).trim_end(), *expected, "{hex}");
    }
}

#[test]
fn a_block_gives_its_instructions_their_conditions_and_takes_their_flags() {
    let block: Vec<String> = decoded("1abf 0130 b0ee600a 0120 0120").iter().map(line).collect();
    assert_eq!(block[0], "itte ne: {} -> {}");
    assert_eq!(block[1], "addne r0, #1: {r0} -> {r0} | if ne");
    assert_eq!(block[2], "vmovne.f32 s0, s1: {s1} -> {s0} | if ne");
    assert_eq!(block[3], "moveq r0, #1: {} -> {r0} | if eq");
    assert_eq!(block[4], "movs r0, #1: {} -> {r0 N Z C} | may keep {C}");
    let returns = decoded("b8bf 7047 48bf 10bd");
    assert!(returns[1].flow == Flow::Return && returns[1].falls_through(), "{}", returns[1]);
    assert!(returns[3].flow == Flow::Return && returns[3].falls_through(), "{}", returns[3]);
}

#[test]
fn a_constant_is_found_where_the_processor_finds_it() {
    assert_eq!(decoded("0248")[0].literal(), Some(0x1000 + 4 + 8));
    // Behind two bytes the program counter is rounded down.
    assert_eq!(decoded("00bf 0248")[1].literal(), Some(0x1004 + 8));
}

#[test]
fn bytes_that_are_no_instruction_are_refused() {
    let decoder = Decoder::new().unwrap();
    for bytes in [&[0xff, 0xff, 0xff, 0xff][..], &[0x00], &[0x00, 0xf0]] {
        assert!(decoder.decode(bytes, 0, &mut ItState::default()).is_err(), "{bytes:02x?}");
    }
}
