//! Example 328: the second motor's mass on the first link, and a mass at the end of the second.

use super::support::{Letters, STATED, TwoLinks, largest, link, link_with_motor, moving, off, two_links};
use super::support_b::{
    DOWN_Y, STATED_2, State, arm, assert_equal, assert_stated, difference, planar_link, wrenches_in_base,
};
use crate::common::torque;
use dynamics_core::Dynamics;
use nalgebra::Vector3;

/// Here `m12` is the arm's own first mass and `m22` its payload; the links' own masses are `m11 = m1`, `m21 = m2`.
struct Massive {
    arm: TwoLinks,
    m12: f64,
    m22: f64,
}

impl Massive {
    fn of(arm: TwoLinks) -> Self {
        Self { arm, m12: 0.7 * arm.m1 + 0.1, m22: arm.m0 }
    }

    fn dynamics(&self) -> Dynamics<f64, 2> {
        let TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, .. } = self.arm;
        let first = planar_link(l1, link_with_motor(link(m1, c1 - l1, iz1), self.m12));
        let second = planar_link(l2, link_with_motor(link(m2, c2 - l2, iz2), self.m22));
        arm(&[first, second], [0.0; 3], 0.0, DOWN_Y)
    }

    /// Mass centre (from the joint) and moment of inertia about it, for a link with a point mass at its end.
    fn shifted(l: f64, c: f64, own: f64, iz: f64, point: f64) -> (f64, f64) {
        let centre = (own * c + point * l) / (own + point);
        (centre, iz + own * (c - centre).powi(2) + point * (l - centre).powi(2))
    }

    /// Joint torques from eq. 12.85-12.90 (`m1 = m11 + m12`, `m2 = m21 + m22`), with these moments of inertia.
    fn torques(&self, state: &State<2>, inertia: [f64; 2]) -> [Vector3<f64>; 2] {
        let (posture, motion) = moving(&self.dynamics(), state);
        let TwoLinks { m1, m2, .. } = self.arm;
        let pull1 = (motion[0].acceleration - DOWN_Y) * (m1 + self.m12);
        let pull2 = (motion[1].acceleration - DOWN_Y) * (m2 + self.m22);
        let Letters { e1, e12, .. } = Letters::of(state);
        let q1 = Vector3::z() * (inertia[1] * e12) - posture.inner_arm(1).cross(&pull2);
        let own = Vector3::z() * (inertia[0] * e1);
        let q0 = q1 + own + posture.outer_arm(0).cross(&pull2) - posture.inner_arm(0).cross(&(pull1 + pull2));
        [q0, q1]
    }

    fn moved_inertia(&self) -> [f64; 2] {
        let TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, .. } = self.arm;
        [Self::shifted(l1, c1, m1, iz1, self.m12).1, Self::shifted(l2, c2, m2, iz2, self.m22).1]
    }
}

#[test]
fn torques_are_those_of_the_recursion_with_the_inertia_about_the_new_mass_centres() {
    assert_equal("12.85-12.90", two_links(), |(arm, state)| {
        let massive = Massive::of(arm);
        let dynamics = massive.dynamics();
        let [q0, q1] = massive.torques(&state, massive.moved_inertia());
        let [first, second] = wrenches_in_base(&dynamics, &state);
        let (posture, _) = moving(&dynamics, &state);
        let c = |i: usize| posture.inner_arm(i).dot(&posture.inner_arm(i)).sqrt();
        let TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, .. } = massive.arm;
        let centres =
            [Massive::shifted(l1, c1, m1, iz1, massive.m12).0, Massive::shifted(l2, c2, m2, iz2, massive.m22).0];
        largest([
            off(q0, first.moment),
            off(q1, second.moment),
            difference(&[q0.z, q1.z], &torque::<f64, 2>(&dynamics, &state.q, &state.qd, &state.qdd)),
            (c(0) / centres[0] - 1.0).abs(),
            (c(1) / centres[1] - 1.0).abs(),
        ])
    });
}

#[test]
fn inertia_left_about_the_old_mass_centres_is_wrong() {
    let massive = Massive::of(STATED);
    let [first, second] = wrenches_in_base(&massive.dynamics(), &STATED_2);
    let [q0, q1] = massive.torques(&STATED_2, [STATED.iz1, STATED.iz2]);
    assert_stated(&[off(q0, first.moment), off(q1, second.moment)], &[0.01054, 0.01054]);
}
