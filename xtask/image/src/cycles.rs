//! From the instructions that the emulator executes to an **estimate** of the cycles that an STM32F405 takes for them.
//!
//! The emulator counts instructions, and an instruction is not a cycle: a division takes 14, code in flash waits for
//! flash, a load waits for its address. This module works that out from three things: what each instruction is
//! ([`Program::decode`](crate::Program::decode)), in which order they were executed ([`trace`]), and the manuals' tables of the core and the flash
//! ([`timing`]). **Nothing here has been compared with silicon**: where a manual leaves a choice, the estimate is a range
//! from the quickest to the slowest reading, with the likeliest between ([`Range`]).
//!
//! | module | holds |
//! |---|---|
//! | [`timing`] | every number, with its source, and the three readings of the manuals |
//! | [`Memory`] | flash with its two caches and its prefetch, or SRAM |
//! | [`Estimator`] | an [`Estimate`] for each run, from the pipeline: hazards, the float unit, branches |
//! | [`trace`] | the emulator, an instruction at a time, between addresses |
//! | [`steps`] | the same with the core's registers, of a program that an emulator is running already |
//! | [`calls`] | an estimate of each call of a function, in a program that counts them |
//!
//! What it does not know: data addresses are not in a trace. A load relative to the program counter reads flash, and its
//! address is known; all others are taken to be in SRAM. A constant in flash that is read through a pointer is therefore
//! counted as SRAM, and an instruction that its IT block skips as executed. There are no interrupts and no DMA.

mod calls;
mod estimator;
mod memory;
mod pipeline;
pub mod steps;
pub mod timing;
pub mod trace;

pub use calls::calls;
pub use estimator::{Estimate, Estimator, Range, Stalls};
pub use memory::{Memory, Placement};
