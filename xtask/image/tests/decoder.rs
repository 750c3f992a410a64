//! Classes, registers and words of instructions that an assembler has encoded.

#![allow(clippy::unwrap_used, reason = "a test ends at the first thing that is not there")]

use chip_image::{Class, Instruction, Program, Registers};

const START: u32 = 0x0800_0000;

fn decode(halves: &[u16]) -> Instruction {
    Program::from_halves(START, halves).decode(START).unwrap()
}

/// Encodings of GNU as: halves, class, words moved.
const ENCODINGS: [(&str, &[u16], Class, u32); 68] = [
    ("movs r0, #1", &[0x2001], Class::Integer, 0),
    ("adds r0, r0, r1", &[0x1840], Class::Integer, 0),
    ("cmp r0, r8", &[0x4540], Class::Integer, 0),
    ("mov r8, r0", &[0x4680], Class::Integer, 0),
    ("muls r0, r1", &[0x4348], Class::Multiply, 0),
    ("bx lr", &[0x4770], Class::Branch, 0),
    ("blx r3", &[0x4798], Class::Branch, 0),
    ("ldr r5, [r4, #4]", &[0x6865], Class::Load, 1),
    ("str r5, [r4, r1]", &[0x5065], Class::Store, 1),
    ("ldr r0, [sp, #8]", &[0x9802], Class::Load, 1),
    ("push {r4, r5, r7, lr}", &[0xb5b0], Class::StoreMultiple, 4),
    ("pop {r4, r5, r7, pc}", &[0xbdb0], Class::LoadMultiple, 4),
    ("stmia r0!, {r1, r2}", &[0xc006], Class::StoreMultiple, 2),
    ("cbz r0, +8", &[0xb110], Class::Branch, 0),
    ("beq +8", &[0xd002], Class::Branch, 0),
    ("b +8", &[0xe002], Class::Branch, 0),
    ("it eq", &[0xbf08], Class::IfThen, 0),
    ("nop", &[0xbf00], Class::System, 0),
    ("uxtb r0, r1", &[0xb2c8], Class::Integer, 0),
    ("bkpt 0", &[0xbe00], Class::System, 0),
    ("ldr r0, [pc, #8]", &[0x4802], Class::Load, 1),
    ("movw r0, #4660", &[0xf241, 0x2034], Class::Integer, 0),
    ("movt r0, #16384", &[0xf2c4, 0x0000], Class::Integer, 0),
    ("add.w r8, r1, r2, lsl #2", &[0xeb01, 0x0882], Class::Integer, 0),
    ("cmp.w r0, #256", &[0xf5b0, 0x7f80], Class::Integer, 0),
    ("mla r0, r1, r2, r3", &[0xfb01, 0x3002], Class::Multiply, 0),
    ("umull r0, r1, r2, r3", &[0xfba2, 0x0103], Class::Multiply, 0),
    ("sdiv r0, r1, r2", &[0xfb91, 0xf0f2], Class::Divide, 0),
    ("ldr.w r8, [r1, #256]", &[0xf8d1, 0x8100], Class::Load, 1),
    ("ldr.w r8, [r1], #4", &[0xf851, 0x8b04], Class::Load, 1),
    ("str.w r8, [r1, r2, lsl #2]", &[0xf841, 0x8022], Class::Store, 1),
    ("ldrd r0, r1, [sp, #8]", &[0xe9dd, 0x0102], Class::LoadMultiple, 2),
    ("strd r0, r1, [sp, #-8]!", &[0xe96d, 0x0102], Class::StoreMultiple, 2),
    ("ldmia.w r0, {r1, r2, r8}", &[0xe890, 0x0106], Class::LoadMultiple, 3),
    ("stmdb sp!, {r4-r8, lr}", &[0xe92d, 0x41f0], Class::StoreMultiple, 6),
    ("ldr.w pc, [r0]", &[0xf8d0, 0xf000], Class::Load, 1),
    ("tbb [pc, r0]", &[0xe8df, 0xf000], Class::TableBranch, 1),
    ("bl +100", &[0xf000, 0xf830], Class::Branch, 0),
    ("b.w +5000", &[0xf001, 0xb9c2], Class::Branch, 0),
    ("bne.w +5000", &[0xf041, 0x81c2], Class::Branch, 0),
    ("dsb sy", &[0xf3bf, 0x8f4f], Class::Barrier, 0),
    ("mrs r0, PRIMASK", &[0xf3ef, 0x8010], Class::System, 0),
    ("vadd.f32 s0, s1, s2", &[0xee30, 0x0a81], Class::FloatArithmetic, 0),
    ("vmul.f32 s31, s1, s2", &[0xee60, 0xfa81], Class::FloatArithmetic, 0),
    ("vmla.f32 s0, s1, s2", &[0xee00, 0x0a81], Class::FloatMultiplyAdd, 0),
    ("vfma.f32 s0, s1, s2", &[0xeea0, 0x0a81], Class::FloatMultiplyAdd, 0),
    ("vnmls.f32 s0, s1, s2", &[0xee10, 0x0a81], Class::FloatMultiplyAdd, 0),
    ("vdiv.f32 s0, s1, s2", &[0xee80, 0x0a81], Class::FloatDivide, 0),
    ("vsqrt.f32 s0, s1", &[0xeeb1, 0x0ae0], Class::FloatSquareRoot, 0),
    ("vneg.f32 s0, s1", &[0xeeb1, 0x0a60], Class::FloatArithmetic, 0),
    ("vmov.f32 s0, s1", &[0xeeb0, 0x0a60], Class::FloatMove, 0),
    ("vmov.f32 s0, #1.0", &[0xeeb7, 0x0a00], Class::FloatMove, 0),
    ("vmov s0, r1", &[0xee00, 0x1a10], Class::FloatTransfer, 0),
    ("vmov r1, s0", &[0xee10, 0x1a10], Class::FloatTransfer, 0),
    ("vmov r0, r1, d1", &[0xec51, 0x0b11], Class::FloatTransferPair, 0),
    ("vcmp.f32 s0, s1", &[0xeeb4, 0x0a60], Class::FloatCompare, 0),
    ("vcmp.f32 s0, #0.0", &[0xeeb5, 0x0a40], Class::FloatCompare, 0),
    ("vmrs APSR_nzcv, fpscr", &[0xeef1, 0xfa10], Class::FloatStatus, 0),
    ("vcvt.s32.f32 s0, s1", &[0xeebd, 0x0ae0], Class::FloatConvert, 0),
    ("vcvt.f32.s32 s0, s0, #8", &[0xeeba, 0x0acc], Class::FloatConvert, 0),
    ("vldr s1, [r0, #4]", &[0xedd0, 0x0a01], Class::FloatLoad, 1),
    ("vstr s1, [sp, #8]", &[0xedcd, 0x0a02], Class::FloatStore, 1),
    ("vldr d1, [r0]", &[0xed90, 0x1b00], Class::FloatLoad, 2),
    ("vldr s0, [pc, #16]", &[0xed9f, 0x0a04], Class::FloatLoad, 1),
    ("vpush {d8-d11}", &[0xed2d, 0x8b08], Class::FloatStoreMultiple, 8),
    ("vpop {s16-s18}", &[0xecbd, 0x8a03], Class::FloatLoadMultiple, 3),
    ("vldmia r0!, {s0-s3}", &[0xecb0, 0x0a04], Class::FloatLoadMultiple, 4),
    ("vstmia r0, {s0-s3}", &[0xec80, 0x0a04], Class::FloatStoreMultiple, 4),
];

#[test]
fn classes_widths_and_words_are_those_of_the_assembler() {
    for (text, halves, class, words) in ENCODINGS {
        let found = decode(halves);
        assert_eq!((found.class, found.words), (class, words), "{text}");
        assert_eq!(found.width as usize, 2 * halves.len(), "{text}");
    }
}

#[test]
fn what_is_no_instruction_of_the_core_is_not_decoded() {
    // A permanently undefined instruction; VADD.F64, which the single-precision unit lacks; a vector sum; a first half without its second.
    for halves in [&[0xde00][..], &[0xee30, 0x0b01], &[0xef00, 0x0d00], &[0xee30]] {
        assert_eq!(Program::from_halves(START, halves).decode(START), None, "{halves:x?}");
    }
}

#[test]
fn registers_are_those_of_the_text() {
    let (core, float) = (Registers::core, Registers::float);
    let vmla = decode(&[0xee00, 0x0a81]);
    assert_eq!((vmla.reads, vmla.addend, vmla.writes), (float(1, 2), float(0, 1), float(0, 1)));
    let vmul = decode(&[0xee60, 0xfa81]);
    assert_eq!((vmul.reads, vmul.writes), (float(1, 2), float(31, 1)));
    let push = decode(&[0xb5b0]);
    assert_eq!((push.reads, push.address_registers), (Registers::core_list(0x40b0), core(13)));
    let pop = decode(&[0xecbd, 0x8a03]);
    assert_eq!(pop.writes, float(16, 3) | core(13));
    let post = decode(&[0xf851, 0x8b04]);
    assert_eq!((post.writes, post.address_registers), (core(8) | core(1), core(1)));
    let kept = decode(&[0xe890, 0x0106]);
    assert_eq!((kept.writes, kept.address_registers), (Registers::core_list(0x0106), core(0)));
    let double = decode(&[0xed90, 0x1b00]);
    assert_eq!(double.writes, float(2, 2));
    let compare = decode(&[0xf5b0, 0x7f80]);
    assert_eq!((compare.reads, compare.writes), (core(0), Registers::NONE));
    let high = decode(&[0xf2c4, 0x0000]);
    assert_eq!((high.reads, high.writes), (core(0), core(0)));
    let low = decode(&[0xf241, 0x2034]);
    assert_eq!((low.reads, low.writes), (Registers::NONE, core(0)));
    assert!(decode(&[0xf841, 0x8022]).register_offset && decode(&[0x5065]).register_offset);
    assert!(!decode(&[0x6865]).register_offset);
}

#[test]
fn data_addresses_are_those_of_the_manual() {
    // r0 is 0x100, r1 is 0x110, and so on; the program counter is the instruction's address.
    let mut registers: [u32; 16] = std::array::from_fn(|number| 0x100 + 0x10 * number as u32);
    registers[15] = START;
    for (text, halves, address) in [
        ("ldr r5, [r4, #4]", &[0x6865][..], 0x144),
        ("ldrb r5, [r4, #4]", &[0x7925], 0x144),
        ("ldrh r5, [r4, #4]", &[0x88a5], 0x144),
        ("ldr r5, [r4, r1]", &[0x5865], 0x140 + 0x110),
        ("ldr r0, [sp, #8]", &[0x9802], 0x1d8),
        ("pop {r4-r7}", &[0xbcf0], 0x1d0),
        ("push {r4-r7}", &[0xb4f0], 0x1c0),
        ("ldmia r1!, {r2, r3}", &[0xc90c], 0x110),
        ("ldr.w r8, [r1, #256]", &[0xf8d1, 0x8100], 0x210),
        ("ldr.w r8, [r1], #4", &[0xf851, 0x8b04], 0x110),
        ("ldr.w r8, [r1, #4]!", &[0xf851, 0x8f04], 0x114),
        ("ldr.w r8, [r1, #-4]", &[0xf851, 0x8c04], 0x10c),
        ("ldr.w r8, [r1, r2, lsl #2]", &[0xf851, 0x8022], 0x110 + 4 * 0x120),
        ("ldrd r0, r1, [sp, #8]", &[0xe9dd, 0x0102], 0x1d8),
        ("strd r0, r1, [sp, #-8]!", &[0xe96d, 0x0102], 0x1c8),
        ("ldmdb r4, {r0, r1}", &[0xe914, 0x0003], 0x138),
        ("ldrex r0, [r1, #4]", &[0xe851, 0x0f01], 0x114),
        ("tbh [pc, r1, lsl #1]", &[0xe8df, 0xf011], START + 4 + 2 * 0x110),
        ("vldr s1, [r0, #4]", &[0xedd0, 0x0a01], 0x104),
        ("vldr s1, [r0, #-4]", &[0xed50, 0x0a01], 0xfc),
        ("vldmia r0!, {s0-s3}", &[0xecb0, 0x0a04], 0x100),
        ("vpush {d8-d11}", &[0xed2d, 0x8b08], 0x1b0),
        ("vldr s0, [pc, #16]", &[0xed9f, 0x0a04], START + 4 + 16),
    ] {
        assert_eq!(decode(halves).data_address(&registers), Some(address), "{text}");
    }
    assert_eq!(decode(&[0x1840]).data_address(&registers), None);
}

#[test]
fn literals_have_their_address_and_branches_without_condition_do_not_fall_through() {
    // Relative to the program counter, 4 ahead, rounded down to a word.
    let program = Program::from_halves(START, &[0xbf00, 0x4802, 0xed9f, 0x0a04]);
    assert_eq!(program.decode(START + 2).unwrap().literal, Some(START + 4 + 8));
    assert_eq!(program.decode(START + 4).unwrap().literal, Some(START + 8 + 16));
    // Relative to 4 ahead: forward; and 4 backward, to itself.
    assert_eq!(decode(&[0xf000, 0xf830]).jumps_to(), Some(START + 4 + 0x60));
    assert_eq!(decode(&[0xf7ff, 0xfffe]).jumps_to(), Some(START));
    // cbz r0, +8; beq +8; b.w +5000; bne.w +5000; bx lr
    let goals = [&[0xb110][..], &[0xd002], &[0xf001, 0xb9c2], &[0xf041, 0x81c2], &[0x4770]];
    assert_eq!(
        goals.map(|halves| decode(halves).jumps_to().map(|goal| goal - START)),
        [Some(8), Some(8), Some(5000), Some(5000), None]
    );
    for (halves, through) in [
        (&[0xe002][..], false),
        (&[0xd002], true),
        (&[0xb110], true),
        (&[0xbdb0], false),
        (&[0xf8d0, 0xf000], false),
        (&[0x6865], true),
    ] {
        assert_eq!(decode(halves).may_fall_through, through, "{halves:x?}");
    }
}
