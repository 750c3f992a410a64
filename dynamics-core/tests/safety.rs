//! The safety state machine: every transition compared with a table, its invariants over random sequences, braking, and the
//! controller inside it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so")]
#![allow(clippy::float_cmp, reason = "limits, edges and what is handed on are promised to the bit")]

mod braking;
mod controlled;
mod disarming;
mod limited;
mod lowering;
mod ordinary;
mod sequences;
mod support;
mod table;
mod texts;
mod watch;
