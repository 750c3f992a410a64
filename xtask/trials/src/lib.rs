//! Tasks that run the simulator. They are a separate package so that no other task has to compile it.
//!
//! | module | program | does |
//! |---|---|---|
//! | [`campaign`] | `campaign` (`cargo xtask campaign`) | injects every fault in every state of the safety state machine, and judges each tick |
//! | [`fuzz`] | one for each target, for `cargo fuzz` | checks properties that must hold for any input: frames, files and lines |
//! | [`budget`] | `chip-budget` (`cargo xtask budget`) | measures a firmware's costs: instructions, stack, blocked interrupts, estimated cycles |
#![forbid(unsafe_code)]

pub mod budget;
pub mod campaign;
pub mod fuzz;
