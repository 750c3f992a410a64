//! This project's functions for the comparison on the chip, in f32: one state per call.

use crate::{JOINTS, given, torques};
use bench::kernels;
use bench::states::States;
use dynamics_core::Trig;
use dynamics_core::trig::Polynomial;

/// `struct state` of `chip.h`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct State {
    q: [f32; JOINTS],
    qd: [f32; JOINTS],
    qdd: [f32; JOINTS],
    turn: [[f32; 2]; JOINTS],
    qd_again: [f32; JOINTS],
    qdd_again: [f32; JOINTS],
}

/// Number of states in `chip.h`.
const STATES: usize = 64;

/// Writes the states for all programs, with cosines and sines.
#[unsafe(no_mangle)]
pub extern "C" fn bench_chip_states(states: &mut [State; STATES]) {
    let mut random = States::new();
    for state in states {
        let bench::states::State { q, qd, qdd } = random.draw();
        let turn = Polynomial.sin_cos_all(&q).map(|t| [t.cos, t.sin]);
        *state = State { q, qd, qdd, turn, qd_again: qd, qdd_again: qdd };
    }
}

/// This project's sine and cosine, for programs without their own.
#[unsafe(no_mangle)]
pub extern "C" fn our_trig(angles: &[f32; JOINTS], turn: &mut [[f32; 2]; JOINTS]) {
    *turn = Polynomial.sin_cos_all(angles).map(|t| [t.cos, t.sin]);
}

/// Defines `$whole`, which also computes sine and cosine, and `$kernel`, which receives them.
macro_rules! contestants {
    ($($arm:expr => $whole:ident, $kernel:ident;)*) => {$(
        /// With trigonometry.
        #[unsafe(no_mangle)]
        pub extern "C" fn $whole(state: &State, out: &mut [f32; JOINTS]) {
            *out = torques(&$arm, &Polynomial.sin_cos_all(&state.q), [&state.q, &state.qd, &state.qdd]);
        }

        /// Without trigonometry.
        #[unsafe(no_mangle)]
        pub extern "C" fn $kernel(state: &State, out: &mut [f32; JOINTS]) {
            *out = torques(&$arm, &given(&state.turn), [&state.q, &state.qd, &state.qdd]);
        }
    )*};
}

contestants! {
    kernels::ur5_inverse_dynamics_regrouped_f32::Kernel => chip_ur5_regrouped, chip_ur5_regrouped_kernel;
    kernels::ur5_inverse_dynamics_exact_f32::Kernel => chip_ur5_exact, chip_ur5_exact_kernel;
    kernels::puma560_inverse_dynamics_regrouped_f32::Kernel => chip_puma560_regrouped, chip_puma560_regrouped_kernel;
    kernels::puma560_inverse_dynamics_exact_f32::Kernel => chip_puma560_exact, chip_puma560_exact_kernel;
}
