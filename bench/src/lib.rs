//! Code that `cargo xtask bench` measures: kernels of three arms, generated when this crate is built, and the states for the measurement. On the
//! chip it is `no_std`, so that the chip runs the same code.
//!
//! | module | holds |
//! |---|---|
//! | [`kernels`] | `ARM_FUNCTION_LEVEL_SCALAR`, for example [`kernels::puma560_inverse_dynamics_regrouped_f32`]; `ARM_arm`, the arm's numbers in f32 |
//! | [`hand`], [`states`] | modules of the programs that count on the chip ([`probe`]) |
//! | `general` | an arm with as few simplifications for the kernel compiler as possible (on the desk) |
//! | `plain` | the arms from their files (on the desk); shared with the task that counts on the chip |
#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]

#[cfg(not(target_os = "none"))]
pub mod general;
#[cfg(not(target_os = "none"))]
#[path = "../../xtask/src/bench/plain.rs"]
pub mod plain;

pub use probe::{hand, states};

/// Kernels and numbers of the arms, in the scene of `plain`.
///
/// | item | meaning |
/// |---|---|
/// | `ARM_inverse_dynamics_LEVEL_SCALAR::Kernel` | implements `InverseDynamics<SCALAR, 6>` |
/// | `ARM_gravity_LEVEL_SCALAR::gravity` | `fn(turn) -> [SCALAR; 6]` |
/// | `ARM_mass_matrix_LEVEL_SCALAR::mass_matrix` | `fn(turn, ..) -> [SCALAR; 21]`, with `q` if the arm has a prismatic joint |
/// | `ARM_inverse_dynamics_regrouped_any::Kernel` | the same for every scalar |
/// | `ARM_forward_dynamics_regrouped_f64::forward_dynamics` | `fn(turn, .., qd, tau) -> [f64; 12]`: `qdd` and the pivots |
/// | `ARM_arm::{model, scene}` | the arm for the recursion, f32 |
///
/// `ARM` is `ur5`, `puma560` or `stanford`; `LEVEL` is `exact` or `regrouped`; `SCALAR` is `f32` or `f64`.
pub mod kernels {
    #![allow(
        unused_imports,
        clippy::approx_constant,
        clippy::excessive_precision,
        reason = "generated: imports what any arm may need"
    )]

    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
