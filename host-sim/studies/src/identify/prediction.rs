//! Measured and predicted torque as CSV.

use super::outcome::JudgedLog;
use sim::failure::{Failure, in_file};
use std::path::Path;

/// Writes `time,tau_1..tau_n,model_1..model_n`: s, and N m or N after the torque filter, evenly in time.
///
/// # Errors
/// [`Failure::Output`]: the file cannot be written.
pub fn write(judged: &JudgedLog, path: &Path) -> Result<(), Failure> {
    let prediction = &judged.prediction;
    let joints = prediction.measured.len();
    let names = |what: &str| (1..=joints).map(|joint| format!("{what}_{joint}")).collect::<Vec<_>>();
    let written = || -> Result<(), csv::Error> {
        let mut out = csv::Writer::from_path(path)?;
        out.write_record([vec!["time".to_owned()], names("tau"), names("model")].concat())?;
        for (k, time) in prediction.time.iter().enumerate() {
            let values = prediction.measured.iter().chain(&prediction.model).map(|series| format!("{:.6}", series[k]));
            out.write_record(std::iter::once(format!("{time:.6}")).chain(values))?;
        }
        Ok(out.flush()?)
    };
    written().map_err(|error| in_file(path, &error))
}
