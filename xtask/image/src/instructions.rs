//! Thumb instructions, as far as they say where a function goes and what it keeps on the stack.
//!
//! Encodings: Arm v7-M Architecture Reference Manual, A7.7.

/// What a function refers to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct References {
    /// Where it jumps out of itself, calls included.
    pub(crate) jumps: Vec<u64>,
    /// Numbers that could be addresses: those loaded in two halves, and those that stand behind the code.
    pub(crate) numbers: Vec<u64>,
    /// Calls through a register.
    pub(crate) indirect: usize,
    /// Jumps through a register that are no return, and jumps to an address out of memory.
    pub(crate) onward: usize,
}

pub(crate) fn half(code: &[u8], at: usize) -> u16 {
    code.get(at..at + 2).map_or(0, |b| u16::from_le_bytes([b[0], b[1]]))
}

/// 11101, 11110 and 11111 begin an instruction of two halves.
pub(crate) const fn is_long(first: u16) -> bool {
    first >= 0xe800
}

/// Each instruction of a function: its offset and its halves, the second of a short one being zero.
fn instructions<'a>(
    code: &'a [u8],
    is_data: impl Fn(u64) -> bool + 'a,
) -> impl Iterator<Item = (usize, u16, u16)> + 'a {
    let mut at = 0;
    std::iter::from_fn(move || {
        while at + 2 <= code.len() && is_data(at as u64) {
            at += 2;
        }
        if at + 2 > code.len() {
            return None;
        }
        let (here, first) = (at, half(code, at));
        let second = if is_long(first) { half(code, at + 2) } else { 0 };
        at += if is_long(first) { 4 } else { 2 };
        Some((here, first, second))
    })
}

/// Single registers that VSTR and VLDR (Thumb encodings T1 and T2) move to and from the stack pointer's frame.
///
/// What is saved on entry goes by VPUSH, and is not counted; inputs and results have pointers of their own.
pub(crate) fn stack_traffic(code: &[u8], is_data: impl Fn(u64) -> bool) -> (usize, usize) {
    let (mut stores, mut loads) = (0, 0);
    for (_, first, second) in instructions(code, is_data) {
        // 1110 1101 UD0L 1101 | Vd 101z imm8: the stack pointer is register 13; z: two singles at once.
        let registers = match second & 0x0f00 {
            0x0a00 => 1,
            0x0b00 => 2,
            _ => continue,
        };
        match first & 0xff3f {
            0xed0d => stores += registers,
            0xed1d => loads += registers,
            _ => {}
        }
    }
    (stores, loads)
}

/// What a function takes off the stack pointer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Taken {
    /// The sum over its instructions, bytes.
    pub(crate) bytes: u64,
    /// Whether one of them gives the stack pointer what is in a register, or takes a register off it.
    pub(crate) unknown: bool,
}

/// What all instructions of a function together take off the stack pointer; what they give back is not counted against it.
pub(crate) fn stack_taken(code: &[u8], is_data: impl Fn(u64) -> bool) -> Taken {
    let mut all = Taken::default();
    for (_, first, second) in instructions(code, is_data) {
        let words = |count: u32| u64::from(count) * 4;
        let (low, wide) =
            (u64::from(second & 0xff), u64::from(first >> 10 & 1) << 11 | u64::from(second >> 12 & 7) << 8);
        let to_stack_pointer = second & 0x8f00 == 0x0d00;
        all.bytes += match first {
            // PUSH, T1: 1011 010M list.
            _ if first & 0xfe00 == 0xb400 => words((first & 0x01ff).count_ones()),
            // SUB of a constant, T1: 1011 0000 1 imm7.
            _ if first & 0xff80 == 0xb080 => words(u32::from(first & 0x7f)),
            // STMDB with its base written back: PUSH, T2.
            0xe92d => words(second.count_ones()),
            // VPUSH: 1110 1101 0D10 1101 | Vd 101z imm8.
            0xed2d | 0xed6d if second & 0x0e00 == 0x0a00 => words(u32::from(second & 0xff)),
            // STRD before its base, which is written back; STR so: PUSH, T3.
            0xe96d => low * 4,
            0xf84d if second & 0x0f00 == 0x0d00 => low,
            // SUB of a constant: T2, T3.
            0xf1ad | 0xf5ad if to_stack_pointer => expanded(wide | low),
            0xf2ad | 0xf6ad if to_stack_pointer => wide | low,
            _ => 0,
        };
        all.unknown |= match first {
            // SUB of a register; MOV from a register; MSR to one of the two stack pointers.
            0xebad => to_stack_pointer,
            _ if first & 0xff87 == 0x4685 => true,
            _ if first & 0xfff0 == 0xf380 => matches!(second, 0x8808 | 0x8809),
            _ => false,
        };
    }
    all
}

/// A constant of 12 bits as the core expands it (A5.3.2): a byte in one of four patterns, or eight bits with the first set, rotated.
fn expanded(bits: u64) -> u64 {
    let byte = bits & 0xff;
    match bits >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => u64::from((0x80 | (bits as u32 & 0x7f)).rotate_right((bits >> 7 & 0x1f) as u32)),
    }
}

/// What a function that begins at `start` refers to; `is_data` is asked with addresses.
pub(crate) fn references(code: &[u8], start: u64, is_data: impl Fn(u64) -> bool) -> References {
    let mut found = References::default();
    let end = start + code.len() as u64;
    // Lower halves that are waiting for their upper ones, by register.
    let mut lower = [None::<u16>; 16];
    for (at, first, second) in instructions(code, |offset| is_data(start + offset)) {
        let here = start + at as u64;
        if let Some(offset) = jump(first, second) {
            let goal = here.wrapping_add_signed(4 + offset);
            if !(start..end).contains(&goal) {
                found.jumps.push(goal);
            }
        }
        // BLX (register): 0100 0111 1mmm m000.
        if first & 0xff87 == 0x4780 {
            found.indirect += 1;
        }
        // BX: 0100 0111 0mmm m000, by any but the link register; LDR (literal) to the program counter.
        if (first & 0xff87 == 0x4700 && first != 0x4770) || (first & 0xff7f == 0xf85f && second & 0xf000 == 0xf000) {
            found.onward += 1;
        }
        // MOVW and MOVT: 1111 0i10 0100 imm4 | 0 imm3 Rd imm8; MOVT has 1100 for 0100.
        if matches!(first & 0xfbf0, 0xf240 | 0xf2c0) && second & 0x8000 == 0 {
            let value = (first & 0xf) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff;
            let register = usize::from(second >> 8 & 0xf);
            if first & 0xfbf0 == 0xf240 {
                lower[register] = Some(value);
            } else if let Some(low) = lower[register].take() {
                found.numbers.push(u64::from(value) << 16 | u64::from(low));
            }
        }
    }
    for at in (0..code.len()).step_by(4) {
        let here = start + at as u64;
        if here.is_multiple_of(4) && is_data(here) {
            found.numbers.push(u64::from(half(code, at)) | u64::from(half(code, at + 2)) << 16);
        }
    }
    found
}

/// How far a jump or call goes from the instruction after the next half: `B` in its four encodings and `BL`.
fn jump(first: u16, second: u16) -> Option<i64> {
    let field = |bits: u32, from: u16, at: u32| u64::from(from >> at) & ((1 << bits) - 1);
    let signed = |value: u64, bits: u32| (value << (64 - bits)) as i64 >> (64 - bits);
    if !is_long(first) {
        return match first & 0xf000 {
            // B, T1: 1101 cond imm8; 1110 and 1111 are no conditions.
            0xd000 if first & 0x0e00 != 0x0e00 => Some(signed(field(8, first, 0) << 1, 9)),
            // B, T2: 11100 imm11.
            0xe000 => Some(signed(field(11, first, 0) << 1, 12)),
            _ => None,
        };
    }
    if first & 0xf800 != 0xf000 || second & 0x8000 == 0 {
        return None;
    }
    let (s, j1, j2) = (field(1, first, 10), field(1, second, 13), field(1, second, 11));
    let low = field(11, second, 0) << 1;
    match second & 0xd000 {
        // B, T4, and BL: 11110 S imm10 | 1 x J1 1 J2 imm11; I = not (J xor S).
        0x9000 | 0xd000 => {
            let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
            Some(signed(s << 24 | i1 << 23 | i2 << 22 | field(10, first, 0) << 12 | low, 25))
        }
        // B, T3: 11110 S cond imm6 | 10 J1 0 J2 imm11.
        0x8000 if first & 0x0380 != 0x0380 => {
            Some(signed(s << 20 | j2 << 19 | j1 << 18 | field(6, first, 0) << 12 | low, 21))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{References, Taken, references, stack_taken, stack_traffic};

    fn bytes(code: &[u16]) -> Vec<u8> {
        code.iter().flat_map(|half| half.to_le_bytes()).collect()
    }

    /// As the assembler gives them.
    const CODE: [u16; 12] = [
        0xb510, // push {r4, lr}
        0xed8d, 0x0a01, // vstr s0, [sp, #4]
        0xeddd, 0x7a02, // vldr s15, [sp, #8]
        0xed9d, 0x1b04, // vldr d1, [sp, #16]
        0xed91, 0x0a01, // vldr s0, [r1, #4]
        0xbd10, // pop {r4, pc}
        0xeddd, 0x7a02, // a number that looks like an instruction
    ];

    #[test]
    fn loads_and_stores_of_the_frame_are_counted_and_nothing_else() {
        let code = bytes(&CODE);
        assert_eq!(stack_traffic(&code, |at| at >= 20), (1, 3));
        assert_eq!(stack_traffic(&code, |_| false), (1, 4));
    }

    fn jumps(code: &[u16]) -> Vec<u64> {
        references(&bytes(code), 0x0800_1000, |_| false).jumps
    }

    #[test]
    fn calls_and_jumps_out_of_a_function_are_found_in_every_encoding() {
        // bl to the instruction after it, at the end of the function; then one forward and one back.
        assert_eq!(jumps(&[0xf000, 0xf800]), [0x0800_1004]);
        assert_eq!(jumps(&[0xf001, 0xf8fe]), [0x0800_2200]);
        assert_eq!(jumps(&[0xf7ff, 0xfefe]), [0x0800_0e00]);
        // Farthest: 16 MiB back, and 16 MiB less two forward.
        assert_eq!(jumps(&[0xf400, 0xd000]), [0x0700_1004]);
        assert_eq!(jumps(&[0xf3ff, 0xd7ff]), [0x0900_1002]);
        // b.w back, b back, beq back, beq.w back.
        assert_eq!(jumps(&[0xf7ff, 0xbefe]), [0x0800_0e00]);
        assert_eq!(jumps(&[0xe6fe]), [0x0800_0e00]);
        assert_eq!(jumps(&[0xd080]), [0x0800_0f04]);
        assert_eq!(jumps(&[0xf43f, 0xaefe]), [0x0800_0e00]);
    }

    #[test]
    fn jumps_inside_and_what_only_looks_like_a_jump_are_not_taken_for_calls() {
        // b to itself; bl to itself; beq over one instruction.
        assert_eq!(jumps(&[0xe7fe]), []);
        assert_eq!(jumps(&[0xf7ff, 0xfffe]), []);
        assert_eq!(jumps(&[0xd000, 0xbf00, 0xbf00]), []);
        // svc 0 and udf 0; dmb sy; mrs r0, control; msr basepri, r0.
        assert_eq!(jumps(&[0xdf00, 0xde00, 0xf3bf, 0x8f5f, 0xf3ef, 0x8014, 0xf380, 0x8811]), []);
        // A number that looks like a call.
        let code = bytes(&[0x4770, 0xbf00, 0xf001, 0xf8fe]);
        assert_eq!(references(&code, 0x0800_1000, |at| at >= 0x0800_1004).jumps, []);
    }

    #[test]
    fn jumps_through_a_register_are_told_from_returns() {
        let onward = |code: &[u16]| references(&bytes(code), 0x0800_1000, |_| false).onward;
        // bx r12; ldr.w pc, [pc, #4]; bx lr and ldr.w r0, [pc, #4].
        assert_eq!([&[0x4760][..], &[0xf8df, 0xf004], &[0x4770, 0xf8df, 0x0004]].map(onward), [1, 1, 0]);
    }

    #[test]
    fn addresses_are_read_from_both_halves_and_from_the_numbers_behind_the_code() {
        let code = [
            0xf241, 0x2034, // movw r0, #0x1234
            0xf245, 0x6178, // movw r1, #0x5678
            0xf6c0, 0x0001, // movt r0, #0x0801
            0xf2c2, 0x0100, // movt r1, #0x2000
            0x4788, // blx r1
            0x4770, // bx lr
            0x4321, 0x0800,
        ];
        let found = references(&bytes(&code), 0x0800_1000, |at| at >= 0x0800_1014);
        let numbers = vec![0x0801_1234, 0x2000_5678, 0x0800_4321];
        assert_eq!(found, References { jumps: vec![], numbers, indirect: 1, onward: 0 });
    }

    #[test]
    fn what_is_taken_off_the_stack_pointer_is_added_up_in_every_encoding() {
        let taken = |code: &[u16]| stack_taken(&bytes(code), |_| false);
        for (code, expected) in [
            (&[0xb5f0][..], 20),                      // push {r4, r5, r6, r7, lr}
            (&[0xe92d, 0x4ff0], 36),                  // push.w {r4-r11, lr}
            (&[0xf84d, 0xbd04], 4),                   // str r11, [sp, #-4]!
            (&[0xe96d, 0x4504], 16),                  // strd r4, r5, [sp, #-16]!
            (&[0xed2d, 0x8b10], 64),                  // vpush {d8-d15}
            (&[0xed6d, 0x8a01], 4),                   // vpush {s17}
            (&[0xb0a4], 144),                         // sub sp, #144
            (&[0xf5ad, 0x7d12], 584),                 // sub.w sp, sp, #584
            (&[0xf1ad, 0x0d08], 8),                   // sub.w sp, sp, #8
            (&[0xf2ad, 0x4d04], 1028),                // subw sp, sp, #1028
            (&[0xb5f0, 0xb0a4, 0xb024, 0xbdf0], 164), // push, sub, add, pop
        ] {
            assert_eq!(taken(code), Taken { bytes: expected, unknown: false }, "{code:x?}");
        }
        // add sp, #144; pop; sub.w r4, sp, #8; str r0, [sp, #4]; ldr r11, [sp], #4.
        let nothing = [0xb024, 0xbdf0, 0xf1ad, 0x0408, 0x9001, 0xf85d, 0xbb04];
        assert_eq!(taken(&nothing), Taken::default());
        // sub.w sp, sp, r0; mov sp, r4; msr msp, r0.
        for code in [&[0xebad, 0x0d00][..], &[0x46a5], &[0xf380, 0x8808]] {
            assert_eq!(taken(code), Taken { bytes: 0, unknown: true }, "{code:x?}");
        }
    }
}
