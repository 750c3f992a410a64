//! A payload that is picked up while the controller runs, and the torque that it adds to the joints.
//!
//! ```console
//! $ cargo run -p dynamics-core --example payload
//! ```

use dynamics_core::nalgebra::{Matrix3, Vector3};
use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, Inertia, InertiaBounds, InverseDynamics, JointKind, JointSpec, Limits, Live, Model,
    ModelError, Rotor, Scene, Term, Tool, Trig,
};

/// Gravitational acceleration, m/s^2.
const G: f32 = 9.81;

/// A slender rod along x that turns about z at its near end: kg, m.
fn rod(mass: f64, length: f64) -> JointSpec {
    let inertia = mass * length * length / 12.0;
    JointSpec {
        kind: JointKind::Revolute,
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
    let (upper, fore) = (0.5, 0.4);
    let model = Model::new(&[rod(2.0, upper), rod(1.0, fore)], &Tool::default())?.cast::<f32>();
    // `Live`: the payload is an input of every tick. `Constant` would fix it in the model.
    let gravity = Scene::with_gravity(Vector3::new(0.0, -G, 0.0), &model);
    let dynamics = Dynamics::new(model, Scene { payload: Term::Live, ..gravity });

    let q = [0.6, -1.0];
    let turn = Polynomial.sin_cos_all(&q);
    let hold = |live: &Live<f32, 2>| dynamics.inverse_dynamics(&turn, &q, &[0.0; 2], &[0.0; 2], live);
    let empty = hold(&Live::zero());
    println!("empty:    {:6.3} N m, {:6.3} N m", empty[0], empty[1]);

    // A cube of 0.5 kg and 60 mm, its centre 50 mm beyond the tip. Masses and lengths are those of the tip frame.
    let (mass, side, ahead) = (0.5, 0.06, 0.05);
    let cube = Matrix3::identity() * (mass * side * side / 6.0);
    let payload = Inertia::from_mass_centre(mass, &Vector3::new(ahead, 0.0, 0.0), &cube);
    // A payload that a host sends can be checked first: is it possible, light enough and small enough?
    assert!(payload.is_within(&InertiaBounds { mass: 1.0, radius: 0.2 }));

    // The recursion reads the payload in the last link's own frame, so it is moved once, when it changes.
    let held = Live { payload: dynamics.payload_in_last_link(&payload), ..Live::zero() };
    let loaded = hold(&held);
    println!("with it:  {:6.3} N m, {:6.3} N m", loaded[0], loaded[1]);

    // The difference is the weight times its horizontal distance from each joint.
    let elbow = mass * G * (fore as f32 + ahead) * (q[0] + q[1]).cos();
    let shoulder = elbow + mass * G * upper as f32 * q[0].cos();
    println!("expected: {shoulder:6.3} N m, {elbow:6.3} N m more");
    assert!((loaded[0] - empty[0] - shoulder).abs() < 1e-5 && (loaded[1] - empty[1] - elbow).abs() < 1e-5);

    // Put down, the arm has exactly the torques that it had before.
    assert_eq!(hold(&Live::zero()).map(f32::to_bits), empty.map(f32::to_bits));
    Ok(())
}
