//! Example 343: two point masses hanging from a ceiling, eq. 12.420-12.436.

use super::support_b::{
    Equations, G, STATED_2, State, arm, assert_equal, assert_stated, coupling, difference, larger, planar_link, point,
    sizes, states,
};
use crate::common::{torque, turns};
use dynamics_core::{Dynamics, Live, energy};
use nalgebra::{Matrix2, Vector2, Vector3};

/// Masses and lengths.
#[derive(Clone, Copy)]
struct Hanging {
    m: [f64; 2],
    l: [f64; 2],
}

const STATED: Hanging = Hanging { m: [3.0, 2.0], l: [0.7, 0.5] };

/// The arm for which printed forms are shown to be wrong.
pub(super) fn stated() -> Dynamics<f64, 2> {
    STATED.dynamics()
}

impl Hanging {
    /// The angles are zero when the arm hangs: gravity acts along x.
    fn dynamics(&self) -> Dynamics<f64, 2> {
        let link = |i: usize| planar_link(self.l[i], point(self.m[i], [0.0; 3]));
        arm(&[link(0), link(1)], [0.0; 3], 0.0, Vector3::new(G, 0.0, 0.0))
    }

    /// `m2 l1 l2 sin(theta_2)`
    fn h(&self, state: &State<2>) -> f64 {
        self.m[1] * self.l[0] * self.l[1] * state.q[1].sin()
    }

    /// 12.425-12.436, 12.431 and 12.434 corrected.
    fn equations(&self, state: &State<2>) -> Equations<2> {
        let ([m1, m2], [l1, l2], [q1, q2], [qd1, qd2]) = (self.m, self.l, state.q, state.qd);
        let d11 = (m1 + m2) * l1 * l1 + m2 * l2 * l2 + 2.0 * m2 * l1 * l2 * q2.cos();
        let d12 = m2 * l2 * (l2 + l1 * q2.cos());
        let [h1, h2] = self.symbols(state);
        let qd = Vector2::new(qd1, qd2);
        let c = Matrix2::from_rows(&[(h1 * qd).transpose(), (h2 * qd).transpose()]);
        let g2 = m2 * G * l2 * (q1 + q2).sin();
        let g1 = (m1 + m2) * G * l1 * q1.sin() + g2;
        Equations { d: Matrix2::new(d11, d12, d12, m2 * l2 * l2), c, g: Vector2::new(g1, g2) }
    }

    /// `H_1jk` (12.429, 12.430, 12.433) and `H_2jk` (12.431 with its sign turned, 12.432, and zero for 12.434).
    fn symbols(&self, state: &State<2>) -> [Matrix2<f64>; 2] {
        let h = self.h(state);
        [Matrix2::new(0.0, -h, -h, -h), Matrix2::new(h, 0.0, 0.0, 0.0)]
    }
}

#[test]
fn equations_of_motion_are_12_425_to_12_436() {
    assert_equal("example 343", (sizes(), states()), |([m1, m2, l1, l2], state)| {
        let arm = Hanging { m: [m1, m2], l: [l1, l2] };
        arm.equations(&state).error(&arm.dynamics(), &state)
    });
}

/// 12.420
#[test]
fn lagrangian_is_12_420() {
    assert_equal("12.420", (sizes(), states()), |([m1, m2, l1, l2], State { q, qd, .. }): ([f64; 4], State<2>)| {
        let dynamics = Hanging { m: [m1, m2], l: [l1, l2] }.dynamics();
        let w12 = qd[0] + qd[1];
        let kinetic = m1 * l1 * l1 * qd[0] * qd[0] / 2.0
            + m2 * (l1 * l1 * qd[0] * qd[0] + l2 * l2 * w12 * w12 + 2.0 * l1 * l2 * qd[0] * w12 * q[1].cos()) / 2.0;
        let potential = -m1 * G * l1 * q[0].cos() - m2 * G * (l1 * q[0].cos() + l2 * (q[0] + q[1]).cos());
        let found = [
            energy::kinetic(&dynamics, &turns(&q), &q, &qd, &Live::zero()),
            energy::potential(&dynamics, &turns(&q), &q, &Live::zero()),
        ];
        let speed = l1 * qd[0].abs() + l2 * (qd[0].abs() + qd[1].abs());
        let kinetic = (found[0] - kinetic).abs() / ((m1 + m2) * speed * speed);
        larger(kinetic, (found[1] - potential).abs() / ((m1 + m2) * G * (l1 + l2)))
    });
}

/// 12.421 and the corrected 12.422. As printed, 12.422 has wrong velocity terms and the wrong sign of the weight.
#[test]
fn torques_are_12_421_and_the_corrected_12_422() {
    let (Hanging { m: [m1, m2], l: [l1, l2] }, State { q: [q1, q2], qd: [qd1, qd2], qdd: [a1, a2] }) =
        (STATED, STATED_2);
    let (s2, c2) = q2.sin_cos();
    let tau1 = ((m1 + m2) * l1 * l1 + m2 * l2 * l2 + 2.0 * m2 * l1 * l2 * c2) * a1 + m2 * l2 * (l2 + l1 * c2) * a2
        - 2.0 * m2 * l1 * l2 * s2 * qd1 * qd2
        - m2 * l1 * l2 * s2 * qd2 * qd2
        + (m1 + m2) * G * l1 * q1.sin()
        + m2 * G * l2 * (q1 + q2).sin();
    let inertial = m2 * l2 * (l2 + l1 * c2) * a1 + m2 * l2 * l2 * a2;
    let tau2 = inertial + m2 * l1 * l2 * s2 * qd1 * qd1 + m2 * G * l2 * (q1 + q2).sin();
    let printed = inertial - 2.0 * m2 * l1 * l2 * s2 * qd1 * (qd1 + qd2) - m2 * G * l2 * (q1 + q2).sin();
    let found = torque::<f64, 2>(&stated(), &STATED_2.q, &STATED_2.qd, &STATED_2.qdd);
    assert!(difference(&found, &[tau1, tau2]) < 1e-14);
    assert_stated(&[difference(&[printed], &[found[1]])], &[1.792]);
}

/// 12.429-12.434 are the recursion's own velocity products: `H_ijk` from the velocities `e_j + e_k`, `e_j`, `e_k`. As printed,
/// 12.431 has the wrong sign and 12.434 is not zero. (12.423-12.424 use the letter D for four of these symbols.)
#[test]
fn velocity_symbols_are_the_corrected_12_429_to_12_434() {
    let dynamics = stated();
    let h = |qd: [f64; 2]| coupling(&dynamics, &STATED_2.q, &qd);
    let unit = |j: usize| if j == 0 { [1.0, 0.0] } else { [0.0, 1.0] };
    let symbol = |j: usize, k: usize| {
        let both = core::array::from_fn(|n| unit(j)[n] + unit(k)[n]);
        (h(both) - h(unit(j)) - h(unit(k))) / 2.0
    };
    let found: [Matrix2<f64>; 2] = core::array::from_fn(|i| Matrix2::from_fn(|j, k| symbol(j, k)[i]));
    let right = STATED.symbols(&STATED_2);
    for i in 0..2 {
        assert!((found[i] - right[i]).amax() < 1e-14 * STATED.h(&STATED_2));
    }
    let h = STATED.h(&STATED_2);
    let printed = Matrix2::new(-h, -h, -h, 0.0);
    assert_stated(&[difference(printed.as_slice(), found[1].as_slice())], &[2.0]);
}
