//! Example 336: two turning bars by Lagrange's method, eq. 12.263-12.280.

use super::support_b::{
    DOWN_Y, Equations, G, STATED_2, State, arm, assert_equal, assert_stated, body, difference, larger,
    mass_matrix_slope, planar_link, posture, sizes, states,
};
use dynamics_core::Dynamics;
use dynamics_core::chapter::lagrange::{self, Jacobian};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, SMatrix, Vector2, Vector3};

/// Masses and lengths.
struct Bars {
    m: [f64; 2],
    l: [f64; 2],
}

impl Bars {
    const STATED: Self = Self { m: [3.0, 2.0], l: [0.7, 0.5] };

    fn of([m1, m2, l1, l2]: [f64; 4]) -> Self {
        Self { m: [m1, m2], l: [l1, l2] }
    }

    fn dynamics(&self) -> Dynamics<f64, 2> {
        let bar = |i: usize| {
            let inertia = self.m[i] * self.l[i] * self.l[i] / 12.0;
            // 12.265-12.266
            planar_link(self.l[i], body(self.m[i], [-self.l[i] / 2.0, 0.0, 0.0], [0.0, inertia, inertia]))
        };
        arm(&[bar(0), bar(1)], [0.0; 3], 0.0, DOWN_Y)
    }

    fn equations(&self, state: &State<2>) -> Equations<2> {
        let ([m1, m2], [l1, l2], [q1, q2], [qd1, qd2]) = (self.m, self.l, state.q, state.qd);
        let (s2, c2, c1, c12) = (q2.sin(), q2.cos(), q1.cos(), (q1 + q2).cos());
        // 12.274, the last line
        let d12 = m2 * (l1 * l2 * c2 / 2.0 + l2 * l2 / 3.0);
        let d11 = m1 * l1 * l1 / 3.0 + m2 * (l1 * l1 + l1 * l2 * c2 + l2 * l2 / 3.0);
        let d = Matrix2::new(d11, d12, d12, m2 * l2 * l2 / 3.0);
        // 12.275-12.276, as the matrix of Christoffel symbols.
        let h = m2 * l1 * l2 * s2 / 2.0;
        let c = Matrix2::new(-h * qd2, -h * (qd1 + qd2), h * qd1, 0.0);
        // 12.277-12.278
        let g2 = m2 * G * l2 * c12 / 2.0;
        let g1 = m1 * G * l1 * c1 / 2.0 + m2 * G * l1 * c1 + g2;
        Equations { d, c, g: Vector2::new(g1, g2) }
    }

    /// `J_D1`, `J_R1`, `J_D2`, `J_R2` (eq. 12.270-12.273, the last corrected).
    fn jacobians(&self, q: &[f64; 2]) -> [Matrix3x2<f64>; 4] {
        let ([l1, l2], (s1, c1), (s12, c12)) = (self.l, q[0].sin_cos(), (q[0] + q[1]).sin_cos());
        [
            Matrix3x2::new(-l1 * s1 / 2.0, 0.0, l1 * c1 / 2.0, 0.0, 0.0, 0.0),
            Matrix3x2::new(0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
            Matrix3x2::new(
                -l1 * s1 - l2 * s12 / 2.0,
                -l2 * s12 / 2.0,
                l1 * c1 + l2 * c12 / 2.0,
                l2 * c12 / 2.0,
                0.0,
                0.0,
            ),
            Matrix3x2::new(0.0, 0.0, 0.0, 0.0, 1.0, 1.0),
        ]
    }
}

/// Error of a matrix, relative to its largest entry.
fn off<const R: usize, const C: usize>(found: &SMatrix<f64, R, C>, wanted: &SMatrix<f64, R, C>) -> f64 {
    difference(found.as_slice(), wanted.as_slice())
}

#[test]
fn equations_of_motion_are_12_274_to_12_280() {
    assert_equal("example 336", (sizes(), states()), |(sizes, state)| {
        let bars = Bars::of(sizes);
        bars.equations(&state).error(&bars.dynamics(), &state)
    });
}

#[test]
fn torques_are_12_279_and_12_280() {
    let (Bars { m: [m1, m2], l: [l1, l2] }, State { q: [q1, q2], qd: [qd1, qd2], qdd: [a1, a2] }) =
        (Bars::STATED, STATED_2);
    let (s2, c2) = q2.sin_cos();
    let tau1 = (m1 * l1 * l1 / 3.0 + m2 * (l1 * l1 + l1 * l2 * c2 + l2 * l2 / 3.0)) * a1
        + m2 * l2 * (l1 * c2 / 2.0 + l2 / 3.0) * a2
        - m2 * l1 * l2 * (qd1 + qd2 / 2.0) * qd2 * s2
        + (m1 / 2.0 + m2) * G * l1 * q1.cos()
        + m2 * G * l2 * (q1 + q2).cos() / 2.0;
    let tau2 = m2 * (l1 * l2 * c2 / 2.0 + l2 * l2 / 3.0) * a1
        + m2 * l2 * l2 * a2 / 3.0
        + m2 * l1 * l2 * qd1 * qd1 * s2 / 2.0
        + m2 * G * l2 * (q1 + q2).cos() / 2.0;
    let found = Equations::of(&Bars::STATED.dynamics(), &STATED_2.q, &STATED_2.qd).torque(&STATED_2.qd, &STATED_2.qdd);
    assert!(difference(&found, &[tau1, tau2]) < 1e-14);
}

/// 12.263-12.264 with 12.267-12.268, and the columns of 12.270-12.273 as velocities under unit joint velocities.
#[test]
fn rotations_inertias_and_jacobians_are_12_263_to_12_273() {
    assert_equal("12.263-12.273", (sizes(), states()), |(sizes, state)| {
        let bars = Bars::of(sizes);
        let posture = posture(&bars.dynamics(), &state.q);
        let jacobians = bars.jacobians(&state.q);
        let of_the_core = lagrange::link_jacobians(&posture);
        let moving = posture.motion(&state.qd, &[0.0; 2]);
        let mut worst = 0.0;
        for i in 0..2 {
            let (s, c) = state.q[..=i].iter().sum::<f64>().sin_cos();
            let rotation = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
            let inertia = Matrix3::new(s * s, -c * s, 0.0, -c * s, c * c, 0.0, 0.0, 0.0, 1.0)
                * (bars.m[i] * bars.l[i] * bars.l[i] / 12.0);
            worst = larger(worst, off(&posture.links[i].rotation, &rotation));
            worst = larger(worst, off(&posture.links[i].inertia, &inertia));
            let column = |j: usize| {
                let mut unit = [0.0; 2];
                unit[j] = 1.0;
                posture.motion(&unit, &[0.0; 2])[i]
            };
            let Jacobian { linear, angular } = &of_the_core[i];
            worst = larger(worst, off(&Matrix3x2::from_columns(linear), &jacobians[2 * i]));
            worst = larger(worst, off(&Matrix3x2::from_columns(angular), &jacobians[2 * i + 1]));
            let speed = bars.l.iter().sum::<f64>() * 3.0;
            worst = larger(worst, (of_the_core[i].velocity(&state.qd) - moving[i].velocity).amax() / speed);
            worst = larger(worst, (of_the_core[i].angular_velocity(&state.qd) - moving[i].omega).amax() / 3.0);
            let columns = [column(0), column(1)];
            worst = larger(worst, off(&Matrix3x2::from_columns(&columns.map(|m| m.velocity)), &jacobians[2 * i]));
            worst = larger(worst, off(&Matrix3x2::from_columns(&columns.map(|m| m.omega)), &jacobians[2 * i + 1]));
        }
        // The Jacobian of the tip, at the end of the second bar.
        let tip = lagrange::tip_jacobian(&posture);
        let end = moving[1].velocity + moving[1].omega.cross(&posture.outer_arm(1));
        larger(worst, (tip.velocity(&state.qd) - end).amax() / (bars.l.iter().sum::<f64>() * 3.0))
    });
}

/// 12.273 as printed means that the second link is not affected by the second joint's turn; the lines of 12.274 halve the
/// rotational part. Neither leads to the printed result that follows them, which is correct.
#[test]
fn printed_lines_of_12_273_and_12_274_are_wrong() {
    let bars = Bars::STATED;
    let right = bars.equations(&STATED_2).d;
    let posture = posture(&bars.dynamics(), &STATED_2.q);
    let [jd1, jr1, jd2, jr2] = bars.jacobians(&STATED_2.q);
    let sum = |half: f64, jr2: &Matrix3x2<f64>| {
        let [one, two] = &posture.links;
        jd1.transpose() * jd1 * bars.m[0]
            + jr1.transpose() * one.inertia * jr1 * half
            + jd2.transpose() * jd2 * bars.m[1]
            + jr2.transpose() * two.inertia * jr2 * half
    };
    assert!(off(&sum(1.0, &jr2), &right) < 1e-15);
    assert_stated(&[off(&sum(0.5, &jr2), &right), off(&sum(1.0, &jr1), &right)], &[0.03962, 0.02011]);
}

/// With the limits 1..1 printed in 12.275 the first velocity term would be zero; with 1..2 it equals the last line.
#[test]
fn printed_limits_of_12_275_are_wrong() {
    let (bars, State { q, qd, .. }) = (Bars::STATED, STATED_2);
    let slope: [Matrix2<f64>; 2] = core::array::from_fn(|k| mass_matrix_slope(&bars.dynamics(), &q, k));
    let h1 = |last: usize| -> f64 {
        let term = |j: usize, k: usize| (slope[k][(0, j)] - slope[0][(j, k)] / 2.0) * qd[j] * qd[k];
        (0..last).flat_map(|j| (0..last).map(move |k| (j, k))).map(|(j, k)| term(j, k)).sum()
    };
    let right = -bars.m[1] * bars.l[0] * bars.l[1] * (qd[0] + qd[1] / 2.0) * qd[1] * q[1].sin();
    assert!(difference(&[h1(2)], &[right]) < 1e-14);
    assert_stated(&[difference(&[h1(1)], &[right])], &[1.0]);
}

/// At rest the only acceleration is 12.269: gravity acts along the base frame's -y.
#[test]
fn gravity_is_12_269() {
    assert_eq!(DOWN_Y, Vector3::new(0.0, -G, 0.0));
    let bars = Bars::STATED;
    let weights = super::support_b::wrenches_in_base(&bars.dynamics(), &State::still(STATED_2.q));
    assert!((weights[0].force - Vector3::new(0.0, (bars.m[0] + bars.m[1]) * G, 0.0)).amax() < 1e-13);
}
