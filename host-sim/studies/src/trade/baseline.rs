//! Baseline of a trade-off: a scene file, or the default scene of a robot.

use super::choice::{Choice, Every, TermSet, put, remove};
use crate::robot_or_scene::RobotOrScene;
use dynamics_core::trig::Method;
use robot_compiler::kernel::Level;
use robot_compiler::scene::{ModelTerm, MotionSpec, ScalarChoice};
use robot_compiler::{Ends, SceneFile};
use sim::failure::Failure;
use std::fs;
use std::path::Path;
use toml_edit::{Array, DocumentMut, InlineTable, Value, value};

/// The scene before any choice, as text into which choices are written.
#[derive(Clone, Debug)]
pub struct Baseline {
    /// The scene as read.
    pub file: SceneFile,
    text: DocumentMut,
}

impl Baseline {
    /// Loads a scene file or a robot file; `ends` selects the chain of a URDF robot.
    ///
    /// `terms = "auto"` is itself a choice, so it is first replaced by every term that acts in the scene's world.
    ///
    /// # Errors
    /// The file cannot be read, or the scene is invalid.
    pub fn load(path: &Path, ends: Ends<'_>) -> Result<Self, Failure> {
        let RobotOrScene { file, scene } = RobotOrScene::load(path, ends)?;
        let unreadable =
            |error: &dyn core::fmt::Display| Failure::Input(miette::miette!("{}: {error}", path.display()));
        let mut text = if scene.is_some() {
            let text = fs::read_to_string(path).map_err(|error| unreadable(&error))?;
            text.parse::<DocumentMut>().map_err(|error| unreadable(&error))?
        } else {
            made_up(&file, ends)
        };
        if file.model.auto.is_some() {
            write_out_auto(&mut text, &file);
        }
        let mut base = Self { file, text };
        base.text["robot"] = value(absolute(&base.file.robot.path).display().to_string());
        base.file = base.read(&base.text.to_string(), path)?;
        Ok(base)
    }

    /// The choice in the scene itself.
    #[must_use]
    pub fn own(&self) -> Choice {
        use dynamics_core::Term;
        use robot_compiler::scene::KernelChoice;
        let SceneFile { control, model, .. } = &self.file;
        let terms = match TermSet::of(control.law) {
            TermSet::Full if matches!(model.coriolis, Term::Absent) => TermSet::NoCoriolis,
            terms => terms,
        };
        Choice {
            scalar: control.scalar,
            trig: control.trig,
            terms,
            friction: true,
            rotors: true,
            every: Every { ticks: control.model_every, between: control.model_between },
            kernel: match control.kernel {
                KernelChoice::Regrouped => Level::Regrouped,
                KernelChoice::Exact | KernelChoice::Generic => Level::Exact,
            },
            rate: control.rate,
        }
    }

    /// The choice whose firmware is measured for the interrupt around the controller: the scene's own, in the firmware's precision, with the model
    /// evaluated in every tick.
    #[must_use]
    pub fn firmware(&self) -> Choice {
        let own = self.own();
        let trig = if own.trig == Method::Libm { Method::Polynomial } else { own.trig };
        Choice { scalar: ScalarChoice::F32, trig, every: Every::TICK, ..own }
    }

    /// Text of the scene with a choice written into it; the robot's path is absolute.
    #[must_use]
    pub fn with(&self, choice: &Choice) -> String {
        let mut text = self.text.clone();
        choice.write(&mut text, self.file.control.rate);
        text.to_string()
    }

    /// Text of the scene without some terms of its model and with its own choices; the robot's path is absolute.
    #[must_use]
    pub fn without(&self, terms: &[ModelTerm]) -> String {
        let mut text = self.text.clone();
        for term in terms {
            put(&mut text, "model", term.key(), value("absent"));
        }
        text.to_string()
    }

    /// Text of the scene with its own choices and another robot file.
    #[must_use]
    pub fn with_robot(&self, robot: &Path) -> String {
        let mut text = self.text.clone();
        text["robot"] = value(absolute(robot).display().to_string());
        text.to_string()
    }

    /// Same as [`Baseline::with`], for a file in a folder: the robot's path is relative to that folder if possible.
    #[must_use]
    pub fn with_in(&self, choice: &Choice, name: &str, folder: &Path) -> String {
        let mut text = self.text.clone();
        choice.write(&mut text, self.file.control.rate);
        text["name"] = value(name);
        text["robot"] = value(relative(&absolute(&self.file.robot.path), &absolute(folder)).display().to_string());
        text.to_string()
    }

    /// Reads a text from [`Baseline::with`].
    ///
    /// # Errors
    /// The scene does not allow the choice.
    pub fn read(&self, text: &str, path: &Path) -> Result<SceneFile, Failure> {
        SceneFile::from_toml_str(text, path).map_err(Failure::input)
    }
}

/// The default scene of a robot as a file.
fn made_up(file: &SceneFile, ends: Ends<'_>) -> DocumentMut {
    let mut text = DocumentMut::new();
    text["name"] = value(&file.name);
    text["robot"] = value("");
    for (key, link) in [("tip", ends.tip), ("base", ends.base)] {
        if let Some(link) = link {
            text[key] = value(link);
        }
    }
    put(&mut text, "motion", "kind", value("quintic"));
    let mut points = Array::new();
    if let MotionSpec::Quintic { points: there, .. } = &file.motion {
        for point in there {
            let mut table = InlineTable::new();
            table.insert("q", Value::Array(point.q.iter().copied().collect()));
            point.duration.map(|duration| table.insert("duration", duration.into()));
            points.push(table);
        }
    }
    put(&mut text, "motion", "points", value(points));
    text
}

/// Writes out the model with every term that acts according to `[plant]`.
fn write_out_auto(text: &mut DocumentMut, file: &SceneFile) {
    remove(text, "model", "terms");
    remove(text, "model", "tolerance");
    for key in ["gravity", "payload", "tip_wrench"] {
        if let Some(there) = text.get("plant").and_then(|plant| plant.get(key)).cloned() {
            put(text, "model", key, there);
        }
    }
    if !file.model.full().friction {
        put(text, "model", "friction", value("absent"));
    }
}

fn absolute(path: &Path) -> std::path::PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// `path` relative to `folder`; both are absolute. Returns `path` itself if they share no component.
fn relative(path: &Path, folder: &Path) -> std::path::PathBuf {
    let (mut there, mut here) = (path.components().peekable(), folder.components().peekable());
    let mut shared = 0;
    while let (Some(a), Some(b)) = (there.peek(), here.peek()) {
        if a != b {
            break;
        }
        shared += 1;
        there.next();
        here.next();
    }
    if shared <= 1 {
        return path.to_owned();
    }
    here.map(|_| std::path::Component::ParentDir).chain(there).collect()
}

#[cfg(test)]
mod tests {
    use super::relative;
    use std::path::Path;

    #[test]
    fn a_robot_is_found_from_another_folder() {
        let from = |path: &str, folder: &str| relative(Path::new(path), Path::new(folder)).display().to_string();
        assert_eq!(from("/a/robots/x.toml", "/a/scenes"), "../robots/x.toml");
        assert_eq!(from("/a/robots/x.toml", "/a/out/b/c"), "../../../robots/x.toml");
        assert_eq!(from("/a/x.toml", "/a"), "x.toml");
        assert_eq!(from("/b/x.toml", "/a"), "/b/x.toml");
    }
}
