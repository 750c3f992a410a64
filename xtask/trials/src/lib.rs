//! Tasks that run the simulator. They are a package of their own so that no other task has to compile it.
//!
//! | module | program | does |
//! |---|---|---|
//! | [`campaign`] | `campaign` (`cargo xtask campaign`) | injects every fault in every state of the safety state machine, and judges each tick |
//! | [`fuzz`] | one for each target, for `cargo fuzz` | checks what must hold for any input: frames, files and lines |
//! | [`budget`] | `chip-budget` (`cargo xtask budget`) | measures what a firmware takes: instructions, stack, blocked interrupts, estimated cycles |
#![forbid(unsafe_code)]

pub mod budget;
pub mod campaign;
pub mod fuzz;
