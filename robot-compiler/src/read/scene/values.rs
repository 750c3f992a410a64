//! Values that several tables of a scene share.

use crate::describe::diagnostics::FileError;
use crate::describe::robot::{Robot, physical_body};
use crate::read::fields::body;
use crate::read::table::Value;
use dynamics_core::Body;

pub(super) const BODY: &str = "a body { mass, com, inertia }";
pub(super) const WRENCH: &str = "a wrench { force, moment }";
pub(super) const GRAVITY: &str = "the gravitational acceleration [x, y, z] in m/s^2";

/// A table of mass, centre and inertia that some mass distribution could have.
pub(super) fn payload(value: &Value<'_>) -> Result<Body, FileError> {
    let table = value.table()?;
    table.only(&["mass", "com", "inertia"])?;
    let body = body(&table)?;
    physical_body(&body).map_err(|(problem, expected)| value.error(problem, expected))?;
    Ok(body)
}

/// One number for all joints, or one for each.
pub(in crate::read) fn per_joint(
    value: &Value<'_>,
    robot: &Robot,
    what: &str,
    one: impl Fn(&Value<'_>) -> Result<f64, FileError>,
) -> Result<Vec<f64>, FileError> {
    if !value.is_array() {
        return Ok(vec![one(value)?; robot.dof()]);
    }
    value.numbers(robot.dof(), &per_joint_text(robot, what))?;
    value.array("")?.iter().map(one).collect()
}

pub(super) fn per_joint_text(robot: &Robot, what: &str) -> String {
    match robot.dof() {
        1 => format!("{what} for the one joint"),
        n => format!("{what} for each of the {n} joints"),
    }
}
