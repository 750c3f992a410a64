//! One call of a function: arguments, computation, result.

use crate::arm::Arm;
use crate::arrays::{Argument, Precision, output, precision, read, reject_shared, states};
use crate::errors::internal;
use batch_engine::arm::Singular;
use batch_engine::{ArmFloat, Quantity, evaluate};
use ndarray::{ArrayViewMut2, ArrayViewMutD, Axis};
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Fewest states for which other Python threads may run meanwhile. Below, releasing the interpreter takes longer than the work.
const RELEASED: usize = 8;

/// Evaluates a function for one state or for many, in the precision of its arguments. Results are new arrays, or `out`.
pub(crate) fn compute<'py>(
    py: Python<'py>,
    arm: &Arm,
    quantity: Quantity,
    arguments: &[Argument<'_, 'py>],
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    match precision(py, arguments)? {
        Precision::Single => compute_in::<f32>(py, arm, quantity, arguments, out),
        Precision::Double => compute_in::<f64>(py, arm, quantity, arguments, out),
    }
}

/// Evaluates a function in the precision `F`.
fn compute_in<'py, F: ArmFloat + Element>(
    py: Python<'py>,
    arm: &Arm,
    quantity: Quantity,
    arguments: &[Argument<'_, 'py>],
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let n = arm.arm.joints();
    let inputs = arguments.iter().map(|argument| read::<F>(*argument)).collect::<PyResult<Vec<_>>>()?;
    let shapes: Vec<_> = arguments.iter().zip(&inputs).map(|((name, _), input)| (*name, input.shape())).collect();
    let batch = states(&shapes, n)?;
    let count = batch.unwrap_or(1);
    let shape: Vec<usize> = batch.into_iter().chain(quantity.shape(n)).collect();
    let array = match out {
        Some(out) => {
            let array = output::<F>(out, &shape)?;
            for ((name, _), input) in arguments.iter().zip(&inputs) {
                reject_shared(name, input, &array)?;
            }
            array
        }
        None => PyArrayDyn::<F>::zeros(py, shape.as_slice(), false),
    };
    let mut writer = array.try_readwrite().map_err(|error| {
        PyValueError::new_err(format!("out: {error}; expected a writeable array that shares no memory with an input"))
    })?;
    let views: Vec<_> = inputs.iter().map(|input| input.as_array()).collect();
    let rows: Option<Vec<_>> = views.iter().map(|view| view.broadcast((count, n))).collect();
    let rows = rows.ok_or_else(|| internal("shapes"))?;
    let results = table(writer.as_array_mut(), batch.is_some(), (count, quantity.results(n)))?;
    let work = || evaluate(&arm.arm, quantity, &rows, results);
    let done = if count < RELEASED { work() } else { py.detach(work) };
    done.map_err(|singular| no_acceleration(arm, singular, batch))?;
    drop(writer);
    Ok(array.into_any())
}

/// Error about a joint that moves no inertia.
fn no_acceleration(arm: &Arm, singular: Singular, batch: Option<usize>) -> PyErr {
    let joint = arm.robot.joints.get(singular.joint).map_or("?", |joint| joint.name.as_str());
    let state = batch.map_or_else(String::new, |_| format!(" in state {}", singular.state));
    PyValueError::new_err(format!(
        "no accelerations follow from tau{state}: joint {} ({joint}) moves neither mass nor rotor, so the mass matrix is singular",
        singular.joint + 1
    ))
}

/// A result as a table: one row for each state. Results with more axes than one for each state are contiguous.
fn table<F>(array: ArrayViewMutD<'_, F>, batch: bool, shape: (usize, usize)) -> PyResult<ArrayViewMut2<'_, F>> {
    let array = if batch { array } else { array.insert_axis(Axis(0)) };
    if array.ndim() == 2 {
        array.into_dimensionality().map_err(internal)
    } else {
        array.into_shape_with_order(shape).map_err(internal)
    }
}
