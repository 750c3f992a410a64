//! The table `[model]`.

use super::values::{BODY, GRAVITY, WRENCH, payload, per_joint_text};
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::ModelSpec;
use crate::read::fields::wrench;
use crate::read::table::{Table, Value};
use dynamics_core::Term;

pub(super) fn read(table: &Table<'_>, robot: &Robot) -> Result<ModelSpec, FileError> {
    table.only(&[
        "gravity",
        "payload",
        "tip_wrench",
        "rotor",
        "coriolis",
        "friction",
        "friction_smoothing",
        "terms",
        "tolerance",
    ])?;
    let mut model = ModelSpec::default_for(robot);
    if let Some(value) = table.get("gravity") {
        model.gravity = term(&value, GRAVITY, |value| value.vector(GRAVITY))?;
    }
    if let Some(value) = table.get("payload") {
        model.payload = term(&value, BODY, payload)?;
    }
    if let Some(value) = table.get("tip_wrench") {
        model.tip_wrench = term(&value, WRENCH, |value| wrench(&value.table()?))?;
    }
    if let Some(value) = table.get("rotor") {
        let choices = [("absent", Term::Absent), ("constant", Term::Constant(())), ("live", Term::Live)];
        model.rotor = value.choice(&choices)?;
    }
    if let Some(value) = table.get("coriolis") {
        let what = per_joint_text(robot, "a velocity");
        model.coriolis = term(&value, &what, |value| value.numbers(robot.dof(), &what))?;
    }
    if let Some(value) = table.get("friction") {
        model.friction = value.choice(&[("feedforward", true), ("absent", false)])?;
        if model.friction && robot.joints.iter().all(|joint| joint.friction.is_none()) {
            return Err(
                value.error("no joint of the robot has friction", "`friction` in the robot file, or \"absent\"")
            );
        }
    }
    if let Some(value) = table.get("friction_smoothing") {
        const EXPECTED: &str = "a speed in rad/s or m/s, at least 1e-6";
        model.friction_smoothing = value.at_least(1e-6, EXPECTED)?;
    }
    Ok(model)
}

/// A term: `"absent"`, `"live"`, or the result of `constant` for any other value; `what` describes the expected value.
fn term<T: Clone>(
    value: &Value<'_>,
    what: &str,
    constant: impl FnOnce(&Value<'_>) -> Result<T, FileError>,
) -> Result<Term<T>, FileError> {
    if value.is_string() {
        value.choice_or(&[("absent", Term::Absent), ("live", Term::Live)], what)
    } else if value.is_table() || value.is_array() {
        constant(value).map(Term::Constant)
    } else {
        Err(value.mismatch(&format!("{what}, \"absent\" or \"live\"")))
    }
}
