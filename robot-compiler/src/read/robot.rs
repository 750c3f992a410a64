//! Robot files: TOML, and URDF.

use super::text::read_text;
use super::urdf;
use crate::describe::cut::{Ends, UrdfArm};
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::draft::Draft;
use crate::describe::link_shape::LinkShape;
use crate::describe::robot::Robot;
use std::path::Path;

pub(crate) mod actuators;
mod drive;
pub(crate) mod drive_bus;
mod heat;
mod places;
mod refusals;
mod toml;

impl Robot {
    /// Reads a robot file: TOML by the extension `.toml`, URDF by `.urdf` or `.xml`.
    ///
    /// # Errors
    /// A file that cannot be read, is not of its format, or describes no possible arm.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::load_between(path, Ends::default())
    }

    /// Reads a robot file; from a URDF, the chain between two links.
    ///
    /// # Errors
    /// As [`Robot::load`]; an end given for a TOML robot, a link that does not exist, a base that is not above the tip.
    pub fn load_between(path: &Path, ends: Ends<'_>) -> Result<Self, FileError> {
        if is_urdf(path)? {
            return Self::from_urdf(path, ends);
        }
        no_ends(path, ends)?;
        let mut robot = toml::read(&read_text(path)?)?;
        path.clone_into(&mut robot.path);
        Ok(robot)
    }

    /// Reads the text of a TOML robot file; errors use `name` as the file's name.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn from_toml_str(text: &str, name: &str) -> Result<Self, FileError> {
        toml::read(&Source { file: name.to_owned(), text: text.to_owned() })
    }

    /// Reads a URDF file.
    ///
    /// # Errors
    /// As [`Robot::load_between`].
    pub fn from_urdf(path: &Path, ends: Ends<'_>) -> Result<Self, FileError> {
        let mut robot = urdf::read(&read_text(path)?, ends)?;
        path.clone_into(&mut robot.path);
        Ok(robot)
    }

    /// Reads the text of a URDF file; errors use `name` as the file's name.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn from_urdf_str(text: &str, name: &str, ends: Ends<'_>) -> Result<Self, FileError> {
        urdf::read(&Source { file: name.to_owned(), text: text.to_owned() }, ends)
    }
}

impl UrdfArm {
    /// As [`Robot::from_urdf_str`], with the names of its links, and with gaps instead of errors for missing numbers.
    ///
    /// # Errors
    /// As [`Robot::load_between`].
    pub fn from_urdf_str(text: &str, name: &str, ends: Ends<'_>) -> Result<Self, FileError> {
        urdf::arm(&Source { file: name.to_owned(), text: text.to_owned() }, ends)
    }

    /// Cuts an arm out of a URDF file, and keeps the names of its links.
    ///
    /// # Errors
    /// As [`Robot::load_between`]; a file of another format.
    pub fn load(path: &Path, ends: Ends<'_>) -> Result<Self, FileError> {
        if !is_urdf(path)? {
            return Err(FileError::whole_file(path, "", "a robot file in TOML", "a URDF file: .urdf or .xml"));
        }
        let mut arm = urdf::arm(&read_text(path)?, ends)?;
        path.clone_into(&mut arm.robot.path);
        Ok(arm)
    }
}

impl LinkShape {
    /// Collision shapes of an arm: first the base's, then those of each moving link with what is fixed to it. Moving joints outside the chain are
    /// at zero. Empty for a TOML robot file, which has none.
    ///
    /// # Errors
    /// As [`Robot::load_between`]; a shape of an unknown form, or with a size that is not above zero.
    pub fn load(path: &Path, ends: Ends<'_>) -> Result<Vec<Self>, FileError> {
        if is_urdf(path)? { urdf::shapes(&read_text(path)?, ends) } else { Ok(Vec::new()) }
    }

    /// Reads the text of a URDF file; errors use `name` as the file's name.
    ///
    /// # Errors
    /// As [`LinkShape::load`].
    pub fn from_urdf_str(text: &str, name: &str, ends: Ends<'_>) -> Result<Vec<Self>, FileError> {
        urdf::shapes(&Source { file: name.to_owned(), text: text.to_owned() }, ends)
    }
}

impl Draft {
    /// Reads a robot file as it is; from a URDF, the chain between two links.
    ///
    /// # Errors
    /// As [`Robot::load_between`], except for bodies and limits that no arm can have: the
    /// [rules](crate::check::findings) report those.
    pub fn load_between(path: &Path, ends: Ends<'_>) -> Result<Self, FileError> {
        let mut draft = if is_urdf(path)? {
            urdf::draft(&read_text(path)?, ends)?
        } else {
            no_ends(path, ends)?;
            toml::draft(&read_text(path)?)?
        };
        path.clone_into(&mut draft.robot.path);
        Ok(draft)
    }

    /// Reads the text of a TOML robot file as it is; findings use `name` as the file's name.
    ///
    /// # Errors
    /// As [`Draft::load_between`].
    pub fn from_toml_str(text: &str, name: &str) -> Result<Self, FileError> {
        toml::draft(&Source { file: name.to_owned(), text: text.to_owned() })
    }

    /// Reads the text of a URDF file as it is; findings use `name` as the file's name.
    ///
    /// # Errors
    /// As [`Draft::load_between`].
    pub fn from_urdf_str(text: &str, name: &str, ends: Ends<'_>) -> Result<Self, FileError> {
        urdf::draft(&Source { file: name.to_owned(), text: text.to_owned() }, ends)
    }
}

/// Rejects the ends of a chain for a TOML robot.
fn no_ends(path: &Path, ends: Ends<'_>) -> Result<(), FileError> {
    let given = [("tip", ends.tip), ("base", ends.base)].into_iter().find(|(_, link)| link.is_some());
    given.map_or(Ok(()), |(end, _)| {
        let problem = "given for a TOML robot, which has one chain only";
        Err(FileError::whole_file(path, end, problem, format!("`{end}` only with a URDF robot")))
    })
}

/// True if a robot file is a URDF, by its extension; otherwise it is TOML.
fn is_urdf(path: &Path) -> Result<bool, FileError> {
    const EXPECTED: &str = "a robot file: .toml or .urdf";
    if path.is_dir() {
        return Err(FileError::whole_file(path, "", "it is a folder", EXPECTED));
    }
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    match ending.to_ascii_lowercase().as_str() {
        "toml" => Ok(false),
        "urdf" | "xml" => Ok(true),
        "xacro" => Err(FileError::whole_file(path, "", "a xacro file, from which a URDF is made", urdf::EXPAND)),
        _ => Err(FileError::whole_file(path, "", format!("the file name ends in {ending:?}"), EXPECTED)),
    }
}
