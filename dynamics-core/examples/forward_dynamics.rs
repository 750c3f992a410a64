//! Joint accelerations from torques, checked against inverse dynamics, and a swing of two seconds that keeps its energy.
//!
//! ```console
//! $ cargo run -p dynamics-core --example forward_dynamics
//! ```

use dynamics_core::nalgebra::{Matrix3, Vector3};
use dynamics_core::trig::Libm;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Singular,
    Tool, Trig, energy, forward_dynamics,
};
use std::error::Error;

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

/// Accelerations of the arm without torque, rad/s^2.
fn falling(dynamics: &Dynamics<f64, 2>, q: &[f64; 2], qd: &[f64; 2]) -> Result<[f64; 2], Singular> {
    forward_dynamics::forward_dynamics(dynamics, &Libm.sin_cos_all(q), q, qd, &[0.0; 2], &Live::zero())
}

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::new(&[rod(2.0, 1.0), rod(1.5, 0.8)], &Tool::default())?;
    let dynamics = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model));
    let live = Live::zero();

    let (mut q, mut qd, torque) = ([0.3, 0.7], [1.0, -2.0], [20.0, 3.0]);
    let turn = Libm.sin_cos_all(&q);
    let qdd = forward_dynamics::forward_dynamics(&dynamics, &turn, &q, &qd, &torque, &live)?;
    println!("{torque:?} N m accelerate the joints by {:.4} and {:.4} rad/s^2", qdd[0], qdd[1]);

    // Inverse dynamics returns the torques.
    let back = dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &live);
    for joint in 0..2 {
        assert!((back[joint] - torque[joint]).abs() < 1e-12);
    }

    // Without torque and friction, the total energy stays constant.
    let total = |q: &[f64; 2], qd: &[f64; 2]| {
        let turn = Libm.sin_cos_all(q);
        energy::kinetic(&dynamics, &turn, q, qd, &live) + energy::potential(&dynamics, &turn, q, &live)
    };
    let (start, h) = (total(&q, &qd), 1e-4);
    for _ in 0..20_000 {
        // The midpoint rule: one half step, then a whole step with the slopes of its end.
        let first = falling(&dynamics, &q, &qd)?;
        let middle: [f64; 2] = std::array::from_fn(|i| q[i] + 0.5 * h * qd[i]);
        let speed: [f64; 2] = std::array::from_fn(|i| qd[i] + 0.5 * h * first[i]);
        let second = falling(&dynamics, &middle, &speed)?;
        for i in 0..2 {
            q[i] += h * speed[i];
            qd[i] += h * second[i];
        }
    }
    let lost = total(&q, &qd) - start;
    println!("a free swing of 2 s changes the energy of {start:.4} J by {lost:.1e} J");
    assert!(lost.abs() < 1e-4);
    Ok(())
}
