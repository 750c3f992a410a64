//! Example 327: joint torques with the joint forces eliminated.

use super::support::{TwoLinks, largest, moving, off, two_links};
use super::support_b::{DOWN_Y, assert_equal, difference, wrenches_in_base};
use crate::common::torque;

#[test]
fn torques_and_forces_are_those_of_the_recursion() {
    assert_equal("12.81-12.84", two_links(), |(arm, state)| {
        let arm = TwoLinks { m0: 0.0, ..arm };
        let dynamics = arm.dynamics();
        let (posture, motion) = moving(&dynamics, &state);
        // The printed `m g J` is the weight: `m g` with the vector g.
        let (weight1, weight2) = (DOWN_Y * arm.m1, DOWN_Y * arm.m2);
        let (pull1, pull2) = (motion[0].acceleration * arm.m1 - weight1, motion[1].acceleration * arm.m2 - weight2);
        let turn = |i: usize| posture.links[i].inertia * motion[i].alpha;
        // 12.81-12.82
        let q1 = turn(1) - posture.inner_arm(1).cross(&pull2);
        let q0 = q1 + turn(0) + posture.outer_arm(0).cross(&pull2) - posture.inner_arm(0).cross(&(pull1 + pull2));
        let [first, second] = wrenches_in_base(&dynamics, &state);
        let tau: [f64; 2] = torque(&dynamics, &state.q, &state.qd, &state.qdd);
        largest([
            difference(&[q0, q1].map(|q| q.z), &tau),
            difference(&[q0, q1].map(|q| q.z), &[first, second].map(|joint| joint.moment.z)),
            // 12.83-12.84
            off(pull2, second.force),
            off(pull1 + pull2, first.force),
        ])
    });
}
