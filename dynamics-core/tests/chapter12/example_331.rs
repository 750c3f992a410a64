//! Example 331: joint forces of the general 2R arm, in base axes.

use super::support::{Letters, STATED, TwoLinks, largest, off, planar, shares, two_links};
use super::support_b::{G, STATED_2, State, assert_equal, assert_stated, wrenches_in_base};
use nalgebra::Vector3;

/// `0F_0` and `0F_1` of eq. 12.152-12.156, corrected; as in example 329, the payload has a weight but no inertia.
fn forces(arm: &TwoLinks, state: &State<2>) -> [Vector3<f64>; 2] {
    let Letters { sin1, cos1, sin12, cos12, w1, w12, e1, e12, .. } = Letters::of(state);
    let TwoLinks { l1, c1, c2, m1, m2, m0, .. } = *arm;
    let (x1, y1) = (-(e1 * sin1 + w1 * w1 * cos1), e1 * cos1 - w1 * w1 * sin1);
    let (x12, y12) = (-(e12 * sin12 + w12 * w12 * cos12), e12 * cos12 - w12 * w12 * sin12);
    let f1 = planar(m2 * (l1 * x1 + c2 * x12), m2 * (l1 * y1 + c2 * y12) + (m0 + m2) * G);
    let f0 = f1 + planar(m1 * c1 * x1, m1 * c1 * y1 + m1 * G);
    [f0, f1]
}

/// As printed; `g` is the signed component along y.
fn printed(arm: &TwoLinks, state: &State<2>) -> [Vector3<f64>; 2] {
    let Letters { sin1, cos1, sin12, cos12, w1, w2, e1, e2, .. } = Letters::of(state);
    let TwoLinks { l1, l2, c1, c2, m1, m2, m0, .. } = *arm;
    let (rest, inner, g) = (m2 * (l2 - c2), m1 * c1 + m2 * l1, -G);
    // 12.152-12.153; the last term of both has one factor of length too many.
    let f1 = planar(
        (rest * sin12 - m2 * l1 * sin1) * e1 - m2 * c2 * e2 * sin12
            + m2 * c2 * w2 * w2 * cos12
            + (rest * cos12 + m2 * l1 * cos1) * w1 * w1
            + 2.0 * rest * l1 * w1 * w2 * cos12,
        (-rest * cos12 + m2 * l1 * cos1) * e1
            + m2 * c2 * e2 * cos12
            + m2 * c2 * w2 * w2 * sin12
            + (-rest * sin12 + m2 * l1 * sin1) * w1 * w1
            - 2.0 * rest * l1 * w1 * w2 * sin12
            - (m0 + m2) * g,
    );
    // 12.155-12.156
    let f0 = planar(
        (rest * sin12 - inner * sin1) * e1 - m2 * c2 * e2 * sin12 - m2 * c2 * w2 * w2 * cos12
            + (-rest * cos12 + inner * cos1) * w1 * w1
            - 2.0 * rest * w1 * w2 * cos12,
        (-rest * cos12 + inner * cos1) * e1
            + m2 * c2 * e2 * cos12
            + m2 * c2 * w2 * w2 * sin12
            + (-rest * sin12 + inner * sin1) * w1 * w1
            - 2.0 * rest * l1 * w1 * w2 * sin12
            - (m0 + m1 + m2) * g,
    );
    [f0, f1]
}

fn of_the_recursion(arm: &TwoLinks, state: &State<2>) -> [Vector3<f64>; 2] {
    wrenches_in_base(&arm.with_static_payload(&state.q), state).map(|wrench| wrench.force)
}

#[test]
fn corrected_forces_are_those_of_the_recursion() {
    assert_equal("12.151-12.156", two_links(), |(arm, state)| {
        let (found, wanted) = (forces(&arm, &state), of_the_recursion(&arm, &state));
        largest([off(found[0], wanted[0]), off(found[1], wanted[1])])
    });
}

#[test]
fn printed_forces_are_wrong() {
    let (found, wanted) = (printed(&STATED, &STATED_2), of_the_recursion(&STATED, &STATED_2));
    let components = |f: [Vector3<f64>; 2]| [f[0].x, f[0].y, f[1].x, f[1].y];
    assert_stated(&shares(components(found), components(wanted)), &[1.6396, 0.05982, 1.8772, 0.06228]);
}
