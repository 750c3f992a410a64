//! Input of a command: a scene, or a robot in its default scene.

use robot_compiler::{Ends, Robot, SceneFile};
use sim::failure::Failure;
use sim::terminal::say_mounting;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// An arm and its surroundings.
pub struct RobotOrScene {
    /// The scene; the robot's [`SceneFile::default_for`] if the file is a robot.
    pub file: SceneFile,
    /// Name of the scene; `None` if the file is a robot.
    pub(crate) scene: Option<String>,
}

impl RobotOrScene {
    /// Loads a scene or a robot; `ends` selects the chain of a URDF robot. A scene is a TOML file that names its robot.
    pub fn load(path: &Path, ends: Ends<'_>) -> Result<Self, Failure> {
        let is_scene = path.extension().is_some_and(|extension| extension == "toml")
            && start_of(path).is_ok_and(|text| text.lines().any(names_a_robot));
        if is_scene {
            refuse_ends(path, ends)?;
            let file = SceneFile::load(path).map_err(Failure::input)?;
            say_mounting(&file.robot);
            Ok(Self { scene: Some(file.name.clone()), file })
        } else {
            let robot = Robot::load_between(path, ends).map_err(Failure::input)?;
            say_mounting(&robot);
            Ok(Self { scene: None, file: SceneFile::default_for(robot) })
        }
    }
}

fn refuse_ends(scene: &Path, ends: Ends<'_>) -> Result<(), Failure> {
    let given = [("tip", ends.tip), ("base", ends.base)].into_iter().find(|(_, link)| link.is_some());
    given.map_or(Ok(()), |(end, _)| {
        Err(Failure::Input(miette::miette!(
            help = format!("expected `{end} = ..` in the scene, or `--{end}` with a URDF robot"),
            "{}: {end}: `--{end}` is given for a scene",
            scene.display()
        )))
    })
}

/// Beginning of a file, at most 8 MiB; the readers reject larger files.
fn start_of(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(8 << 20).read_to_string(&mut text)?;
    Ok(text)
}

/// True for a line with the key `robot = ..`, which no robot file has.
fn names_a_robot(line: &str) -> bool {
    line.trim_start().strip_prefix("robot").is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// Loads the given scene and checks that it is a scene of the given robot. Without a scene, returns the robot's default scene.
pub fn scene_about(robot_file: &Path, ends: Ends<'_>, scene_file: Option<&Path>) -> Result<SceneFile, Failure> {
    let robot = Robot::load_between(robot_file, ends).map_err(Failure::input)?;
    say_mounting(&robot);
    let Some(path) = scene_file else { return Ok(SceneFile::default_for(robot)) };
    let file = SceneFile::load(path).map_err(Failure::input)?;
    // Compare contents, because the same file can have many paths, and the source of a URDF robot contains its path.
    let (path_there, source_there) = (file.robot.path.clone(), file.robot.source.clone());
    if (Robot { path: path_there, source: source_there, ..robot.clone() }) == file.robot {
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
