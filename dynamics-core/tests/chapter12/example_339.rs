//! Example 339: a turning beam with a mass at its tip, eq. 12.286-12.300; all of it is correct.

use super::support_b::{
    DOWN_Y, Equations, G, State, arm, assert_equal, body, difference, larger, planar_link, posture, sizes, states,
};
use crate::common::turns;
use dynamics_core::{Live, energy};
use nalgebra::{Matrix1, Matrix3, Vector1, Vector3};

#[test]
fn one_link_is_12_286_to_12_300() {
    assert_equal("example 339", (sizes::<6>(), states::<1>()), |([m1, m2, l, ix, iy, iz], state)| {
        let beam = planar_link(l, body(m1, [-l / 2.0, 0.0, 0.0], [ix, iy, iz]));
        let dynamics = arm(&[beam], [0.0; 3], m2, DOWN_Y);
        let State { q: [theta], qd: [speed], .. } = state;
        let (s, c) = theta.sin_cos();

        // 12.300, with 12.297-12.298 and 12.299.
        let inertia = m1 * l * l / 4.0 + m2 * l * l + iz;
        let weight = (m1 / 2.0 + m2) * G * l * c;
        let closed = Equations { d: Matrix1::new(inertia), c: Matrix1::zeros(), g: Vector1::new(weight) };
        let mut error = closed.error(&dynamics, &state);

        // 12.292 and 12.294; the Lagrangian 12.295 is their difference.
        let kinetic = l * l * speed * speed * (m1 + 4.0 * m2) / 8.0 + iz * speed * speed / 2.0;
        let potential = m1 * G * l * s / 2.0 + m2 * G * l * s;
        let turn = turns(&state.q);
        let found = energy::kinetic(&dynamics, &turn, &state.q, &state.qd, &Live::zero());
        error = larger(error, difference(&[found], &[kinetic]));
        let found = energy::potential(&dynamics, &turn, &state.q, &Live::zero());
        error = larger(error, (found - potential).abs() / ((m1 + m2) * G * l));

        // 12.286-12.291 and 12.293, for the beam without the mass at its tip.
        let bare = arm(&[beam], [0.0; 3], 0.0, DOWN_Y);
        let place = posture(&bare, &state.q);
        let motion = place.motion(&state.qd, &[0.0])[0];
        let turned = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        let tensor = Matrix3::new(
            ix * c * c + iy * s * s,
            (ix - iy) * c * s,
            0.0,
            (ix - iy) * c * s,
            iy * c * c + ix * s * s,
            0.0,
            0.0,
            0.0,
            iz,
        );
        let vectors = [
            (place.links[0].centre, Vector3::new(c, s, 0.0) * (l / 2.0)),
            (place.end(0), Vector3::new(c, s, 0.0) * l),
            (motion.omega, Vector3::new(0.0, 0.0, speed)),
            (motion.velocity, Vector3::new(-s, c, 0.0) * (l / 2.0 * speed)),
            (motion.omega.cross(&place.end(0)), Vector3::new(-s, c, 0.0) * (l * speed)),
        ];
        let pairs = vectors.map(|(found, wanted)| difference(found.as_slice(), wanted.as_slice()));
        let rotation = difference(place.links[0].rotation.as_slice(), turned.as_slice());
        let inertia = difference(place.links[0].inertia.as_slice(), tensor.as_slice());
        pairs.into_iter().chain([rotation, inertia]).fold(error, larger)
    });
}

/// 12.300 equals 12.69: the same arm as in example 325, with the same torque.
#[test]
fn torque_12_300_is_12_69() {
    let (m1, m2, l, iz, theta, acceleration) = (3.0, 2.0, 0.7, 0.2, 0.4_f64, 2.1);
    let beam = planar_link(l, body(m1, [-l / 2.0, 0.0, 0.0], [0.1, 0.2, iz]));
    let dynamics = arm(&[beam], [0.0; 3], m2, DOWN_Y);
    let found = crate::common::torque::<f64, 1>(&dynamics, &[theta], &[1.3], &[acceleration]);
    let rx = (m1 + 2.0 * m2) / (2.0 * (m1 + m2)) * l;
    let i3 = iz + m1 * (rx - l / 2.0) * (rx - l / 2.0) + m2 * (l - rx) * (l - rx);
    // 12.68 with I_3 instead of the printed I_z, which makes it 12.69.
    let wanted = (i3 + (m1 + m2) * rx * rx) * acceleration + (m1 + m2) * rx * G * theta.cos();
    assert!(difference(&found, &[wanted]) < 1e-14);
}
