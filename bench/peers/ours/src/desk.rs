//! This project's functions for the comparison on the desk, in f64: all states per call.

use crate::{JOINTS, given, torques};
use bench::states::{DESK, State, States};
use bench::{kernels, plain};
use dynamics_batch::{F64Lanes, inverse_dynamics_batch};
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{Dynamics, InverseDynamics, Live, Trig};
use std::sync::LazyLock;
use std::sync::atomic::{Ordering, compiler_fence};

/// One number per joint and state.
type ByState = [[f64; JOINTS]; DESK];
/// The same, in the layout for batches.
type ByJoint = [[f64; DESK]; JOINTS];

/// `struct states` of `contestant.h`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AllStates<'a> {
    q: &'a ByState,
    qd: &'a ByState,
    qdd: &'a ByState,
    tau: &'a ByState,
    turn: &'a [[[f64; 2]; JOINTS]; DESK],
    inverse_rows: &'a [[f64; 3 * JOINTS]; DESK],
    kernel_rows: &'a [[f64; 4 * JOINTS]; DESK],
    forward_rows: &'a [[f64; 3 * JOINTS]; DESK],
    q_by_joint: &'a ByJoint,
    qd_by_joint: &'a ByJoint,
    qdd_by_joint: &'a ByJoint,
}

/// Writes the states for all programs.
#[unsafe(no_mangle)]
pub extern "C" fn bench_states(q: &mut ByState, qd: &mut ByState, qdd: &mut ByState) {
    let mut random = States::new();
    for i in 0..DESK {
        State { q: q[i], qd: qd[i], qdd: qdd[i] } = random.draw();
    }
}

/// Prevents the compiler from combining several states in one vector when they are measured one after another.
#[inline(always)]
fn one_by_one() {
    compiler_fence(Ordering::SeqCst);
}

fn lists(all: &ByJoint) -> [&[f64]; JOINTS] {
    all.each_ref().map(<[f64; DESK]>::as_slice)
}

impl AllStates<'_> {
    #[inline(always)]
    fn whole(&self, arm: &impl InverseDynamics<f64, JOINTS>, trig: impl Trig<f64>, out: &mut ByState) {
        for (i, out) in out.iter_mut().enumerate() {
            one_by_one();
            *out = torques(arm, &trig.sin_cos_all(&self.q[i]), [&self.q[i], &self.qd[i], &self.qdd[i]]);
        }
    }

    #[inline(always)]
    fn kernel(&self, arm: &impl InverseDynamics<f64, JOINTS>, out: &mut ByState) {
        for (i, out) in out.iter_mut().enumerate() {
            one_by_one();
            *out = torques(arm, &given(&self.turn[i]), [&self.q[i], &self.qd[i], &self.qdd[i]]);
        }
    }

    /// Accelerations by the recursion: the model is read at run time.
    #[inline(always)]
    fn forward(&self, arm: &Dynamics<f64, JOINTS>, out: &mut ByState) {
        for (i, out) in out.iter_mut().enumerate() {
            one_by_one();
            let turn = Polynomial.sin_cos_all(&self.q[i]);
            // The harness detects NaN.
            *out = forward_dynamics(arm, &turn, &self.q[i], &self.qd[i], &self.tau[i], &Live::zero())
                .unwrap_or([f64::NAN; JOINTS]);
        }
    }

    fn batch(&self, arm: &impl InverseDynamics<F64Lanes, JOINTS>, out: &mut ByJoint) {
        let computed =
            dynamics_batch::States::new(lists(self.q_by_joint), lists(self.qd_by_joint), lists(self.qdd_by_joint))
                .and_then(|states| {
                    let out = out.each_mut().map(|list| list.as_mut_slice());
                    inverse_dynamics_batch(arm, &Polynomial, &states, &Live::zero(), out)
                });
        // All lists have the same length by their type. If not, the harness would detect these NaNs.
        if computed.is_err() {
            *out = [[f64::NAN; DESK]; JOINTS];
        }
    }
}

/// Defines `$whole`, which also computes sine and cosine, `$libm`, which uses those of libm, and `$kernel`, which receives them.
macro_rules! contestants {
    ($($arm:expr => $whole:ident, $libm:ident, $kernel:ident;)*) => {$(
        /// With our trigonometry.
        #[unsafe(no_mangle)]
        pub extern "C" fn $whole(states: &AllStates<'_>, out: &mut ByState) {
            states.whole($arm, Polynomial, out);
        }

        /// With libm's trigonometry.
        #[unsafe(no_mangle)]
        pub extern "C" fn $libm(states: &AllStates<'_>, out: &mut ByState) {
            states.whole($arm, Libm, out);
        }

        /// Without trigonometry.
        #[unsafe(no_mangle)]
        pub extern "C" fn $kernel(states: &AllStates<'_>, out: &mut ByState) {
            states.kernel($arm, out);
        }
    )*};
}

contestants! {
    &*UR5 => ur5_generic, ur5_generic_libm, ur5_generic_kernel;
    &kernels::ur5_inverse_dynamics_exact_f64::Kernel => ur5_exact, ur5_exact_libm, ur5_exact_kernel;
    &kernels::ur5_inverse_dynamics_regrouped_f64::Kernel => ur5_regrouped, ur5_regrouped_libm, ur5_regrouped_kernel;
    &*PUMA560 => puma560_generic, puma560_generic_libm, puma560_generic_kernel;
    &kernels::puma560_inverse_dynamics_exact_f64::Kernel => puma560_exact, puma560_exact_libm, puma560_exact_kernel;
    &kernels::puma560_inverse_dynamics_regrouped_f64::Kernel =>
        puma560_regrouped, puma560_regrouped_libm, puma560_regrouped_kernel;
}

/// Defines `$batch`, which computes all torques in lanes, and `$forward`, which computes the accelerations of one state after another. Both use
/// this project's sine and cosine.
macro_rules! batch_and_forward {
    ($($kernel:ident => $batch:ident; $forward_dynamics:ident => $forward:ident;)*) => {$(
        /// Torques, all states in one call.
        #[unsafe(no_mangle)]
        pub extern "C" fn $batch(states: &AllStates<'_>, out: &mut ByJoint) {
            states.batch(&kernels::$kernel::Kernel, out);
        }

        /// Accelerations.
        #[unsafe(no_mangle)]
        pub extern "C" fn $forward(states: &AllStates<'_>, out: &mut ByState) {
            for (i, out) in out.iter_mut().enumerate() {
                one_by_one();
                let turn = Polynomial.sin_cos_all(&states.q[i]);
                // The divisors (inertias) of the function follow the accelerations.
                let [qdd @ .., _, _, _, _, _, _] = kernels::$forward_dynamics::forward_dynamics(&turn, &states.qd[i], &states.tau[i]);
                *out = qdd;
            }
        }
    )*};
}

batch_and_forward! {
    ur5_inverse_dynamics_regrouped_any => ur5_batch; ur5_forward_dynamics_regrouped_f64 => ur5_forward;
    puma560_inverse_dynamics_regrouped_any => puma560_batch; puma560_forward_dynamics_regrouped_f64 => puma560_forward;
}

/// The arm, read from the robot file at the start of the measurement.
static UR5: LazyLock<Dynamics<f64, JOINTS>> = LazyLock::new(|| arm("ur5"));
static PUMA560: LazyLock<Dynamics<f64, JOINTS>> = LazyLock::new(|| arm("puma560"));

#[allow(clippy::expect_used, reason = "the file was read before, when the kernels were built from it")]
fn arm(name: &str) -> Dynamics<f64, JOINTS> {
    let scene = plain::scene(name).expect("a robot file of the project");
    let model = scene.robot.model().expect("six joints");
    Dynamics::new(model, scene.scene(&model))
}

/// Accelerations; the model is read at run time.
#[unsafe(no_mangle)]
pub extern "C" fn ur5_generic_forward(states: &AllStates<'_>, out: &mut ByState) {
    states.forward(&UR5, out);
}

/// Accelerations; the model is read at run time.
#[unsafe(no_mangle)]
pub extern "C" fn puma560_generic_forward(states: &AllStates<'_>, out: &mut ByState) {
    states.forward(&PUMA560, out);
}
