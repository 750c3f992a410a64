//! Example 326: the 2R arm's Newton-Euler equations and their matrix form `[A] x = b`.

use super::support::{Letters, STATED, TwoLinks, largest, moving, shares, two_links};
use super::support_b::{
    DOWN_Y, G, STATED_2, State, assert_equal, assert_stated, difference, largest as largest_of, wrenches_in_base,
};
use crate::common::torque;
use dynamics_core::Wrench;
use dynamics_core::chapter::global::{Assembled, residuals, weights};

/// `[A]` and `b` of eq. 12.75-12.76, `x = (F0x, F0y, Q0, F1x, F1y, Q1)`. `sign` is 1 as corrected and -1 as printed, because the
/// printed cross products in rows 3 and 6 have the wrong sign. In `b` the printed `-m g` holds for a signed g; with g = 9.81 it is `+m g`.
fn system(arm: &TwoLinks, state: &State<2>, sign: f64) -> ([[f64; 6]; 6], [f64; 6]) {
    let (posture, motion) = moving(&arm.dynamics(), state);
    let (n1, m1, n2) = (posture.inner_arm(0) * sign, posture.outer_arm(0) * sign, posture.inner_arm(1) * sign);
    let (a1, a2) = (motion[0].acceleration, motion[1].acceleration);
    let a = [
        [1.0, 0.0, 0.0, -1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, -1.0, 0.0],
        [-n1.y, n1.x, 1.0, m1.y, -m1.x, -1.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, -n2.y, n2.x, 1.0],
    ];
    let Letters { e1, e12, .. } = Letters::of(state);
    let TwoLinks { m1, m2, iz1, iz2, .. } = *arm;
    let b = [m1 * a1.x, m1 * a1.y + m1 * G, iz1 * e1, m2 * a2.x, m2 * a2.y + m2 * G, iz2 * e12];
    (a, b)
}

/// The second link's rows come first; in this order `[A]` is lower triangular with ones on its diagonal.
fn solved((a, b): &([[f64; 6]; 6], [f64; 6])) -> [f64; 6] {
    let mut x = [0.0; 6];
    for k in [3, 4, 5, 0, 1, 2] {
        let known: f64 = (0..6).filter(|j| *j != k).map(|j| a[k][j] * x[j]).sum();
        x[k] = b[k] - known;
    }
    x
}

fn from_the_recursion(arm: &TwoLinks, state: &State<2>) -> [f64; 6] {
    let dynamics = arm.dynamics();
    let [first, second] = wrenches_in_base(&dynamics, state);
    let tau: [f64; 2] = torque(&dynamics, &state.q, &state.qd, &state.qdd);
    [first.force.x, first.force.y, tau[0], second.force.x, second.force.y, tau[1]]
}

/// The same unknowns from the core's system of all equations in space.
fn from_the_assembled(arm: &TwoLinks, state: &State<2>) -> [f64; 6] {
    let (posture, motion) = moving(&arm.dynamics(), state);
    let system = Assembled::new(&posture, &motion, &weights(&posture, &DOWN_Y), &Wrench::zero());
    let [first, second] = system.solve().unwrap();
    [first.force.x, first.force.y, first.moment.z, second.force.x, second.force.y, second.moment.z]
}

/// Residual of the links' equations 12.70-12.73 (left side less right side) with the wrenches of the recursion, relative to those.
fn missed(arm: &TwoLinks, state: &State<2>) -> f64 {
    let dynamics = arm.dynamics();
    let (posture, motion) = moving(&dynamics, state);
    let joints = wrenches_in_base(&dynamics, state);
    let missed = residuals(&posture, &motion, &joints, &weights(&posture, &DOWN_Y), &Wrench::zero());
    largest_of(&missed) / largest_of(&joints)
}

fn empty(arm: TwoLinks) -> TwoLinks {
    TwoLinks { m0: 0.0, ..arm }
}

#[test]
fn the_corrected_system_gives_the_forces_and_torques_of_the_recursion() {
    assert_equal("12.74-12.76", two_links(), |(arm, state)| {
        let arm = empty(arm);
        let (a, b) = system(&arm, &state, 1.0);
        let wanted = from_the_recursion(&arm, &state);
        let back: [f64; 6] = core::array::from_fn(|k| a[k].iter().zip(&wanted).map(|(a, x)| a * x).sum());
        let assembled = from_the_assembled(&arm, &state);
        largest([
            difference(&solved(&(a, b)), &wanted),
            difference(&back, &b),
            difference(&assembled, &wanted),
            missed(&arm, &state),
        ])
    });
}

#[test]
fn the_printed_matrix_gives_other_torques() {
    let arm = empty(STATED);
    let wanted = from_the_assembled(&arm, &STATED_2);
    let found = solved(&system(&arm, &STATED_2, -1.0));
    // The forces do not depend on rows 3 and 6.
    assert!(
        difference(&[found[0], found[1], found[3], found[4]], &[wanted[0], wanted[1], wanted[3], wanted[4]]) < 1e-12
    );
    assert_stated(&shares([found[2], found[5]], [wanted[2], wanted[5]]), &[1.9638, 1.9613]);
}
