//! Example 341: special cases of the planar arm of two revolute joints, eq. 12.332-12.362.

use super::example_340::Arm;
use super::support_b::{Equations, G, STATED_2, State, assert_equal, assert_stated, difference, larger, sizes, states};
use nalgebra::{Matrix2, Vector2};

/// Removes the effects that are absent in a special case.
type Special = fn(Arm) -> Arm;

/// The equations that the chapter prints for a case.
type Form = fn(&Arm, &State<2>) -> Equations<2>;

/// 12.333-12.342 with `g`: the links have no mass. Their moments of inertia remain, as those of the motors.
fn massless_arms(arm: &Arm, state: &State<2>) -> Equations<2> {
    let Arm { m12, m0, l: [l1, l2], iz: [iz1, iz2], .. } = *arm;
    let ([q1, q2], [qd1, qd2]) = (state.q, state.qd);
    let (s2, cos2, cos1, cos12) = (q2.sin(), q2.cos(), q1.cos(), (q1 + q2).cos());
    let d11 = 2.0 * m0 * l1 * l2 * cos2 + iz1 + iz2 + m12 * l1 * l1 + m0 * (l1 * l1 + l2 * l2);
    let d12 = m0 * l1 * l2 * cos2 + iz2 + m0 * l2 * l2;
    let h = m0 * l1 * l2 * s2;
    Equations {
        d: Matrix2::new(d11, d12, d12, iz2 + m0 * l2 * l2),
        c: Matrix2::new(-h * qd2, -h * (qd1 + qd2), h * qd1, 0.0),
        g: Vector2::new((m12 + m0) * l1 * cos1 + m0 * l2 * cos12, m0 * l2 * cos12) * G,
    }
}

/// 12.343-12.352 with `g`: only the links have mass.
fn massless_joints(arm: &Arm, state: &State<2>) -> Equations<2> {
    let Arm { m11, m21, l: [l1, _], c: [c1, c2], iz: [iz1, iz2], .. } = *arm;
    let ([q1, q2], [qd1, qd2]) = (state.q, state.qd);
    let (s2, cos2, cos1, cos12) = (q2.sin(), q2.cos(), q1.cos(), (q1 + q2).cos());
    let d11 = 2.0 * m21 * l1 * c2 * cos2 + iz1 + iz2 + m11 * c1 * c1 + m21 * (c2 * c2 + l1 * l1);
    let d12 = m21 * c2 * (l1 * cos2 + c2) + iz2;
    let h = m21 * l1 * c2 * s2;
    Equations {
        d: Matrix2::new(d11, d12, d12, iz2 + m21 * c2 * c2),
        c: Matrix2::new(-h * qd2, -h * (qd1 + qd2), h * qd1, 0.0),
        g: Vector2::new((m21 * l1 + m11 * c1) * cos1 + m21 * c2 * cos12, m21 * c2 * cos12) * G,
    }
}

/// 12.353-12.362 with 12.354, 12.359 and the `g` corrected: the same with mass centres at half length.
fn uniform_links(arm: &Arm, state: &State<2>) -> Equations<2> {
    let Arm { m11, m21, l: [l1, l2], iz: [iz1, iz2], .. } = *arm;
    let ([q1, q2], [qd1, qd2]) = (state.q, state.qd);
    let (s2, cos2, cos1, cos12) = (q2.sin(), q2.cos(), q1.cos(), (q1 + q2).cos());
    let d11 = m21 * l1 * l2 * cos2 + iz1 + iz2 + m11 * l1 * l1 / 4.0 + m21 * (l2 * l2 / 4.0 + l1 * l1);
    let d12 = m21 * l2 * (l1 * cos2 + l2 / 2.0) / 2.0 + iz2;
    let d21 = m21 * l1 * l2 * cos2 / 2.0 + iz2 + m21 * l2 * l2 / 4.0;
    let h = m21 * l1 * l2 * s2 / 2.0;
    Equations {
        d: Matrix2::new(d11, d12, d21, iz2 + m21 * l2 * l2 / 4.0),
        c: Matrix2::new(-h * qd2, -h * (qd1 + qd2), h * qd1, 0.0),
        g: Vector2::new((m21 + m11 / 2.0) * l1 * cos1 + m21 * l2 * cos12 / 2.0, m21 * l2 * cos12 / 2.0) * G,
    }
}

fn without_arms(arm: Arm) -> Arm {
    Arm { m11: 0.0, m21: 0.0, ..arm }
}

fn without_joints(arm: Arm) -> Arm {
    Arm { m12: 0.0, m0: 0.0, ..arm }
}

fn uniform(arm: Arm) -> Arm {
    Arm { c: arm.l.map(|l| l / 2.0), ..without_joints(arm) }
}

/// Compares a special case with the recursion and with the general equations of example 340.
fn check(what: &str, special: Special, form: Form) {
    assert_equal(what, (sizes(), states()), |(sizes, state)| {
        let arm = special(Arm::of(sizes));
        let (closed, general) = (form(&arm, &state), arm.equations(&state));
        let size = general.d.amax();
        let parts = [
            closed.error(&arm.dynamics(), &state),
            (closed.d - general.d).amax() / size,
            (closed.c - general.c).amax() / (3.0 * size),
        ];
        parts.into_iter().fold(0.0, larger)
    });
}

#[test]
fn massless_arms_are_12_333_to_12_342() {
    check("12.333-12.342", without_arms, massless_arms);
}

#[test]
fn massless_joints_are_12_343_to_12_352() {
    check("12.343-12.352", without_joints, massless_joints);
}

#[test]
fn uniform_links_are_12_353_to_12_362() {
    check("12.353-12.362", uniform, uniform_links);
}

/// 12.341-12.342, 12.351-12.352 and 12.361-12.362 lack `g`.
#[test]
fn printed_gravity_terms_lack_g() {
    let cases: [(Special, Form); 3] =
        [(without_arms, massless_arms), (without_joints, massless_joints), (uniform, uniform_links)];
    for (special, form) in cases {
        let arm = special(Arm::STATED);
        let found = Equations::of(&arm.dynamics(), &STATED_2.q, &STATED_2.qd).g;
        let printed = form(&arm, &STATED_2).g / G;
        let off = [difference(&[printed.x], &[found.x]), difference(&[printed.y], &[found.y])];
        assert_stated(&off, &[0.8981, 0.8981]);
    }
}

/// 12.354 multiplies both of its terms by the cosine and so is not symmetric to 12.355, which is correct.
#[test]
fn printed_12_354_is_wrong() {
    let arm = uniform(Arm::STATED);
    let found = Equations::of(&arm.dynamics(), &STATED_2.q, &STATED_2.qd).d;
    let printed = arm.m21 * arm.l[1] * (arm.l[0] + arm.l[1] / 2.0) * STATED_2.q[1].cos() / 2.0 + arm.iz[1];
    assert_stated(&[difference(&[printed], &[found.m12])], &[0.1175]);
}

/// 12.359 has a quarter, but 12.349 with `c2 = l2/2` gives a half.
#[test]
fn printed_12_359_is_half_of_what_it_should_be() {
    let arm = uniform(Arm::STATED);
    let found = Equations::of(&arm.dynamics(), &STATED_2.q, &STATED_2.qd).c;
    let printed = arm.m21 * arm.l[0] * arm.l[1] * STATED_2.qd[0] * STATED_2.q[1].sin() / 4.0;
    assert_stated(&[difference(&[printed], &[found.m21])], &[0.5]);
}
