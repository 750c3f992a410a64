//! The TOML form of a study file.

use super::fields::text;
use super::shown::counted;
use super::table::{Table, Value, parse};
use super::text::read_text;
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::study::{Design, Experiment, Figure, Metric, Places, Runs, Study, Vary};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

mod copies;
mod edit;
mod template;
mod vary;

pub use copies::with_robot;
pub use template::{Drawn, Template};

/// Most runs of a study.
const RUNS_MAX: u64 = 1_000_000_000_000;
/// Most figures of a run.
const METRICS_MAX: usize = 64;

const KEYS: [&str; 7] = ["name", "scene", "runs", "unset", "set", "vary", "metric"];

impl Study {
    /// Reads a study file; [`Template::load`] reads the scenes that it names.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, or a setting that is impossible.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let mut study = read(read_text(path)?)?;
        path.clone_into(&mut study.path);
        Ok(study)
    }

    /// Reads the text of a study file; errors use `path` as the file's name, and the scenes' paths are relative to it.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn from_toml_str(text: &str, path: &Path) -> Result<Self, FileError> {
        read(Source { file: path.display().to_string(), text: text.to_owned() })
    }
}

fn read(source: Source) -> Result<Study, FileError> {
    let (name, experiment, runs, places) = {
        let document = parse(&source)?;
        let root = Table::root(&source, &document);
        root.only(&KEYS)?;
        let name = text(&root.require("name", "the study's name")?, "the study's name")?;
        let folder = Path::new(&source.file).parent().unwrap_or(Path::new(""));
        experiment(&root, &source, folder, name)?
    };
    Ok(Study { name, path: PathBuf::from(&source.file), experiment, runs, source, places })
}

type Read = (String, Experiment, Runs, Places);

fn experiment(root: &Table<'_>, source: &Source, folder: &Path, name: String) -> Result<Read, FileError> {
    const SCENE: &str = "the path of a scene file, relative to this file";
    let scene = root.require("scene", SCENE)?;
    let set = vary::settings(root, source)?;
    let vary = vary::varied(root, source)?;
    let (runs, count) = runs(root, &vary)?;
    let metrics = metrics(root)?;
    let places = Places { scene: scene.span.clone(), count };
    let experiment = Experiment { scene: folder.join(scene.string(SCENE)?), set, vary, metrics };
    Ok((name, experiment, runs, places))
}

/// The runs, and the location of their number in the file.
fn runs(root: &Table<'_>, vary: &[Vary]) -> Result<(Runs, Option<Range<usize>>), FileError> {
    const EITHER: &str = "exactly one of `count`, `sobol` (numbers of runs) and `grid = true`";
    let table = root.require("runs", "a [runs] table with `count`, `sobol` or `grid`")?.table()?;
    table.only(&["count", "sobol", "grid", "seed"])?;
    const SEED: &str = "a whole number of zero or more";
    let seed = table.get("seed").map_or(Ok(1), |value| value.whole(i64::MAX as u64, SEED))?;
    let given: Vec<&str> = ["count", "sobol", "grid"].into_iter().filter(|key| table.get(key).is_some()).collect();
    let &[key] = given.as_slice() else {
        let problem = if given.is_empty() { "missing".to_owned() } else { format!("given beside `{}`", given[0]) };
        return Err(table.error(given.last().unwrap_or(&"count"), problem, EITHER));
    };
    let value = table.require(key, EITHER)?;
    if key == "grid" {
        if !value.boolean()? {
            return Err(value.error("found false", EITHER));
        }
        return Ok((Runs { design: Design::Grid, count: grid(&value, vary)?, seed }, None));
    }
    if let Some(stepped) = vary.iter().find(|vary| vary.steps != 0 && vary.values.countable().is_none()) {
        let problem = format!("`{}` has `steps`, which only a grid takes", stepped.key.name);
        return Err(value.error(problem, "`grid = true`, or no `steps`"));
    }
    const COUNT: &str = "a number of runs, 1 to 1,000,000,000,000";
    let count = value.whole(RUNS_MAX, COUNT)?;
    if count == 0 {
        return Err(value.error("found 0", COUNT));
    }
    let design = if key == "sobol" { Design::Sobol } else { Design::Random };
    Ok((Runs { design, count, seed }, Some(value.span.clone())))
}

/// Number of all combinations.
fn grid(value: &Value<'_>, vary: &[Vary]) -> Result<u64, FileError> {
    let mut count: u64 = 1;
    for vary in vary {
        if vary.steps == 0 {
            let problem = format!("`{}` has no `steps`", vary.key.name);
            return Err(value.error(problem, "`steps` beside every range in a grid"));
        }
        count = count.checked_mul(vary.steps).filter(|count| *count <= RUNS_MAX).ok_or_else(|| {
            value.error("more combinations than 1,000,000,000,000", "fewer steps, or a Sobol sequence")
        })?;
    }
    Ok(count)
}

fn metrics(root: &Table<'_>) -> Result<Vec<Metric>, FileError> {
    const EXPECTED: &str = "1 to 64 [[metric]] tables, each with the `name` of a figure";
    let list = root.require("metric", EXPECTED)?;
    let items = list.array(EXPECTED)?;
    if !(1..=METRICS_MAX).contains(&items.len()) {
        return Err(list.error(format!("found {}", counted(items.len(), "table", "tables")), EXPECTED));
    }
    let mut titles = BTreeSet::new();
    items
        .iter()
        .map(|item| {
            let table = item.table()?;
            let metric = metric(&table)?;
            if !titles.insert(metric.title.clone()) {
                return Err(table.error("name", format!("`{}` is given twice", metric.title), "every figure once"));
            }
            Ok(metric)
        })
        .collect()
}

fn metric(table: &Table<'_>) -> Result<Metric, FileError> {
    const JOINT: &str = "a joint's number, 1 to 6";
    table.only(&["name", "joint", "limit", "least"])?;
    let value = table.require("name", "the name of a figure")?;
    let figure: Figure = value.named()?;
    let joint = table.get("joint").map(|value| value.count(6, JOINT)).transpose()?.map(|joint| joint as usize);
    if joint.is_some() && !figure.is_per_joint() {
        return Err(table.error("joint", "given for a figure of the whole arm", "no `joint` beside it"));
    }
    let bound = |key| table.get(key).map(|value| value.finite("a finite number")).transpose();
    let (limit, least) = (bound("limit")?, bound("least")?);
    if let (Some(limit), Some(least)) = (limit, least)
        && least > limit
    {
        return Err(table.error("least", format!("found {least}"), format!("at most the `limit` of {limit}")));
    }
    let name = crate::names::name(figure);
    let title = joint.map_or_else(|| name.to_owned(), |joint| format!("{name}.{joint}"));
    Ok(Metric { figure, joint, limit, least, title })
}
