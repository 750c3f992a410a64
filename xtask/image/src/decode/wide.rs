//! Instructions of two halves (32 bits).

use super::instruction::{goal, offset};
use super::registers::{LR, PC, SP};
use super::{Class, Effect, Instruction, Registers, float, narrow};

pub(super) fn decode(address: u32, first: u16, second: u16) -> Option<Instruction> {
    match first >> 9 {
        // 1110100
        0b111_0100 if first & 0x0040 == 0 => list(address, first, second),
        0b111_0100 => pair_or_exclusive(address, first, second),
        0b111_0101 => Some(shifted(address, first, second)),
        0b111_0110 | 0b111_0111 => float::decode(address, first, second),
        0b111_1000..=0b111_1011 if second & 0x8000 == 0 => Some(immediate(address, first, second)),
        0b111_1000..=0b111_1011 => branch_or_control(address, first, second),
        0b111_1100 => single(address, first, second),
        0b111_1101 => register(address, first, second),
        _ => None,
    }
}

/// Four bits of a half at position `at`: a register.
fn field(half: u16, at: u32) -> Registers {
    Registers::core((half >> at) & 15)
}

/// LDM, STM.
fn list(address: u32, first: u16, second: u16) -> Option<Instruction> {
    // Increment after, or decrement before.
    if !matches!((first >> 7) & 3, 1 | 2) {
        return None;
    }
    let loads = first & 0x10 != 0;
    let class = if loads { Class::LoadMultiple } else { Class::StoreMultiple };
    let mut all = narrow::multiple(Instruction::new(address, 4, class), first & 15, second, loads);
    if first & 0x0100 != 0 {
        all = all.at(first, -4 * i64::from(all.words));
    }
    if first & 0x20 == 0 {
        // The base register is not changed.
        let base = if loads { field(first, 0).without(Registers::core_list(second)) } else { field(first, 0) };
        all.writes = all.writes.without(base);
    }
    // STMDB with update of the stack pointer: PUSH.
    Some(if first == 0xe92d { all.with(Effect::Push(4 * all.words)) } else { all })
}

/// LDRD, STRD, the exclusive loads and stores, and table branches.
fn pair_or_exclusive(address: u32, first: u16, second: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 4, class);
    let (base, one, two) = (field(first, 0), field(second, 12), field(second, 8));
    let loads = first & 0x10 != 0;
    if first & 0x0120 == 0 {
        let exclusive = if loads {
            new(Class::Load).writing(one)
        } else {
            // STREX writes its success to a register: the fourth field, or the last one in its byte and half forms.
            let status = if first & 0x0080 == 0 { two } else { field(second, 0) };
            new(Class::Store).reading(one).writing(status)
        };
        let is_table = first & 0xfff0 == 0xe8d0 && second & 0xffe0 == 0xf000;
        return Some(if is_table {
            let table = new(Class::TableBranch).moving(1).addressed_by(base | field(second, 0));
            table.at(first, 0).plus(second, second >> 4 & 1).never_falls_through()
        } else {
            // Only the word form has an offset.
            let words = if first & 0x0080 == 0 { second & 0xff } else { 0 };
            exclusive.moving(1).addressed_by(base).at(first, 4 * i64::from(words))
        });
    }
    let moved = if first & 0x20 == 0 { Registers::NONE } else { base };
    let pair = if loads {
        new(Class::LoadMultiple).writing(one | two | moved)
    } else {
        new(Class::StoreMultiple).reading(one | two).writing(moved)
    };
    // Pre-indexed downwards with writeback on the stack pointer.
    let pair = if first == 0xe96d { pair.with(Effect::Push(4 * u32::from(second & 0xff))) } else { pair };
    Some(if base == Registers::core(PC) && loads {
        pair.moving(2).of_literal(offset(first, second & 0xff, 4))
    } else {
        // Post-indexed: the access is at the base itself.
        let from = if first & 0x0100 == 0 { 0 } else { offset(first, second & 0xff, 4) };
        pair.moving(2).addressed_by(base).at(first, from)
    })
}

/// Data processing with a shifted register.
fn shifted(address: u32, first: u16, second: u16) -> Instruction {
    processed(address, first, second).reading(field(second, 0))
}

/// Data processing without its second operand.
fn processed(address: u32, first: u16, second: u16) -> Instruction {
    let new = Instruction::new(address, 4, Class::Integer);
    let (operation, n, d) = ((first >> 5) & 15, field(first, 0), field(second, 8));
    let (no_source, no_result) = (n == Registers::core(PC), d == Registers::core(PC));
    // MOV and MVN are ORR and ORN without a first operand. TST, TEQ, CMN and CMP are AND, EOR, ADD and SUB without a destination.
    let new = if no_source && matches!(operation, 2 | 3) { new } else { new.reading(n) };
    if no_result && first & 0x10 != 0 && matches!(operation, 0 | 4 | 8 | 13) { new } else { new.writing(d) }
}

/// Data processing with a constant.
fn immediate(address: u32, first: u16, second: u16) -> Instruction {
    let new = Instruction::new(address, 4, Class::Integer);
    let (n, d) = (field(first, 0), field(second, 8));
    let constant = (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff;
    let from_stack = n == Registers::core(SP) && d == n;
    if first & 0x0200 == 0 {
        let with = processed(address, first, second);
        let is_push = from_stack && first & 0x01f0 == 0x01a0;
        return if is_push { with.with(Effect::Push(expanded(constant))) } else { with };
    }
    // MOVW and MOVT use a register field for part of their constant.
    let half = (first & 15) << 12 | constant;
    match (first >> 4) & 0x1f {
        0b00100 => new.writing(d).with(Effect::LowerHalf(half)),
        0b01100 => new.reading(d).writing(d).with(Effect::UpperHalf(half)),
        0b01010 if from_stack => new.reading(n).writing(d).with(Effect::Push(constant.into())),
        // BFI keeps the rest of its register; BFC is BFI of zero.
        0b10110 if n == Registers::core(PC) => new.reading(d).writing(d),
        0b10110 => new.reading(n | d).writing(d),
        // ADR.
        0b00000 | 0b01010 if n == Registers::core(PC) => new.writing(d),
        _ => new.reading(n).writing(d),
    }
}

/// Branches, barriers, hints and special registers.
fn branch_or_control(address: u32, first: u16, second: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 4, class);
    Some(match second & 0x5000 {
        0x1000 => new(Class::Branch).never_falls_through().with(far(address, first, second)),
        0x5000 => {
            let call = new(Class::Branch).writing(Registers::core(LR)).never_falls_through();
            call.with(far(address, first, second))
        }
        0x0000 if (first >> 7) & 7 != 7 => new(Class::Branch).with(near(address, first, second)),
        0x0000 => match (first >> 4) & 0x7f {
            // MSR; hints; CLREX, DSB, DMB, ISB; MRS.
            0b011_1000 | 0b011_1001 => {
                new(Class::System).reading(field(first, 0)).with(Effect::ToSpecial(second & 0xff))
            }
            0b011_1010 => new(Class::System),
            0b011_1011 if matches!((second >> 4) & 15, 4..=6) => new(Class::Barrier),
            0b011_1011 => new(Class::System),
            0b011_1110 | 0b011_1111 => new(Class::System).writing(field(second, 8)),
            _ => return None,
        },
        _ => return None,
    })
}

/// Target of B and BL. The offset's sign and its next two bits are stored separately; these two are inverted if the sign is 0.
fn far(address: u32, first: u16, second: u16) -> Effect {
    let bit = |half: u16, at: u32| u32::from(half >> at & 1);
    let sign = bit(first, 10);
    let (one, two) = (1 ^ bit(second, 13) ^ sign, 1 ^ bit(second, 11) ^ sign);
    let low = u32::from(first & 0x3ff) << 12 | u32::from(second & 0x7ff) << 1;
    goal(address, low | two << 22 | one << 23 | sign << 24, 25)
}

/// Target of a conditional B.
fn near(address: u32, first: u16, second: u16) -> Effect {
    let bit = |half: u16, at: u32| u32::from(half >> at & 1);
    let low = u32::from(first & 0x3f) << 12 | u32::from(second & 0x7ff) << 1;
    goal(address, low | bit(second, 13) << 18 | bit(second, 11) << 19 | bit(first, 10) << 20, 21)
}

/// Expands a 12-bit constant as the core does (A5.3.2): a byte in one of four patterns, or eight bits with the first one set, rotated.
fn expanded(bits: u16) -> u32 {
    let byte = u32::from(bits & 0xff);
    match bits >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | u32::from(bits & 0x7f)).rotate_right(u32::from(bits >> 7 & 0x1f)),
    }
}

/// Loads and stores of one register.
fn single(address: u32, first: u16, second: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 4, class).moving(1);
    let (base, moved) = (field(first, 0), field(second, 12));
    let (loads, signed, size) = (first & 0x10 != 0, first & 0x100 != 0, (first >> 5) & 3);
    if size == 3 || (signed && !loads) {
        return None;
    }
    if loads && size != 2 && moved == Registers::core(PC) {
        // PLD, PLI are hints.
        return Some(Instruction::new(address, 4, Class::System));
    }
    let with = if loads { new(Class::Load).writing(moved) } else { new(Class::Store).reading(moved) };
    // Pre-indexed downwards with writeback on the stack pointer: PUSH of one register.
    let is_push = first == 0xf84d && second & 0x0f00 == 0x0d00;
    let with = if is_push { with.with(Effect::Push(u32::from(second & 0xff))) } else { with };
    if base == Registers::core(PC) {
        return loads.then(|| with.of_literal(offset(first, second & 0xfff, 1)));
    }
    let with = with.addressed_by(base);
    Some(if first & 0x80 != 0 {
        with.at(first, i64::from(second & 0xfff))
    } else if second & 0x0800 != 0 {
        // Pre-indexed or post-indexed with writeback. A post-indexed access is at the base itself.
        let up = if second & 0x0200 == 0 { -1 } else { 1 };
        let from = if second & 0x0400 == 0 { 0 } else { up * i64::from(second & 0xff) };
        let with = with.at(first, from);
        if second & 0x0100 != 0 { with.writing(base) } else { with }
    } else {
        let with = with.addressed_by(field(second, 0)).at(first, 0).plus(second, second >> 4 & 3);
        Instruction { register_offset: !loads, ..with }
    })
}

/// Data processing with registers, multiplication, division.
fn register(address: u32, first: u16, second: u16) -> Option<Instruction> {
    let new = |class| Instruction::new(address, 4, class);
    let (n, a, d, m) = (field(first, 0), field(second, 12), field(second, 8), field(second, 0));
    let none = Registers::core(PC);
    let given = |register: Registers| if register == none { Registers::NONE } else { register };
    Some(match (first >> 7) & 3 {
        // Shifts, extensions, sums of parts, reversals, leading zeros.
        0 | 1 if second & 0xf000 == 0xf000 => new(Class::Integer).reading(given(n) | m).writing(d),
        2 => new(Class::Multiply).reading(n | m | given(a)).writing(d),
        3 => match (first >> 4) & 7 {
            1 | 3 => new(Class::Divide).reading(n | m).writing(d),
            0 | 2 => new(Class::Multiply).reading(n | m).writing(a | d),
            _ => new(Class::Multiply).reading(n | m | a | d).writing(a | d),
        },
        _ => return None,
    })
}
