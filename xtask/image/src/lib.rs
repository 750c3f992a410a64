//! Analysis of a linked program for the chip, from its ELF file: contents, largest stack depth, execution time.
//!
//! | module | holds |
//! |---|---|
//! | [`Program`] | the reader of ELF files: sections, symbols, the vector table, and any address as an instruction |
//! | [`decode`](Instruction) | the decoder of Thumb-2: an instruction's class, registers, words and effect |
//! | [`Program::function`], [`Program::reached_from`] | bytes of a function, its stack traffic, and everything that it calls and refers to |
//! | [`Program::stack`] | the worst-case stack depth |
//! | [`cycles`] | an estimate of a program's cycles from the emulator's trace |
//! | [`costs`] | run-time costs of a firmware, as one program prints them and another reads them |
//!
//! Everything except [`cycles`] is read from symbols and instructions; nothing is run.
#![forbid(unsafe_code)]

pub mod costs;
pub mod cycles;
mod decode;
mod elf;
mod functions;
mod reached;
mod stack;

pub use decode::{Class, Effect, Instruction, Place, Registers};
pub use elf::{ImageError, Program};
pub use functions::Function;
pub use reached::{Part, Reached};
pub use stack::{Depth, EXCEPTION_FRAME, Stack};
