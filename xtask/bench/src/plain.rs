//! The arms that are measured, in the scene that every neighbour can be measured in too.

use dynamics_core::Term;
use robot_compiler::{FileError, Robot, SceneFile};
use std::path::Path;

/// The arms, by the names of their files and modules. Six joints each.
pub const ARMS: [&str; 3] = ["ur5", "puma560", "stanford"];

/// An arm on the floor: gravity and velocity terms; no rotors, nothing held, nothing touched.
///
/// # Errors
/// A robot file that cannot be read.
pub fn scene(arm: &str) -> Result<SceneFile, FileError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../robots/{arm}.toml"));
    let mut scene = SceneFile::default_for(Robot::load(&path)?);
    arm.clone_into(&mut scene.name);
    scene.model.rotor = Term::Absent;
    Ok(scene)
}
