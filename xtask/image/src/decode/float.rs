//! Instructions of the float unit, FPv4-SP.

use super::instruction::offset;
use super::registers::PC;
use super::{Class, Effect, Instruction, Registers};

pub(super) fn decode(address: u32, first: u16, second: u16) -> Option<Instruction> {
    // Coprocessors 10 and 11: singles and doubles. 0xef: the vector unit, which this core lacks.
    if second & 0x0e00 != 0x0a00 || first & 0xff00 == 0xef00 {
        return None;
    }
    match first & 0xff00 {
        0xee00 if second & 0x10 != 0 => Some(transfer(address, first, second)),
        0xee00 => operation(address, first, second),
        _ if first & 0xffe0 == 0xec40 => Some(pair(address, first, second)),
        _ => memory(address, first, second),
    }
}

/// A register given by four bits and a fifth: a single, or both halves of a double.
fn register(four: u16, fifth: u16, second: u16) -> Registers {
    let (four, fifth) = (four & 15, fifth & 1);
    if is_double(second) {
        Registers::float(2 * (four | fifth << 4), 2)
    } else {
        Registers::float(four << 1 | fifth, 1)
    }
}

fn is_double(second: u16) -> bool {
    second & 0x0100 != 0
}

/// Destination.
fn d(first: u16, second: u16) -> Registers {
    register(second >> 12, first >> 6, second)
}

/// First operand.
fn n(first: u16, second: u16) -> Registers {
    register(first, second >> 7, second)
}

/// Second operand.
fn m(second: u16) -> Registers {
    register(second, second >> 5, second)
}

fn operation(address: u32, first: u16, second: u16) -> Option<Instruction> {
    if is_double(second) {
        return None;
    }
    let new = |class| Instruction::new(address, 4, class);
    let (d, n, m) = (d(first, second), n(first, second), m(second));
    Some(match (first >> 4) & 0b1011 {
        0b0000 | 0b0001 | 0b1001 | 0b1010 => {
            Instruction { addend: d, ..new(Class::FloatMultiplyAdd).reading(n | m).writing(d) }
        }
        0b0010 | 0b0011 => new(Class::FloatArithmetic).reading(n | m).writing(d),
        0b1000 => new(Class::FloatDivide).reading(n | m).writing(d),
        _ if (first >> 4) & 0b1011 != 0b1011 => return None,
        // VMOV of a constant.
        _ if second & 0x40 == 0 => new(Class::FloatMove).writing(d),
        _ => match (first & 15, second & 0x80 != 0) {
            (0, false) => new(Class::FloatMove).reading(m).writing(d),
            (0, true) | (1, false) => new(Class::FloatArithmetic).reading(m).writing(d),
            (1, true) => new(Class::FloatSquareRoot).reading(m).writing(d),
            (4, _) => new(Class::FloatCompare).reading(d | m),
            (5, _) => new(Class::FloatCompare).reading(d),
            (2 | 3 | 8 | 12 | 13, _) => new(Class::FloatConvert).reading(m).writing(d),
            // To and from fixed point, in place.
            (10 | 11 | 14 | 15, _) => new(Class::FloatConvert).reading(d).writing(d),
            _ => return None,
        },
    })
}

/// Transfer of one register between the core and the unit, or of the unit's status.
fn transfer(address: u32, first: u16, second: u16) -> Instruction {
    let (core, to_core) = (Registers::core(second >> 12), first & 0x10 != 0);
    if first & 0xe0 == 0xe0 {
        let status = Instruction::new(address, 4, Class::FloatStatus);
        // Register 15 means the flags.
        return match (to_core, second >> 12 == PC) {
            (true, true) => status,
            (true, false) => status.writing(core),
            (false, _) => status.reading(core),
        };
    }
    moved(address, Class::FloatTransfer, to_core, core, n(first, second))
}

/// Transfer of two registers between the core and the unit.
fn pair(address: u32, first: u16, second: u16) -> Instruction {
    let core = Registers::core(second >> 12) | Registers::core(first);
    let from = (second & 15) << 1 | ((second >> 5) & 1);
    let float = if is_double(second) { m(second) } else { Registers::float(from, 2) };
    moved(address, Class::FloatTransferPair, first & 0x10 != 0, core, float)
}

fn moved(address: u32, class: Class, to_core: bool, core: Registers, float: Registers) -> Instruction {
    let (from, to) = if to_core { (float, core) } else { (core, float) };
    Instruction::new(address, 4, class).reading(from).writing(to)
}

/// Loads and stores.
fn memory(address: u32, first: u16, second: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 4, class);
    let (loads, base) = (first & 0x10 != 0, Registers::core(first));
    let (before, up, back) = (first & 0x100 != 0, first & 0x80 != 0, first & 0x20 != 0);
    let words = if before && !back { 1 + u32::from(is_double(second)) } else { u32::from(second & 0xff) };
    let one = d(first, second);
    let start = one.numbers().next().map_or(0, |number| number as u16 - 16);
    let float = Registers::float(start, words as u16);
    let with = match (before && !back, loads) {
        (true, true) => new(Class::FloatLoad).writing(float),
        (true, false) => new(Class::FloatStore).reading(float),
        // The only valid combinations are increment after and decrement before.
        (false, _) if before == up => return None,
        (false, true) => new(Class::FloatLoadMultiple).writing(float),
        (false, false) => new(Class::FloatStoreMultiple).reading(float),
    };
    let with = if back { with.writing(base) } else { with }.moving(words);
    // VPUSH.
    let with = if first & 0xffbf == 0xed2d { with.with(Effect::Push(4 * words)) } else { with };
    let is_literal = loads && before && !back && base == Registers::core(PC);
    let distance = offset(first, second & 0xff, 4);
    // Several registers: from the base upwards, or ending below it.
    let from = if before { distance } else { 0 };
    Some(if is_literal { with.of_literal(distance) } else { with.addressed_by(base).at(first, from) })
}
