//! Closed-loop simulation on the desk and against the emulated chip.
//!
//! | module | holds |
//! |---|---|
//! | [`plant`] | the simulated arm, its actuators and sensors: f64, an algorithm of its own |
//! | [`target`] | who computes the torques: the desk, the chip, or both beside each other |
//! | [`closed_loop`] | the loop itself, once per control period |
//! | [`record`] | what happened, tick by tick, and its CSV |
//! | [`summary`] | a run in a few numbers |
//! | [`plot`] | a run in pictures |
#![forbid(unsafe_code)]

pub mod closed_loop;
pub mod plant;
pub mod plot;
pub mod record;
pub mod summary;
pub mod target;
