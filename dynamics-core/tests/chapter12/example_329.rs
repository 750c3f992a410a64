//! Example 329: the general 2R arm with a payload, its kinematics and its joint torques.

use super::support::{Letters, STATED, TwoLinks, largest, moving, off, planar, shares, two_links};
use super::support_b::{G, STATED_2, State, assert_equal, assert_stated, difference};
use crate::common::torque;
use dynamics_core::chapter::posture::BaseFrameMotion;
use nalgebra::Vector3;

/// Accelerations of `C_1`, the elbow, the tip and `C_2`.
type Accelerations = [Vector3<f64>; 4];

/// Eq. 12.121-12.128, corrected.
fn accelerations(arm: &TwoLinks, state: &State<2>) -> Accelerations {
    let Letters { sin1, cos1, sin12, cos12, w1, w12, e1, e12, .. } = Letters::of(state);
    let first = |r: f64| planar(-r * (e1 * sin1 + w1 * w1 * cos1), r * (e1 * cos1 - w1 * w1 * sin1));
    let second = |r: f64| planar(-r * (e12 * sin12 + w12 * w12 * cos12), r * (e12 * cos12 - w12 * w12 * sin12));
    let elbow = first(arm.l1);
    [first(arm.c1), elbow, elbow + second(arm.l2), elbow + second(arm.c2)]
}

/// As printed: `omega x (omega x r)` with a minus, and the second joint's relative velocity instead of the link's own.
fn printed_accelerations(arm: &TwoLinks, state: &State<2>) -> Accelerations {
    let Letters { sin1, cos1, sin12, cos12, w1, w2, w12, e1, e2, e12, .. } = Letters::of(state);
    let TwoLinks { l1, l2, c1, c2, .. } = *arm;
    // 12.121-12.122
    let first = |r: f64| planar(-r * e1 * sin1 + r * w1 * w1 * cos1, r * e1 * cos1 + r * w1 * w1 * sin1);
    // 12.124-12.125
    let tip = planar(
        -l1 * e1 * sin1 - l2 * e2 * sin12 + l1 * w1 * w1 * cos1 + l2 * w2 * w2 * cos12,
        l1 * e1 * cos1 + l2 * e2 * cos12 + l1 * w1 * w1 * sin1 + l2 * w2 * w2 * sin12,
    );
    // 12.127-12.128
    let (turning, spinning) = ((l2 - c2) * e12 - l2 * e2, (l2 - c2) * w12 * w12 - l2 * w2 * w2);
    let centre = planar(
        turning * sin12 - l1 * e1 * sin1 + l1 * w1 * w1 * cos1 - spinning * cos12,
        -turning * cos12 + l1 * e1 * cos1 + l1 * w1 * w1 * sin1 - spinning * sin12,
    );
    [first(c1), first(l1), tip, centre]
}

/// The same from the core: to get elbow and tip, the links' masses are put at their ends.
fn accelerations_of_the_core(arm: &TwoLinks, state: &State<2>) -> Accelerations {
    let centres = |arm: &TwoLinks| moving(&arm.dynamics(), state).1.map(|link| link.acceleration);
    let empty = TwoLinks { m0: 0.0, ..*arm };
    let [c1, c2] = centres(&empty);
    let [elbow, tip] = centres(&TwoLinks { c1: arm.l1, c2: arm.l2, ..empty });
    [c1, elbow, tip, c2]
}

/// `(Q0, Q1)` of eq. 12.135 and 12.133, corrected. As in the example, the payload has a weight but no inertia.
fn torques(arm: &TwoLinks, state: &State<2>) -> [f64; 2] {
    let Letters { cos1, sin2, cos2, cos12, w1, w2, e1, e2, .. } = Letters::of(state);
    let TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, m0 } = *arm;
    let q1 = (iz2 + m2 * c2 * c2 + m2 * l1 * c2 * cos2) * e1
        + (iz2 + m2 * c2 * c2) * e2
        + m2 * l1 * c2 * w1 * w1 * sin2
        + (m2 * c2 + m0 * l2) * G * cos12;
    let q0 = (iz1 + iz2 + m1 * c1 * c1 + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * cos2)) * e1
        + (iz2 + m2 * c2 * (c2 + l1 * cos2)) * e2
        - m2 * l1 * c2 * (2.0 * w1 * w2 + w2 * w2) * sin2
        + (m0 * l1 + m1 * c1 + m2 * l1) * G * cos1
        + (m0 * l2 + m2 * c2) * G * cos12;
    [q0, q1]
}

/// Contribution of the payload's inertia to the torques.
fn payload_torques(arm: &TwoLinks, state: &State<2>) -> [f64; 2] {
    let Letters { sin2, cos2, w1, w2, e1, e2, .. } = Letters::of(state);
    let TwoLinks { l1, l2, m0, .. } = *arm;
    let q1 = m0 * l2 * ((l2 + l1 * cos2) * e1 + l2 * e2 + l1 * w1 * w1 * sin2);
    let q0 = m0
        * ((l1 * l1 + l2 * l2 + 2.0 * l1 * l2 * cos2) * e1 + (l2 * l2 + l1 * l2 * cos2) * e2
            - l1 * l2 * (2.0 * w1 * w2 + w2 * w2) * sin2);
    [q0, q1]
}

/// Eq. 12.135 and 12.133 as printed, with `g` the signed component along y.
fn printed_torques(arm: &TwoLinks, state: &State<2>) -> [f64; 2] {
    let Letters { cos1, sin2, cos2, cos12, w1, w2, e1, e2, .. } = Letters::of(state);
    let TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, m0 } = *arm;
    let g = -G;
    let q1 = (iz2 + m2 * c2 * c2 - m2 * l2 * c2 + m2 * l1 * c2 * cos2) * e1 + (iz2 + m2 * c2 * c2) * e2
        - m2 * c2 * l1 * w1 * w1 * sin2
        - (m2 * c2 + m0 * l2) * g * cos12;
    let q0 = (iz1 + iz2 + m1 * c1 * c1 + m2 * (l1 * l1 + c2 * c2 - l2 * c2 + l1 * (2.0 * c2 - l2) * cos2)) * e1
        + (iz2 + m2 * c2 * (c2 + l1 * cos2)) * e2
        - m2 * l1 * l2 * w1 * w1 * sin2
        + m2 * l1 * c2 * w2 * w2 * sin2
        - 2.0 * m2 * l1 * (l2 - c2) * w1 * w2 * sin2
        - (m0 * l1 + m1 * c1 + m2 * l1) * g * cos1
        - (m0 * l2 + m2 * c2) * g * cos12;
    [q0, q1]
}

#[test]
fn points_are_where_the_core_has_them() {
    assert_equal("12.104-12.116, 12.129-12.130", two_links(), |(arm, state)| {
        let arm = TwoLinks { m0: 0.0, ..arm };
        let (posture, motion) = moving(&arm.dynamics(), &state);
        let Letters { sin1, cos1, sin12, cos12, w1, w12, e1, e12, .. } = Letters::of(&state);
        let (along1, along2) = (planar(cos1, sin1), planar(cos12, sin12));
        let TwoLinks { l1, l2, c1, c2, iz1, iz2, .. } = arm;
        // 12.129-12.130: the bodies here have Ix = Iy, so a turn about z does not change the tensor.
        let turned = |iz: f64| Vector3::new(0.5 * iz, 0.5 * iz, iz);
        largest([
            off(posture.inner_arm(0), -along1 * c1),
            off(posture.inner_arm(1), -along2 * c2),
            // The part of a link beyond its mass centre may be short, so the error is relative to the link's length.
            (posture.outer_arm(0) - along1 * (l1 - c1)).amax() / l1,
            (posture.outer_arm(1) - along2 * (l2 - c2)).amax() / l2,
            off(posture.links[0].centre, along1 * c1),
            off(posture.links[1].centre, along1 * l1 + along2 * c2),
            off(posture.end(0), along1 * l1),
            off(posture.end(1), along1 * l1 + along2 * l2),
            off(posture.links[0].inertia.diagonal(), turned(iz1)),
            off(posture.links[1].inertia.diagonal(), turned(iz2)),
            // 12.117-12.120
            off(motion[0].omega, Vector3::z() * w1),
            off(motion[1].omega, Vector3::z() * w12),
            off(motion[0].alpha, Vector3::z() * e1),
            off(motion[1].alpha, Vector3::z() * e12),
        ])
    });
}

#[test]
fn corrected_accelerations_are_those_of_the_core() {
    assert_equal("12.121-12.128", two_links(), |(arm, state)| {
        let (found, wanted) = (accelerations(&arm, &state), accelerations_of_the_core(&arm, &state));
        largest(core::array::from_fn::<_, 4, _>(|i| off(found[i], wanted[i])))
    });
}

#[test]
fn printed_accelerations_are_wrong() {
    let (printed, wanted) = (printed_accelerations(&STATED, &STATED_2), accelerations_of_the_core(&STATED, &STATED_2));
    let found: [f64; 4] = core::array::from_fn(|i| off(printed[i], wanted[i]));
    assert_stated(&found, &[1.3112, 1.3112, 1.7322, 1.8909]);
    // 12.126, with the correct acceleration of the tip: only the sign of `omega x (omega x m_2)` is wrong.
    let (posture, motion) = moving(&TwoLinks { m0: 0.0, ..STATED }.dynamics(), &STATED_2);
    let (m2, BaseFrameMotion { omega, alpha, .. }) = (posture.outer_arm(1), motion[1]);
    let (turning, spinning) = (alpha.cross(&m2), omega.cross(&omega.cross(&m2)));
    assert!(off(wanted[2] - turning - spinning, wanted[3]) < 1e-12);
    assert_stated(&[off(wanted[2] - turning + spinning, wanted[3])], &[0.13615]);
}

#[test]
fn corrected_torques_are_those_of_the_recursion() {
    assert_equal("12.133, 12.135 with the payload as a weight", two_links(), |(arm, state)| {
        let wanted: [f64; 2] = torque(&arm.with_static_payload(&state.q), &state.q, &state.qd, &state.qdd);
        difference(&torques(&arm, &state), &wanted)
    });
    assert_equal("12.133, 12.135 with the payload as a body", two_links(), |(arm, state)| {
        let wanted: [f64; 2] = torque(&arm.dynamics(), &state.q, &state.qd, &state.qdd);
        let (links, payload) = (torques(&arm, &state), payload_torques(&arm, &state));
        difference(&[links[0] + payload[0], links[1] + payload[1]], &wanted)
    });
}

#[test]
fn printed_torques_are_wrong_and_so_is_a_payload_without_inertia() {
    let State { q, qd, qdd } = STATED_2;
    let weight: [f64; 2] = torque(&STATED.with_static_payload(&q), &q, &qd, &qdd);
    let body: [f64; 2] = torque(&STATED.dynamics(), &q, &qd, &qdd);
    let printed = printed_torques(&STATED, &STATED_2);
    assert_stated(&shares(printed, weight), &[0.07157, 0.38959]);
    assert_stated(&shares(weight, body), &[0.11067, 0.36779]);
}
