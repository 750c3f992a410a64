//! The measured arms, in a scene that all peers support too.

use dynamics_core::Term;
use robot_compiler::{FileError, Robot, SceneFile};
use std::path::{Path, PathBuf};

/// The arms, by the names of their files and modules. Six joints each.
pub const ARMS: [&str; 3] = ["ur5", "puma560", "stanford"];

/// An arm on the floor: gravity and velocity terms; no rotors, nothing held, nothing touched.
///
/// # Errors
/// A robot file that cannot be read.
pub fn scene(arm: &str) -> Result<SceneFile, FileError> {
    // The package `bench` reads this file too; `robots` is above each of them.
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut paths = above.map(|folder| folder.join(format!("robots/{arm}.toml")));
    let path = paths.find(|path| path.exists()).unwrap_or_else(|| PathBuf::from(format!("robots/{arm}.toml")));
    let mut scene = SceneFile::default_for(Robot::load(&path)?);
    arm.clone_into(&mut scene.name);
    scene.model.rotor = Term::Absent;
    Ok(scene)
}
