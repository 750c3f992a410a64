//! Two runs on one page, from their reports.
//!
//! A report holds its run's curves and `summary.json`: whoever has two reports needs neither logs nor scenes.

mod thin;

use crate::failure::{Failure, in_file};
use crate::run::report::SUMMARY;
use crate::run::summary::engineering;
use report::page::{VIEWER_DATA, data_in};
use report::{Block, Cell, Page, Table};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A run, read from its report.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    path: PathBuf,
    run: Value,
    summary: Value,
}

/// A number per joint of `summary.json`: its name in a table, its key, and which unit of the joint it has.
type Quantity = (&'static str, &'static str, &'static str);

const ERRORS: [Quantity; 3] = [
    ("rms", "tracking_rms", "position_unit"),
    ("max", "tracking_max", "position_unit"),
    ("at rest", "rest_error", "position_unit"),
];
const TORQUES: [Quantity; 3] = [
    ("rms", "torque_rms", "torque_unit"),
    ("peak", "torque_peak", "torque_unit"),
    ("chatter", "torque_chatter", "torque_unit"),
];

/// Settings of a run that `summary.json` names.
const SETTINGS: [&str; 8] = ["scene", "robot", "target", "scalar", "law", "trig", "period", "duration"];

impl Side {
    /// Read a run: its report, or the folder that holds `report.html`.
    ///
    /// # Errors
    /// [`Failure`] for a file that cannot be read, or that holds no run or two.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let path = if path.is_dir() { path.join("report.html") } else { path.to_owned() };
        let wrong = |found: &str| {
            Failure::Input(miette::miette!(
                help = "expected a folder that `host-sim run` wrote without --no-report, or its report.html",
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

    fn number(&self, key: &str, joint: usize) -> Option<f64> {
        self.summary[key].get(joint)?.as_f64()
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
    let mut lead = vec![format!("A: {}. B: {}.", a.title(), b.title())];
    lead.extend(greatest(a, b));
    let mut blocks = vec![
        Block::Viewer(json!({ "runs": runs, "joint": 0 })),
        Block::Heading("Differences".to_owned()),
        Block::Table(table("Position error", &ERRORS, a, b)),
        Block::Table(table("Torque or force", &TORQUES, a, b)),
        Block::Heading("Settings".to_owned()),
        Block::Facts(settings(a, b)),
    ];
    if stride > 1 {
        blocks.push(Block::Words(format!(
            "So that both fit, every {stride}th row of each report is kept, as it was; bands show the lowest and the highest value between."
        )));
    }
    Ok(Page { title: format!("{} beside {}", a.title(), b.title()), lead, blocks })
}

/// The joint with the greatest error in A, in both.
fn greatest(a: &Side, b: &Side) -> Option<String> {
    let of = |side: &Side, joint: usize| side.number("tracking_max", joint);
    let all = (0..a.joints().len()).filter_map(|joint| Some((joint, of(a, joint)?)));
    let (joint, before) = all.max_by(|x, y| x.1.total_cmp(&y.1))?;
    let after = of(b, joint)?;
    let [name, unit] = ["name", "position_unit"].map(|key| a.joints()[joint][key].as_str().unwrap_or_default());
    Some(format!(
        "Joint {} ({name}) has the greatest error in A: {} at most; in B {}, {}.",
        joint + 1,
        engineering(before, unit),
        engineering(after, unit),
        change(before, after)
    ))
}

/// Change from A to B in percent of A.
fn change(before: f64, after: f64) -> String {
    let (before, after) = (before.abs(), after.abs());
    if before.to_bits() == after.to_bits() {
        "the same".to_owned()
    } else if before > 0.0 {
        format!("{:+.1} %", 100.0 * (after / before - 1.0))
    } else {
        "more".to_owned()
    }
}

fn table(caption: &str, quantities: &[Quantity], a: &Side, b: &Side) -> Table {
    let head: Vec<String> = std::iter::once("joint".to_owned())
        .chain(quantities.iter().flat_map(|(name, ..)| [format!("A {name}"), format!("B {name}"), "change".to_owned()]))
        .collect();
    let mut table = Table::new(caption, &head.iter().map(String::as_str).collect::<Vec<_>>());
    for (index, joint) in a.joints().iter().enumerate() {
        let mut row = vec![Cell::from(joint["name"].as_str().unwrap_or_default())];
        for (_, key, unit) in quantities {
            let unit = joint[*unit].as_str().unwrap_or_default();
            let values = [a, b].map(|side| side.number(key, index));
            row.extend(values.map(|value| value.map_or("none".into(), |x| Cell::number(engineering(x, unit), x))));
            row.push(match values {
                [Some(before), Some(after)] => change(before, after).into(),
                _ => "".into(),
            });
        }
        table.row(row);
    }
    table
}

/// Settings of both, and faults.
fn settings(a: &Side, b: &Side) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let fact = |key: &str| {
        let [of_a, of_b] = [a, b].map(|side| text(&side.summary[key]));
        let said = if of_a == of_b { of_a } else { format!("A {of_a}, B {of_b}") };
        (key.to_owned(), said)
    };
    let faults = |side: &Side| {
        let all = side.summary["faults"].as_array().map_or(&[][..], Vec::as_slice);
        let messages: Vec<&str> = all.iter().filter_map(|fault| fault["message"].as_str()).collect();
        if messages.is_empty() { "none".to_owned() } else { messages.join(", ") }
    };
    let faults = ("faults".to_owned(), format!("A {}, B {}", faults(a), faults(b)));
    SETTINGS.into_iter().map(fact).chain([faults]).collect()
}
