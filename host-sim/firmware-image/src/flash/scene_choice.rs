//! Choice of the scene, and the check that the board has connections for its drives.

use crate::bad_input::BadInput;
use crate::board::Board;
use crate::can_buses;
use crate::process::{root, shown};
use anyhow::Result;
use robot_compiler::SceneFile;
use robot_compiler::drive::JointDrive;
use std::fmt;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item};

/// The user's choice.
pub(super) enum Wanted {
    /// This scene.
    Scene(PathBuf),
    /// The scene of this robot.
    Robot(PathBuf),
}

/// A scene that fits the board.
pub(super) struct Choice {
    /// Its file.
    pub(super) path: PathBuf,
    /// Drives of its joints.
    pub(super) drives: Drives,
}

/// Drives of a robot's joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drives {
    /// No drives of the board: torques go over the link to the host.
    Link,
    /// Drives of this kind, as a robot file names it.
    Kind(&'static str),
}

impl fmt::Display for Drives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link => f.write_str("joints over the link"),
            Self::Kind(kind) => f.write_str(in_words(kind)),
        }
    }
}

/// Description of a family of drives, from its name in a robot file.
fn in_words(family: &'static str) -> &'static str {
    match family {
        "mit" => "CAN drives (MIT mode)",
        "pwm" => "PWM power stages",
        other => other,
    }
}

impl Drives {
    /// The first joint is enough: loading has checked that all joints have drives of one kind, or none has.
    fn of(scene: &SceneFile) -> Self {
        let first = scene.robot.joints.first().and_then(|joint| joint.drive.as_ref());
        first.map(JointDrive::family).map_or(Self::Link, Self::Kind)
    }

    /// True if `board` has connections for these drives. A board that uses only the link accepts any arm.
    fn fit(self, board: Board) -> bool {
        board.drives().is_none_or(|kind| self == Self::Kind(kind))
    }
}

/// The requested scene, loaded and checked, if it fits the board.
///
/// # Errors
/// [`BadInput`]: a wrong file, drives of another kind, a robot with no scene or with several.
pub(super) fn choose(wanted: &Wanted, board: Board) -> Result<Choice> {
    let chosen = match wanted {
        Wanted::Scene(path) => scene(path, board),
        Wanted::Robot(path) => scene_of(path, board),
    };
    chosen.map_err(|problem| BadInput(problem).into())
}

fn scene(path: &Path, board: Board) -> Result<Choice, String> {
    let file = SceneFile::load(path).map_err(|error| BadInput::from(&error).0)?;
    let drives = Drives::of(&file);
    if !drives.fit(board) {
        let line = line_of_robot(path).map_or_else(String::new, |line| format!(":{line}"));
        let expected = in_words(board.drives().unwrap_or_default());
        return Err(format!(
            "{}{line}: robot: found {drives} ({}), expected {expected}, which {board} has lines for",
            path.display(),
            file.robot.name,
        ));
    }
    can_buses::schedules(&file, path, board)?;
    let path = path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Choice { path, drives })
}

fn scene_of(robot: &Path, board: Board) -> Result<Choice, String> {
    let robot_there = robot.canonicalize().map_err(|error| format!("--robot {}: {error}", robot.display()))?;
    let mut files = Vec::new();
    let folder = root().join("scenes");
    toml_files(&folder, &mut files).map_err(|error| format!("{}: {error}", folder.display()))?;
    files.sort();
    let about: Vec<_> = files.into_iter().filter(|scene| names_robot(scene, &robot_there)).collect();
    let named = |scenes: &[PathBuf]| scenes.iter().map(|scene| format!("\n  {}", shown(scene))).collect::<String>();
    let (mut fitting, mut others) = (Vec::new(), Vec::new());
    for path in &about {
        match scene(path, board) {
            Ok(choice) => fitting.push(choice),
            Err(problem) => others.push(problem),
        }
    }
    match (fitting.len(), about.len()) {
        (1, _) => fitting.pop().ok_or_else(String::new),
        (0, 0) => Err(format!(
            "--robot {}: found no scene under scenes/ that is about it, expected one; write it (scenes/README.md) and name it by --scene",
            robot.display()
        )),
        (0, _) => {
            Err(format!("--robot {}: none of its scenes fits {board}:\n  {}", robot.display(), others.join("\n  ")))
        }
        (count, _) => Err(format!(
            "--robot {}: found {count} scenes that fit {board}, expected one; name it by --scene:{}",
            robot.display(),
            named(&fitting.into_iter().map(|choice| choice.path).collect::<Vec<_>>())
        )),
    }
}

/// The folder of scenes for the fault-injection campaign, which are not for boards.
const CAMPAIGN: &str = "campaign";

/// Collects every TOML file in a folder and its subfolders, except those in [`CAMPAIGN`].
fn toml_files(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            if path.ends_with(CAMPAIGN) {
                continue;
            }
            toml_files(&path, found)?;
        } else if path.extension().is_some_and(|extension| extension == "toml") {
            found.push(path.canonicalize()?);
        }
    }
    Ok(())
}

/// True if the path in a scene's key `robot`, relative to the scene, is this file. The rest of the scene may be wrong.
fn names_robot(scene: &Path, robot: &Path) -> bool {
    let text = std::fs::read_to_string(scene).unwrap_or_default();
    let document = text.parse::<DocumentMut>().unwrap_or_default();
    let named = document.get("robot").and_then(Item::as_str);
    let there = named.zip(scene.parent()).and_then(|(named, folder)| folder.join(named).canonicalize().ok());
    there.is_some_and(|there| there == robot)
}

/// The line in which a scene refers to its robot, counted from 1.
fn line_of_robot(scene: &Path) -> Option<usize> {
    let text = std::fs::read_to_string(scene).ok()?;
    let names =
        |line: &str| line.trim_start().strip_prefix("robot").is_some_and(|rest| rest.trim_start().starts_with('='));
    text.lines().position(names).map(|index| index + 1)
}
