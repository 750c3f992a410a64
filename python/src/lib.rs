//! The compiled part of the Python package `newtau`.
//!
//! | module | holds |
//! |---|---|
//! | `arm` | the class `Arm`: robot, gravity and payload |
//! | `arm_methods` | its methods and properties, for one state and for many |
//! | `arrays` | precision, shape and memory of the arguments |
//! | `commands` | check, simulation and identification, as data for the dataclasses of the package |
//! | `compute` | one call of a function: arguments, computation, result |
//! | `errors` | Python's exceptions for the errors of the program |
//! | `kernel_source` | source text of an arm's inverse dynamics |
//! | `load` | robot files, gravity and payload |

mod arm;
mod arm_methods;
mod arrays;
mod commands;
mod compute;
mod errors;
mod kernel_source;
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
