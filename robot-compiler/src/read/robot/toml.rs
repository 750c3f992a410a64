//! The TOML form of a robot file.

use super::refusals::{field_of, remedy};
use super::{drive, drive_bus, heat, places};
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::draft::{Draft, FileKind, readable};
use crate::describe::robot::{BuildError, DOF, JointEncoder, Robot, RobotJoint};
use crate::read::fields::{body, origin, placement, text};
use crate::read::friction;
use crate::read::linkage::refuse;
use crate::read::rest;
use crate::read::shown::counted;
use crate::read::table::{Table, Value, parse};
use dynamics_core::model::Place;
use dynamics_core::{Dh, Frame, JointKind, JointSpec, Limits, ModelError, Rotor, Tool};
use nalgebra::Matrix3;
use std::path::PathBuf;

const ROBOT_KEYS: [&str; 8] = ["name", "source", "allow_unphysical", "ideal", "mounting", "rest", "joint", "tool"];
const JOINT_KEYS: [&str; 15] = [
    "name",
    "type",
    "dh",
    "mdh",
    "placement",
    "axis",
    "mass",
    "com",
    "inertia",
    "rotor",
    "friction",
    "limits",
    "encoder",
    "drive",
    "heat",
];

/// Reads an arm, and rejects an impossible one.
pub(super) fn read(source: &Source) -> Result<Robot, FileError> {
    let document = parse(source)?;
    let stated = Stated::read(source, Table::root(source, &document))?;
    stated.robot.check().map_err(|error| stated.placed(error))?;
    Ok(stated.robot)
}

/// Reads an arm as stated in its file.
pub(super) fn draft(source: &Source) -> Result<Draft, FileError> {
    let document = parse(source)?;
    let stated = Stated::read(source, Table::root(source, &document))?;
    readable(&stated.robot).map_err(|error| stated.placed(error))?;
    Ok(Draft {
        source: source.clone(),
        kind: FileKind::Toml,
        bodies: places::bodies(&stated.robot, &stated.joints, stated.tool.as_ref()),
        places: stated.joints.iter().map(|table| places::joint(table, &stated.root)).collect(),
        remarks: places::open_lines(source),
        angles: places::angles(&stated.joints, stated.tool.as_ref(), &stated.root),
        robot: stated.robot,
    })
}

/// An unchecked arm and the tables from which it was read.
struct Stated<'a> {
    robot: Robot,
    root: Table<'a>,
    joints: Vec<Table<'a>>,
    tool: Option<Table<'a>>,
}

impl<'a> Stated<'a> {
    fn read(source: &Source, root: Table<'a>) -> Result<Self, FileError> {
        refuse(&root, "an arm with [[joint]] tables")?;
        root.only(&ROBOT_KEYS)?;
        let name = text(&root.require("name", "the robot's name")?, "the robot's name")?;
        let origin = origin(&root)?;
        let allow_unphysical = root
            .get("allow_unphysical")
            .map(|value| text(&value, "the reason, as a string that is not empty, why impossible bodies are accepted"))
            .transpose()?;
        let ideal = root
            .get("ideal")
            .map(|value| text(&value, "the reason, as a string that is not empty, why what is left out is ideal"))
            .transpose()?;
        let tables = joint_tables(&root)?;
        let joints = tables.iter().map(joint).collect::<Result<Vec<_>, _>>()?;
        for (index, table) in tables.iter().enumerate() {
            if joints.iter().take(index).any(|before| before.name == joints[index].name) {
                let problem = format!("{:?} names two joints", joints[index].name);
                return Err(table.error("name", problem, "a name of its own for every joint"));
            }
        }
        drive_bus::check(&joints, &tables)?;
        let rest = root.get("rest").map(|value| rest::read(&value, &joints)).transpose()?;
        let tool = root.table("tool")?;
        let mounting = root.table("mounting")?.as_ref().map(mounting).transpose()?;
        let robot = Robot {
            name,
            source: origin,
            allow_unphysical,
            ideal,
            joints,
            tool: tool.as_ref().map_or(Ok(Tool::default()), read_tool)?,
            rest,
            mounting,
            path: PathBuf::from(&source.file),
        };
        Ok(Self { robot, root, joints: tables, tool })
    }

    /// The core's error, reported at the field that caused it.
    fn placed(&self, error: BuildError) -> FileError {
        placed(error, &self.robot, &self.joints, self.tool.as_ref().unwrap_or(&self.root))
    }
}

fn joint_tables<'a>(root: &Table<'a>) -> Result<Vec<Table<'a>>, FileError> {
    const EXPECTED: &str = "one to six [[joint]] tables, base first";
    let list = root.require("joint", EXPECTED)?;
    let items = list.array(EXPECTED)?;
    if !DOF.contains(&items.len()) {
        return Err(list.error(format!("found {}", counted(items.len(), "joint", "joints")), EXPECTED));
    }
    let named = |(index, item): (usize, &Value<'a>)| {
        let table = item.table()?.named(format!("joint {}", index + 1));
        table.only(&JOINT_KEYS)?;
        let name = text(&table.require("name", "the joint's name")?, "the joint's name")?;
        Ok(table.named(Robot::joint_label(index, &name)))
    };
    items.iter().enumerate().map(named).collect()
}

fn joint(table: &Table<'_>) -> Result<RobotJoint, FileError> {
    let name = text(&table.require("name", "the joint's name")?, "the joint's name")?;
    let kind = table
        .require("type", "revolute or prismatic")?
        .choice(&[("revolute", JointKind::Revolute), ("prismatic", JointKind::Prismatic)])?;
    let spec = JointSpec {
        kind,
        frame: frame(table)?,
        body: body(table)?,
        rotor: table.table("rotor")?.as_ref().map_or(Ok(Rotor::default()), rotor)?,
        limits: table.table("limits")?.as_ref().map_or(Ok(Limits::none()), limits)?,
    };
    let encoder = table.table("encoder")?.as_ref().map(|encoder| read_encoder(encoder, kind)).transpose()?;
    let drive = table.table("drive")?;
    let drive = drive.map(|drive| drive::read(&drive, &spec.limits, &spec.rotor, encoder.as_ref())).transpose()?;
    let heat = heat::read(table, drive.as_ref())?;
    Ok(RobotJoint {
        name,
        spec,
        friction: table.table("friction")?.as_ref().map(friction::of_joint).transpose()?,
        encoder,
        drive,
        heat,
    })
}

/// The joint's frame, from exactly one of the three forms in which it can be given.
fn frame(table: &Table<'_>) -> Result<Frame, FileError> {
    const EXPECTED: &str = "exactly one of `dh`, `mdh`, `placement`";
    let given: Vec<&str> = ["dh", "mdh", "placement"].into_iter().filter(|key| table.get(key).is_some()).collect();
    if let [first, second, ..] = given.as_slice() {
        return Err(table.error(second, format!("given beside `{first}`"), EXPECTED));
    }
    let frame = if let Some(place) = table.table("placement")? {
        let (rotation, translation) = placement(&place)?;
        let unit = "the unit vector [x, y, z] that the joint turns about or slides along";
        let axis = table.require("axis", unit)?.vector(unit)?;
        return Ok(Frame::Placement { rotation, translation, axis });
    } else if let Some(row) = table.table("dh")? {
        Frame::ClassicalDh(dh(&row)?)
    } else if let Some(row) = table.table("mdh")? {
        Frame::ModifiedDh(dh(&row)?)
    } else {
        return Err(table.error("dh", "missing: nothing says where the joint sits", EXPECTED));
    };
    if table.get("axis").is_some() {
        return Err(table.error(
            "axis",
            "given beside a DH row",
            "no axis: it is z in a DH row, and free with `placement`",
        ));
    }
    Ok(frame)
}

/// Orientation of the base frame in a world whose z axis points up.
fn mounting(table: &Table<'_>) -> Result<Matrix3<f64>, FileError> {
    table.only(&["rpy"])?;
    Ok(placement(table)?.0)
}

fn dh(row: &Table<'_>) -> Result<Dh, FileError> {
    row.only(&["a", "alpha", "d", "theta"])?;
    let length = |key| row.require(key, "a length in m")?.finite("a length in m");
    let angle = |key| row.require(key, "an angle in rad")?.finite("an angle in rad");
    Ok(Dh { a: length("a")?, alpha: angle("alpha")?, d: length("d")?, theta: angle("theta")? })
}

fn rotor(table: &Table<'_>) -> Result<Rotor, FileError> {
    table.only(&["inertia", "gear"])?;
    let inertia = table.require("inertia", "the rotor's inertia in kg m^2")?.finite("the rotor's inertia in kg m^2")?;
    const GEAR: &str = "rotor turns per joint turn (rad per m on a prismatic joint), not zero";
    let gear = table.require("gear", GEAR)?;
    let ratio = gear.finite(GEAR)?;
    if ratio == 0.0 { Err(gear.error("found 0", GEAR)) } else { Ok(Rotor { inertia, gear: ratio }) }
}

fn limits(table: &Table<'_>) -> Result<Limits<f64>, FileError> {
    table.only(&["position", "velocity", "torque", "torque_rate"])?;
    let mut limits = Limits::none();
    if let Some(value) = table.get("position") {
        const EXPECTED: &str = "[lowest, highest] in rad or m";
        let ends = value.array(EXPECTED)?;
        let [lo, hi] = ends.as_slice() else {
            return Err(value.error(format!("found {}", counted(ends.len(), "entry", "entries")), EXPECTED));
        };
        limits.position = (limit(lo, "a position in rad or m")?, limit(hi, "a position in rad or m")?);
    }
    let bound = |key, expected| table.get(key).map_or(Ok(f64::INFINITY), |value| limit(&value, expected));
    limits.velocity = bound("velocity", "a speed in rad/s or m/s")?;
    limits.torque = bound("torque", "a torque in N m or force in N")?;
    limits.torque_rate = bound("torque_rate", "a rate in N m/s or N/s")?;
    Ok(limits)
}

/// A number that may be infinite.
fn limit(value: &Value<'_>, expected: &str) -> Result<f64, FileError> {
    let number = value.number(expected)?;
    if number.is_nan() { Err(value.error("found nan", expected)) } else { Ok(number) }
}

fn read_encoder(table: &Table<'_>, kind: JointKind) -> Result<JointEncoder, FileError> {
    let key = match kind {
        JointKind::Revolute => "counts_per_turn",
        // Both keys hold the same number: a slide has no turn, but robot files may use one key for all joints.
        JointKind::Prismatic if table.get("counts_per_metre").is_some() => "counts_per_metre",
        JointKind::Prismatic => "counts_per_turn",
    };
    table.only(&[key])?;
    const EXPECTED: &str = "counts per joint turn (per metre on a prismatic joint), above zero";
    Ok(JointEncoder { counts_per_turn: table.require(key, EXPECTED)?.positive(EXPECTED)? })
}

fn read_tool(table: &Table<'_>) -> Result<Tool, FileError> {
    table.only(&["placement", "mass", "com", "inertia"])?;
    let mut tool = Tool::default();
    if let Some(place) = table.table("placement")? {
        (tool.rotation, tool.translation) = placement(&place)?;
    }
    if ["mass", "com", "inertia"].iter().any(|key| table.get(key).is_some()) {
        tool.body = body(table)?;
    }
    Ok(tool)
}

fn placed(error: BuildError, robot: &Robot, joints: &[Table<'_>], tool: &Table<'_>) -> FileError {
    let (_, problem, expected) = error.describe(robot);
    let (table, what) = match error {
        BuildError::Impossible(ModelError { place: Place::Joint(index), what }) => (joints.get(index), Some(what)),
        BuildError::Impossible(ModelError { place: Place::Tool, what }) => (Some(tool), Some(what)),
        BuildError::TooLarge(index) => (joints.get(index), None),
    };
    let table = table.unwrap_or(tool);
    let expected = format!("{expected}{}", what.as_ref().map_or("", remedy));
    let (outer, inner) = what.as_ref().map_or(("mass", None), field_of);
    let nested = inner.and_then(|inner| Some((table.table(outer).ok()??, inner)));
    match nested {
        Some((nested, inner)) => nested.error(inner, problem, expected),
        None => table.error(outer, problem, expected),
    }
}
