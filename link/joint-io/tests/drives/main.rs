//! Tests with drives that receive nothing, do not answer, switch off or lose power: from a host's requests to a shaft with a weight on it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]
#![allow(clippy::float_cmp, reason = "where a test asks for equality, the bits must be equal")]
#![allow(clippy::disallowed_types, reason = "the models and the bounds are in double precision")]
#![allow(clippy::struct_excessive_bools, reason = "switches of a test")]

mod brakes;
mod enable;
mod motions;
mod notices;
mod overrun;
mod power;
mod replies;
mod rig;
mod timeout;
mod weak;
