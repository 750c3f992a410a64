//! Computed-torque control of a two-link arm, once a millisecond, against a simulated arm that is 20 % heavier at its tip.
//!
//! ```console
//! $ cargo run -p dynamics-core --example control_loop
//! ```

use dynamics_core::control::Gains;
use dynamics_core::control::trajectory::{Bounds, Motion, Timing, Waypoint};
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{
    Body, Command, Controller, ControllerConfig, Dh, Dynamics, Frame, JointKind, JointSpec, Limits, Live, Measurement,
    Model, Rotor, Scene, Sensed, Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};
use std::error::Error;

/// Control period, s.
const PERIOD: f64 = 1e-3;

/// Two rods in a vertical plane, the outer one of this mass (kg).
fn arm(outer: f64) -> Result<Dynamics<f64, 2>, Box<dyn Error>> {
    let rod = |mass: f64, length: f64| JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: length, ..Dh::default() }),
        body: Body {
            mass,
            com: Vector3::new(-0.5 * length, 0.0, 0.0),
            inertia: Matrix3::identity() * (mass * length * length / 12.0),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let model = Model::new(&[rod(2.0, 1.0), rod(outer, 0.8)], &Tool::default())?;
    Ok(Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model)))
}

fn main() -> Result<(), Box<dyn Error>> {
    // 20 rad/s, critically damped; the last number is for laws with a fixed inertia.
    let config = ControllerConfig::new([Gains::new(20.0, 1.0, 1.0); 2], [Limits::none(); 2], PERIOD);
    let model = arm(1.5)?;
    let mut controller =
        Controller::new(config.cast::<f32>(), Dynamics::new(model.model().cast(), model.scene().cast()), Polynomial);
    let plant = arm(1.8)?;

    let bounds = Bounds { position: [(-3.0, 3.0); 2], velocity: [2.0; 2], acceleration: [10.0; 2] };
    let way = [Waypoint::through([0.0, 0.0]), Waypoint::through([1.0, -0.5])];
    let motion = Motion::quintic(&way, Timing::Fastest, &bounds)?;

    let (mut q, mut qd) = ([0.0; 2], [0.0; 2]);
    let mut error = 0.0;
    for tick in 0..(2.0 * motion.duration() / PERIOD) as u32 {
        let reference = motion.sample(f64::from(tick) * PERIOD);
        let sensed = Sensed::State { q: q.map(|x| x as f32), qd: qd.map(|x| x as f32) };
        let torque = match controller.tick(&reference.cast::<f32>(), &Measurement { sensed, age_ticks: 0 }) {
            Command::Drive { torque, .. } => torque.map(f64::from),
            Command::Brake(fault) => return Err(fault.to_string().into()),
        };
        let qdd = forward_dynamics(&plant, &Libm.sin_cos_all(&q), &q, &qd, &torque, &Live::zero())?;
        for i in 0..2 {
            qd[i] += qdd[i] * PERIOD;
            q[i] += qd[i] * PERIOD;
        }
        error = f64::max((q[0] - reference.q[0]).abs(), (q[1] - reference.q[1]).abs());
        if tick % 100 == 0 {
            println!("{:.1} s: off by {:.2} mrad", f64::from(tick) * PERIOD, 1e3 * error);
        }
    }
    // At most the weight missing from the model, divided by the stiffness.
    assert!((1e-4..0.02).contains(&error), "at rest it is off by {error} rad");
    Ok(())
}
