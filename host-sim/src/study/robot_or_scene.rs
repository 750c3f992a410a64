//! Input of a command: a scene, or a robot in a default scene.

use crate::failure::Failure;
use robot_compiler::{Robot, SceneFile};
use std::fs;
use std::path::Path;

/// An arm and its surroundings.
pub(crate) struct RobotOrScene {
    /// The scene; [`SceneFile::default_for`] the robot if the file is a robot.
    pub(crate) file: SceneFile,
    /// Name of the scene; `None` if the file is a robot.
    pub(crate) scene: Option<String>,
}

impl RobotOrScene {
    /// Load a scene or a robot. A scene is a TOML file that names its robot.
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

/// Recognises the key `robot = ..`, which no robot file has.
fn names_a_robot(line: &str) -> bool {
    line.trim_start().strip_prefix("robot").is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// Loads the given scene and checks that it is a scene of the given robot; without a scene, the robot's default scene.
pub(crate) fn scene_about(robot_file: &Path, scene_file: Option<&Path>) -> Result<SceneFile, Failure> {
    let robot = Robot::load(robot_file).map_err(Failure::input)?;
    let Some(path) = scene_file else { return Ok(SceneFile::default_for(robot)) };
    let file = SceneFile::load(path).map_err(Failure::input)?;
    // Compare contents: the same file may be reached by many paths.
    if (Robot { path: file.robot.path.clone(), ..robot.clone() }) == file.robot {
        return Ok(file);
    }
    let (scene, asked) = (path.display(), robot_file.display());
    Err(Failure::Input(miette::miette!(
        help = "expected a scene whose `robot` is that file",
        "{scene} is a scene of another robot, {:?}; {asked} holds {:?}",
        file.robot.name,
        robot.name
    )))
}
