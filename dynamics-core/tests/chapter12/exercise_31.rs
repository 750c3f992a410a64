//! Exercise 31: work of the actuators of a planar arm that carries 12 kg at 1 m/s along two semicircles.
//!
//! The figure is in another chapter. Assumed: from (1.5, 0.5) through (0, 0.5) to (-1.5, 0.5), radius 0.75 m, massless links,
//! gravity along -y, and both possible paths: over both circles, and over the first and under the second.

use super::support_b::{DOWN_Y, G, State, arm, planar_link};
use crate::common::torque;
use dynamics_core::{Body, Dynamics};
use nalgebra::{Matrix2, Vector2};

const RADIUS: f64 = 0.75;
const LOAD: f64 = 12.0;

/// Position, velocity and acceleration after a fraction of the first or the second semicircle.
fn path(second: bool, over: bool, fraction: f64) -> [Vector2<f64>; 3] {
    let centre = Vector2::new(if second { -0.75 } else { 0.75 }, 0.5);
    let side = if over { 1.0 } else { -1.0 };
    // The arc runs from the right to the left at 1 m/s.
    let (angle, rate) = (core::f64::consts::PI * fraction, 1.0 / RADIUS);
    let along = Vector2::new(angle.cos(), side * angle.sin());
    let across = Vector2::new(-angle.sin(), side * angle.cos());
    [centre + along * RADIUS, across * (RADIUS * rate), -along * (RADIUS * rate * rate)]
}

/// Joint motion of the arm with links of 1 m, elbow on one side.
fn joints([p, v, a]: [Vector2<f64>; 3]) -> State<2> {
    let elbow = ((p.dot(&p) - 2.0) / 2.0).acos();
    let shoulder = p.y.atan2(p.x) - elbow / 2.0;
    let ((s1, c1), (s12, c12)) = (shoulder.sin_cos(), (shoulder + elbow).sin_cos());
    // Inverse of the tip's Jacobian, whose determinant is the sine of the elbow's angle.
    let inverse = Matrix2::new(c12, s12, -c1 - c12, -s1 - s12) / elbow.sin();
    let qd = inverse * v;
    let w = qd.x + qd.y;
    let slope = Vector2::new(c1, s1) * (qd.x * qd.x) + Vector2::new(c12, s12) * (w * w);
    State { q: [shoulder, elbow], qd: qd.into(), qdd: (inverse * (a + slope)).into() }
}

fn dynamics() -> Dynamics<f64, 2> {
    arm(&[planar_link(1.0, Body::massless()), planar_link(1.0, Body::massless())], [0.0; 3], LOAD, DOWN_Y)
}

/// The actuators' power at any moment is that of the load, `m (a - g) . v`; at constant speed only the weight's part remains.
#[test]
fn power_of_the_actuators_is_that_of_the_load() {
    let dynamics = dynamics();
    for k in 1..40 {
        let moving = path(k >= 20, k % 3 == 0, f64::from(k % 20) / 20.0 + 0.01);
        let State { q, qd, qdd } = joints(moving);
        let tau = torque::<f64, 2>(&dynamics, &q, &qd, &qdd);
        let power: f64 = tau.iter().zip(&qd).map(|(t, v)| t * v).sum();
        assert!((power - LOAD * G * moving[1].y).abs() < 1e-11 * LOAD * G, "{k}: {power}");
    }
}

/// Net work up to the top of the first circle is that of lifting the load, 12 g 0.75 = 88.29 J. Over the whole path it is zero for
/// either direction, because height and speed at the end are those at the start.
#[test]
fn net_work_is_the_rise_of_the_load() {
    let dynamics = dynamics();
    let power = |moving| {
        let State { q, qd, qdd } = joints(moving);
        torque::<f64, 2>(&dynamics, &q, &qd, &qdd).iter().zip(&qd).map(|(t, v)| t * v).sum::<f64>()
    };
    let arc_time = core::f64::consts::PI * RADIUS;
    // Simpson's rule over part of one semicircle.
    let work = |second: bool, over: bool, end: f64| -> f64 {
        let (steps, time) = (200, end * arc_time);
        let at = |n: i32| power(path(second, over, end * f64::from(n) / f64::from(steps)));
        let weight = |n: i32| {
            if n == 0 || n == steps {
                1.0
            } else if n % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=steps).map(|n| weight(n) * at(n)).sum::<f64>() * time / f64::from(3 * steps)
    };
    assert!((work(false, true, 0.5) - 88.29).abs() < 1e-6);
    for over in [true, false] {
        assert!((work(false, true, 1.0) + work(true, over, 1.0)).abs() < 1e-6);
    }
}
