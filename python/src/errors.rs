//! Python's exceptions for the errors of the program.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use robot_compiler::FileError;
use sim::failure::Failure;

/// `ValueError` with the program's message: file, line, column, field, found, expected.
pub(crate) fn file_error(error: &FileError) -> PyErr {
    PyValueError::new_err(format!("{error}; expected {}", error.expected()))
}

/// The error for a failure of a command: `ValueError` for wrong input, otherwise `RuntimeError`.
pub(crate) fn failure(failure: Failure) -> PyErr {
    let input = matches!(failure, Failure::Input(_));
    let report = failure.report();
    let mut message = report.to_string();
    if let Some(help) = report.help() {
        message += &format!("; {help}");
    }
    if input { PyValueError::new_err(message) } else { PyRuntimeError::new_err(message) }
}

/// An error that no argument can cause.
pub(crate) fn internal(error: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(format!("newtau: {error}"))
}
