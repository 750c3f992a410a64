//! Robot files, gravity and payload.

use crate::arm::Arm;
use crate::errors::file_error;
use dynamics_core::{Body, Dh, Frame, Inertia, JointKind, JointSpec, Limits, Model, Rotor, Tool};
use nalgebra::{Matrix3, Vector3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_compiler::{Ends, Robot};
use std::path::PathBuf;

/// Mass, kg; mass centre, m, and inertia tensor about it, kg m^2, in the tip frame.
type Payload = (f64, [f64; 3], [[f64; 3]; 3]);

/// Reads a robot file. The package's function of this name checks the arguments' types.
#[pyfunction]
pub(crate) fn load(
    path: PathBuf,
    tip: Option<&str>,
    base: Option<&str>,
    gravity: Option<[f64; 3]>,
    payload: Option<Payload>,
) -> PyResult<Arm> {
    let robot = Robot::load_between(&path, Ends { base, tip }).map_err(|error| file_error(&error))?;
    let gravity = gravity.map_or_else(|| robot.gravity(), Vector3::from);
    if !gravity.iter().all(|g| g.is_finite()) {
        let [x, y, z] = <[f64; 3]>::from(gravity);
        return Err(PyValueError::new_err(format!("gravity: found ({x}, {y}, {z}); expected finite numbers, m/s^2")));
    }
    let payload = payload.map(body).transpose()?;
    let inertia = payload.map(|Body { mass, com, inertia }| Inertia::from_mass_centre(mass, &com, &inertia));
    let arm = batch_engine::Arm::new(&robot, gravity, inertia).map_err(|error| file_error(&error))?;
    Ok(Arm { arm, robot, gravity: gravity.into(), payload })
}

/// The payload in the tip frame.
///
/// # Errors
/// `ValueError` for a body that no mass distribution can have.
fn body((mass, com, [x, y, z]): Payload) -> PyResult<Body> {
    let com = Vector3::from(com);
    let inertia = Matrix3::from_rows(&[x.into(), y.into(), z.into()]);
    let body = Body { mass, com, inertia };
    let tool = Tool { body, ..Tool::default() };
    // The core checks the bodies of a model.
    let joint = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh::default()),
        body: Body::massless(),
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    Model::new(&[joint], &tool).map_err(|error| PyValueError::new_err(format!("payload: {}", error.what)))?;
    Ok(body)
}
