//! Parts that several kinds of file share: texts, bodies, placements, wrenches.

use crate::describe::diagnostics::FileError;
use crate::read::table::{Table, Value};
use dynamics_core::geometry::from_rpy;
use dynamics_core::{Body, Wrench};
use nalgebra::{Matrix3, Vector3};

const COM: &str = "the centre of mass [x, y, z] in m";
const INERTIA_KEYS: [&str; 6] = ["xx", "yy", "zz", "xy", "xz", "yz"];

/// Source of the numbers; empty if the file gives none.
pub(crate) fn origin(root: &Table<'_>) -> Result<String, FileError> {
    const EXPECTED: &str = "where the numbers come from";
    let Some(value) = root.get("source") else { return Ok(String::new()) };
    let found = value.string(EXPECTED)?;
    without_control(&value, found.replace(['\n', '\r', '\t'], " ").as_str(), EXPECTED)?;
    Ok(found.to_owned())
}

/// A string that is not empty, on one line, and safe to show on a terminal.
pub(crate) fn text(value: &Value<'_>, expected: &str) -> Result<String, FileError> {
    let found = value.string(expected)?;
    if found.trim().is_empty() {
        return Err(value.error("found an empty string", expected));
    }
    without_control(value, found, expected)?;
    Ok(found.to_owned())
}

/// Rejects control characters, which could control a terminal.
fn without_control(value: &Value<'_>, found: &str, expected: &str) -> Result<(), FileError> {
    found.chars().find(|c| c.is_control()).map_or(Ok(()), |c| {
        let problem = format!("found the control character {:?}", c.escape_unicode().to_string());
        Err(value.error(problem, format!("{expected}, in characters that can be printed")))
    })
}

/// `mass`, `com` and `inertia` of a table. A mass needs a centre; without an inertia it is a point mass.
pub(crate) fn body(table: &Table<'_>) -> Result<Body, FileError> {
    let mass = table.require("mass", "the mass in kg")?.finite("the mass in kg")?;
    let com = match table.get("com") {
        Some(value) => value.vector(COM)?,
        None if mass == 0.0 => Vector3::zeros(),
        None => return Err(table.error("com", "missing", COM)),
    };
    Ok(Body { mass, com, inertia: inertia(table)? })
}

/// The optional inertia tensor about the centre of mass; missing entries are zero.
fn inertia(table: &Table<'_>) -> Result<Matrix3<f64>, FileError> {
    let Some(tensor) = table.table("inertia")? else {
        return Ok(Matrix3::zeros());
    };
    tensor.only(&INERTIA_KEYS)?;
    let moment = |key| {
        tensor.require(key, "the moment of inertia in kg m^2, about the centre of mass")?.finite("a number in kg m^2")
    };
    let product = |key| tensor.get(key).map_or(Ok(0.0), |value| value.finite("a number in kg m^2"));
    let (xx, yy, zz) = (moment("xx")?, moment("yy")?, moment("zz")?);
    let (xy, xz, yz) = (product("xy")?, product("xz")?, product("yz")?);
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

/// `placement = { xyz, rpy }`, each optional: rotation and translation.
pub(crate) fn placement(table: &Table<'_>) -> Result<(Matrix3<f64>, Vector3<f64>), FileError> {
    table.only(&["xyz", "rpy"])?;
    let vector = |key, expected| table.get(key).map_or(Ok(Vector3::zeros()), |value| value.vector(expected));
    let xyz = vector("xyz", "the origin [x, y, z] in m")?;
    let rpy = vector("rpy", "roll, pitch and yaw about fixed axes, [r, p, y] in rad")?;
    Ok((from_rpy(rpy.x, rpy.y, rpy.z), xyz))
}

/// `{ force, moment }`, each optional.
pub(crate) fn wrench(table: &Table<'_>) -> Result<Wrench<f64>, FileError> {
    table.only(&["force", "moment"])?;
    let vector = |key, expected| table.get(key).map_or(Ok(Vector3::zeros()), |value| value.vector(expected));
    Ok(Wrench {
        force: vector("force", "the force [x, y, z] in N")?,
        moment: vector("moment", "the moment [x, y, z] in N m")?,
    })
}
