//! Example 346: recursive statics in the links' frames, eq. 12.497-12.502.

use super::support_b::{State, assert_equal, assert_stated, chain, difference, posture, pushed, wrenches_in_base};
use crate::common::arms::{arm, joints, vector};
use crate::common::turns;
use dynamics_core::chapter::posture::Posture;
use dynamics_core::chapter::statics::{Points, backward_in_links, forward_in_links};
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{Dynamics, Live, Scene, Wrench};
use nalgebra::Vector3;
use proptest::prelude::Strategy;

/// A random arm at rest under gravity and a wrench on its tip.
#[derive(Debug)]
struct Holding {
    dynamics: Dynamics<f64, 5>,
    gravity: Vector3<f64>,
    /// Wrench of the end-effector on the environment, in base axes.
    on_environment: Wrench<f64>,
    q: [f64; 5],
}

fn draws() -> impl Strategy<Value = Holding> {
    (arm(), vector(12.0), vector(30.0), vector(5.0), joints(3.2)).prop_map(|(model, gravity, force, moment, q)| {
        let free = Dynamics::new(model, Scene::with_gravity(gravity, &model));
        let dynamics = pushed(&free, &q, -force, -moment);
        Holding { dynamics, gravity, on_environment: Wrench { force, moment }, q }
    })
}

/// `(F_{i-1}, M_{i-1})` of every link in its own frame by 12.497-12.500, with the weight's moment about the point `about` of the link.
fn backward(holding: &Holding, about: fn(&Posture<f64, 5>, usize) -> Vector3<f64>) -> [Wrench<f64>; 5] {
    let posture = posture(&holding.dynamics, &holding.q);
    let tip = &posture.links[4].rotation;
    // (F_n, M_n), in the last link's frame.
    let mut beyond = Wrench {
        force: tip.transpose() * holding.on_environment.force,
        moment: tip.transpose() * holding.on_environment.moment,
    };
    let mut wrenches = [Wrench::zero(); 5];
    for i in (0..5).rev() {
        let link = &posture.links[i];
        let into = link.rotation.transpose();
        let weight = into * holding.gravity * link.mass;
        let moment_of_weight = (into * (link.centre - about(&posture, i))).cross(&weight);
        let across = into * (posture.end(i) - link.origin);
        // 12.497-12.498
        wrenches[i] = Wrench {
            force: beyond.force - weight,
            moment: beyond.moment - moment_of_weight + across.cross(&beyond.force),
        };
        if i > 0 {
            // 12.499-12.500: only the rotation of the transformation acts, because the fourth element is zero.
            let turn = posture.links[i - 1].rotation.transpose() * link.rotation;
            beyond = Wrench { force: turn * wrenches[i].force, moment: turn * wrenches[i].moment };
        }
    }
    wrenches
}

fn off(found: &[Wrench<f64>; 5], wanted: &[Wrench<f64>; 5]) -> f64 {
    let flat = |w: &[Wrench<f64>; 5]| -> Vec<f64> {
        w.iter().flat_map(|w| w.force.iter().chain(w.moment.iter()).copied().collect::<Vec<_>>()).collect()
    };
    difference(&flat(found), &flat(wanted))
}

/// The core's statics in the links' frames.
fn of_the_core(holding: &Holding) -> [Wrench<f64>; 5] {
    let Holding { dynamics, gravity, on_environment, q } = holding;
    let into = posture(dynamics, q).tip.rotation.transpose();
    let on_tip = Wrench { force: -(into * on_environment.force), moment: -(into * on_environment.moment) };
    backward_in_links(&chain(dynamics), &turns(q), q, gravity, &[&[]; 5], &on_tip)
}

fn general(holding: &Holding) -> [Wrench<f64>; 5] {
    let still = [0.0; 5];
    joint_wrenches(&holding.dynamics, &turns(&holding.q), &holding.q, &still, &still, &Live::zero())
}

/// 12.497-12.500 with the weight's moment about `O_{i-1}`.
#[test]
fn joint_wrenches_at_rest_are_12_497_to_12_500() {
    assert_equal("12.497-12.500", draws(), |holding| {
        let (own, wanted) = (backward(&holding, |posture, i| posture.links[i].origin), general(&holding));
        off(&own, &wanted).max(off(&of_the_core(&holding), &wanted))
    });
}

/// 12.501-12.502
#[test]
fn wrenches_turned_into_the_base_frame_are_12_501_and_12_502() {
    assert_equal("12.501-12.502", draws(), |holding| {
        let posture = posture(&holding.dynamics, &holding.q);
        let own = backward(&holding, |posture, i| posture.links[i].origin);
        let turned = core::array::from_fn(|i| {
            let rotation = posture.links[i].rotation;
            Wrench { force: rotation * own[i].force, moment: rotation * own[i].moment }
        });
        // From the base's wrench to the tip: the wrench that a link passes on is the next link's.
        let chain = chain(&holding.dynamics);
        let first = own[0];
        let outward = forward_in_links(&chain, &turns(&holding.q), &holding.q, &holding.gravity, &[&[]; 5], &first);
        let turned_outward = core::array::from_fn(|i| {
            let from = if i == 0 { first } else { outward[i - 1] };
            // A link passes on the wrench in its own axes.
            let rotation = posture.links[i.saturating_sub(1)].rotation;
            Wrench { force: rotation * from.force, moment: rotation * from.moment }
        });
        let wanted = wrenches_in_base(&holding.dynamics, &State::still(holding.q));
        off(&turned, &wanted).max(off(&turned_outward, &wanted))
    });
}

/// 12.465 and 12.510 compute the weight's moment about the base; 12.498 needs it about the link's own joint.
#[test]
fn weight_about_the_base_is_wrong_in_12_498() {
    let (dynamics, q) = (super::example_342::stated(), super::support_b::STATED_3.q);
    let posture = posture(&dynamics, &q);
    let link = &posture.links[2];
    let chain = chain(&dynamics);
    let gravity = Vector3::new(0.0, 0.0, -super::support_b::G);
    let own = backward_in_links(&chain, &turns(&q), &q, &gravity, &[&[]; 3], &Wrench::zero())[2];
    let found = own.in_parent(&link.rotation, &Vector3::zeros());
    let weight = Vector3::new(0.0, 0.0, -super::support_b::G) * link.mass;
    let right = -(link.centre - link.origin).cross(&weight);
    let printed = -link.centre.cross(&weight);
    assert!(difference(right.as_slice(), found.moment.as_slice()) < 1e-14);
    assert_stated(&[difference(printed.as_slice(), found.moment.as_slice())], &[3.215]);
}

/// The fourth element of a force or a moment is zero (12.466 prints 1 for a relative position): with 1 the transformation
/// would add the link's length to a force.
#[test]
fn fourth_element_of_a_free_vector_is_zero() {
    let (dynamics, q) = (super::example_342::stated(), super::support_b::STATED_3.q);
    let posture = posture(&dynamics, &q);
    let own = joint_wrenches(&dynamics, &turns(&q), &q, &[0.0; 3], &[0.0; 3], &Live::zero())[2];
    let link = &posture.links[2];
    let found = wrenches_in_base(&dynamics, &State::still(q))[2].force;
    let turned = link.rotation * own.force;
    assert!(difference(turned.as_slice(), found.as_slice()) < 1e-14);
    // 12.466 in the link's frame, from the base's origin to the joint's.
    let moved = link.rotation * (own.force - Points::in_link(&posture, 2).base);
    assert!((moved - turned - link.origin).amax() < 1e-13);
    assert_stated(&[difference(moved.as_slice(), found.as_slice())], &[0.01711]);
}
