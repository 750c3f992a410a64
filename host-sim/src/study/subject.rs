//! What a command is about: a scene, or a robot in a scene made up for it.

use crate::failure::Failure;
use robot_compiler::{Robot, SceneFile};
use std::fs;
use std::path::Path;

/// An arm and what acts on it.
pub(crate) struct Subject {
    /// The scene, or [`SceneFile::default_for`] the robot.
    pub(crate) file: SceneFile,
    /// The scene's name, where the file was one.
    pub(crate) scene: Option<String>,
}

impl Subject {
    /// A scene is a TOML file that names its robot.
    pub(crate) fn load(path: &Path) -> Result<Self, Failure> {
        let is_scene = path.extension().is_some_and(|extension| extension == "toml")
            && fs::read_to_string(path).is_ok_and(|text| text.lines().any(names_a_robot));
        if is_scene {
            let file = SceneFile::load(path).map_err(Failure::input)?;
            Ok(Self { scene: Some(file.name.clone()), file })
        } else {
            let robot = Robot::load(path).map_err(Failure::input)?;
            Ok(Self { scene: None, file: SceneFile::default_for(robot) })
        }
    }
}

/// `robot = ..`: a key that a robot file has not.
fn names_a_robot(line: &str) -> bool {
    line.trim_start().strip_prefix("robot").is_some_and(|rest| rest.trim_start().starts_with('='))
}
