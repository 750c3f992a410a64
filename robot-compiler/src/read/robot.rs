//! Robot files: TOML, and URDF.

use super::text::read_text;
use super::urdf;
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::robot::Robot;
use std::path::Path;

mod drive;
mod toml;

impl Robot {
    /// Read a robot file: TOML by the extension `.toml`, URDF by `.urdf` or `.xml`.
    ///
    /// # Errors
    /// A file that cannot be read, is not of its format, or describes no possible arm.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let mut robot = match extension {
            "toml" => toml::read(&read_text(path)?)?,
            "urdf" | "xml" => urdf::read(&read_text(path)?, None)?,
            other => {
                let problem = format!("the file name ends in {other:?}");
                return Err(FileError::whole_file(path, "", problem, "a robot file: .toml or .urdf"));
            }
        };
        path.clone_into(&mut robot.path);
        Ok(robot)
    }

    /// Reads the text of a TOML robot file; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn from_toml_str(text: &str, name: &str) -> Result<Self, FileError> {
        toml::read(&Source { file: name.to_owned(), text: text.to_owned() })
    }

    /// Read a URDF file, with the chain that ends at the link `tip`; `None` when the tree has no branch.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn from_urdf(path: &Path, tip: Option<&str>) -> Result<Self, FileError> {
        let mut robot = urdf::read(&read_text(path)?, tip)?;
        path.clone_into(&mut robot.path);
        Ok(robot)
    }

    /// Reads the text of a URDF file; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn from_urdf_str(text: &str, name: &str, tip: Option<&str>) -> Result<Self, FileError> {
        urdf::read(&Source { file: name.to_owned(), text: text.to_owned() }, tip)
    }
}
