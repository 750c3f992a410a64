//! The program on the chip.

use crate::cases::{self, Case, Inputs, Outputs};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, Inertia, Live, Trig, Wrench};
use nalgebra::{Matrix3, Vector3};
use probe::Counter;
use probe::states::States;

/// Number of random states in which each function is counted.
const STATES: usize = 200;

#[entry]
fn main() -> ! {
    probe::run(all)
}

/// Counts all functions and prints a line for each: name, address, lowest and highest count, operations, negations, live inputs, values alive at
/// most.
fn all(counter: &Counter) {
    let arms = cases::arms();
    let (_, any) = &arms[0];
    for case in cases::COMMON.iter().chain(&cases::KERNELS) {
        count(counter, "", case, any);
    }
    for (arm, dynamics) in &arms {
        for case in &cases::OF_ARMS {
            count(counter, arm, case, dynamics);
        }
    }
}

fn count(counter: &Counter, arm: &str, case: &Case, dynamics: &Dynamics<f32, 6>) {
    let mut states = States::new();
    let (mut least, mut most) = (u32::MAX, 0);
    let mut out = Outputs::default();
    for _ in 0..STATES {
        let state = states.draw::<f32>();
        let inputs = Inputs {
            turn: Polynomial.sin_cos_all(&state.q),
            q: state.q,
            qd: state.qd,
            qdd: state.qdd,
            live: live(),
            dynamics: *dynamics,
        };
        let (empty, ()) = counter.call(cases::nothing, &inputs, &mut out);
        let (called, ()) = counter.call(case.run, &inputs, &mut out);
        let taken = called.wrapping_sub(empty);
        (least, most) = (least.min(taken), most.max(taken));
    }
    let (address, [operations, negations, live, alive]) = (case.run as usize, case.work);
    let (between, name) = (if arm.is_empty() { "" } else { "_" }, case.name);
    hprintln!(
        "count,{}{}{},{},{},{},{},{},{},{}",
        arm,
        between,
        name,
        address,
        least,
        most,
        operations,
        negations,
        live,
        alive
    );
}

/// Arbitrary values for all live inputs; no branch depends on them.
fn live() -> Live<f32, 6> {
    Live {
        gravity: Vector3::new(0.5, -0.25, -9.75),
        payload: Inertia { mass: 1.0, first_moment: Vector3::zeros(), about_origin: Matrix3::identity() },
        tip_wrench: Wrench { force: Vector3::new(3.0, -2.0, 8.0), moment: Vector3::new(0.5, 0.25, -1.0) },
        rotor: [0.5; 6],
    }
}
