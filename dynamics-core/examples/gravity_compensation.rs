//! Torques that hold a two-link arm against its weight, in single precision, compared with the closed form.
//!
//! ```console
//! $ cargo run -p dynamics-core --example gravity_compensation
//! ```

use dynamics_core::nalgebra::{Matrix3, Vector3};
use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, ModelError, Rotor, Scene,
    Tool, Trig,
};

/// Gravitational acceleration, m/s^2.
const G: f64 = 9.81;

/// Mass (kg) and length (m) of each link.
const LINKS: [(f64, f64); 2] = [(2.0, 1.0), (1.5, 0.8)];

/// A slender rod along x that turns about z at its near end.
fn rod((mass, length): (f64, f64)) -> JointSpec {
    let inertia = mass * length * length / 12.0;
    JointSpec {
        kind: JointKind::Revolute,
        // Classical Denavit-Hartenberg: the link's frame is at its far end, so the mass centre is half a length back.
        frame: Frame::ClassicalDh(Dh { a: length, ..Dh::default() }),
        body: Body {
            mass,
            com: Vector3::new(-0.5 * length, 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.0, inertia, inertia)),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    }
}

/// The same torques from the lever arms of the weights, N m.
fn closed_form(q: [f64; 2]) -> [f64; 2] {
    let [(m1, l1), (m2, l2)] = LINKS;
    let elbow = m2 * G * 0.5 * l2 * (q[0] + q[1]).cos();
    [(0.5 * m1 + m2) * G * l1 * q[0].cos() + elbow, elbow]
}

fn main() -> Result<(), ModelError> {
    // The model is checked in double precision, then cast to the precision of the controller.
    let model = Model::new(&LINKS.map(rod), &Tool::default())?.cast::<f32>();
    // The arm swings in a vertical plane: gravity acts along -y of the base.
    let dynamics = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -G as f32, 0.0), &model));

    for degrees in [[0.0, 0.0], [30.0, 40.0], [90.0, 0.0], [120.0, -75.0]] {
        let q = degrees.map(f32::to_radians);
        let torque = dynamics.gravity_torque(&Polynomial.sin_cos_all(&q), &q, &Live::zero());
        println!("at {degrees:?} degrees: {:7.3} N m, {:7.3} N m", torque[0], torque[1]);

        let expected = closed_form(q.map(f64::from));
        for joint in 0..2 {
            let error = (f64::from(torque[joint]) - expected[joint]).abs();
            assert!(error < 1e-5, "joint {}: {error} N m off", joint + 1);
        }
    }
    Ok(())
}
