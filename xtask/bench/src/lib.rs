//! Contents of `cargo xtask bench`: kernels of three arms, generated when this crate is built, and the states for the
//! measurement. `no_std`, so that the chip runs the same code.
//!
//! | module | holds |
//! |---|---|
//! | [`kernels`] | `ARM_FUNCTION_LEVEL_SCALAR`, for example [`kernels::puma560_inverse_dynamics_regrouped_f32`]; `ARM_arm`, the arm's numbers in f32 |
//! | [`hand`] | gravity torques written by hand, to compare with |
//! | [`states`] | random states, the same in every run, on every machine and in both precisions |
//! | `general` | the arm that leaves the compiler the least to fold (feature `desk`) |
//! | `plain` | the arms as the files give them (feature `desk`) |
#![cfg_attr(not(feature = "desk"), no_std)]
#![forbid(unsafe_code)]

#[cfg(feature = "desk")]
pub mod general;
pub mod hand;
#[cfg(feature = "desk")]
pub mod plain;
pub mod states;

/// Kernels and numbers of the arms, in the scene of `plain` (feature `kernels`).
///
/// | item | meaning |
/// |---|---|
/// | `ARM_inverse_dynamics_LEVEL_SCALAR::Kernel` | implements `InverseDynamics<SCALAR, 6>` |
/// | `ARM_gravity_LEVEL_SCALAR::gravity` | `fn(turn) -> [SCALAR; 6]` |
/// | `ARM_mass_matrix_LEVEL_SCALAR::mass_matrix` | `fn(turn, ..) -> [SCALAR; 21]`, with `q` where the arm has a prismatic joint |
/// | `ARM_inverse_dynamics_regrouped_any::Kernel` | the same for every scalar |
/// | `ARM_forward_dynamics_regrouped_f64::forward_dynamics` | `fn(turn, .., qd, tau) -> [f64; 12]`: `qdd` and the pivots |
/// | `ARM_arm::{model, scene}` | the arm for the recursion, f32 |
///
/// `ARM` is `ur5`, `puma560` or `stanford`; `LEVEL` is `exact` or `regrouped`; `SCALAR` is `f32` or `f64`.
#[cfg(feature = "kernels")]
pub mod kernels {
    #![allow(
        unused_imports,
        clippy::approx_constant,
        clippy::excessive_precision,
        reason = "generated: imports what any arm may need"
    )]

    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
