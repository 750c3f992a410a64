//! Example 344: two bars by transformation matrices and pseudo inertias, eq. 12.437-12.454.

use super::support_b::{
    DOWN_Y, Equations, G, STATED_2, State, arm, assert_equal, assert_stated, body, difference, planar_link, sizes,
    states,
};
use dynamics_core::Dynamics;
use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

/// Masses and lengths.
struct Bars {
    m: [f64; 2],
    l: [f64; 2],
}

const STATED: Bars = Bars { m: [3.0, 2.0], l: [0.7, 0.5] };

/// `z` axis of a revolute joint: the velocity coefficient matrix of eq. 12.440.
fn delta() -> Matrix4<f64> {
    let mut delta = Matrix4::zeros();
    (delta[(0, 1)], delta[(1, 0)]) = (-1.0, 1.0);
    delta
}

/// 12.437-12.438
fn transformation(q: f64, l: f64) -> Matrix4<f64> {
    let (s, c) = q.sin_cos();
    Matrix4::new(c, -s, 0.0, l * c, s, c, 0.0, l * s, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
}

impl Bars {
    fn dynamics(&self) -> Dynamics<f64, 2> {
        let bar = |i: usize| {
            let inertia = self.m[i] * self.l[i] * self.l[i] / 12.0;
            planar_link(self.l[i], body(self.m[i], [-self.l[i] / 2.0, 0.0, 0.0], [0.0, inertia, inertia]))
        };
        arm(&[bar(0), bar(1)], [0.0; 3], 0.0, DOWN_Y)
    }

    /// 12.443-12.444
    fn pseudo_inertia(&self, i: usize) -> Matrix4<f64> {
        let (m, l) = (self.m[i], self.l[i]);
        let mut inertia = Matrix4::zeros();
        inertia[(0, 0)] = m * l * l / 3.0;
        (inertia[(0, 3)], inertia[(3, 0)]) = (-m * l / 2.0, -m * l / 2.0);
        inertia[(3, 3)] = m;
        inertia
    }

    /// `0T_r` with each joint `i` differentiated `times[i]` times (eq. 12.440-12.442 and the second derivatives).
    fn derivative(&self, r: usize, q: &[f64; 2], times: [usize; 2]) -> Matrix4<f64> {
        (0..=r).fold(Matrix4::identity(), |place, i| {
            let turned = (0..times[i]).fold(transformation(q[i], self.l[i]), |t, _| delta() * t);
            place * turned
        })
    }

    /// The equations of motion by 12.417-12.419.
    fn traces(&self, State { q, qd, .. }: &State<2>) -> Equations<2> {
        let first = |r: usize, i: usize| {
            let mut times = [0; 2];
            times[i] += 1;
            self.derivative(r, q, times)
        };
        let second = |r: usize, j: usize, k: usize| {
            let mut times = [0; 2];
            times[j] += 1;
            times[k] += 1;
            self.derivative(r, q, times)
        };
        let d = Matrix2::from_fn(|i, j| {
            (i.max(j)..2).map(|r| (first(r, j) * self.pseudo_inertia(r) * first(r, i).transpose()).trace()).sum()
        });
        let symbol = |i: usize, j: usize, k: usize| -> f64 {
            (i.max(j).max(k)..2)
                .map(|r| (second(r, j, k) * self.pseudo_inertia(r) * first(r, i).transpose()).trace())
                .sum()
        };
        let c = Matrix2::from_fn(|i, j| (0..2).map(|k| symbol(i, j, k) * qd[k]).sum());
        let down = Vector4::new(0.0, -G, 0.0, 0.0);
        let centre = |r: usize| Vector4::new(-self.l[r] / 2.0, 0.0, 0.0, 1.0);
        let g = Vector2::from_fn(|i, _| -(i..2).map(|r| self.m[r] * down.dot(&(first(r, i) * centre(r)))).sum::<f64>());
        Equations { d, c, g }
    }

    /// 12.445, the corrected 12.446, 12.447, 12.451, the corrected 12.452 and 12.453.
    fn equations(&self, State { q: [q1, q2], qd: [qd1, qd2], .. }: &State<2>) -> Equations<2> {
        let ([m1, m2], [l1, l2], (s2, c2)) = (self.m, self.l, q2.sin_cos());
        let d11 = m1 * l1 * l1 / 3.0 + m2 * (l1 * l1 + l2 * l2 / 3.0) + m2 * l1 * l2 * c2;
        let d12 = m2 * l2 * l2 / 3.0 + m2 * l1 * l2 * c2 / 2.0;
        let h = m2 * l1 * l2 * s2 / 2.0;
        let g2 = m2 * G * l2 * (q1 + q2).cos() / 2.0;
        let g1 = m1 * G * l1 * q1.cos() / 2.0 + g2 + m2 * G * l1 * q1.cos();
        Equations {
            d: Matrix2::new(d11, d12, d12, m2 * l2 * l2 / 3.0),
            c: Matrix2::new(-h * qd2, -h * (qd1 + qd2), h * qd1, 0.0),
            g: Vector2::new(g1, g2),
        }
    }
}

#[test]
fn equations_of_motion_are_the_corrected_12_454() {
    assert_equal("example 344", (sizes(), states()), |([m1, m2, l1, l2], state)| {
        let bars = Bars { m: [m1, m2], l: [l1, l2] };
        bars.equations(&state).error(&bars.dynamics(), &state)
    });
}

/// The traces of 12.417-12.418 give `D` and, element by element, the Christoffel symbols; 12.419 gives `G`.
#[test]
fn traces_of_transformations_are_the_equations_of_motion() {
    assert_equal("12.437-12.453", (sizes(), states()), |([m1, m2, l1, l2], state)| {
        let bars = Bars { m: [m1, m2], l: [l1, l2] };
        bars.traces(&state).error(&bars.dynamics(), &state)
    });
}

/// 12.451
#[test]
fn velocity_vector_is_12_451() {
    let ([_, m2], [l1, l2], [_, q2], [qd1, qd2]) = (STATED.m, STATED.l, STATED_2.q, STATED_2.qd);
    let h = m2 * l1 * l2 * q2.sin();
    let wanted = [-h * qd2 * qd2 / 2.0 - h * qd1 * qd2, h * qd1 * qd1 / 2.0];
    let c = Equations::by_traces(&STATED.dynamics(), &STATED_2.q, &STATED_2.qd).c;
    let found: [f64; 2] = (c * Vector2::from(STATED_2.qd)).into();
    assert!(difference(&found, &wanted) < 1e-14);
}

/// 12.446 differentiates by the first joint twice and so prints a part of `D_11`; 12.452 uses the second link's length instead of
/// the first's.
#[test]
fn printed_12_446_and_12_452_are_wrong() {
    let found = Equations::by_traces(&STATED.dynamics(), &STATED_2.q, &STATED_2.qd);
    let ([m1, m2], [l1, l2], [q1, q2]) = (STATED.m, STATED.l, STATED_2.q);
    let d12 = m2 * l2 * l2 / 3.0 + m2 * l1 * l1 + m2 * l1 * l2 * q2.cos();
    let g1 = m1 * G * l1 * q1.cos() / 2.0 + m2 * G * l1 * (q1 + q2).cos() / 2.0 + m2 * G * l1 * q1.cos();
    assert_stated(&[difference(&[d12], &[found.d.m12]), difference(&[g1], &[found.g.x])], &[3.117, 0.02238]);
}

/// 12.454 prints an unsymmetric matrix; one of its elements has the unit kg^2 m^2.
#[test]
fn printed_12_454_is_wrong() {
    let found = Equations::by_traces(&STATED.dynamics(), &STATED_2.q, &STATED_2.qd);
    let ([m1, m2], [l1, l2], c2) = (STATED.m, STATED.l, STATED_2.q[1].cos());
    let d12 = m2 * (l1 * l1 + l2 * l2 / 3.0 + l1 * l2 * c2);
    let d21 = (m1 * l1 * l1 / 3.0 + m2 * l2 * l2 / 3.0) * m2 + m2 * l1 * l2 * c2;
    assert_stated(&[difference(&[d12], &[found.d.m12]), difference(&[d21], &[found.d.m21])], &[3.117, 3.551]);
}
