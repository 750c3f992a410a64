//! Comparison of two runs on one page, from their reports.
//!
//! A report contains its run's curves and `summary.json`, so logs and scenes are not needed.

mod side;
mod tables;
mod thin;
mod words;

use report::{Block, Page};
use serde_json::{Value, json};
pub use side::Side;
use sim::failure::Failure;
use sim::run::report::keys;

/// Creates the page that compares two runs.
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
    Ok(Page { title: format!("{} and {}", a.title(), b.title()), lead: words::lead(a, b), blocks })
}
