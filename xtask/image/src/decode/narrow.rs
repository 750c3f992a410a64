//! Instructions of one half (16 bits).

use super::instruction::goal;
use super::registers::{LR, PC, SP};
use super::{Class, Effect, Instruction, Registers};

pub(super) fn decode(address: u32, half: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 2, class);
    // Three bits at position `at`: one of the lower eight registers.
    let low = |at: u32| Registers::core((half >> at) & 7);
    let top = Registers::core((half >> 8) & 7);
    let sp = Registers::core(SP);
    Some(match half >> 11 {
        // LSL, LSR, ASR by a constant.
        0b00000..=0b00010 => new(Class::Integer).reading(low(3)).writing(low(0)),
        // ADD, SUB of a register or a three-bit constant.
        0b00011 => {
            let sum = new(Class::Integer).reading(low(3)).writing(low(0));
            if half & 0x0400 == 0 { sum.reading(low(6)) } else { sum }
        }
        0b00100 => new(Class::Integer).writing(top),
        0b00101 => new(Class::Integer).reading(top),
        0b00110 | 0b00111 => new(Class::Integer).reading(top).writing(top),
        0b01000 if half & 0x0400 == 0 => {
            let (d, m) = (low(0), low(3));
            match (half >> 6) & 15 {
                // TST, CMP, CMN.
                8 | 10 | 11 => new(Class::Integer).reading(d | m),
                // RSB, MVN.
                9 | 15 => new(Class::Integer).reading(m).writing(d),
                13 => new(Class::Multiply).reading(d | m).writing(d),
                _ => new(Class::Integer).reading(d | m).writing(d),
            }
        }
        0b01000 => {
            let number = (half & 7) | ((half >> 4) & 8);
            let (d, m) = (Registers::core(number), Registers::core((half >> 3) & 15));
            match (half >> 8) & 3 {
                0 => new(Class::Integer).reading(d | m).writing(d),
                1 => new(Class::Integer).reading(d | m),
                2 => new(Class::Integer).reading(m).writing(d),
                // BX, BLX.
                _ => {
                    let link = if half & 0x80 == 0 { Registers::NONE } else { Registers::core(LR) };
                    new(Class::Branch).reading(m).writing(link).never_falls_through()
                }
            }
        }
        0b01001 => new(Class::Load).moving(1).writing(top).of_literal(i64::from(half & 0xff) * 4),
        // Loads and stores at the sum of two registers: three kinds of store, then five of load.
        0b01010 | 0b01011 => {
            let at = low(3) | low(6);
            let with = if (half >> 9) & 7 < 3 {
                Instruction { register_offset: true, ..new(Class::Store).moving(1).reading(low(0)).addressed_by(at) }
            } else {
                new(Class::Load).moving(1).writing(low(0)).addressed_by(at)
            };
            with.at((half >> 3) & 7, 0).plus((half >> 6) & 7, 0)
        }
        // At a constant number of words, bytes or halves from a register. Stores have even numbers, loads odd ones.
        0b01100..=0b10001 => {
            let bytes = match half >> 12 {
                6 => 4,
                7 => 1,
                _ => 2,
            };
            let new =
                if half & 0x0800 == 0 { new(Class::Store).reading(low(0)) } else { new(Class::Load).writing(low(0)) };
            new.moving(1).addressed_by(low(3)).at((half >> 3) & 7, i64::from((half >> 6) & 31) * bytes)
        }
        0b10010 | 0b10011 => {
            let new = if half & 0x0800 == 0 { new(Class::Store).reading(top) } else { new(Class::Load).writing(top) };
            new.moving(1).addressed_by(sp).at(SP, i64::from(half & 0xff) * 4)
        }
        // ADR, ADD of the stack pointer.
        0b10100 => new(Class::Integer).writing(top),
        0b10101 => new(Class::Integer).reading(sp).writing(top),
        0b10110 | 0b10111 => return miscellaneous(address, half),
        0b11000 => multiple(new(Class::StoreMultiple), (half >> 8) & 7, half & 0xff, false),
        0b11001 => multiple(new(Class::LoadMultiple), (half >> 8) & 7, half & 0xff, true),
        0b11010 | 0b11011 => match (half >> 8) & 15 {
            14 => return None,
            15 => new(Class::System),
            _ => new(Class::Branch).with(goal(address, u32::from(half & 0xff) << 1, 9)),
        },
        0b11100 => new(Class::Branch).never_falls_through().with(goal(address, u32::from(half & 0x7ff) << 1, 12)),
        _ => return None,
    })
}

/// 1011: miscellaneous instructions.
fn miscellaneous(address: u32, half: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 2, class);
    let low = |at: u32| Registers::core((half >> at) & 7);
    let sp = Registers::core(SP);
    Some(match (half >> 8) & 15 {
        // ADD and SUB of a constant number of words.
        0x0 if half & 0x80 == 0 => new(Class::Integer).reading(sp).writing(sp),
        0x0 => new(Class::Integer).reading(sp).writing(sp).with(Effect::Push(4 * u32::from(half & 0x7f))),
        // CBZ, CBNZ, which only jump forward.
        0x1 | 0x3 | 0x9 | 0xb => {
            let offset = u32::from(half >> 9 & 1) << 6 | u32::from(half >> 3 & 0x1f) << 1;
            new(Class::Branch).reading(low(0)).with(goal(address, offset, 8))
        }
        // Extensions, reversals.
        0x2 | 0xa => new(Class::Integer).reading(low(3)).writing(low(0)),
        0x4 | 0x5 => {
            let link = if half & 0x100 == 0 { 0 } else { 1 << LR };
            let push = multiple(new(Class::StoreMultiple), SP, (half & 0xff) | link, false);
            push.at(SP, -4 * i64::from(push.words)).with(Effect::Push(4 * push.words))
        }
        0xc | 0xd => {
            let counter = if half & 0x100 == 0 { 0 } else { 1 << PC };
            multiple(new(Class::LoadMultiple), SP, (half & 0xff) | counter, true)
        }
        0x6 if half & 0xffef == 0xb662 => new(Class::System).with(Effect::Mask(half & 0x10 != 0)),
        0x6 | 0xe => new(Class::System),
        0xf if half & 15 == 0 => new(Class::System),
        0xf => new(Class::IfThen),
        _ => return None,
    })
}

/// Load or store of a list of core registers from their base upwards, which updates the base.
pub(super) fn multiple(with: Instruction, base: u16, list: u16, loads: bool) -> Instruction {
    let (registers, number) = (Registers::core_list(list), base);
    let base = Registers::core(number);
    let with = with.moving(list.count_ones()).addressed_by(base).writing(base).at(number, 0);
    if loads { with.writing(registers) } else { with.reading(registers) }
}
