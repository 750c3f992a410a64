//! Exhaustive exploration of session, safety machine and drive protocol.
//!
//! The code that the board runs ([`session::Session`], [`joint_io::can::CanJoints`]) is the transition function of an explicit-state model
//! checker (`stateright`). It is connected to simulated drives (`actuator_model`), a bus, and a plant of one or two joints. Positions and speeds
//! of the plant are rounded to a grid, so that states with irrelevant differences become one. The board itself is not modelled: its real state is
//! copied at every branch.
//!
//! | module | holds |
//! |---|---|
//! | [`scene`] | an arm to explore: drive kind, safe action, numbers of controller and machine |
//! | [`world`] | bus, drives, power, brakes, joints |
//! | [`host`] | the operator: a function from what the board reports to the next request |
//! | [`event`] | disturbing events, and steps between them |
//! | [`state`] | one state, and the step by one control period |
//! | [`judge`] | the properties, judged from the simulated drives and the motion, never from the board's own estimate |
//! | [`digest`] | hash of the part of a state that determines its future |
//! | [`explorer`] | the transition system for the checker, and readable traces |
//! | [`faulty`] | a board that is broken on purpose |
//!
//! # How states are explored
//! The initial states are all states of an undisturbed session, one for each control period: the operator homes, arms, moves up, holds, moves
//! down, disarms. From each of them the checker follows every interleaving of up to `budget` disturbing events. An event takes no time; several
//! may happen in one period. The operator's own requests do not count as events: they always follow from the board's reports.
#![forbid(unsafe_code)]
#![allow(dead_code, unreachable_pub, reason = "`main.rs` uses one part, `examples/search.rs` another")]
#![allow(clippy::disallowed_types, reason = "the plant and its bounds are in double precision")]

pub mod digest;
pub mod event;
pub mod explorer;
pub mod faulty;
pub mod host;
pub mod judge;
pub mod scene;
pub mod state;
pub mod world;
