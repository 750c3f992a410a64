//! Two runs on one page, from their reports.
//!
//! A report holds its run's curves and `summary.json`: whoever has two reports needs neither logs nor scenes.
//!
//! | module | holds |
//! |---|---|
//! | `tables` | the numbers of both summaries, and how they differ |
//! | `thin` | fewer rows, so that both fit |
//! | `words` | what matters most, settings, events |

mod tables;
mod thin;
mod words;

use report::page::{VIEWER_DATA, data_in};
use report::{Block, Page};
use serde_json::{Value, json};
use sim::failure::{Failure, in_file};
use sim::run::report::{SUMMARY, keys};
use std::path::{Path, PathBuf};

/// A run, read from its report.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    path: PathBuf,
    run: Value,
    summary: Value,
}

impl Side {
    /// Read a run: its report, or the folder that holds `report.html`.
    ///
    /// # Errors
    /// [`Failure`] for a file that cannot be read, or that holds no run or two.
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

    fn joints(&self) -> &[Value] {
        self.run["joints"].as_array().map_or(&[], Vec::as_slice)
    }

    /// Name of a joint, counted from 0.
    fn name(&self, joint: usize) -> &str {
        self.joints().get(joint).and_then(|joint| joint["name"].as_str()).unwrap_or_default()
    }

    /// A number per joint of the summary, by the pointer of its list: `/work/given`.
    fn number(&self, list: &str, joint: usize) -> Option<f64> {
        self.summary.pointer(list)?.get(joint)?.as_f64()
    }

    /// Time of a tick, s.
    fn time(&self, tick: &Value) -> f64 {
        tick.as_f64().unwrap_or_default() * self.summary["period"].as_f64().unwrap_or_default()
    }

    fn title(&self) -> String {
        let folder = self.path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        let scene = self.summary["scene"].as_str().unwrap_or_default();
        if folder == scene || folder.is_empty() { scene.to_owned() } else { format!("{scene} ({folder})") }
    }
}

/// The page of two runs.
///
/// # Errors
/// [`Failure::Input`]: the arms have different joints.
pub fn page(a: &Side, b: &Side) -> Result<Page, Failure> {
    let kinds = |side: &Side| -> Vec<Value> { side.joints().iter().map(|joint| joint["effort"].clone()).collect() };
    if kinds(a) != kinds(b) {
        return Err(Failure::Input(miette::miette!(
            help = "expected two arms with as many joints of the same kinds",
            "{} has {} joints, {} has {}",
            a.path.display(),
            a.joints().len(),
            b.path.display(),
            b.joints().len()
        )));
    }
    let (runs, stride) = thin::both(&a.run, &b.run);
    let mut blocks = vec![Block::Viewer(json!({ "runs": runs, "joint": 0 })), Block::Heading("Differences".to_owned())];
    blocks.extend(tables::all(a, b).map(Block::Table));
    blocks.extend([Block::Heading("Settings".to_owned()), Block::Facts(words::settings(a, b))]);
    blocks.push(Block::Heading("Events".to_owned()));
    blocks.extend(words::events(a, b));
    blocks.extend([Block::Heading("How to read this page".to_owned()), Block::Words(keys(a.joints().len()))]);
    if stride > 1 {
        blocks.push(Block::Words(format!(
            "So that both fit, every {stride}th row of each report is kept, as it was; bands show the lowest and the highest value between."
        )));
    }
    Ok(Page { title: format!("{} beside {}", a.title(), b.title()), lead: words::lead(a, b), blocks })
}
