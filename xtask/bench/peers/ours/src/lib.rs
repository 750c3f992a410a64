//! What `cargo xtask bench --peers` measures of ours, as C functions of the same shape as everybody else's: on the desk
//! `contestant.h`, on the chip `chip.h`. References are pointers in C, so nothing here is unsafe but the names.
#![cfg_attr(target_os = "none", no_std)]
#![allow(unsafe_code, reason = "the harness must find its contestants by name")]

pub mod chip;
#[cfg(not(target_os = "none"))]
pub mod desk;

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

use dynamics_core::{InverseDynamics, Live, Real, SinCos};

/// Joints of every arm that is measured.
const JOINTS: usize = 6;

/// Torques of a state: everything here ends in this call.
#[inline(always)]
fn torques<S: Real>(
    arm: &impl InverseDynamics<S, JOINTS>,
    turn: &[SinCos<S>; JOINTS],
    [q, qd, qdd]: [&[S; JOINTS]; 3],
) -> [S; JOINTS] {
    arm.inverse_dynamics(turn, q, qd, qdd, &Live::zero())
}

/// Sine and cosine from where the harness keeps them: cosine first, as Pinocchio wants them.
#[inline(always)]
fn given<S: Real>(turn: &[[S; 2]; JOINTS]) -> [SinCos<S>; JOINTS] {
    turn.map(|[cos, sin]| SinCos { sin, cos })
}
