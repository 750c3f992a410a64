//! The compiled part of the Python package `newtau`.
//!
//! | module | holds |
//! |---|---|
//! | `arm` | the class `Arm`, and its functions for one state and for many |
//! | `arrays` | precision, shape and memory of the arguments |
//! | `commands` | check, simulation and identification, as data for the dataclasses of the package |
//! | `compute` | one call of a function: arguments, computation, result |
//! | `load` | robot files, gravity and payload |

mod arm;
mod arrays;
mod commands;
mod compute;
mod load;

use pyo3::prelude::*;

/// Compiled part of newtau.
#[pymodule]
fn _newtau(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<arm::Arm>()?;
    module.add_function(wrap_pyfunction!(load::load, module)?)?;
    module.add_function(wrap_pyfunction!(commands::check, module)?)?;
    module.add_function(wrap_pyfunction!(commands::simulation::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(commands::identification::identify, module)?)?;
    Ok(())
}
