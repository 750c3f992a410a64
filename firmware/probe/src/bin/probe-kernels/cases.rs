//! The counted functions. They are never inlined, so that each has an address and a size.

use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{Dynamics, InverseDynamics, Live, SinCos, Trig};

/// All inputs that a kernel may read.
#[derive(Clone, Copy)]
pub(crate) struct Inputs {
    pub(crate) turn: [SinCos<f32>; 6],
    pub(crate) q: [f32; 6],
    pub(crate) qd: [f32; 6],
    pub(crate) qdd: [f32; 6],
    pub(crate) live: Live<f32, 6>,
    /// The arm that the recursion runs on.
    pub(crate) dynamics: Dynamics<f32, 6>,
}

/// Results; as many as the function with the most results has, a mass matrix.
pub(crate) type Outputs = [f32; 21];

/// A counted function.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) run: fn(&Inputs, &mut Outputs),
    /// Number of operations, of negations, of live inputs, and of values alive at most.
    pub(crate) work: [u32; 4],
}

pub(crate) use kernels::KERNELS;

/// Empty function, which counts the cost of a call.
#[inline(never)]
pub(crate) fn nothing(_: &Inputs, _: &mut Outputs) {}

/// The arms, for the recursion.
pub(crate) fn arms() -> [(&'static str, Dynamics<f32, 6>); 3] {
    [
        ("ur5", Dynamics::new(kernels::ur5_arm::model(), kernels::ur5_arm::scene())),
        ("puma560", Dynamics::new(kernels::puma560_arm::model(), kernels::puma560_arm::scene())),
        ("stanford", Dynamics::new(kernels::stanford_arm::model(), kernels::stanford_arm::scene())),
    ]
}

/// Functions that are counted once.
pub(crate) const COMMON: [Case; 3] = [
    Case { name: "trig_polynomial", run: trig_polynomial, work: [0; 4] },
    Case { name: "trig_libm", run: trig_libm, work: [0; 4] },
    Case { name: "puma560_gravity_by_hand", run: puma560_gravity_by_hand, work: [24, 1, 0, 0] },
];

/// Functions that are counted once for each arm.
pub(crate) const OF_ARMS: [Case; 2] = [
    Case { name: "generic", run: generic, work: [0; 4] },
    Case { name: "generic_with_trig", run: generic_with_trig, work: [0; 4] },
];

#[inline(never)]
fn generic(i: &Inputs, out: &mut Outputs) {
    put(i.dynamics.inverse_dynamics(&i.turn, &i.q, &i.qd, &i.qdd, &i.live), out);
}

#[inline(never)]
fn generic_with_trig(i: &Inputs, out: &mut Outputs) {
    put(i.dynamics.inverse_dynamics(&Polynomial.sin_cos_all(&i.q), &i.q, &i.qd, &i.qdd, &i.live), out);
}

#[inline(never)]
fn trig_polynomial(i: &Inputs, out: &mut Outputs) {
    put_turn(&Polynomial.sin_cos_all(&i.q), out);
}

#[inline(never)]
fn trig_libm(i: &Inputs, out: &mut Outputs) {
    put_turn(&Libm.sin_cos_all(&i.q), out);
}

#[inline(never)]
fn puma560_gravity_by_hand(i: &Inputs, out: &mut Outputs) {
    put(probe::hand::puma560(&i.turn), out);
}

#[inline(always)]
fn put<const M: usize>(from: [f32; M], to: &mut Outputs) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from;
    }
}

#[inline(always)]
fn put_turn(from: &[SinCos<f32>; 6], to: &mut Outputs) {
    for (i, turn) in from.iter().enumerate() {
        to[2 * i] = turn.sin;
        to[2 * i + 1] = turn.cos;
    }
}

#[allow(
    unused_imports,
    unreachable_pub,
    dead_code,
    clippy::approx_constant,
    clippy::excessive_precision,
    reason = "generated: imports and holds what any arm may need"
)]
mod kernels {
    use super::{Case, Inputs, Outputs, put};
    use dynamics_core::InverseDynamics;
    use dynamics_core::trig::{Polynomial, Trig};

    include!(concat!(env!("KERNELS"), "/kernels.rs"));
}
