//! Decoder of Thumb-2 instructions with FPv4-SP: class, registers, words, jump target, and effect on the stack.
//!
//! It follows the encodings in the ARMv7-M Architecture Reference Manual, chapters A5 to A7. It is our own code, because the published decoders
//! lack the float unit's Thumb instructions, which are most of a kernel.

mod class;
mod float;
mod instruction;
mod narrow;
mod registers;
mod wide;

pub use class::Class;
pub use instruction::{Effect, Instruction, Place};
pub use registers::Registers;

/// Width in bytes of the instruction with this first half.
pub(crate) const fn width(first: u16) -> u32 {
    // 11101, 11110 and 11111 begin an instruction of two halves.
    if first < 0xe800 { 2 } else { 4 }
}

/// The instruction with this first half; a wide one needs the second half too.
pub(crate) fn decode(address: u32, first: u16, second: Option<u16>) -> Option<Instruction> {
    if width(first) == 2 { narrow::decode(address, first) } else { wide::decode(address, first, second?) }
}
