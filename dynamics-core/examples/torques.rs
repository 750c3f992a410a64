//! Torques of a two-link arm, in the single precision of a microcontroller.
//!
//! ```console
//! $ cargo run -p dynamics-core --example torques
//! ```

use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, ModelError, Rotor, Scene,
    Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};

/// A slender rod along x that turns about z at its near end: kg, m.
fn rod(mass: f64, length: f64) -> JointSpec {
    let inertia = mass * length * length / 12.0;
    JointSpec {
        kind: JointKind::Revolute,
        // The frame is at the far end, the mass centre half way back.
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

fn main() -> Result<(), ModelError> {
    // Checked once, in f64; then cast to the scalar of the computation.
    let model = Model::new(&[rod(2.0, 1.0), rod(1.5, 0.8)], &Tool::default())?.cast::<f32>();
    // It swings in a vertical plane: gravity along -y of the base, m/s^2.
    let dynamics = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model));

    let (q, qd, qdd) = ([0.3, 0.7], [1.0, -2.0], [0.5, 0.1]);
    let turn = Polynomial.sin_cos_all(&q);
    let (zero, nothing) = ([0.0; 2], Live::zero());
    println!("tau = D qdd + C qd + G  {:?} N m", dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &nothing));
    println!("G, holding the weight   {:?} N m", dynamics.inverse_dynamics(&turn, &q, &zero, &zero, &nothing));
    println!("D, the inertia matrix  {}", mass_matrix(&dynamics, &turn, &q, &nothing));
    Ok(())
}
