//! Example 332: backward recursive Newton-Euler for a 2R arm of uniform rods, in the links' own frames.

use super::support::{Letters, TwoLinks, largest, moving, off, planar, shares, two_links};
use super::support_b::{G, STATED_2, State, assert_equal, assert_stated, difference, pushed};
use crate::common::turns;
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{Live, Wrench};
use nalgebra::Vector3;
use proptest::prelude::Strategy;

/// Force and moment of the environment on the arm at the tip, in base axes.
#[derive(Clone, Copy, Debug)]
struct Load {
    fx: f64,
    fy: f64,
    m: f64,
}

const LOAD: Load = Load { fx: 7.0, fy: -11.0, m: 3.0 };

fn rods() -> TwoLinks {
    TwoLinks::rods(1.0, 0.8, 4.0, 2.5)
}

/// `2F_1`, `2M_1z`, `1F_0`, `1M_0z`.
#[derive(Clone, Copy, Debug)]
struct Joints {
    f1: Vector3<f64>,
    m1: f64,
    f0: Vector3<f64>,
    m0: f64,
}

/// Eq. 12.203-12.211, corrected.
fn joints(arm: &TwoLinks, state: &State<2>, load: &Load) -> Joints {
    let Letters { sin1, cos1, sin2, cos2, sin12, cos12, w1, w2, w12, e1, e12, e2, .. } = Letters::of(state);
    let TwoLinks { l1, l2, m1, m2, .. } = *arm;
    let Load { fx, fy, m } = *load;
    Joints {
        // 12.203-12.204
        f1: planar(
            m2 * (-0.5 * l2 * w12 * w12 - l1 * w1 * w1 * cos2 + l1 * e1 * sin2) - fx * cos12 - (fy - m2 * G) * sin12,
            m2 * (0.5 * l2 * e12 + l1 * w1 * w1 * sin2 + l1 * e1 * cos2) + fx * sin12 - (fy - m2 * G) * cos12,
        ),
        // 12.206
        m1: -m + l2 * fx * sin12 - l2 * fy * cos12
            + m2 * l2 * l2 * e12 / 3.0
            + 0.5 * m2 * l1 * l2 * (e1 * cos2 + w1 * w1 * sin2)
            + 0.5 * m2 * G * l2 * cos12,
        f0: planar(
            // 12.208
            -fx * cos1
                - (fy - (m1 + m2) * G) * sin1
                - 0.5 * l2 * m2 * (e12 * sin2 + w12 * w12 * cos2)
                - l1 * (0.5 * m1 + m2) * w1 * w1,
            // 12.209
            fx * sin1 - (fy - (m1 + m2) * G) * cos1
                + 0.5 * l2 * m2 * (e12 * cos2 - w12 * w12 * sin2)
                + l1 * (0.5 * m1 + m2) * e1,
        ),
        // 12.211: the torque of eq. 12.279 plus the contribution of the load.
        m0: (m1 * l1 * l1 / 3.0 + m2 * (l1 * l1 + l1 * l2 * cos2 + l2 * l2 / 3.0)) * e1
            + m2 * (0.5 * l1 * l2 * cos2 + l2 * l2 / 3.0) * e2
            - m2 * l1 * l2 * sin2 * (w1 * w2 + 0.5 * w2 * w2)
            + (0.5 * m1 + m2) * G * l1 * cos1
            + 0.5 * m2 * G * l2 * cos12
            - m
            - fy * (l1 * cos1 + l2 * cos12)
            + fx * (l1 * sin1 + l2 * sin12),
    }
}

/// As printed.
fn printed(arm: &TwoLinks, state: &State<2>, load: &Load) -> Joints {
    let Letters { sin1, cos1, sin2, cos2, sin12, cos12, w1, w12, e1, e12, .. } = Letters::of(state);
    let TwoLinks { l1, l2, m1, m2, .. } = *arm;
    let Load { fx, fy, m } = *load;
    // The angle `2 theta_2 + theta_1` of eq. 12.208-12.209 results from turning the second link's weight in the wrong direction.
    let (sin122, cos122) = (2.0 * state.q[1] + state.q[0]).sin_cos();
    Joints {
        f1: planar(
            -0.5 * l2 * m2 * w12 * w12 - fx * cos12 - (fy - G * m2) * sin12,
            0.5 * l2 * m2 * e12 + fx * sin12 - (fy + G * m2) * cos12,
        ),
        m1: -m + l2 * fx * sin12 - l2 * fy * cos12 + l2 * l2 * m2 * e12 / 3.0 - 0.5 * G * l2 * m2 * cos12,
        f0: planar(
            -fx * cos1 - (fy - G * m1) * sin1 - 0.5 * l2 * m2 * (e12 * sin2 + w12 * w12 * cos2) + G * m2 * sin122
                - 0.5 * l1 * m1 * w1 * w1,
            fx * sin1 - (fy + G * m1) * cos1 + 0.5 * l2 * m2 * (e12 * cos2 - w12 * w12 * sin2) - G * m2 * cos122
                + 0.5 * l1 * m1 * e1,
        ),
        m0: -m + l2 * l2 * m2 * e12 / 3.0 + l1 * l1 * m1 * e1 / 3.0
            - (fy * l2 + 0.5 * G * l2 * m2) * cos12
            - 0.5 * l1 * m1 * G * cos1
            + fx * l2 * sin12,
    }
}

fn of_the_recursion(arm: &TwoLinks, state: &State<2>, load: &Load) -> Joints {
    let State { q, qd, qdd } = state;
    let loaded = pushed(&arm.dynamics(), q, planar(load.fx, load.fy), Vector3::z() * load.m);
    let [first, second]: [Wrench<f64>; 2] = joint_wrenches(&loaded, &turns(q), q, qd, qdd, &Live::zero());
    Joints { f1: second.force, m1: second.moment.z, f0: first.force, m0: first.moment.z }
}

/// `1a_1` and `2a_2` (eq. 12.194 and 12.196, corrected: the second includes the elbow's own acceleration).
fn accelerations(arm: &TwoLinks, state: &State<2>) -> [Vector3<f64>; 2] {
    let Letters { sin2, cos2, w1, w12, e1, e12, .. } = Letters::of(state);
    let TwoLinks { l1, l2, .. } = *arm;
    [
        planar(-0.5 * l1 * w1 * w1, 0.5 * l1 * e1),
        planar(
            -0.5 * l2 * w12 * w12 - l1 * w1 * w1 * cos2 + l1 * e1 * sin2,
            0.5 * l2 * e12 + l1 * w1 * w1 * sin2 + l1 * e1 * cos2,
        ),
    ]
}

/// The core's accelerations and gravity, in the links' frames.
fn in_links(arm: &TwoLinks, state: &State<2>) -> ([Vector3<f64>; 2], [Vector3<f64>; 2]) {
    let (posture, motion) = moving(&arm.dynamics(), state);
    let into = |i: usize, v: &Vector3<f64>| posture.links[i].rotation.transpose() * v;
    let gravity = Vector3::new(0.0, -G, 0.0);
    ([0, 1].map(|i| into(i, &motion[i].acceleration)), [0, 1].map(|i| into(i, &gravity)))
}

fn loaded_rods() -> impl Strategy<Value = (TwoLinks, State<2>, Load)> {
    (two_links(), -20.0..20.0, -20.0..20.0, -5.0..5.0).prop_map(|((arm, state), fx, fy, m)| {
        (TwoLinks::rods(arm.l1, arm.l2, arm.m1, arm.m2), state, Load { fx, fy, m })
    })
}

#[test]
fn corrected_accelerations_and_gravity_are_those_of_the_core() {
    assert_equal("12.194-12.199", loaded_rods(), |(arm, state, _)| {
        let Letters { sin1, cos1, sin12, cos12, .. } = Letters::of(&state);
        let (wanted, gravity) = in_links(&arm, &state);
        let found = accelerations(&arm, &state);
        largest([
            off(found[0], wanted[0]),
            off(found[1], wanted[1]),
            // 12.198-12.199, corrected
            off(planar(-G * sin1, -G * cos1), gravity[0]),
            off(planar(-G * sin12, -G * cos12), gravity[1]),
        ])
    });
}

#[test]
fn printed_accelerations_and_gravity_are_wrong() {
    let arm = rods();
    let Letters { sin2, cos2, sin12, cos12, w12, e12, .. } = Letters::of(&STATED_2);
    let (wanted, gravity) = in_links(&arm, &STATED_2);
    let (posture, _) = moving(&arm.dynamics(), &STATED_2);
    let (n1, n2) = (posture.inner_arm(0), posture.inner_arm(1));
    assert!(off(-n1 + posture.outer_arm(0) - n2, posture.links[1].centre) < 1e-12);
    let found = [
        // 12.196-12.197
        off(planar(-0.5 * arm.l2 * w12 * w12, 0.5 * arm.l2 * e12), wanted[1]),
        // 12.198, for `0g = -g J` and for `0g = +g J`
        off(planar(-G * sin2, G * cos2), gravity[0]),
        off(planar(G * sin2, -G * cos2), gravity[0]),
        // 12.199 likewise
        off(planar(-G * sin12, G * cos12), gravity[1]),
        off(planar(G * sin12, -G * cos12), gravity[1]),
        // 12.191: `m_2` is printed instead of `m_1`, which leads from the first mass centre to the elbow
        off(-n1 + posture.outer_arm(1) - n2, posture.links[1].centre),
    ];
    assert_stated(&found, &[0.92931, 1.6749, 1.2733, 0.55523, 2.0, 0.34388]);
}

#[test]
fn corrected_joint_forces_and_moments_are_those_of_the_recursion() {
    assert_equal("12.200-12.211", loaded_rods(), |(arm, state, load)| {
        let (found, wanted) = (joints(&arm, &state, &load), of_the_recursion(&arm, &state, &load));
        largest([
            off(found.f1, wanted.f1),
            off(found.f0, wanted.f0),
            difference(&[found.m0, found.m1], &[wanted.m0, wanted.m1]),
        ])
    });
}

#[test]
fn printed_joint_forces_and_moments_are_wrong() {
    let (found, wanted) = (printed(&rods(), &STATED_2, &LOAD), of_the_recursion(&rods(), &STATED_2, &LOAD));
    let all = |j: Joints| [j.f1.x, j.f1.y, j.m1, j.f0.x, j.f0.y, j.m0];
    assert_stated(&shares(all(found), all(wanted)), &[0.04438, 0.84447, 0.76705, 1.0039, 1.057, 1.1792]);
}
