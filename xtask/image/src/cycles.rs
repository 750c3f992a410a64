//! **Estimate** of the cycles that an STM32F405 needs for the instructions that the emulator executes.
//!
//! The emulator counts instructions, and an instruction is not a cycle: a division takes 14, code in flash waits for flash, a load waits for its
//! address. This module estimates the cycles from three sources: the decoded instructions ([`Program::decode`](crate::Program::decode)), their order
//! of execution ([`trace`]), and the manuals' tables of the core and the flash ([`timing`]). Where a manual is ambiguous, the estimate is a range
//! from the quickest to the slowest interpretation, with the most probable in between ([`Range`]). **None of our own programs has run on silicon**;
//! programs of others have, and `docs/measured/calibration.md` compares their published cycles with our estimates.
//!
//! | module | holds |
//! |---|---|
//! | [`timing`] | every number, with its source, and the three interpretations of the manuals |
//! | [`Memory`] | flash with its two caches and its prefetch, or SRAM |
//! | [`Estimator`] | an [`Estimate`] for each run, from the pipeline: hazards, the float unit, branches |
//! | [`emulator`] | start and end of the emulator, and the lines of its log |
//! | [`trace`] | single instructions between given addresses |
//! | [`steps`] | single instructions of a whole program, which may already be running in an emulator |
//! | [`calls`] | an estimate of each call of functions, in a program that counts them |
//!
//! Limits: a device is assumed to answer as quickly as SRAM. An instruction skipped by its IT block is counted as executed. There are no interrupts
//! and no DMA.

mod calls;
pub mod emulator;
mod estimator;
mod memory;
mod pipeline;
pub mod steps;
pub mod timing;
pub mod trace;

pub use calls::calls;
pub use estimator::{Estimate, Estimator, Range};
pub use memory::{Memory, Placement};
pub use pipeline::Stalls;
