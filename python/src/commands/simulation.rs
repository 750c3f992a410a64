//! Simulation of a scene: the summary, and the record as arrays.

use crate::errors::{failure, file_error, internal};
use indicatif::ProgressBar;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_compiler::SceneFile;
use sim::failure::Failure;
use sim::run::record::JointSample;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Time between two checks for signals.
const SIGNALS: Duration = Duration::from_millis(20);

/// Runs a scene on the desk. Returns the program's summary as JSON, the names of the joints, and the columns of the record.
#[pyfunction]
pub(crate) fn simulate(
    py: Python<'_>,
    scene: PathBuf,
    duration: Option<f64>,
) -> PyResult<(String, Vec<String>, Bound<'_, PyDict>)> {
    let mut scene = SceneFile::load(&scene).map_err(|error| file_error(&error))?;
    if let Some(duration) = duration {
        if !(duration.is_finite() && duration > 0.0) {
            let problem = format!("duration: found {duration}; expected a time in s above zero");
            return Err(PyValueError::new_err(problem));
        }
        scene.duration = Some(duration);
    }
    let run = interruptible(py, &scene)?;
    if let Some(report) = run.failure {
        return Err(failure(Failure::Target(report)));
    }
    let names = run.record.joints().iter().map(|joint| joint.name.clone()).collect();
    let summary = serde_json::to_string(&run.summary).map_err(internal)?;
    Ok((summary, names, columns(py, &run)?))
}

/// Runs the scene on another thread, and ends it when Python has a signal, such as that of Ctrl-C.
fn interruptible(py: Python<'_>, scene: &SceneFile) -> PyResult<Run> {
    let (stop, waiting) = (AtomicBool::new(false), thread::current());
    py.detach(|| {
        thread::scope(|threads| {
            let run = threads.spawn(|| {
                let run = simulation::run(scene, &stop, &ProgressBar::hidden());
                waiting.unpark();
                run
            });
            while !run.is_finished() {
                thread::park_timeout(SIGNALS);
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    stop.store(true, Ordering::Relaxed);
                    return Err(signal);
                }
            }
            run.join().map_err(|_| internal("the simulation ended without a result"))?.map_err(failure)
        })
    })
}

/// Columns of the record: `t` and `fault` with one number a tick, the others with one for each joint, tick after tick.
fn columns<'py>(py: Python<'py>, run: &Run) -> PyResult<Bound<'py, PyDict>> {
    let record = &run.record;
    let columns = PyDict::new(py);
    columns.set_item("t", PyArray1::from_slice(py, record.time()))?;
    let each = |value: fn(&JointSample) -> f64| {
        let ticks = (0..record.ticks()).flat_map(|tick| record.tick(tick));
        PyArray1::from_iter(py, ticks.map(|sample| value(&sample)))
    };
    columns.set_item("q", each(|sample| sample.q))?;
    columns.set_item("qd", each(|sample| sample.qd))?;
    columns.set_item("q_reference", each(|sample| sample.q_reference))?;
    columns.set_item("qd_reference", each(|sample| sample.qd_reference))?;
    columns.set_item("tau", each(|sample| sample.torque))?;
    let limits = (0..record.ticks()).flat_map(|tick| record.tick(tick));
    columns.set_item("limits", PyArray1::from_iter(py, limits.map(|sample| u32::from(sample.limits.bits()))))?;
    let faults = record.faults().iter().map(|fault| fault.map_or(0, |fault| u32::from(fault.code())));
    columns.set_item("fault", PyArray1::from_iter(py, faults))?;
    if record.estimates() {
        let external = (0..record.ticks()).flat_map(|tick| record.outside(tick).0);
        columns.set_item("tau_external", PyArray1::from_iter(py, external))?;
    }
    Ok(columns)
}
