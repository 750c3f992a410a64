//! Exercises 18, 24, 29 and 36: a SCARA arm, with three vertical revolute joints and a slider down along the third's axis.
//!
//! The figure is in another chapter. Assumed: the third and the fourth link are balanced about their axis.

use super::support_b::{
    Equations, G, State, arm, assert_equal, body, larger, largest, placed, sizes, states, there_and_back,
    wrenches_in_base,
};
use dynamics_core::{Dynamics, JointKind};
use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3};

/// Masses of the links, lengths and mass centres of the first two, moments of inertia about vertical axes.
struct Scara {
    m: [f64; 4],
    l: [f64; 2],
    c: [f64; 2],
    i: [f64; 4],
}

impl Scara {
    fn of([m1, m2, m3, m4, l1, l2, c1, c2, i1, i2, i3, i4]: [f64; 12]) -> Self {
        Self { m: [m1, m2, m3, m4], l: [l1, l2], c: [c1, c2], i: [i1, i2, i3, i4] }
    }

    fn dynamics(&self) -> Dynamics<f64, 4> {
        let link = |k: usize, c: f64| body(self.m[k], [c, 0.0, 0.0], [0.0, 0.0, self.i[k]]);
        let (plain, turn, slide) = (Matrix3::identity(), JointKind::Revolute, JointKind::Prismatic);
        let joints = [
            placed(turn, plain, [0.0; 3], [0.0, 0.0, 1.0], link(0, self.c[0])),
            placed(turn, plain, [self.l[0], 0.0, 0.0], [0.0, 0.0, 1.0], link(1, self.c[1])),
            placed(turn, plain, [self.l[1], 0.0, 0.0], [0.0, 0.0, 1.0], link(2, 0.0)),
            placed(slide, plain, [0.0; 3], [0.0, 0.0, -1.0], link(3, 0.0)),
        ];
        arm(&joints, [0.0; 3], 0.0, Vector3::new(0.0, 0.0, -G))
    }

    /// By Lagrange's method: the planar arm of two joints with the outer links' mass at its end, a rotation common to all
    /// joints, and a slider that is not coupled with them.
    fn equations(&self, State { q, qd: [v1, v2, ..], .. }: &State<4>) -> Equations<4> {
        let Self { m: [m1, m2, m3, m4], l: [l1, l2], c: [c1, c2], i: [i1, i2, i3, i4] } = *self;
        let (s2, cos2) = q[1].sin_cos();
        let (end, spin, b) = (m3 + m4, i3 + i4, m2 * c2 + (m3 + m4) * l2);
        let d22 = i2 + m2 * c2 * c2 + end * l2 * l2 + spin;
        let d12 = d22 + l1 * b * cos2;
        let d11 = i1 + m1 * c1 * c1 + (m2 + end) * l1 * l1 + d22 + 2.0 * l1 * b * cos2;
        let d = Matrix4::new(d11, d12, spin, 0.0, d12, d22, spin, 0.0, spin, spin, spin, 0.0, 0.0, 0.0, 0.0, m4);
        let mut c = SMatrix::zeros();
        let h = -l1 * b * s2;
        (c[(0, 0)], c[(0, 1)], c[(1, 0)]) = (h * v2, h * (v1 + v2), -h * v1);
        Equations { d, c, g: SVector::from([0.0, 0.0, 0.0, -m4 * G]) }
    }
}

#[test]
fn equations_of_motion_of_the_scara_arm() {
    assert_equal("exercises 18, 24, 29", (sizes(), states()), |(x, state)| {
        let arm = Scara::of(x);
        arm.equations(&state).error(&arm.dynamics(), &state)
    });
}

/// Exercise 24: on this arm the forward recursion inverts the backward one.
#[test]
fn both_recursions_of_the_scara_arm() {
    assert_equal("exercise 24", (sizes(), states()), |(x, state)| there_and_back(&Scara::of(x).dynamics(), &state));
}

/// Exercise 18: the joints' whole forces, and the moments about the vertical axes, which the actuators give, in motion.
#[test]
fn joint_forces_of_the_scara_arm() {
    assert_equal("exercise 18", (sizes(), states()), |(x, state)| {
        let (arm, State { q, qd, qdd }) = (Scara::of(x), state);
        let sum = |x: &[f64; 4], k: usize| x[..=k].iter().sum::<f64>();
        let gained = |k: usize| {
            let ((s, c), w, a) = (sum(&q, k).sin_cos(), sum(&qd, k), sum(&qdd, k));
            Vector3::new(-s * a - c * w * w, c * a - s * w * w, 0.0)
        };
        let elbow = gained(0) * arm.l[0];
        let end = elbow + gained(1) * arm.l[1];
        let accelerations = [gained(0) * arm.c[0], elbow + gained(1) * arm.c[1], end, end - Vector3::z() * qdd[3]];
        let down = Vector3::new(0.0, 0.0, -G);
        let found = wrenches_in_base(&arm.dynamics(), &state);
        let turns = arm.equations(&state).torque(&qd, &qdd);
        let size = largest(&found);
        (0..4)
            .map(|k| {
                let force: Vector3<f64> = (k..4).map(|j| (accelerations[j] - down) * arm.m[j]).sum();
                let off = (found[k].force - force).amax() / size;
                if k < 3 { larger(off, (found[k].moment.z - turns[k]).abs() / size) } else { off }
            })
            .fold(0.0, larger)
    });
}

/// Exercise 36, 10 kg on the slider: every joint carries the weight beyond it and horizontal moments; only the slider's
/// actuator has to hold it.
#[test]
fn statics_of_the_scara_arm() {
    assert_equal("exercise 36", (sizes(), states()), |(x, state): (_, State<4>)| {
        let mut arm = Scara::of(x);
        arm.m[3] += 10.0;
        let ([m1, m2, m3, m4], [l1, l2], [c1, c2]) = (arm.m, arm.l, arm.c);
        let along = |angle: f64| Vector3::new(angle.cos(), angle.sin(), 0.0);
        let (first, second) = (along(state.q[0]), along(state.q[0] + state.q[1]));
        let outer = second * (m2 * c2 + (m3 + m4) * l2);
        // Mass times distance from joint 1 and from joint 2; the last two joints are directly above their loads.
        let moments = [first * (m1 * c1 + (m2 + m3 + m4) * l1) + outer, outer, Vector3::zeros(), Vector3::zeros()];
        let masses = [m1 + m2 + m3 + m4, m2 + m3 + m4, m3 + m4, m4];
        let down = Vector3::new(0.0, 0.0, -G);
        let found = wrenches_in_base(&arm.dynamics(), &State::still(state.q));
        let size = masses[0] * G * (1.0 + l1 + l2 + c1 + c2);
        (0..4)
            .map(|k| {
                let force = (found[k].force + down * masses[k]).amax();
                larger(force, (found[k].moment + moments[k].cross(&down)).amax()) / size
            })
            .fold(0.0, larger)
    });
}
