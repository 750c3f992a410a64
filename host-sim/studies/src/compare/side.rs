//! A run, read from its report.

use report::page::{VIEWER_DATA, data_in};
use serde_json::Value;
use sim::failure::{Failure, in_file};
use sim::run::report::SUMMARY;
use std::path::{Path, PathBuf};

/// A run, read from its report.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    pub(super) path: PathBuf,
    pub(super) run: Value,
    pub(super) summary: Value,
}

impl Side {
    /// Reads a run from its report, or from the folder with its `report.html`.
    ///
    /// # Errors
    /// [`Failure`] if the file cannot be read, or contains no run or two runs.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let path = if path.is_dir() { path.join("report.html") } else { path.to_owned() };
        let wrong = |found: &str| {
            Failure::Input(miette::miette!(
                help = "expected a folder that `newtau run` wrote without --no-report, or its report.html",
                "{}: {found}",
                path.display()
            ))
        };
        let text = std::fs::read_to_string(&path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => wrong("there is no such file"),
            std::io::ErrorKind::InvalidData => wrong("this is no text"),
            _ => in_file(&path, &error),
        })?;
        let data = |id: &str| -> Option<Value> { serde_json::from_str(data_in(&text, id)?).ok() };
        let (Some(view), Some(summary)) = (data(VIEWER_DATA), data(SUMMARY)) else {
            return Err(wrong("no data of one run in it"));
        };
        let run = view["runs"].get(0).cloned().ok_or_else(|| wrong("no run in it"))?;
        if !run["joints"].is_array() || !run["columns"].is_object() {
            return Err(wrong("its run has no joints"));
        }
        Ok(Self { path, run, summary })
    }

    pub(super) fn joints(&self) -> &[Value] {
        self.run["joints"].as_array().map_or(&[], Vec::as_slice)
    }

    /// Name of a joint, counted from 0.
    pub(super) fn name(&self, joint: usize) -> &str {
        self.joints().get(joint).and_then(|joint| joint["name"].as_str()).unwrap_or_default()
    }

    /// A number of a joint from the summary; `list` is the JSON pointer of the list, such as `/work/given`.
    pub(super) fn number(&self, list: &str, joint: usize) -> Option<f64> {
        self.summary.pointer(list)?.get(joint)?.as_f64()
    }

    /// Time of a tick, s.
    pub(super) fn time(&self, tick: &Value) -> f64 {
        tick.as_f64().unwrap_or_default() * self.summary["period"].as_f64().unwrap_or_default()
    }

    pub(super) fn title(&self) -> String {
        let folder = self.path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        let scene = self.summary["scene"].as_str().unwrap_or_default();
        if folder == scene || folder.is_empty() { scene.to_owned() } else { format!("{scene} ({folder})") }
    }
}
