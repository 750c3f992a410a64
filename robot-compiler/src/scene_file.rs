//! The TOML form of a scene file.

use crate::body_fields::{body, wrench};
use crate::diagnostics::{FileError, Source};
use crate::linkage_file;
use crate::reader::{Table, Value, parse};
use crate::robot::{Robot, physical_body, read_text};
use crate::scene::choices::{BETWEENS, LAWS, METHODS, SCALARS};
use crate::scene::{ActuatorSpec, ControlSpec, KernelChoice, KernelMemory, ModelSpec, SceneFile, SensorSpec};
use dynamics_core::{Body, Term};
use std::path::Path;

mod auto;
mod collision;
mod motion;
mod safety;
mod world;

const SCENE_KEYS: [&str; 13] = [
    "name",
    "robot",
    "tip",
    "duration",
    "seed",
    "model",
    "control",
    "safety",
    "collision",
    "motion",
    "plant",
    "sensors",
    "actuators",
];
const BODY: &str = "a body { mass, com, inertia }";
const WRENCH: &str = "a wrench { force, moment }";
const GRAVITY: &str = "the gravitational acceleration [x, y, z] in m/s^2";

pub(crate) fn load(path: &Path) -> Result<SceneFile, FileError> {
    let source = read_text(path)?;
    let mut scene = read(&source, path.parent().unwrap_or(Path::new("")))?;
    path.clone_into(&mut scene.path);
    Ok(scene)
}

pub(crate) fn from_text(text: &str, path: &Path) -> Result<SceneFile, FileError> {
    let source = Source { file: path.display().to_string(), text: text.to_owned() };
    read(&source, path.parent().unwrap_or(Path::new("")))
}

/// `folder` is what the path of the robot file is relative to.
fn read(source: &Source, folder: &Path) -> Result<SceneFile, FileError> {
    let document = parse(source)?;
    let root = Table::root(source, &document);
    linkage_file::refuse(&root, "a scene that names a robot file")?;
    root.only(&SCENE_KEYS)?;
    let name = root.require("name", "the scene's name")?;
    let robot = robot(&root, folder)?;
    let model = root.table("model")?.map_or_else(|| Ok(ModelSpec::default_for(&robot)), |t| model(&t, &robot))?;
    let control =
        root.table("control")?.map_or_else(|| Ok(ControlSpec::default_for(&robot)), |t| control(&t, &robot))?;
    let safety = safety::safety(&root.table("safety")?.unwrap_or(root.empty("safety")), &robot, &control)?;
    let motion_table = root.require("motion", "a [motion] table")?.table()?;
    let motion = motion::read(&motion_table, &robot)?;
    let empty = root.empty("plant");
    let plant = world::plant(&root.table("plant")?.unwrap_or(empty), &robot, &model, &control, motion.start())?;
    let auto = root.table("model")?.map_or(Ok(None), |table| auto::read(&table, &robot))?;
    let mut scene = SceneFile {
        name: name.string("the scene's name")?.to_owned(),
        path: Path::new(&source.file).to_path_buf(),
        duration: root.get("duration").map(|value| value.positive_up_to(1e5, "a time in s, above zero")).transpose()?,
        seed: root.get("seed").map_or(Ok(0), |value| value.whole(i64::MAX as u64, "a whole number of zero or more"))?,
        sensors: root
            .table("sensors")?
            .map_or(Ok(SensorSpec::default()), |t| world::sensors(&t, &robot, &plant, &control))?,
        actuators: root.table("actuators")?.map_or(Ok(ActuatorSpec::default()), |t| world::actuators(&t, &control))?,
        collision: root.table("collision")?.map(|t| collision::read(&t, &robot, &control)).transpose()?,
        model,
        control,
        safety,
        motion,
        plant,
        robot,
    };
    if let Some(auto) = &auto {
        auto.know(&mut scene);
    }
    motion::check(&scene, &motion_table)?;
    if let Some(auto) = &auto {
        auto.choose(&mut scene)?;
    }
    Ok(scene)
}

/// The line of a key in a table of the file, counted from 1, if both are there.
pub(crate) fn line_of(path: &Path, table: &str, key: &str) -> Option<usize> {
    let source = read_text(path).ok()?;
    let document = parse(&source).ok()?;
    let value = Table::root(&source, &document).table(table).ok()??.get(key)?;
    value.error("", "").line_column().map(|(line, _)| line)
}

fn robot(root: &Table<'_>, folder: &Path) -> Result<Robot, FileError> {
    let named = root.require("robot", "the path of a robot file, relative to this file")?;
    let path = folder.join(named.string("the path of a robot file, relative to this file")?);
    if !path.is_file() {
        let problem = format!("there is no file {}", path.display());
        return Err(named.error(problem, "the path of a robot file, relative to this file"));
    }
    let Some(tip) = root.get("tip") else {
        return Robot::load(&path);
    };
    if path.extension().is_some_and(|extension| extension == "toml") {
        return Err(tip.error("given for a TOML robot, which has one chain only", "`tip` only with a URDF robot"));
    }
    Robot::from_urdf(&path, Some(tip.string("the name of the link that the chain ends at")?))
}

/// `"absent"`, `"live"`, or what `constant` makes of any other value; `what` says what that is.
fn term<T: Clone>(
    value: &Value<'_>,
    what: &str,
    constant: impl FnOnce(&Value<'_>) -> Result<T, FileError>,
) -> Result<Term<T>, FileError> {
    if value.is_string() {
        value.choice_or(&[("absent", Term::Absent), ("live", Term::Live)], what)
    } else {
        constant(value).map(Term::Constant)
    }
}

/// A table of mass, centre and inertia that some mass distribution could have.
fn payload(value: &Value<'_>) -> Result<Body, FileError> {
    let table = value.table()?;
    table.only(&["mass", "com", "inertia"])?;
    let body = body(&table)?;
    physical_body(&body).map_err(|(problem, expected)| value.error(problem, expected))?;
    Ok(body)
}

fn model(table: &Table<'_>, robot: &Robot) -> Result<ModelSpec, FileError> {
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

fn control(table: &Table<'_>, robot: &Robot) -> Result<ControlSpec, FileError> {
    table.only(&[
        "rate",
        "law",
        "model_every",
        "model_between",
        "natural_frequency",
        "damping",
        "trig",
        "scalar",
        "kernel",
        "kernel_memory",
        "observer_bandwidth",
        "age_max",
        "guard",
        "tunable",
    ])?;
    let mut control = ControlSpec::default_for(robot);
    let number = |key, max, expected, default| table.get(key).map_or(Ok(default), |v| v.positive_up_to(max, expected));
    control.rate = number("rate", 1e5, "a rate in Hz, above zero and at most 1e5", control.rate)?;
    let bandwidth = "a bandwidth in rad/s, above zero and at most 1e6";
    control.observer_bandwidth = number("observer_bandwidth", 1e6, bandwidth, control.observer_bandwidth)?;
    if let Some(value) = table.get("tunable") {
        control.tunable = value.boolean()?;
    }
    if let Some(value) = table.get("law") {
        control.law = value.choice(&LAWS)?;
    }
    if let Some(value) = table.get("model_every") {
        control.model_every = value.count(1000, "a whole number of ticks, 1 to 1,000")?;
    }
    if let Some(value) = table.get("model_between") {
        control.model_between = value.choice(&BETWEENS)?;
        if table.get("model_every").is_none() {
            let problem = "the model is evaluated in every tick, and nothing is between";
            return Err(value.error(problem, "`model_every` beside it, the ticks from one evaluation to the next"));
        }
    }
    if let Some(value) = table.get("trig") {
        control.trig = value.choice(&METHODS)?;
    }
    if let Some(value) = table.get("scalar") {
        control.scalar = value.choice(&SCALARS)?;
    }
    if let Some(value) = table.get("kernel") {
        control.kernel = value.choice(&[
            ("generic", KernelChoice::Generic),
            ("exact", KernelChoice::Exact),
            ("regrouped", KernelChoice::Regrouped),
        ])?;
    }
    if let Some(value) = table.get("kernel_memory") {
        control.kernel_memory = value.choice(&[("flash", KernelMemory::Flash), ("sram", KernelMemory::Sram)])?;
        if control.kernel_memory == KernelMemory::Sram && control.kernel == KernelChoice::Generic {
            return Err(value.error("the recursion is not placed in SRAM", "`kernel` exact or regrouped, or \"flash\""));
        }
    }
    if let Some(value) = table.get("natural_frequency") {
        let one = |value: &Value<'_>| value.positive_up_to(1e4, "a frequency in rad/s, above zero and at most 1e4");
        control.natural_frequency = per_joint(&value, robot, "a frequency in rad/s", one)?;
    }
    if let Some(value) = table.get("damping") {
        let one = |value: &Value<'_>| value.positive_up_to(1e3, "a damping ratio, above zero and at most 1e3");
        control.damping = per_joint(&value, robot, "a damping ratio", one)?;
    }
    if let Some(value) = table.get("age_max") {
        control.age_max = value.whole(1_000_000, "a whole number of ticks, at most 1,000,000")? as u32;
    }
    if let Some(guard) = table.table("guard")? {
        guard.only(&["position_margin", "velocity_factor"])?;
        if let Some(value) = guard.get("position_margin") {
            control.position_margin = value.not_negative("a margin in rad or m, zero or more")?;
        }
        if let Some(value) = guard.get("velocity_factor") {
            control.velocity_factor = value.at_least(1.0, "a factor of at least 1 on the velocity limit")?;
        }
    }
    Ok(control)
}

/// One number for all joints, or one for each.
fn per_joint(
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

fn per_joint_text(robot: &Robot, what: &str) -> String {
    match robot.dof() {
        1 => format!("{what} for the one joint"),
        n => format!("{what} for each of the {n} joints"),
    }
}
