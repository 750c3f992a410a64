//! Reference motions: smooth, exact at their ends, inside their bounds, and rejected if they are impossible.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so")]
#![allow(clippy::float_cmp, reason = "ends of motions are promised to the bit")]

mod quintic;
mod refused;
mod scaling;
mod series;
mod support;
mod sweep;
mod torque;
mod trapezoid;
