//! The arm as a page draws it. `host-sim/report/web/src/runs.js` documents the value.

use crate::failure::Failure;
use crate::run::joint_label::JointLabel;
use dynamics_core::{JointKind, Limits, Model};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::{SceneFile, with_dof};
use serde_json::{Value, json};

/// The arm of a scene.
///
/// # Errors
/// [`Failure::Input`] for an impossible robot.
pub fn of_scene(scene: &SceneFile) -> Result<Value, Failure> {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let labels: Vec<JointLabel> = scene.robot.joints.iter().map(JointLabel::from).collect();
        Ok(of(scene, &model, &labels))
    })
}

/// The arm of a scene with this model and these joints.
pub(super) fn of<const N: usize>(scene: &SceneFile, model: &Model<f64, N>, labels: &[JointLabel]) -> Value {
    let joints: Vec<Value> = labels.iter().zip(model.links()).map(|(label, link)| joint(label, &link.limits)).collect();
    let chain = model.links().iter().map(|link| {
        json!({ "slides": link.kind == JointKind::Prismatic, "place": place(&link.rotation, &link.translation) })
    });
    let (tip, plant) = (model.tip(), &scene.plant);
    json!({
        "robot": scene.robot.name,
        "joints": joints,
        "chain": chain.collect::<Vec<_>>(),
        "tip": place(&tip.rotation, &tip.translation),
        "gravity": plant.gravity.as_slice(),
        "payload": plant.payload.map(|body| json!({ "mass": body.mass, "com": body.com.as_slice() })),
    })
}

fn joint(label: &JointLabel, limits: &Limits<f64>) -> Value {
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
