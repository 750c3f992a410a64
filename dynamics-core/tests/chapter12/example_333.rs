//! Example 333: split of a joint's force and moment between its actuator and its bearings.

use super::support::{STATED, largest, moving, off};
use super::support_b::{DOWN_Y, STATED_2, State, assert_equal, assert_stated, pushed, states, wrenches_in_base};
use crate::common::arms::{arm, vector};
use crate::common::{torque, turns};
use dynamics_core::chapter::reactions::{Axes, joint_reactions};
use dynamics_core::{Dynamics, JointKind, Live, Scene, Term, Wrench};
use nalgebra::Vector3;
use proptest::prelude::Strategy;

/// An arm of mixed joints, its state, and the wrench of the environment at its tip, in base axes.
type Case<const N: usize> = (Dynamics<f64, N>, State<N>, Wrench<f64>);

fn cases<const N: usize>() -> impl Strategy<Value = Case<N>> {
    (arm::<N>(), vector(12.0), states::<N>(), vector(30.0), vector(5.0)).prop_map(
        |(model, gravity, state, force, moment)| {
            // The rotors act between motor and link, so they are not part of a joint's wrench.
            let scene = Scene { rotor: Term::Absent, ..Scene::with_gravity(gravity, &model) };
            let free = Dynamics::new(model, scene);
            (pushed(&free, &state.q, force, moment), state, Wrench { force, moment })
        },
    )
}

/// The component along the axis, which the actuator gives, and the rest, which the bearings give.
fn shares_of(kind: JointKind, axis: Vector3<f64>, wrench: &Wrench<f64>) -> (f64, Wrench<f64>) {
    let Wrench { force, moment } = *wrench;
    match kind {
        JointKind::Revolute => {
            let along = axis.dot(&moment);
            (along, Wrench { force, moment: moment - axis * along })
        }
        JointKind::Prismatic => {
            let along = axis.dot(&force);
            (along, Wrench { force: force - axis * along, moment })
        }
    }
}

/// The chapter's `(F_{i-1}, M_{i-1})` as sums over everything beyond a joint (eq. 12.1-12.2 added up, with the gyroscopic
/// term), without a recursion.
fn summed<const N: usize>((dynamics, state, load): &Case<N>) -> [Wrench<f64>; N] {
    let gravity = *dynamics.scene().gravity.value(&Vector3::zeros()).unwrap();
    let (posture, motion) = moving(dynamics, state);
    core::array::from_fn(|i| {
        let about = posture.links[i].origin;
        let mut sum =
            Wrench { force: -load.force, moment: -load.moment - (posture.tip.translation - about).cross(&load.force) };
        for (link, motion) in posture.links.iter().zip(&motion).skip(i) {
            let force = (motion.acceleration - gravity) * link.mass;
            sum.force += force;
            sum.moment += (link.centre - about).cross(&force)
                + link.inertia * motion.alpha
                + motion.omega.cross(&(link.inertia * motion.omega));
        }
        sum
    })
}

fn actuators_and_bearings<const N: usize>() {
    assert_equal(&format!("12.212-12.213 with index i-1, {N} joints"), cases::<N>(), |case| {
        let (dynamics, state, _) = &case;
        let tau: [f64; N] = torque(dynamics, &state.q, &state.qd, &state.qdd);
        let wrenches = wrenches_in_base(dynamics, state);
        let (posture, _) = moving(dynamics, state);
        let summed = summed(&case);
        let State { q, qd, qdd } = state;
        let shared = joint_reactions(dynamics, &turns(q), q, qd, qdd, &Live::zero(), Axes::Base);
        let size = wrenches.iter().fold(1.0_f64, |m, w| m.max(w.force.amax()).max(w.moment.amax()));
        (0..N).fold(0.0, |worst, i| {
            let link = &posture.links[i];
            let (actuator, bearings) = shares_of(link.kind, link.axis, &wrenches[i]);
            let (none, _) = shares_of(link.kind, link.axis, &bearings);
            largest([
                worst,
                (actuator - tau[i]).abs() / size,
                none.abs() / size,
                (shared[i].actuator - actuator).abs() / size,
                (shared[i].bearing.force - bearings.force).amax() / size,
                (shared[i].bearing.moment - bearings.moment).amax() / size,
                (wrenches[i].force - summed[i].force).amax() / size,
                (wrenches[i].moment - summed[i].moment).amax() / size,
            ])
        })
    });
}

#[test]
fn the_actuator_gives_the_component_of_the_wrench_that_the_joint_itself_carries() {
    actuators_and_bearings::<1>();
    actuators_and_bearings::<2>();
    actuators_and_bearings::<3>();
    actuators_and_bearings::<6>();
}

/// The printed index selects the wrench of the next joint; for the last joint this is the wrench of the arm on the environment.
#[test]
fn the_printed_index_names_another_joints_torque() {
    let dynamics = pushed(&STATED.dynamics(), &STATED_2.q, Vector3::new(7.0, -11.0, 0.0), Vector3::z() * 3.0);
    let tau: [f64; 2] = torque(&dynamics, &STATED_2.q, &STATED_2.qd, &STATED_2.qdd);
    let [_, second] = wrenches_in_base(&dynamics, &STATED_2);
    let at_the_tip = -3.0;
    assert_stated(&[(second.moment.z / tau[0] - 1.0).abs(), (at_the_tip / tau[1] - 1.0).abs()], &[0.82031, 1.1673]);
    // In a plane the bearings carry no moment, but all of the force.
    let (_, bearings) = shares_of(JointKind::Revolute, Vector3::z(), &second);
    assert!(off(bearings.moment + DOWN_Y, DOWN_Y) < 1e-12 && bearings.force == second.force);
}
