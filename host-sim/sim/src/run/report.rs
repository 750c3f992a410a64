//! A run as a page: its arm, its curves, its numbers, and a description in sentences.
//!
//! | module | holds |
//! |---|---|
//! | [`drawing`] | the arm as the page draws it |
//! | `rows` | the ticks that are kept, and their size |
//! | `terms` | what each term of the controller's model contributes to the torque |
//! | `events` | waypoints, limits, faults, pushes |
//! | `words` | the run in sentences and tables |

pub mod drawing;
mod events;
mod rows;
mod terms;
mod words;

use crate::failure::Failure;
use crate::run::simulate::Run;
use dynamics_core::Wrench;
use report::{Block, Page};
use robot_compiler::{SceneFile, with_dof};
use rows::Rows;
use serde_json::{Value, json};

pub use words::keys;

/// Id of the page's copy of `summary.json`, which is identical except for an escaped `<`.
pub const SUMMARY: &str = "summary";

/// The page of a run.
///
/// # Errors
/// [`Failure::Input`] for an impossible robot; a scene that has run has none.
pub fn page(run: &Run, scene: &SceneFile) -> Result<Page, Failure> {
    let view = with_dof!(scene.robot.dof(), N => view::<N>(run, scene))?;
    let summary = serde_json::to_string_pretty(&run.summary).map_err(|error| Failure::Output(error.into()))? + "\n";
    let stride = view["stride"].as_u64().unwrap_or(1);
    let shown = run.summary.closest_limit.as_ref().map_or(0, |closest| closest.joint - 1);
    let events = events::events(run, scene);
    let mut blocks = vec![
        Block::Viewer(json!({ "runs": [view], "joint": shown })),
        Block::Heading("Summary".to_owned()),
        Block::Table(words::quality(run)),
        Block::Table(words::loads(run)),
        Block::Facts(words::settings(run)),
        Block::Heading("Events".to_owned()),
    ];
    blocks.extend(words::events(&events, run));
    blocks.extend([
        Block::Heading("How to read this page".to_owned()),
        Block::List(words::reading(run, stride)),
        Block::Data { id: SUMMARY, json: summary },
    ]);
    Ok(Page {
        title: format!("{}: {}", run.summary.setting.scene, run.summary.setting.robot),
        lead: words::lead(run),
        blocks,
    })
}

/// Data of the run for the page's viewer.
fn view<const N: usize>(run: &Run, scene: &SceneFile) -> Result<Value, Failure> {
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    let (record, setting) = (&run.record, &run.summary.setting);
    let contributions = terms::Contributions::new(scene, &model);
    let rows = Rows::new(record, contributions.as_ref().map_or(0, terms::Contributions::count));
    let mut columns = rows.columns(record);
    if let Some(contributions) = &contributions {
        columns.extend(contributions.columns(record, rows.stride));
    }
    let mut view = drawing::of(scene, &model, record.joints());
    let of_run = json!({
        "name": setting.scene,
        "robot": setting.robot,
        "letter": "A",
        "period": setting.period,
        "ticks": record.ticks(),
        "stride": rows.stride,
        "wrenches": wrenches(scene, record.ticks() as f64 * setting.period),
        "terms": contributions.is_some(),
        "thresholds": scene.collision.as_ref().map(|spec| &spec.threshold),
        "columns": columns,
        "tip_estimate": rows.wrenches(record),
        "events": events::events(run, scene),
    });
    if let (Value::Object(view), Value::Object(of_run)) = (&mut view, of_run) {
        view.extend(of_run);
    }
    Ok(view)
}

/// Wrenches that act on the tip of the simulated arm, and their times.
fn wrenches(scene: &SceneFile, end: f64) -> Vec<Value> {
    let value = |name: &str, from: f64, to: f64, wrench: &Wrench<f64>| {
        let (force, moment) = (wrench.force.as_slice(), wrench.moment.as_slice());
        json!({ "name": name, "from": from, "to": to, "force": force, "moment": moment })
    };
    let steady = scene.plant.tip_wrench.as_ref().map(|wrench| value("contact", 0.0, end, wrench));
    let push = scene.plant.push.as_ref().map(|push| value("push", push.at, push.at + push.duration, &push.wrench));
    steady.into_iter().chain(push).collect()
}
