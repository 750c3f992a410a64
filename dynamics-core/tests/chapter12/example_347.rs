//! Example 347: the actuator's share of a joint's wrench, eq. 12.503-12.504 with the index of 12.212-12.213 corrected.

use super::support_b::{G, STATED_3, State, assert_equal, assert_stated, difference, posture, wrenches_in_base};
use crate::common::arms::{arm, joints, vector};
use crate::common::{torque, turns};
use dynamics_core::chapter::reactions::{Axes, joint_reactions};
use dynamics_core::chapter::statics::holding_torque;
use dynamics_core::{Dynamics, JointKind, Live, Scene, Wrench};
use nalgebra::Vector3;
use proptest::prelude::Strategy;

/// `k_{i-1} . F_{i-1}` of a prismatic joint, `k_{i-1} . M_{i-1}` of a revolute one.
#[test]
fn actuator_carries_the_joints_own_component() {
    let draws = (arm::<5>(), vector(12.0), joints(3.2))
        .prop_map(|(model, gravity, q)| (Dynamics::new(model, Scene::with_gravity(gravity, &model)), gravity, q));
    assert_equal("12.503-12.504", draws, |(dynamics, gravity, q)| {
        let still = [0.0; 5];
        let wrenches = wrenches_in_base(&dynamics, &State::still(q));
        let links = posture(&dynamics, &q).links;
        let along: [f64; 5] = core::array::from_fn(|i| match links[i].kind {
            JointKind::Prismatic => links[i].axis.dot(&wrenches[i].force),
            JointKind::Revolute => links[i].axis.dot(&wrenches[i].moment),
        });
        let held = holding_torque(&posture(&dynamics, &q), &gravity, &Wrench::zero());
        let tau = torque::<f64, 5>(&dynamics, &q, &still, &still);
        let shared = joint_reactions(&dynamics, &turns(&q), &q, &still, &still, &Live::zero(), Axes::Link);
        let actuators = shared.map(|reaction| reaction.actuator);
        difference(&along, &tau).max(difference(&held, &tau)).max(difference(&actuators, &tau))
    });
}

/// With `M_i`, the moment at the next joint, instead of `M_{i-1}`: this does not hold the arm. (There is no joint after
/// the last.)
#[test]
fn printed_index_of_12_503_and_12_504_is_wrong() {
    let dynamics = super::example_342::stated();
    let q = STATED_3.q;
    let wrenches = wrenches_in_base(&dynamics, &State::still(q));
    let links = posture(&dynamics, &q).links;
    let gravity = Vector3::new(0.0, 0.0, -G);
    let found = holding_torque(&posture(&dynamics, &q), &gravity, &Wrench::zero());
    assert!(difference(&found, &torque::<f64, 3>(&dynamics, &q, &[0.0; 3], &[0.0; 3])) < 1e-14);
    // The first joint of this arm is upright and carries no weight; the second does.
    let printed = links[1].axis.dot(&wrenches[2].moment);
    assert_stated(&[difference(&[printed], &[found[1]])], &[0.829]);
}
