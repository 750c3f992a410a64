//! Pose and Jacobian of the tip of a three-link arm, and the joint torques of a tip force by virtual work.
//!
//! ```console
//! $ cargo run -p dynamics-core --example tip_pose
//! ```

use dynamics_core::kinematics::{tip_jacobian, tip_pose};
use dynamics_core::nalgebra::{Matrix3, Vector3};
use dynamics_core::trig::Libm;
use dynamics_core::{
    Body, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, ModelError, Rotor, Scene, Term,
    Tool, Trig, Wrench,
};

/// A link without mass, placed as in a URDF: kinematics needs no body.
fn joint(translation: Vector3<f64>, axis: Vector3<f64>) -> JointSpec {
    JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::Placement { rotation: Matrix3::identity(), translation, axis },
        body: Body::massless(),
        rotor: Rotor::default(),
        limits: Limits::none(),
    }
}

fn main() -> Result<(), ModelError> {
    // A turntable, a shoulder 0.3 m above it, an elbow 0.5 m along x; the tip is 0.4 m beyond the elbow.
    let (up, across) = (Vector3::z(), Vector3::y());
    let joints = [
        joint(Vector3::zeros(), up),
        joint(Vector3::new(0.0, 0.0, 0.3), across),
        joint(Vector3::new(0.5, 0.0, 0.0), across),
    ];
    let model = Model::new(&joints, &Tool { translation: Vector3::new(0.4, 0.0, 0.0), ..Tool::default() })?;

    let q = [0.4, -0.5, 0.9];
    let turn = Libm.sin_cos_all(&q);
    let tip = tip_pose(&model, &turn, &q);
    let position = |p: &Vector3<f64>| format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z);
    println!("tip at {} m", position(&tip.translation));
    let reach = 0.5 * q[1].cos() + 0.4 * (q[1] + q[2]).cos();
    let height = 0.3 - 0.5 * q[1].sin() - 0.4 * (q[1] + q[2]).sin();
    assert!((tip.translation - Vector3::new(reach * q[0].cos(), reach * q[0].sin(), height)).norm() < 1e-15);

    // One column per joint: velocity of the tip (m/s) at a joint velocity of 1 rad/s, in the base frame.
    let jacobian = tip_jacobian(&model, &turn, &q);
    for (number, column) in jacobian.linear.iter().enumerate() {
        println!("joint {} moves the tip by {} m/rad", number + 1, position(column));
    }

    // Virtual work: the joints that hold a force on the tip carry -J^T f.
    let force = Wrench { force: Vector3::new(5.0, 0.0, -10.0), moment: Vector3::zeros() };
    let holding = jacobian.transposed(&force).map(|torque| -torque);
    println!("a tip force of {:?} N needs {:.3?} N m", force.force.as_slice(), holding);

    // Inverse dynamics gives the same. It takes the force in the axes of the tip frame.
    let in_tip = Wrench { force: tip.rotation.transpose() * force.force, ..force };
    let dynamics = Dynamics::new(model, Scene { tip_wrench: Term::Live, ..Scene::free_space() });
    let live = Live { tip_wrench: in_tip, ..Live::zero() };
    let torque = dynamics.inverse_dynamics(&turn, &q, &[0.0; 3], &[0.0; 3], &live);
    assert!((0..3).all(|i| (torque[i] - holding[i]).abs() < 1e-14), "{torque:?} N m");
    Ok(())
}
