//! This project's functions for `cargo xtask bench --peers`, as C functions with the same signatures as those of the other programs:
//! `contestant.h` on the desk, `chip.h` on the chip. References are pointers in C, so only the exported names are unsafe.
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

/// Number of joints of every measured arm.
const JOINTS: usize = 6;

/// Torques of a state. All functions for torques here end in this call.
#[inline(always)]
fn torques<S: Real>(
    arm: &impl InverseDynamics<S, JOINTS>,
    turn: &[SinCos<S>; JOINTS],
    [q, qd, qdd]: [&[S; JOINTS]; 3],
) -> [S; JOINTS] {
    arm.inverse_dynamics(turn, q, qd, qdd, &Live::zero())
}

/// Sine and cosine in the harness's order: cosine first, as Pinocchio expects them.
#[inline(always)]
fn given<S: Real>(turn: &[[S; 2]; JOINTS]) -> [SinCos<S>; JOINTS] {
    turn.map(|[cos, sin]| SinCos { sin, cos })
}
