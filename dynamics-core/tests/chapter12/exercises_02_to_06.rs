//! Exercises 2 to 5: a link's motion from the motion of the link two before it. Exercise 6: accelerations in different frames.

use super::support_b::{
    DOWN_Y, State, arm as planar, assert_equal, body, difference, larger, planar_link, posture, sizes, states,
};
use crate::common::arms::arm;
use dynamics_core::chapter::posture::Posture;
use dynamics_core::{Dynamics, JointKind, Scene};
use nalgebra::Vector3;

/// A joint's own speed or acceleration, split into turn and slide.
fn shares<const N: usize>(posture: &Posture<f64, N>, i: usize, rate: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (along, zero) = (posture.links[i].axis * rate, Vector3::zeros());
    match posture.links[i].kind {
        JointKind::Revolute => (along, zero),
        JointKind::Prismatic => (zero, along),
    }
}

/// `omega_i = omega_{i-2} + turn_{i-1} + turn_i`, with the velocity and the accelerations, in both directions,
/// for an arm of mixed joints.
#[test]
fn two_joints_at_a_time_relate_the_motions_of_links() {
    assert_equal("exercises 2-5", (arm::<5>(), states::<5>()), |(model, State { q, qd, qdd })| {
        let dynamics = Dynamics::new(model, Scene::free_space());
        let posture = posture(&dynamics, &q);
        let motion = posture.motion(&qd, &qdd);
        let mut worst = 0.0;
        for i in 2..5 {
            let (first, last) = (&motion[i - 2], &motion[i]);
            let ((turn1, slide1), (turn2, slide2)) = (shares(&posture, i - 1, qd[i - 1]), shares(&posture, i, qd[i]));
            let ((spin1, start1), (spin2, start2)) = (shares(&posture, i - 1, qdd[i - 1]), shares(&posture, i, qdd[i]));
            let arms = [
                posture.links[i - 1].origin - posture.links[i - 2].centre,
                posture.links[i].origin - posture.links[i - 1].origin,
                posture.links[i].centre - posture.links[i].origin,
            ];
            // Exercise 3
            let omegas = [first.omega, first.omega + turn1, first.omega + turn1 + turn2];
            // Exercise 5
            let middle = first.alpha + spin1 + first.omega.cross(&turn1);
            let alphas = [first.alpha, middle, middle + spin2 + omegas[1].cross(&turn2)];
            // Exercise 2
            let gained = slide1 + slide2 + (0..3).map(|k| omegas[k].cross(&arms[k])).sum::<Vector3<f64>>();
            // Exercise 4
            let coriolis = first.omega.cross(&slide1) * 2.0 + omegas[1].cross(&slide2) * 2.0;
            let pull = |k: usize| alphas[k].cross(&arms[k]) + omegas[k].cross(&omegas[k].cross(&arms[k]));
            let rise = start1 + start2 + coriolis + (0..3).map(pull).sum::<Vector3<f64>>();
            let pairs = [
                (omegas[2], last.omega),
                (alphas[2], last.alpha),
                (first.velocity + gained, last.velocity),
                (first.acceleration + rise, last.acceleration),
                // In the other direction the same increments are subtracted.
                (last.omega - turn1 - turn2, first.omega),
                (last.velocity - gained, first.velocity),
                (last.acceleration - rise, first.acceleration),
            ];
            for (found, wanted) in pairs {
                // Accelerations of several turning links reach 100 m/s^2.
                worst = larger(worst, (found - wanted).amax() / (100.0 + wanted.amax()));
            }
        }
        worst
    });
}

/// The planar arm of two revolute joints: absolute accelerations of the mass centres in the links' frames, and
/// accelerations of one link relative to the other.
#[test]
fn accelerations_of_the_planar_arm_in_different_frames() {
    assert_equal(
        "exercise 6",
        (sizes(), states()),
        |([l1, l2, c1, c2], State { q, qd, qdd }): ([f64; 4], State<2>)| {
            let links = [
                planar_link(l1, body(1.0, [c1 - l1, 0.0, 0.0], [0.0; 3])),
                planar_link(l2, body(1.0, [c2 - l2, 0.0, 0.0], [0.0; 3])),
            ];
            let posture = posture(&planar(&links, [0.0; 3], 0.0, DOWN_Y), &q);
            let motion = posture.motion(&qd, &qdd);
            let (s2, cos2) = q[1].sin_cos();
            let (w1, w12, a1, a12) = (qd[0], qd[0] + qd[1], qdd[0], qdd[0] + qdd[1]);
            let rotations = posture.links.map(|link| link.rotation);
            let [one, two] = [&motion[0], &motion[1]];

            // Absolute accelerations, in the frames of the links.
            let a2_in_1 = Vector3::new(
                -l1 * w1 * w1 - c2 * (a12 * s2 + w12 * w12 * cos2),
                l1 * a1 + c2 * (a12 * cos2 - w12 * w12 * s2),
                0.0,
            );
            let a1_in_2 = Vector3::new(-w1 * w1 * cos2 + a1 * s2, w1 * w1 * s2 + a1 * cos2, 0.0) * c1;
            let a2_in_2 = Vector3::new(
                l1 * (a1 * s2 - w1 * w1 * cos2) - c2 * w12 * w12,
                l1 * (a1 * cos2 + w1 * w1 * s2) + c2 * a12,
                0.0,
            );
            // Motion of C_2 relative to link 1, without the first joint's turn; and of C_1 relative to link 2, a turn by
            // -theta_2 about O_1. From O_1, C_1 is at c1 - l1 along the first link.
            let seen_from_1 = rotations[1] * Vector3::new(-c2 * qd[1] * qd[1], c2 * qdd[1], 0.0);
            let seen_from_2 = rotations[0] * Vector3::new(-(c1 - l1) * qd[1] * qd[1], -(c1 - l1) * qdd[1], 0.0);
            // Transport: a - a_O - alpha x r - omega x (omega x r) - 2 omega x v_rel, with r from the observer's origin.
            let transported = |frame: usize, origin: Vector3<f64>, origin_acceleration: Vector3<f64>, point: usize| {
                let (observer, r) = (&motion[frame], posture.links[point].centre - origin);
                let origin_velocity = one.omega.cross(&posture.end(0)) * if frame == 1 { 1.0 } else { 0.0 };
                let relative = motion[point].velocity - origin_velocity - observer.omega.cross(&r);
                motion[point].acceleration
                    - origin_acceleration
                    - observer.alpha.cross(&r)
                    - observer.omega.cross(&observer.omega.cross(&r))
                    - observer.omega.cross(&relative) * 2.0
            };
            let d1 = posture.end(0);
            let d1_acceleration = one.alpha.cross(&d1) + one.omega.cross(&one.omega.cross(&d1));
            let pairs = [
                (rotations[0].transpose() * two.acceleration, a2_in_1),
                (rotations[1].transpose() * one.acceleration, a1_in_2),
                (rotations[1].transpose() * two.acceleration, a2_in_2),
                (transported(0, Vector3::zeros(), Vector3::zeros(), 1), seen_from_1),
                (transported(1, d1, d1_acceleration, 0), seen_from_2),
                // C_1 rests in its own link.
                (transported(0, Vector3::zeros(), Vector3::zeros(), 0), Vector3::zeros()),
            ];
            let size = (l1 + l2 + c1 + c2) * 50.0;
            pairs
                .map(|(found, wanted)| difference((found - wanted).as_slice(), &[0.0; 3]) / size)
                .into_iter()
                .fold(0.0, larger)
        },
    );
}
