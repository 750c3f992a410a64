//! Identification of an arm from logs.

use crate::errors::{failure, file_error};
use identification::identify::Settings;
use identification::log::{ColumnNames, Log};
use identification::verdict::Grade;
use nalgebra::Vector3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_compiler::{Ends, Robot};
use serde_json::{Value, json};
use std::path::PathBuf;
use studies::identify::{LogOptions, Outcome, Subject, verdict};

/// Files and options of an identification, as the package gives them.
#[derive(FromPyObject)]
pub(crate) struct Request {
    robot: PathBuf,
    logs: Vec<PathBuf>,
    validate: Vec<PathBuf>,
    tip: Option<String>,
    base: Option<String>,
    gravity: Option<[f64; 3]>,
    degrees: bool,
    torque_per_ampere: Option<Vec<f64>>,
    columns: Option<String>,
    trust: f64,
    plain_friction: bool,
    accept_doubtful: bool,
}

/// Identifies an arm. Returns the program's JSON, with the text of the robot file if the verdict allows one.
#[pyfunction]
pub(crate) fn identify(py: Python<'_>, request: Request) -> PyResult<String> {
    py.detach(|| identified(&request)).map(|found| found.to_string())
}

fn identified(request: &Request) -> PyResult<Value> {
    if request.logs.is_empty() {
        return Err(PyValueError::new_err("logs: found no file; expected a record of the arm's motion"));
    }
    if !(request.trust > 0.0 && request.trust.is_finite()) {
        let problem = format!("trust: found {}; expected a number above zero", request.trust);
        return Err(PyValueError::new_err(problem));
    }
    let ends = Ends { base: request.base.as_deref(), tip: request.tip.as_deref() };
    let robot = Robot::load_between(&request.robot, ends).map_err(|error| file_error(&error))?;
    let gravity = request.gravity.map_or_else(|| robot.gravity(), Vector3::from);
    // A mass grows with the square of a length.
    let subject = Subject::load(&request.robot, ends, gravity, 0.5 * request.trust).map_err(failure)?;
    let columns = request.columns.as_deref().map(ColumnNames::parse).transpose();
    let options = LogOptions {
        degrees: request.degrees,
        torque_per_ampere: request.torque_per_ampere.clone(),
        columns: columns.map_err(|problem| PyValueError::new_err(format!("columns: {problem}")))?,
        ..LogOptions::default()
    };
    let mut notes = Vec::new();
    let mut logs = Vec::new();
    for path in &request.logs {
        match subject.log(path, &options, &mut notes) {
            Ok(log) => logs.push(log),
            // The log contains motions that the arm cannot make. A wrong sign or scale may be the reason.
            Err(error) => {
                let refused = subject.explained(path, &options).ok_or_else(|| failure(error))?;
                return Ok(json!({ "robot": subject.robot.name, "verdict": verdict::json(&refused, &subject) }));
            }
        }
    }
    let resting = LogOptions { may_rest: true, ..options };
    let read = |path: &PathBuf| subject.log(path, &resting, &mut notes).map_err(failure);
    let validation: Vec<Log> = request.validate.iter().map(read).collect::<PyResult<_>>()?;
    let (same, validation): (Vec<Log>, Vec<Log>) =
        validation.into_iter().partition(|log| logs.iter().any(|other| log.is_same(other)));
    notes.extend(same.iter().map(|log| {
        format!("{}: has the samples of a log of `logs`: it is not held out and not used for validation", log.file)
    }));
    let settings = Settings { plain_friction: request.plain_friction, ..Settings::default() };
    let outcome = Outcome::of(&subject, &logs, &validation, &settings);
    let accepted = match outcome.verdict.grade {
        Grade::Trusted => true,
        Grade::Doubtful => request.accept_doubtful,
        Grade::Refused => false,
    };
    let text = accepted.then(|| outcome.numbers.robot_file(&subject, &request.robot, ends));
    let mut all = outcome.json(&subject);
    all["robot_file"] = json!(text.transpose().map_err(failure)?);
    all["notes"] = notes.into();
    Ok(all)
}
