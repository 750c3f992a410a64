//! Linked program for the chip, read from its ELF file: its contents, its largest stack depth, its execution time.
//!
//! | module | holds |
//! |---|---|
//! | [`Program`] | the one reader of ELF files: sections, symbols, the vector table, and any address as an instruction |
//! | [`decode`](Instruction) | the one decoder of Thumb-2: an instruction's class, registers, words and effect |
//! | [`Program::function`], [`Program::reached_from`] | bytes of a function, its stack traffic, and all that it calls and refers to |
//! | [`Program::stack`] | the worst-case stack depth |
//! | [`cycles`] | from the emulator's trace of a program to an estimate of its cycles |
//! | [`costs`] | what a firmware takes while it runs, as one program prints it and another reads it |
//!
//! All but [`cycles`] is read from symbols and instructions; nothing is run.
#![forbid(unsafe_code)]

pub mod costs;
pub mod cycles;
mod decode;
mod elf;
mod functions;
mod reached;
mod stack;

pub use decode::{Class, Effect, Instruction, Place, Registers};
pub use elf::{ImageError, Program, SRAM};
pub use functions::Function;
pub use reached::{Part, Reached};
pub use stack::{Depth, EXCEPTION_FRAME, Stack};
