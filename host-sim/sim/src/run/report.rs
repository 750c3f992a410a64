//! A run as a page: its arm, its curves, its numbers, and a description in sentences.
//!
//! | module | holds |
//! |---|---|
//! | `rows` | the ticks that are kept, and their size |
//! | `terms` | what each term of the controller's model contributes to the torque |
//! | `events` | waypoints, limits, faults, pushes |
//! | `words` | the run in sentences and tables |

mod events;
mod rows;
mod terms;
mod words;

use crate::failure::Failure;
use crate::run::joint_label::JointLabel;
use crate::run::simulate::Run;
use dynamics_core::{JointKind, Wrench};
use nalgebra::{Matrix3, Vector3};
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
    let joints: Vec<Value> =
        record.joints().iter().zip(model.links()).map(|(label, link)| joint(label, &link.limits)).collect();
    let chain = model.links().iter().map(|link| {
        json!({ "slides": link.kind == JointKind::Prismatic, "place": place(&link.rotation, &link.translation) })
    });
    let tip = model.tip();
    let plant = &scene.plant;
    Ok(json!({
        "name": setting.scene,
        "robot": setting.robot,
        "letter": "A",
        "period": setting.period,
        "ticks": record.ticks(),
        "stride": rows.stride,
        "joints": joints,
        "chain": chain.collect::<Vec<_>>(),
        "tip": place(&tip.rotation, &tip.translation),
        "gravity": plant.gravity.as_slice(),
        "payload": plant.payload.map(|body| json!({ "mass": body.mass, "com": body.com.as_slice() })),
        "wrenches": wrenches(scene, record.ticks() as f64 * setting.period),
        "terms": contributions.is_some(),
        "thresholds": scene.collision.as_ref().map(|spec| &spec.threshold),
        "columns": columns,
        "tip_estimate": rows.wrenches(record),
        "events": events::events(run, scene),
    }))
}

fn joint(label: &JointLabel, limits: &dynamics_core::Limits<f64>) -> Value {
    let (low, high) = limits.position;
    let finite = |x: f64| x.is_finite().then_some(x);
    json!({
        "name": label.name,
        "position_unit": label.position_unit(),
        "velocity_unit": label.velocity_unit(),
        "torque_unit": label.torque_unit(),
        "effort": label.effort(),
        "position": (low.is_finite() && high.is_finite()).then_some([low, high]),
        "velocity": finite(limits.velocity),
        "torque": finite(limits.torque),
    })
}

/// Rotation and origin as twelve numbers, row by row.
fn place(rotation: &Matrix3<f64>, origin: &Vector3<f64>) -> Vec<f64> {
    (0..3).flat_map(|row| [rotation[(row, 0)], rotation[(row, 1)], rotation[(row, 2)], origin[row]]).collect()
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
