//! The TOML form of a scene file.

use super::fields::text;
use super::linkage::refuse;
use super::table::{Table, parse};
use super::text::read_text;
use crate::describe::cut::Ends;
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::robot::Robot;
use crate::describe::scene::{ControlSpec, ModelSpec, SceneFile};
use std::path::Path;

mod auto;
mod bounds;
mod collision;
mod control;
mod entries;
mod model;
mod motion;
mod safety;
mod sensing;
pub(super) mod values;
mod world;

const SCENE_KEYS: [&str; 14] = [
    "name",
    "robot",
    "tip",
    "base",
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
impl SceneFile {
    /// Reads a scene file and its robot file.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, or a setting that is impossible.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let source = read_text(path)?;
        let mut scene = read(&source, path.parent().unwrap_or(Path::new("")))?;
        path.clone_into(&mut scene.path);
        Ok(scene)
    }

    /// Reads the text of a scene file; errors use `path` as the file's name, and the robot's path is relative to it.
    ///
    /// # Errors
    /// As [`SceneFile::load`].
    pub fn from_toml_str(text: &str, path: &Path) -> Result<Self, FileError> {
        let source = Source { file: path.display().to_string(), text: text.to_owned() };
        read(&source, path.parent().unwrap_or(Path::new("")))
    }

    /// Replaces the motion by that of another file, which has only the table `[motion]`. The simulated arm starts at the motion's start.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, or a motion that this arm cannot make.
    pub fn take_motion(&mut self, path: &Path) -> Result<(), FileError> {
        let source = read_text(path)?;
        let document = parse(&source)?;
        let root = Table::root(&source, &document);
        root.only(&["motion"])?;
        let table = root.require("motion", "a [motion] table")?.table()?;
        let motion = motion::read(&table, &self.robot)?;
        if self.plant.start == self.motion.start() {
            self.plant.start = motion.start().to_vec();
        }
        self.motion = motion;
        motion::check(self, &table)
    }

    /// The line of a key of a table, counted from 1, in the scene's current file; `None` if the file does not have
    /// the key.
    #[must_use]
    pub fn line_of(&self, table: &str, key: &str) -> Option<usize> {
        let source = read_text(&self.path).ok()?;
        let document = parse(&source).ok()?;
        let value = Table::root(&source, &document).table(table).ok()??.get(key)?;
        value.error("", "").line_column().map(|(line, _)| line)
    }
}

/// Reads a scene; the path of the robot file is relative to `folder`.
fn read(source: &Source, folder: &Path) -> Result<SceneFile, FileError> {
    read_with(source, folder, None)
}

/// As [`read`], with a robot that has been read already.
pub(super) fn read_with(source: &Source, folder: &Path, known: Option<&Robot>) -> Result<SceneFile, FileError> {
    let document = parse(source)?;
    let root = Table::root(source, &document);
    refuse(&root, "a scene that names a robot file")?;
    root.only(&SCENE_KEYS)?;
    let name = text(&root.require("name", "the scene's name")?, "the scene's name")?;
    let robot = known.map_or_else(|| robot(&root, folder), |robot| Ok(robot.clone()))?;
    let model = root.table("model")?.map_or_else(|| Ok(ModelSpec::default_for(&robot)), |t| model::read(&t, &robot))?;
    let control =
        root.table("control")?.map_or_else(|| Ok(ControlSpec::default_for(&robot)), |t| control::read(&t, &robot))?;
    let safety = safety::read(&root.table("safety")?.unwrap_or(root.empty("safety")), &robot, &control)?;
    let motion_table = root.require("motion", "a [motion] table")?.table()?;
    let motion = motion::read(&motion_table, &robot)?;
    let empty = root.empty("plant");
    let plant = world::plant(&root.table("plant")?.unwrap_or(empty), &robot, &model, &control, motion.start())?;
    let auto = root.table("model")?.map_or(Ok(None), |table| auto::read(&table, &robot))?;
    let table = root.table("actuators")?.unwrap_or(root.empty("actuators"));
    let actuators = sensing::actuators(&table, &robot, &control)?;
    let sensors_table = root.table("sensors")?.unwrap_or(root.empty("sensors"));
    let sensors = sensing::sensors(&sensors_table, &robot, &plant, &control)?;
    sensing::sensed_by_drives(&sensors_table, &robot, &actuators)?;
    let mut scene = SceneFile {
        name,
        path: Path::new(&source.file).to_path_buf(),
        duration: root.get("duration").map(|value| value.positive_up_to(1e5, "a time in s, above zero")).transpose()?,
        seed: root.get("seed").map_or(Ok(0), |value| value.whole(i64::MAX as u64, "a whole number of zero or more"))?,
        sensors,
        actuators,
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
    bounds::check(&root, &mut scene)?;
    motion::check(&scene, &motion_table)?;
    if let Some(auto) = &auto {
        auto.choose(&mut scene)?;
    }
    Ok(scene)
}

/// Reads the robot of a scene.
pub(super) fn robot(root: &Table<'_>, folder: &Path) -> Result<Robot, FileError> {
    let named = root.require("robot", "the path of a robot file, relative to this file")?;
    let path = folder.join(named.string("the path of a robot file, relative to this file")?);
    if !path.is_file() {
        let what = if path.is_dir() { "found the folder" } else { "there is no file" };
        let problem = format!("{what} {}", path.display());
        return Err(named.error(problem, "the path of a robot file, relative to this file"));
    }
    let is_toml = path.extension().is_some_and(|extension| extension == "toml");
    let end = |key, expected| {
        let Some(link) = root.get(key) else { return Ok(None) };
        if is_toml {
            let problem = "given for a TOML robot, which has one chain only";
            return Err(link.error(problem, format!("`{key}` only with a URDF robot")));
        }
        link.string(expected).map(Some)
    };
    let tip = end("tip", "the name of the link that the chain ends at")?;
    let base = end("base", "the name of the link that the arm stands on")?;
    Robot::load_between(&path, Ends { base, tip })
}
