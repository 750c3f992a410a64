//! Example 323: a link on a ball joint, and a uniform beam that turns about Z.

use super::support::{largest, moving, off, planar, shares};
use super::support_b::{
    DOWN_Y, G, STATED_3, State, arm, assert_equal, assert_stated, body, placed, planar_link, pushed, sizes, states,
    wrenches_in_base,
};
use crate::common::arms::{body as any_body, vector};
use crate::common::torque;
use dynamics_core::chapter::global::{residuals, weights};
use dynamics_core::{Body, Dynamics, JointKind, Wrench};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::Strategy;

/// Eq. 12.10 and 12.11 for any link on a ball joint: the loads on it from the joint and the environment, and the resulting
/// motion.
struct Ball {
    force: Vector3<f64>,
    moment_about_centre: Vector3<f64>,
    /// `m a_C`.
    pull: Vector3<f64>,
    /// `I_C alpha + omega x I_C omega`.
    euler: Vector3<f64>,
    /// As printed: `I_O alpha`.
    printed: Vector3<f64>,
    /// Residual of both equations computed by the core: left side less right side.
    missed: Wrench<f64>,
}

/// A ball joint modelled as three revolute joints through one point; the first two links have no mass.
fn on_a_ball(link: Body, tip: [f64; 3]) -> Dynamics<f64, 3> {
    let about = |axis, body| placed(JointKind::Revolute, Matrix3::identity(), [0.0; 3], axis, body);
    let z = [0.0, 0.0, 1.0];
    let joints = [about(z, Body::massless()), about([1.0, 0.0, 0.0], Body::massless()), about(z, link)];
    arm(&joints, tip, 0.0, DOWN_Y)
}

fn ball(link: Body, tip: [f64; 3], state: &State<3>, world: &Wrench<f64>) -> Ball {
    let dynamics = pushed(&on_a_ball(link, tip), &state.q, world.force, world.moment);
    let joints = wrenches_in_base(&dynamics, state);
    let joint = joints[2];
    let (posture, motion) = moving(&dynamics, state);
    let missed = residuals(&posture, &motion, &joints, &weights(&posture, &DOWN_Y), world)[2];
    let (n, m) = (posture.inner_arm(2), posture.outer_arm(2));
    let (inertia, moving) = (posture.links[2].inertia, motion[2]);
    let about_joint = inertia + (Matrix3::identity() * n.dot(&n) - n * n.transpose()) * link.mass;
    Ball {
        force: joint.force + world.force + DOWN_Y * link.mass,
        moment_about_centre: joint.moment + world.moment + n.cross(&joint.force) + m.cross(&world.force),
        pull: moving.acceleration * link.mass,
        euler: inertia * moving.alpha + moving.omega.cross(&(inertia * moving.omega)),
        printed: about_joint * moving.alpha,
        missed,
    }
}

#[test]
fn a_link_on_a_ball_joint_obeys_newton_and_euler_about_its_mass_centre() {
    let world = (vector(20.0), vector(5.0)).prop_map(|(force, moment)| Wrench { force, moment });
    assert_equal("12.10-12.11", (any_body(), vector(1.0), states::<3>(), world), |(link, tip, state, world)| {
        let Ball { force, moment_about_centre, pull, euler, missed, .. } = ball(link, tip.into(), &state, &world);
        let size = |v: Vector3<f64>| v.amax() + world.force.amax() + link.mass * G;
        largest([
            (force - pull).amax() / size(pull),
            (moment_about_centre - euler).amax() / size(euler),
            (missed.force - (force - pull)).amax() / size(pull),
            (missed.moment - (moment_about_centre - euler)).amax() / size(euler),
        ])
    });
}

#[test]
fn the_printed_moment_equation_is_wrong() {
    let link = body(3.0, [0.6, 0.1, 0.0], [0.05, 0.3, 0.32]);
    let world = Wrench { force: Vector3::new(4.0, 2.0, -3.0), moment: Vector3::new(0.5, -0.2, 1.0) };
    let Ball { moment_about_centre, euler, printed, missed, .. } = ball(link, [1.2, 0.0, 0.0], &STATED_3, &world);
    assert!(off(moment_about_centre, euler) < 1e-12 && missed.moment.amax() < 1e-12 * euler.amax());
    assert_stated(&[off(printed, moment_about_centre)], &[2.7286]);
}

/// The beam that turns about Z: mass, length, moments of inertia about its middle.
#[derive(Clone, Copy, Debug)]
struct Beam {
    m: f64,
    l: f64,
    i: [f64; 3],
}

const BEAM: Beam = Beam { m: 3.0, l: 1.2, i: [0.0, 0.36, 0.36] };
const TURNING: State<1> = State { q: [0.4], qd: [1.3], qdd: [2.1] };

impl Beam {
    fn dynamics(&self) -> Dynamics<f64, 1> {
        arm(&[planar_link(self.l, body(self.m, [-0.5 * self.l, 0.0, 0.0], self.i))], [0.0; 3], 0.0, DOWN_Y)
    }

    /// Eq. 12.18, corrected.
    fn acceleration(&self, state: &State<1>) -> Vector3<f64> {
        let (sin, cos) = state.q[0].sin_cos();
        let ([w], [e]) = (state.qd, state.qdd);
        planar(e * sin + w * w * cos, -e * cos + w * w * sin) * (-0.5 * self.l)
    }

    /// Eq. 12.25, corrected.
    fn force(&self, state: &State<1>) -> Vector3<f64> {
        let (sin, cos) = state.q[0].sin_cos();
        let ([w], [e]) = (state.qd, state.qdd);
        let half = 0.5 * self.m * self.l;
        planar(-half * (e * sin + w * w * cos), half * (e * cos - w * w * sin) + self.m * G)
    }

    /// Eq. 12.27, for a force at the joint.
    fn moment(&self, state: &State<1>, force: Vector3<f64>) -> Vector3<f64> {
        let (sin, cos) = state.q[0].sin_cos();
        let half = 0.5 * self.l;
        let turning = self.i[2] * state.qdd[0] + half * (force.y * cos - force.x * sin);
        Vector3::new(half * force.z * sin, -half * force.z * cos, turning)
    }

    /// Eq. 12.28.
    fn torque(&self, state: &State<1>) -> f64 {
        let Self { m, l, i } = *self;
        (i[2] + 0.25 * m * l * l) * state.qdd[0] + 0.5 * m * G * l * state.q[0].cos()
    }

    /// Eq. 12.23.
    fn turned_inertia(&self, q: f64) -> Matrix3<f64> {
        let ((sin, cos), [x, y, z]) = (q.sin_cos(), self.i);
        let beside = (x - y) * cos * sin;
        let (xx, yy) = (x * cos * cos + y * sin * sin, y * cos * cos + x * sin * sin);
        Matrix3::new(xx, beside, 0.0, beside, yy, 0.0, 0.0, 0.0, z)
    }
}

#[test]
fn the_beam_moves_as_the_core_says() {
    let beams = sizes::<5>().prop_map(|[m, l, x, y, z]| Beam { m, l, i: [x, y, z] });
    assert_equal("12.12-12.28", (beams, states::<1>()), |(beam, state)| {
        let dynamics = beam.dynamics();
        let (posture, motion) = moving(&dynamics, &state);
        let [joint] = wrenches_in_base(&dynamics, &state);
        let [tau] = torque(&dynamics, &state.q, &state.qd, &state.qdd);
        let (sin, cos) = state.q[0].sin_cos();
        let half = planar(cos, sin) * (0.5 * beam.l);
        let inertia = beam.turned_inertia(state.q[0]);
        let size = joint.force.amax() * beam.l;
        largest([
            off(posture.outer_arm(0), half),
            off(posture.inner_arm(0), -half),
            off(motion[0].acceleration, beam.acceleration(&state)),
            (posture.links[0].inertia - inertia).amax() / inertia.amax(),
            off(joint.force, beam.force(&state)),
            (joint.moment - beam.moment(&state, beam.force(&state))).amax() / size,
            (tau - beam.torque(&state)).abs() / size,
        ])
    });
}

#[test]
fn printed_acceleration_and_force_are_wrong_and_the_torque_is_right_all_the_same() {
    let Beam { m, l, .. } = BEAM;
    let (sin, cos) = TURNING.q[0].sin_cos();
    let ([w], [e]) = (TURNING.qd, TURNING.qdd);
    // 12.18 has `omega x (omega x r)` with a minus; both of its lines agree.
    let acceleration = planar(-e * sin + w * w * cos, e * cos + w * w * sin) * (0.5 * l);
    // 12.25
    let force = planar(-0.5 * m * l * (e * sin - w * w * cos), 0.5 * m * l * (e * cos + w * w * sin) + m * G);
    let dynamics = BEAM.dynamics();
    let (_, motion) = moving(&dynamics, &TURNING);
    let [joint] = wrenches_in_base(&dynamics, &TURNING);
    let found = [off(acceleration, motion[0].acceleration), off(force, joint.force)];
    assert_stated(&found, &[1.3112, 0.17662]);
    // The error of the force is along the beam, so it has no moment.
    let [torque] = shares([BEAM.moment(&TURNING, force).z], [joint.moment.z]);
    assert!(torque < 1e-12, "{torque:e}");
}
