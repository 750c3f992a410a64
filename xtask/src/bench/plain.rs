//! The measured arms, in a scene that all compared programs support.

use dynamics_core::Term;
use robot_compiler::{FileError, Robot, SceneFile};
use std::path::{Path, PathBuf};

/// The arms, by the names of their files and modules. Each has six joints.
pub const ARMS: [&str; 3] = ["ur5", "puma560", "stanford"];

/// An arm on the floor with gravity and velocity terms; no rotors, no payload, no contact.
///
/// # Errors
/// The robot file cannot be read.
pub fn scene(arm: &str) -> Result<SceneFile, FileError> {
    // The package `bench` also includes this file; `robots` is in a folder above both packages.
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut paths = above.map(|folder| folder.join(format!("robots/{arm}.toml")));
    let path = paths.find(|path| path.exists()).unwrap_or_else(|| PathBuf::from(format!("robots/{arm}.toml")));
    let mut scene = SceneFile::default_for(Robot::load(&path)?);
    arm.clone_into(&mut scene.name);
    scene.model.rotor = Term::Absent;
    Ok(scene)
}
