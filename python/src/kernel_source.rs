//! Source text of an arm's inverse dynamics.

use crate::arm::Arm;
use crate::errors::file_error;
use dynamics_core::Term;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_compiler::emit::kernel_file::{Language, source};
use robot_compiler::kernel::{Function, Level};
use robot_compiler::names::named;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};

/// The inverse dynamics of an arm as straight-line code in this language and floating-point type.
///
/// # Errors
/// `ValueError` for an unknown language or scalar.
pub(crate) fn kernel_source(arm: &Arm, language: &str, scalar: &str) -> PyResult<String> {
    let unknown = |argument: &str, message| PyValueError::new_err(format!("{argument}: found {message}"));
    let language = named::<Language>(language).map_err(|message| unknown("language", message))?;
    let scalar = named::<ScalarChoice>(scalar).map_err(|message| unknown("scalar", message))?;
    let mut file = SceneFile::default_for(arm.robot.clone());
    file.model.gravity = Term::Constant(arm.gravity.into());
    file.model.payload = arm.payload.map_or(Term::Absent, Term::Constant);
    with_dof!(arm.robot.dof(), N => {
        let model = arm.robot.model::<N>().map_err(|error| file_error(&error))?;
        Ok(source(language, &file, &model, Function::InverseDynamics, Level::Exact, scalar.precision()))
    })
}
