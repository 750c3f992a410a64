//! Example 325: the turning beam with a mass at its free end.

use super::support::{largest, moving, off, planar, shares};
use super::support_b::{
    DOWN_Y, G, State, arm, assert_equal, assert_stated, body, planar_link, sizes, states, wrenches_in_base,
};
use crate::common::torque;
use dynamics_core::Dynamics;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::Strategy;

/// A beam of mass `m1` and moments of inertia `i` about its middle, and a point `m2` at its end.
#[derive(Clone, Copy, Debug)]
struct Beam {
    m1: f64,
    m2: f64,
    l: f64,
    i: [f64; 3],
}

const STATED: Beam = Beam { m1: 3.0, m2: 2.0, l: 1.2, i: [0.0, 0.36, 0.36] };
const TURNING: State<1> = State { q: [0.4], qd: [1.3], qdd: [2.1] };

impl Beam {
    fn dynamics(&self) -> Dynamics<f64, 1> {
        arm(&[planar_link(self.l, body(self.m1, [-0.5 * self.l, 0.0, 0.0], self.i))], [0.0; 3], self.m2, DOWN_Y)
    }

    fn mass(&self) -> f64 {
        self.m1 + self.m2
    }

    /// `r_x` of eq. 12.48.
    fn centre(&self) -> f64 {
        (self.m1 + 2.0 * self.m2) / (2.0 * self.mass()) * self.l
    }

    /// `I_3` of eq. 12.61.
    fn i3(&self) -> f64 {
        let r = self.centre();
        self.i[2] + self.m1 * (r - 0.5 * self.l).powi(2) + self.m2 * (self.l - r).powi(2)
    }

    /// The principal moments about the common mass centre (eq. 12.60, corrected: a term that changes `Iz` also changes
    /// `Iy`).
    fn moments(&self) -> [f64; 3] {
        let [x, y, z] = self.i;
        [x, y + self.i3() - z, self.i3()]
    }

    /// Eq. 12.65, corrected.
    fn force(&self, state: &State<1>) -> Vector3<f64> {
        self.acceleration(state) * self.mass() + Vector3::y() * (self.mass() * G)
    }

    /// Eq. 12.56, corrected.
    fn acceleration(&self, state: &State<1>) -> Vector3<f64> {
        let (sin, cos) = state.q[0].sin_cos();
        let ([w], [e]) = (state.qd, state.qdd);
        planar(e * sin + w * w * cos, -e * cos + w * w * sin) * -self.centre()
    }

    /// `Q_Z` of eq. 12.67 from a force at the joint.
    fn moment(&self, state: &State<1>, force: Vector3<f64>) -> f64 {
        let (sin, cos) = state.q[0].sin_cos();
        self.i3() * state.qdd[0] + self.centre() * (force.y * cos - force.x * sin)
    }

    /// Eq. 12.69.
    fn torque(&self, state: &State<1>) -> f64 {
        let Self { m1, m2, l, i } = *self;
        (0.25 * m1 * l * l + m2 * l * l + i[2]) * state.qdd[0] + (0.5 * m1 + m2) * G * l * state.q[0].cos()
    }
}

/// `R_Z diag R_Z^T` (eq. 12.63).
fn turned([x, y, z]: [f64; 3], q: f64) -> Matrix3<f64> {
    let (sin, cos) = q.sin_cos();
    let beside = (x - y) * cos * sin;
    let (xx, yy) = (x * cos * cos + y * sin * sin, y * cos * cos + x * sin * sin);
    Matrix3::new(xx, beside, 0.0, beside, yy, 0.0, 0.0, 0.0, z)
}

#[test]
fn the_loaded_beam_moves_as_the_core_says() {
    let beams = sizes::<6>().prop_map(|[m1, m2, l, x, y, z]| Beam { m1, m2, l, i: [x, y, z] });
    assert_equal("12.48-12.69", (beams, states::<1>()), |(beam, state)| {
        let dynamics = beam.dynamics();
        let (posture, motion) = moving(&dynamics, &state);
        let [joint] = wrenches_in_base(&dynamics, &state);
        let [tau] = torque(&dynamics, &state.q, &state.qd, &state.qdd);
        let (sin, cos) = state.q[0].sin_cos();
        let along = planar(cos, sin);
        let inertia = turned(beam.moments(), state.q[0]);
        let size = joint.force.amax() * beam.l;
        largest([
            off(posture.inner_arm(0), along * -beam.centre()),
            // From the common mass centre to the end. This distance may be short, so the error is relative to the length.
            (posture.outer_arm(0) - along * (beam.l - beam.centre())).amax() / beam.l,
            off(motion[0].acceleration, beam.acceleration(&state)),
            (posture.links[0].inertia - inertia).amax() / inertia.amax(),
            off(joint.force, beam.force(&state)),
            (joint.moment.z - beam.moment(&state, beam.force(&state))).abs() / size,
            (tau - beam.torque(&state)).abs() / size,
        ])
    });
}

#[test]
fn printed_intermediate_results_are_wrong() {
    let Beam { m1, m2, i: [x, y, z], .. } = STATED;
    let r = STATED.centre();
    let (sin, cos) = TURNING.q[0].sin_cos();
    let ([w], [e]) = (TURNING.qd, TURNING.qdd);
    let dynamics = STATED.dynamics();
    let (posture, motion) = moving(&dynamics, &TURNING);
    let [joint] = wrenches_in_base(&dynamics, &TURNING);
    let [tau] = torque(&dynamics, &TURNING.q, &TURNING.qd, &TURNING.qdd);
    let inertia = posture.links[0].inertia;
    // 12.56, result
    let acceleration = planar(-e * sin + w * w * cos, e * cos + w * w * sin) * r;
    // 12.60, and 12.63 with it
    let tensor = turned([x, y, STATED.i3()], TURNING.q[0]);
    // 12.64: half of the second mass, and only the weight of the first
    let newton = motion[0].acceleration * (m1 + 0.5 * m2) - DOWN_Y * m1;
    // 12.65
    let force = acceleration * STATED.mass() + Vector3::y() * (STATED.mass() * G);
    // 12.68: Iz instead of I3
    let moment = (z + STATED.mass() * r * r) * e + STATED.mass() * r * G * cos;
    let [moment] = shares([moment], [tau]);
    let found = [
        off(acceleration, motion[0].acceleration),
        (tensor - inertia).amax() / inertia.amax(),
        off(newton, joint.force),
        off(force, joint.force),
        moment,
    ];
    assert_stated(&found, &[1.3112, 0.46274, 0.3803, 0.24031, 0.01929]);
    // The error of the force in 12.65 is along the beam only, and with I3 the torque is correct.
    let [right] = shares([STATED.moment(&TURNING, force)], [tau]);
    assert!(right < 1e-12, "{right:e}");
}
