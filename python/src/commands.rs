//! Check, simulation and identification, as data for the dataclasses of the package.

pub(crate) mod identification;
pub(crate) mod simulation;

use crate::errors::{failure, file_error, internal};
use pyo3::prelude::*;
use robot_compiler::Ends;
use robot_compiler::check::Draft;
use std::path::PathBuf;
use studies::check::answer_in;
use studies::robot_or_scene::scene_about;

/// Checks a robot file. Returns the program's JSON.
#[pyfunction]
pub(crate) fn check(
    py: Python<'_>,
    path: PathBuf,
    tip: Option<&str>,
    base: Option<&str>,
    gravity: Option<[f64; 3]>,
    scene: Option<PathBuf>,
) -> PyResult<String> {
    py.detach(|| {
        let ends = Ends { base, tip };
        let draft = Draft::load_between(&path, ends).map_err(|error| file_error(&error))?;
        let scene = scene.map(|scene| scene_about(&path, ends, Some(&scene))).transpose().map_err(failure)?;
        let gravity = gravity.unwrap_or_else(|| draft.robot.gravity().into());
        let answer = answer_in(draft, &gravity, scene).map_err(failure)?;
        serde_json::to_string(&answer.json()).map_err(internal)
    })
}
