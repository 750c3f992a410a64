//! Exercises 15 and 37: the arm of a spherical manipulator, with a vertical and a horizontal revolute joint and a slider. The
//! load of its wrist is assumed to be balanced about the wrist's centre, so it counts as part of the slider.
//!
//! The figure is in another chapter. Assumed: the axes meet, the elevation is zero with the slider horizontal, and the slider's
//! distance is measured to the mass centre of slider, wrist and load.

use super::support_b::{Equations, G, State, arm, assert_equal, body, larger, placed, sizes, states, wrenches_in_base};
use dynamics_core::geometry::about_x;
use dynamics_core::{Dynamics, JointKind};
use nalgebra::{Matrix3, Vector3};

/// `I1, m2, c2, m3`, and principal moments of inertia of links 2 and 3.
struct Spherical([f64; 10]);

impl Spherical {
    fn dynamics(&self) -> Dynamics<f64, 3> {
        let Self([i1, m2, c2, m3, xx2, yy2, zz2, xx3, yy3, zz3]) = *self;
        let (plain, level) = (Matrix3::identity(), about_x(core::f64::consts::FRAC_PI_2));
        let joints = [
            placed(JointKind::Revolute, plain, [0.0; 3], [0.0, 0.0, 1.0], body(0.0, [0.0; 3], [0.0, 0.0, i1])),
            placed(JointKind::Revolute, level, [0.0; 3], [0.0, 0.0, 1.0], body(m2, [c2, 0.0, 0.0], [xx2, yy2, zz2])),
            placed(JointKind::Prismatic, plain, [0.0; 3], [1.0, 0.0, 0.0], body(m3, [0.0; 3], [xx3, yy3, zz3])),
        ];
        arm(&joints, [0.0; 3], 0.0, Vector3::new(0.0, 0.0, -G))
    }

    fn equations(&self, State { q: [_, elevation, d], qd: [v1, v2, v3], .. }: &State<3>) -> Equations<3> {
        let Self([i1, m2, c2, m3, xx2, yy2, zz2, xx3, yy3, zz3]) = *self;
        let (s, c) = elevation.sin_cos();
        let (about_out, about_up) = (xx2 + xx3, yy2 + yy3 + m2 * c2 * c2 + m3 * d * d);
        // Halves of dD11/dq2, dD11/dd and dD22/dd.
        let (h2, h3, f) = ((about_out - about_up) * s * c, m3 * d * c * c, m3 * d);
        Equations {
            d: Matrix3::from_diagonal(&Vector3::new(
                i1 + about_out * s * s + about_up * c * c,
                zz2 + zz3 + m2 * c2 * c2 + m3 * d * d,
                m3,
            )),
            c: Matrix3::new(h2 * v2 + h3 * v3, h2 * v1, h3 * v1, -h2 * v1, f * v3, f * v2, -h3 * v1, -f * v2, 0.0),
            g: Vector3::new(0.0, (m2 * c2 + m3 * d) * c, m3 * s) * G,
        }
    }
}

#[test]
fn equations_of_motion_of_the_spherical_arm() {
    assert_equal("exercise 15", (sizes(), states()), |(x, state)| {
        let arm = Spherical(x);
        arm.equations(&state).error(&arm.dynamics(), &state)
    });
}

/// Exercise 37, 12 kg at the wrist's centre.
#[test]
fn statics_of_the_spherical_arm() {
    assert_equal("exercise 37", (sizes(), states()), |(mut x, state): ([f64; 10], State<3>)| {
        x[3] += 12.0;
        let (arm, [azimuth, elevation, d]) = (Spherical(x), state.q);
        let [_, m2, c2, m3, ..] = x;
        let out = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * elevation.cos() + Vector3::z() * elevation.sin();
        let up = Vector3::z() * G;
        let moment = (out * (m2 * c2 + m3 * d)).cross(&up);
        let wanted = [(m2 + m3, moment), (m2 + m3, moment), (m3, Vector3::zeros())];
        let found = wrenches_in_base(&arm.dynamics(), &State::still(state.q));
        let off = wanted
            .into_iter()
            .zip(found)
            .map(|((mass, moment), found)| larger((found.force - up * mass).amax(), (found.moment - moment).amax()));
        off.fold(0.0, larger) / ((m2 + m3) * G * (1.0 + c2 + d.abs()))
    });
}
