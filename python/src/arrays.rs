//! Arguments of a function: their precision, their shape and their memory.

use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods, dtype};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// An argument: its name, and the object that the caller gave.
pub(crate) type Argument<'a, 'py> = (&'static str, &'a Bound<'py, PyAny>);

/// Precision of a computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    /// Every argument is float32, or NumPy's promotion gives float32.
    Single,
    /// All others.
    Double,
}

/// The precision of the arguments by NumPy's promotion: float32 if that is the common type, otherwise float64.
///
/// # Errors
/// `TypeError` for a type that float64 cannot hold, and for a masked array.
pub(crate) fn precision(py: Python<'_>, arguments: &[Argument<'_, '_>]) -> PyResult<Precision> {
    if arguments.iter().all(|(_, object)| is_plain::<f64>(object)) {
        return Ok(Precision::Double);
    }
    if arguments.iter().all(|(_, object)| is_plain::<f32>(object)) {
        return Ok(Precision::Single);
    }
    let numpy = py.import("numpy")?;
    let mut types = Vec::new();
    for (name, object) in arguments {
        reject_masked(name, object)?;
        let array = as_array(&numpy, name, object)?;
        let found = array.getattr("dtype")?;
        let kind: String = found.getattr("kind")?.extract()?;
        let size: usize = found.getattr("itemsize")?.extract()?;
        if !matches!(kind.as_str(), "b" | "i" | "u" | "f") || size > 8 {
            return Err(PyTypeError::new_err(format!(
                "{name}: found an array of {found}; expected float64, float32, or a type that converts to one of them without loss: \
                 a shorter float, an integer or a boolean"
            )));
        }
        types.push(found);
    }
    let common = numpy.call_method1("result_type", PyTuple::new(py, types)?)?;
    Ok(if common.eq(dtype::<f32>(py))? { Precision::Single } else { Precision::Double })
}

/// True if an object is an array of `F`, and not of a subclass of `numpy.ndarray`.
fn is_plain<F: Element>(object: &Bound<'_, PyAny>) -> bool {
    object.is_exact_instance_of::<PyUntypedArray>() && object.is_instance_of::<PyArrayDyn<F>>()
}

/// Rejects a masked array, and a list or tuple of masked arrays. `numpy.asarray` drops the mask without a warning.
///
/// # Errors
/// `TypeError` that names two ways to make a plain array.
fn reject_masked(name: &str, object: &Bound<'_, PyAny>) -> PyResult<()> {
    if object.is_exact_instance_of::<PyUntypedArray>() {
        return Ok(());
    }
    let class = object.py().import("numpy.ma")?.getattr("MaskedArray")?;
    let mut masked = object.is_instance(&class)?;
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        for item in object.try_iter()? {
            masked |= item?.is_instance(&class)?;
        }
    }
    if !masked {
        return Ok(());
    }
    Err(PyTypeError::new_err(format!(
        "{name}: found a masked array; expected an array without a mask, because the numbers under the mask would be used. \
         numpy.ma.filled({name}, numpy.nan) makes the results of masked states NaN; numpy.ma.compress_rows({name}) drops these states"
    )))
}

/// An object as an array, as `numpy.asarray` makes it.
fn as_array<'py>(numpy: &Bound<'py, PyModule>, name: &str, object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    numpy.call_method1("asarray", (object,)).map_err(|error| {
        let found = object.get_type();
        let reason = error.value(object.py()).to_string();
        PyValueError::new_err(format!("{name}: cannot convert {found} to an array of numbers: {reason}"))
    })
}

/// An array of `F` with the numbers of an argument: the argument itself, if its memory can be read as it is.
pub(crate) fn read<'py, F: Element + Copy>((name, object): Argument<'_, 'py>) -> PyResult<PyReadonlyArrayDyn<'py, F>> {
    let array = match object.cast::<PyArrayDyn<F>>() {
        Ok(array) if is_aligned(array) => array.clone(),
        _ => {
            let py = object.py();
            let numpy = py.import("numpy")?;
            let array = as_array(&numpy, name, object)?;
            // A copy, aligned and in this machine's byte order.
            let array = array.call_method1("astype", (dtype::<F>(py),))?;
            array.cast_into::<PyArrayDyn<F>>().map_err(PyErr::from)?
        }
    };
    array.try_readonly().map_err(|error| {
        PyValueError::new_err(format!("{name}: another call writes to this array at the same time ({error})"))
    })
}

/// True if address and strides are multiples of the size of an element.
fn is_aligned<F: Element>(array: &Bound<'_, PyArrayDyn<F>>) -> bool {
    let size = size_of::<F>();
    (array.data() as usize).is_multiple_of(align_of::<F>())
        && array.strides().iter().all(|stride| stride.unsigned_abs().is_multiple_of(size))
}

/// Number of states of the arguments: `None` if all have the shape `(n,)`.
///
/// # Errors
/// `ValueError` with the name of the first argument that has another shape, its shape, and the expected one.
pub(crate) fn states(shapes: &[(&'static str, &[usize])], joints: usize) -> PyResult<Option<usize>> {
    let mut batch: Option<(&str, usize)> = None;
    for (name, shape) in shapes {
        match (*shape, batch) {
            ([n], _) if *n == joints => {}
            ([count, n], None) if *n == joints => batch = Some((name, *count)),
            ([count, n], Some((first, others))) if *n == joints => {
                if *count != others {
                    return Err(shape_error(name, shape, &format!("({others}, {joints}), as {first} has")));
                }
            }
            _ => return Err(shape_error(name, shape, &format!("({joints},) or (batch, {joints})"))),
        }
    }
    Ok(batch.map(|(_, count)| count))
}

/// Error about the shape of an argument.
pub(crate) fn shape_error(name: &str, found: &[usize], expected: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: found shape {}; expected {expected}", shown(found)))
}

/// A shape as Python prints it.
pub(crate) fn shown(shape: &[usize]) -> String {
    let all: Vec<String> = shape.iter().map(ToString::to_string).collect();
    if let [one] = all.as_slice() { format!("({one},)") } else { format!("({})", all.join(", ")) }
}

/// True if no two elements of an array share memory. Strides are in bytes.
///
/// With the axes in order of their strides' lengths, each stride must reach past all elements of the shorter axes. Every slice and
/// transposition of an ordinary array has this property. Some unusual layouts from `as_strided` do not have it although their elements
/// are distinct; for these the answer is also false.
fn is_injective(shape: &[usize], strides: &[isize], size: usize) -> bool {
    if shape.contains(&0) {
        return true;
    }
    let axes = shape.iter().zip(strides).filter(|(length, _)| **length > 1);
    let mut axes: Vec<(usize, usize)> = axes.map(|(length, stride)| (stride.unsigned_abs(), *length)).collect();
    axes.sort_unstable();
    let mut extent = size;
    axes.into_iter().all(|(stride, length)| {
        let past = stride >= extent;
        extent = extent.saturating_add(stride.saturating_mul(length - 1));
        past
    })
}

/// The caller's array for the result, checked.
///
/// # Errors
/// `TypeError` if it is not an array of `F`, or is masked; `ValueError` for another shape, or for elements that share memory.
pub(crate) fn output<'py, F: Element + Copy>(
    out: &Bound<'py, PyAny>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<F>>> {
    reject_masked("out", out)?;
    let Ok(array) = out.cast::<PyArrayDyn<F>>() else {
        let array = out.cast::<PyUntypedArray>();
        let found = array.map_or_else(|_| out.get_type().to_string(), |array| format!("an array of {}", array.dtype()));
        let expected = dtype::<F>(out.py());
        let problem = format!("out: found {found}; expected an array of {expected}, which the inputs have");
        return Err(PyTypeError::new_err(problem));
    };
    if array.shape() != shape {
        return Err(shape_error("out", array.shape(), &shown(shape)));
    }
    if !is_aligned(array) {
        return Err(PyValueError::new_err("out: found elements that are not aligned; expected an aligned array"));
    }
    if !is_injective(array.shape(), array.strides(), size_of::<F>()) {
        let (shape, strides) = (shown(array.shape()), array.strides());
        return Err(PyValueError::new_err(format!(
            "out: found elements that share memory (shape {shape}, strides {strides:?} bytes); expected an array whose elements are \
             distinct, such as numpy.empty({shape})"
        )));
    }
    Ok(array.clone())
}

/// Rejects an `out` that shares memory with an input.
///
/// rust-numpy compares two arrays only if they have the same base object. Arrays from `as_strided` or from two memoryviews of one
/// buffer have different ones.
///
/// # Errors
/// `ValueError` with the name of the input. Also if NumPy cannot decide within its work limit.
pub(crate) fn reject_shared<F: Element>(
    name: &str,
    input: &Bound<'_, PyArrayDyn<F>>,
    out: &Bound<'_, PyArrayDyn<F>>,
) -> PyResult<()> {
    let ((first, past), (out_first, out_past)) = (bounds(input), bounds(out));
    if first >= out_past || out_first >= past {
        return Ok(());
    }
    let answer = out.py().import("numpy")?.call_method1("shares_memory", (input, out, WORK));
    if answer.and_then(|shared| shared.is_truthy()).unwrap_or(true) {
        return Err(PyValueError::new_err(format!(
            "out: found memory that {name} has too; expected a writeable array that shares no memory with an input"
        )));
    }
    Ok(())
}

/// Largest number of candidate solutions that NumPy examines for common memory of two arrays. Slices of one array needed one (measured).
const WORK: usize = 1000;

/// Addresses of an array's first byte, and of the first byte after it.
fn bounds<F: Element>(array: &Bound<'_, PyArrayDyn<F>>) -> (usize, usize) {
    let start = array.data() as usize;
    if array.shape().contains(&0) {
        return (start, start);
    }
    let (mut first, mut past) = (start, start.saturating_add(size_of::<F>()));
    for (length, stride) in array.shape().iter().zip(array.strides()) {
        let reach = stride.unsigned_abs().saturating_mul(length - 1);
        if *stride < 0 {
            first = first.saturating_sub(reach);
        } else {
            past = past.saturating_add(reach);
        }
    }
    (first, past)
}
