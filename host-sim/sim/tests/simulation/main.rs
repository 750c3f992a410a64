//! Tests of the simulated arm and of the closed loop.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod batch;
mod closed_loop;
mod collision;
mod drives;
mod plant;
mod plant_elasticity;
mod plant_integrators;
mod plant_rotor_coupling;
mod rates;
mod reference;
mod split;
mod stiction;
