//! Functions of a program, and their references.

use crate::decode::{Class, Effect, Registers};
use crate::elf::{ImageError, Program};
use std::ops::Range;

/// The stack pointer's number.
const SP: u16 = 13;

/// A function of the chip's program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Function {
    /// Size in bytes, including the literals after the code.
    pub bytes: u64,
    /// Number of float registers stored on the stack one at a time.
    pub stores: usize,
    /// Number of float registers loaded from the stack one at a time.
    pub loads: usize,
}

/// References of a function.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct References {
    /// Targets of jumps out of the function, including calls.
    pub(crate) jumps: Vec<u32>,
    /// Numbers that could be addresses: those loaded in two halves, and the literals after the code.
    pub(crate) numbers: Vec<u32>,
    /// Number of calls through a register.
    pub(crate) indirect: usize,
    /// Number of jumps through a register that are not returns, and of jumps to an address from memory.
    pub(crate) onward: usize,
}

impl Program {
    /// Start address of the first function with a name that satisfies the predicate.
    #[must_use]
    pub fn address_of(&self, name: impl Fn(&str) -> bool) -> Option<u32> {
        self.functions.iter().find(|(_, (known, _))| name(known)).map(|(address, _)| *address)
    }

    /// Measures the function at an address; the lowest bit, which marks Thumb code, is ignored.
    ///
    /// # Errors
    /// No function begins there.
    pub fn function(&self, address: u32) -> Result<Function, ImageError> {
        let range = self.range(address & !1)?;
        let bytes = range.len() as u64;
        let (stores, loads) = self.stack_traffic(range);
        Ok(Function { bytes, stores, loads })
    }

    /// Return address of the first call through a register, in the first function with `name` in its symbol.
    ///
    /// A program that counts calls one after another with the same few instructions has one such call.
    #[must_use]
    pub fn behind_call_in(&self, name: &str) -> Option<u32> {
        let range = self.range(self.address_of(|known| known.contains(name))?).ok()?;
        let call = self.instructions(range).find(|instruction| instruction.calls_register())?;
        Some(call.address + call.width)
    }

    /// References of the function in this range.
    pub(crate) fn references(&self, range: Range<u32>) -> References {
        let mut found = References::default();
        // Lower halves that wait for their upper halves, by register.
        let mut lower = [None::<u16>; Registers::COUNT];
        for instruction in self.instructions(range.clone()) {
            let register = instruction.writes.numbers().next().unwrap_or_default();
            match instruction.effect {
                Effect::Jump(goal) if !range.contains(&goal) => found.jumps.push(goal),
                Effect::LowerHalf(low) => lower[register] = Some(low),
                Effect::UpperHalf(high) => {
                    let number = |low| u32::from(high) << 16 | u32::from(low);
                    found.numbers.extend(lower[register].take().map(number));
                }
                _ => {}
            }
            found.indirect += usize::from(instruction.calls_register());
            found.onward += usize::from(instruction.jumps_to_register());
        }
        let words = range.clone().step_by(4).map(|at| at & !3);
        found.numbers.extend(words.filter(|at| range.contains(at) && self.is_data(*at)).filter_map(|at| self.word(at)));
        found
    }

    /// Counts the registers that VSTR and VLDR move one at a time to and from the stack frame.
    ///
    /// Registers saved on entry use VPUSH and are not counted. Inputs and results are accessed through pointers.
    fn stack_traffic(&self, range: Range<u32>) -> (usize, usize) {
        let (mut stores, mut loads) = (0, 0);
        for instruction in self.instructions(range).filter(|found| found.address_registers == Registers::core(SP)) {
            match instruction.class {
                Class::FloatStore => stores += instruction.words as usize,
                Class::FloatLoad => loads += instruction.words as usize,
                _ => {}
            }
        }
        (stores, loads)
    }

    /// Range of the function that begins at this address.
    pub(crate) fn range(&self, start: u32) -> Result<Range<u32>, ImageError> {
        let none = || ImageError::NoFunction(start);
        let (_, size) = self.functions.get(&start).ok_or_else(none)?;
        let end = start.saturating_add(*size);
        let inside = self.sections.iter().any(|section| section.contains(start) && end <= section.end());
        inside.then_some(start..end).ok_or_else(none)
    }

    /// Start of the function that contains an address.
    pub(crate) fn containing(&self, address: u32) -> Option<u32> {
        let (start, (_, size)) = self.functions.range(..=address).next_back()?;
        (address - start < *size).then_some(*start)
    }

    /// Start of the function to which this number points, with the lowest bit set as the core requires for jumps.
    pub(crate) fn function_at(&self, number: u32) -> Option<u32> {
        let at = number & !1;
        (number & 1 == 1 && self.functions.contains_key(&at)).then_some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::{Program, References};

    const START: u32 = 0x0800_1000;

    /// References of a function with these instruction halves; the last `numbers` of them are data.
    fn references(code: &[u16], numbers: usize) -> References {
        program(code, numbers).references(START..START + 2 * code.len() as u32)
    }

    fn program(code: &[u16], numbers: usize) -> Program {
        let mut program = Program::from_halves(START, code);
        program.marks.insert(START + 2 * (code.len() - numbers) as u32, true);
        program
    }

    /// As the assembler encodes them.
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
        let traffic = |numbers| program(&CODE, numbers).stack_traffic(START..START + 2 * CODE.len() as u32);
        assert_eq!(traffic(2), (1, 3));
        assert_eq!(traffic(0), (1, 4));
    }

    fn jumps(code: &[u16]) -> Vec<u32> {
        references(code, 0).jumps
    }

    #[test]
    fn calls_and_jumps_out_of_a_function_are_found_in_every_encoding() {
        // bl to the instruction after it, at the end of the function; then one forward and one backward.
        assert_eq!(jumps(&[0xf000, 0xf800]), [0x0800_1004]);
        assert_eq!(jumps(&[0xf001, 0xf8fe]), [0x0800_2200]);
        assert_eq!(jumps(&[0xf7ff, 0xfefe]), [0x0800_0e00]);
        // Farthest targets: 16 MiB backward, and 16 MiB minus two bytes forward.
        assert_eq!(jumps(&[0xf400, 0xd000]), [0x0700_1004]);
        assert_eq!(jumps(&[0xf3ff, 0xd7ff]), [0x0900_1002]);
        // b.w, b, beq and beq.w, all backward.
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
        // A number that looks like a call instruction.
        assert_eq!(references(&[0x4770, 0xbf00, 0xf001, 0xf8fe], 2).jumps, []);
    }

    #[test]
    fn jumps_through_a_register_are_distinguished_from_returns() {
        let onward = |code: &[u16]| references(code, 0).onward;
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
        let found = references(&code, 2);
        let numbers = vec![0x0801_1234, 0x2000_5678, 0x0800_4321];
        assert_eq!(found, References { jumps: vec![], numbers, indirect: 1, onward: 0 });
    }
}
