//! Tests of the controller: laws, friction, observer, limits, faults, and that a tick is total.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so")]
#![allow(clippy::float_cmp, reason = "limits, latches and resets are promised to the bit")]

mod collision;
mod every_nth;
mod faults;
mod friction;
mod friction_terms;
mod integral;
mod laws;
mod limits;
mod observer;
mod support;
mod teach;
mod totality;
