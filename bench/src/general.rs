//! A six-joint arm with as few simplifications for the kernel compiler as possible.

use dynamics_core::{
    Body, Dh, Frame, Inertia, JointKind, JointSpec, Limits, Model, ModelError, Rotor, Scene, Term, Tool, geometry,
};
use nalgebra::{Matrix3, Vector3};

/// Six revolute joints with no right angle and no zero, full inertias and a tool. Every term of the scene is present, live
/// except the payload.
///
/// # Errors
/// None: the numbers describe a possible arm.
pub fn arm() -> Result<(Model<f64, 6>, Scene<f64, 6>), ModelError> {
    let body = |size: f64| Body {
        mass: 1.3 * size,
        com: Vector3::new(0.11, -0.07, 0.05) * size,
        inertia: Matrix3::new(0.06, 0.004, -0.003, 0.004, 0.07, 0.002, -0.003, 0.002, 0.05) * size,
    };
    let joints: [JointSpec; 6] = core::array::from_fn(|i| {
        let size = 1.7 - 0.2 * i as f64;
        JointSpec {
            kind: JointKind::Revolute,
            frame: Frame::ClassicalDh(Dh { a: 0.3 * size, alpha: 0.4 + 0.2 * size, d: 0.2 * size, theta: 0.3 }),
            body: body(size),
            rotor: Rotor { inertia: 2e-4, gear: 50.0 * size },
            limits: Limits::none(),
        }
    });
    let tool =
        Tool { rotation: geometry::from_rpy(0.3, 0.4, 0.5), translation: Vector3::new(0.1, 0.2, 0.3), body: body(0.2) };
    let model = Model::new(&joints, &tool)?;
    let payload = Inertia::from_mass_centre(2.0, &Vector3::new(0.02, -0.01, 0.05), &(Matrix3::identity() * 0.005));
    let scene = Scene {
        gravity: Term::Live,
        payload: Term::Constant(payload),
        tip_wrench: Term::Live,
        rotor: Term::Live,
        coriolis: Term::Live,
    };
    Ok((model, scene))
}
