//! An arm at rest, compared with the dynamics of an arm that does not move.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::common::arms::vector;
use crate::common::moving::{Moving, fixed, moving, worst, worst_over_arms};
use crate::common::{into_base, numbers_of, pinned, pinned_rounding, relative_error, torque, turns};
use dynamics_core::chapter::global::{residuals, weights};
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::statics::{
    ExternalLoad, Point, Points, backward, backward_in_links, forward, forward_in_links, holding_torque,
};
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{Body, Dh, Frame, Inertia, JointKind, JointSpec, Limits, Live, Model, Rotor, Tool, Wrench};
use nalgebra::{Matrix3, Vector3};

const POINTS: [Point; 4] = [Point::MassCentre, Point::InnerOrigin, Point::OuterOrigin, Point::Base];

/// Two loads on every link in base axes, with moments about points that change from link to link.
fn loads<const N: usize>(case: &Moving<N>) -> [[ExternalLoad<f64>; 2]; N] {
    let mut vectors = fixed((vector(20.0), vector(5.0)), 2 * N);
    let posture = case.posture();
    core::array::from_fn(|i| {
        core::array::from_fn(|k| {
            let (force, moment) = vectors.next().unwrap();
            // Turned with the link, so that no two arms have the same loads.
            let turn = |v| posture.links[i].rotation * v;
            ExternalLoad { force: turn(force), moment: turn(moment), about: POINTS[(i + k) % 4] }
        })
    })
}

fn slices<const N: usize>(loads: &[[ExternalLoad<f64>; 2]; N]) -> [&[ExternalLoad<f64>]; N] {
    loads.each_ref().map(|loads| &loads[..])
}

fn difference<const N: usize>(found: &[Wrench<f64>; N], wanted: &[Wrench<f64>; N]) -> f64 {
    relative_error(&numbers_of(found), &numbers_of(wanted))
}

/// Backward statics compared with the recursion at rest: wrenches, and torques.
fn against_dynamics<const N: usize>(case: &Moving<N>) -> f64 {
    let (posture, still) = (case.posture(), [0.0; N]);
    let recursion = joint_wrenches(&case.dynamics(), &turns(&case.q), &case.q, &still, &still, &Live::zero());
    let found = backward(&posture, &case.gravity, &[&[]; N], &case.push());
    let held = holding_torque(&posture, &case.gravity, &case.push());
    let tau = torque::<f64, N>(&case.dynamics(), &case.q, &still, &still);
    // A torque may be tiny compared with the wrenches: its error is relative to the wrenches.
    let size = numbers_of(&recursion).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let off = held.iter().zip(&tau).fold(0.0, |most: f64, (h, t)| most.max((h - t).abs()));
    difference(&found, &into_base(&posture, &recursion)).max(off / size)
}

#[test]
fn statics_is_dynamics_at_rest() {
    pinned_rounding("statics against dynamics at rest", worst_over_arms!(against_dynamics), 1.16e-15);
}

/// From the tip to the base and back to the tip, with loads: every intermediate wrench is reproduced, and the tip's.
fn round_trip<const N: usize>(case: &Moving<N>) -> f64 {
    let (posture, loads) = (case.posture(), loads(case));
    let inward = backward(&posture, &case.gravity, &slices(&loads), &case.push());
    let outward = forward(&posture, &case.gravity, &slices(&loads), &inward[0]);
    let met: [Wrench<f64>; N] = core::array::from_fn(|i| if i == 0 { inward[0] } else { outward[i - 1] });
    let tip = numbers_of(&[outward[N - 1] + case.push()]).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let size = numbers_of(&inward).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    difference(&met, &inward).max(tip / size)
}

#[test]
fn outward_undoes_inward() {
    pinned_rounding("outward after inward", worst_over_arms!(round_trip), 1.10e-15);
}

/// Loads and wrenches in link axes: turned into the base frame they equal those computed there, inward and outward.
fn in_links<const N: usize>(case: &Moving<N>) -> f64 {
    let (chain, posture, loads, turn) = (case.chain(), case.posture(), loads(case), turns(&case.q));
    let local: [[ExternalLoad<f64>; 2]; N] = core::array::from_fn(|i| {
        let into = posture.links[i].rotation.transpose();
        loads[i].map(|load| ExternalLoad { force: into * load.force, moment: into * load.moment, ..load })
    });
    for i in 0..N {
        let (link, [own, base]) = (&posture.links[i], [Points::in_link(&posture, i), Points::in_base(&posture, i)]);
        for point in POINTS {
            let turned = link.origin + link.rotation * own.at(point);
            assert!((turned - base.at(point)).amax() < 1e-13, "{point:?} of link {i}");
        }
    }
    let inward = backward(&posture, &case.gravity, &slices(&loads), &case.push());
    let found = backward_in_links(&chain, &turn, &case.q, &case.gravity, &slices(&local), &case.contact);
    let outward = forward(&posture, &case.gravity, &slices(&loads), &inward[0]);
    let found_outward = forward_in_links(&chain, &turn, &case.q, &case.gravity, &slices(&local), &found[0]);
    // The last outward wrench may be small compared with those whose difference it is.
    let all = |a: &[Wrench<f64>; N], b: &[Wrench<f64>; N]| numbers_of(&[*a, *b].concat());
    relative_error(&all(&into_base(&posture, &found), &into_base(&posture, &found_outward)), &all(&inward, &outward))
}

#[test]
fn link_frames_and_base_frame_agree() {
    pinned_rounding("link frames against base frame", worst_over_arms!(in_links), 1.54e-15);
}

/// Every load's moment about every point in turn gives the same joint wrenches. Also checks the balance about mass centres,
/// 12.458-12.459.
fn about_every_point<const N: usize>(case: &Moving<N>) -> f64 {
    let (posture, loads) = (case.posture(), loads(case));
    let wanted = backward(&posture, &case.gravity, &slices(&loads), &case.push());
    let moved = |to: Point| -> [[ExternalLoad<f64>; 2]; N] {
        core::array::from_fn(|i| loads[i].map(|load| load.moved(to, &Points::in_base(&posture, i))))
    };
    let worst = POINTS
        .iter()
        .map(|&point| difference(&backward(&posture, &case.gravity, &slices(&moved(point)), &case.push()), &wanted))
        .fold(0.0, f64::max);
    let mut external = weights(&posture, &case.gravity);
    for (sum, loads) in external.iter_mut().zip(moved(Point::MassCentre)) {
        for load in loads {
            *sum = *sum + Wrench { force: load.force, moment: load.moment };
        }
    }
    for (link, weight) in posture.links.iter().zip(weights(&posture, &case.gravity)) {
        let load = ExternalLoad::weight(link.mass, &case.gravity);
        assert_eq!((load.force, load.moment, load.about), (weight.force, weight.moment, Point::MassCentre));
    }
    let rest = posture.motion(&[0.0; N], &[0.0; N]);
    let missed = residuals(&posture, &rest, &wanted, &external, &case.push());
    let most = |w: &[Wrench<f64>]| numbers_of(w).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    worst.max(most(&missed) / most(&wanted))
}

#[test]
fn a_moment_may_be_about_any_point_that_is_named() {
    pinned_rounding("reference points", worst_over_arms!(about_every_point), 4.79e-16);
}

/// Weight with the moment printed in 12.4, 12.465 and 12.510, `r x m g`, in an equation that needs it about this point.
fn printed<const N: usize>(
    posture: &Posture<f64, N>,
    gravity: &Vector3<f64>,
    about: Point,
) -> [[ExternalLoad<f64>; 1]; N] {
    posture.links.map(|link| {
        let force = gravity * link.mass;
        [ExternalLoad { force, moment: link.centre.cross(&force), about }]
    })
}

/// Torques at rest with the printed moments, relative to the correct ones; their error is known.
fn printed_error(case: &Moving<6>, about: Point) -> f64 {
    let posture = case.posture();
    let loads = printed(&posture, &case.gravity, about);
    let joint = backward(&posture, &Vector3::zeros(), &loads.each_ref().map(|l| &l[..]), &case.push());
    // As corrected: moved from the mass centre to the point that the equation needs.
    let weight = |i: usize| ExternalLoad::weight(posture.links[i].mass, &case.gravity);
    let moved: [_; 6] = core::array::from_fn(|i| [weight(i).moved(about, &Points::in_base(&posture, i))]);
    let right = backward(&posture, &Vector3::zeros(), &moved.each_ref().map(|l| &l[..]), &case.push());
    assert!(difference(&right, &backward(&posture, &case.gravity, &[&[]; 6], &case.push())) < 1e-13);
    let size = right.iter().fold(0.0, |most: f64, w| most.max(w.moment.amax()));
    let mut off = Vector3::zeros();
    for i in (0..6).rev() {
        let weight = case.gravity * posture.links[i].mass;
        off -= Points::in_base(&posture, i).at(about).cross(&weight);
        assert!((joint[i].moment - right[i].moment - off).amax() < 1e-12 * size);
        assert!((joint[i].force - right[i].force).amax() < 1e-12 * size);
    }
    (0..6).map(|i| (joint[i].moment - right[i].moment).amax()).fold(0.0, f64::max) / size
}

#[test]
fn the_printed_moments_of_weight_are_off_by_the_weights_about_the_point_that_the_equation_wants() {
    pinned("r x m g in 12.459, about the mass centre", worst(|case| printed_error(case, Point::MassCentre)), 2.05);
    pinned("r x m g in 12.456, about the inner origin", worst(|case| printed_error(case, Point::InnerOrigin)), 2.50);
    assert!(worst(|case| printed_error(case, Point::Base)) < 1e-12, "about the base, where it belongs");

    // 12.472, outward, needs it about the outer origin.
    let off = worst::<6>(|case| {
        let posture = case.posture();
        let loads = printed(&posture, &case.gravity, Point::OuterOrigin);
        let first = backward(&posture, &case.gravity, &[&[]; 6], &case.push())[0];
        let found = forward(&posture, &Vector3::zeros(), &loads.each_ref().map(|l| &l[..]), &first)[5];
        let expected = (0..6).fold(Vector3::zeros(), |sum: Vector3<f64>, i| {
            sum + posture.end(i).cross(&(case.gravity * posture.links[i].mass))
        });
        let error = found.moment + case.push().moment;
        assert!((error - expected).amax() < 1e-12 * first.moment.amax().max(expected.amax()));
        error.amax() / first.moment.amax()
    });
    pinned("r x m g in 12.472, about the outer origin", off, 4.10);
}

/// Uniform rods in a vertical plane.
fn rods<const N: usize>(rods: [(f64, f64); N]) -> Chain<f64, N> {
    let joints = rods.map(|(length, mass)| JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: length, ..Dh::default() }),
        body: Body { mass, com: Vector3::new(-length / 2.0, 0.0, 0.0), inertia: Matrix3::zeros() },
        rotor: Rotor::default(),
        limits: Limits::none(),
    });
    Chain::new(&Model::new_unphysical(&joints, &Tool::default()).unwrap(), &Inertia::zero())
}

/// Forces and moments of 12.482-12.493; `(fx, fy)` and `mz` are the wrench of the arm on the environment, in base axes.
#[test]
fn four_rods_in_a_plane_are_held_as_in_example_345() {
    let (l, m) = ([0.8, 0.7, 0.5, 0.3], [4.0, 3.0, 2.0, 1.0]);
    let q = [0.3, 0.5, -0.9, 0.7];
    let (g, fx, fy, mz) = (9.81, 11.0, -7.0, 3.0);
    let chain = rods(core::array::from_fn(|i| (l[i], m[i])));
    let posture = chain.posture(&turns(&q), &q);
    let gravity = Vector3::new(0.0, -g, 0.0);
    let tip = Wrench { force: Vector3::new(-fx, -fy, 0.0), moment: Vector3::new(0.0, 0.0, -mz) };
    let joint = backward(&posture, &gravity, &[&[]; 4], &tip);

    let mut wanted = [[0.0; 3]; 4];
    let (mut carried, mut moment) = (0.0, mz);
    for i in (0..4).rev() {
        let theta: f64 = q[..=i].iter().sum();
        moment += l[i] * (fy + carried) * theta.cos() - l[i] * fx * theta.sin() + 0.5 * g * l[i] * m[i] * theta.cos();
        carried += g * m[i];
        wanted[i] = [fx, fy + carried, moment];
    }
    let found = joint.map(|w| [w.force.x, w.force.y, w.moment.z]);
    assert!(relative_error(found.as_flattened(), wanted.as_flattened()) < 1e-15, "{found:?} {wanted:?}");
    assert!(joint.iter().all(|w| w.force.z.abs() + w.moment.x.abs() + w.moment.y.abs() < 1e-15));
}

/// Exercise 32: 24 kg and 18 kg on 1 m each, 14 kg at the end, 30 and 45 degrees from the vertical.
#[test]
fn two_rods_with_a_load_are_held_as_in_exercise_32() {
    let chain = rods([(1.0, 24.0), (1.0, 18.0)]);
    let q = [(30.0_f64 - 90.0).to_radians(), 45.0_f64.to_radians()];
    let g = 9.81;
    let tip = Wrench { force: Vector3::new(0.0, -14.0 * g, 0.0), moment: Vector3::zeros() };
    let found = holding_torque(&chain.posture(&turns(&q), &q), &Vector3::new(0.0, -g, 0.0), &tip);
    let (c1, c12) = (q[0].cos(), (q[0] + q[1]).cos());
    let second = (18.0 / 2.0 + 14.0) * g * c12;
    let first = (24.0 / 2.0 + 18.0 + 14.0) * g * c1 + second;
    assert!(relative_error(&found, &[first, second]) < 1e-15, "{found:?}");
}

#[test]
fn a_prismatic_joint_is_held_by_a_force() {
    let case = fixed(moving::<6>(), 64)
        .find(|case| case.model.links().iter().any(|link| link.kind == JointKind::Prismatic))
        .unwrap();
    let tau = torque::<f64, 6>(&case.dynamics(), &case.q, &[0.0; 6], &[0.0; 6]);
    let found = holding_torque(&case.posture(), &case.gravity, &case.push());
    assert!(relative_error(&found, &tau) < 1e-13, "{found:?} {tau:?}");
}
