//! Work of the actuators along a path that is given as states over time, without a controller and without a simulation.

use super::numbers::finite;
use dynamics_core::chapter::work::WorkMeter;
use nalgebra::SVector;
use robot_compiler::{SceneFile, with_dof};
use serde::{Deserialize, Serialize};
use sim::failure::Failure;
use sim::run::numbers::engineering;
use sim::run::scene_world;
use sim::table::table;
use std::io::BufRead;

/// A state of the path.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PathState {
    /// Time, s; not before that of the previous line. Two lines with the same time are a jump of the acceleration.
    t: f64,
    /// Joint position, rad or m.
    q: Vec<f64>,
    /// Joint velocity, rad/s or m/s.
    qd: Vec<f64>,
    /// Joint acceleration, rad/s^2 or m/s^2.
    qdd: Vec<f64>,
}

/// Work along a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathWork {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// Time from the first to the last state, s.
    pub duration: f64,
    /// Number of states.
    pub samples: usize,
    /// Every joint, base first.
    pub joints: Vec<JointPathWork>,
    /// Work of all actuators, J.
    pub total: f64,
}

/// Work on a joint, J.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointPathWork {
    /// Name of the joint.
    pub name: String,
    /// Positive work of the actuator, J.
    pub positive: f64,
    /// Negative work of the actuator, J; not above zero.
    pub negative: f64,
}

/// Computes the work of the actuators of the scene's simulated arm (payload, gravity and wrench of its `[plant]`, no friction) along a path, with the
/// trapezoidal rule over `tau qd` and `tau = D qdd + h + G - J^T w`.
///
/// # Errors
/// [`Failure::Input`]: the number of the first wrong line, and what was expected there.
pub fn path_work(scene: &SceneFile, source: &str, input: &mut dyn BufRead) -> Result<PathWork, Failure> {
    with_dof!(scene.robot.dof(), N => path_work_for::<N>(scene, source, input))
}

fn path_work_for<const N: usize>(
    scene: &SceneFile,
    source: &str,
    input: &mut dyn BufRead,
) -> Result<PathWork, Failure> {
    let arm = scene_world::arm::<N>(scene)?;
    let mut meter = WorkMeter::<f64, N>::new();
    let (mut first, mut last, mut samples) = (None, 0.0, 0);
    for (index, line) in input.lines().enumerate() {
        let wrong = |problem: String| {
            let help = format!("expected {{\"t\": s, \"q\": [{N} numbers], \"qd\": [..], \"qdd\": [..]}}");
            Failure::Input(miette::miette!(help = help, "{source}, line {}: {problem}", index + 1))
        };
        let line = line.map_err(|error| wrong(error.to_string()))?;
        if line.trim().is_empty() {
            continue;
        }
        let sample: PathState = serde_json::from_str(&line).map_err(|error| wrong(error.to_string()))?;
        let list = |name: &str, values: &[f64]| finite::<N>(name, values, "one for each joint").map_err(wrong);
        let (q, qd, qdd) = (list("q", &sample.q)?, list("qd", &sample.qd)?, list("qdd", &sample.qdd)?);
        let after = first.is_none() || sample.t >= last;
        if !(after && sample.t.is_finite()) {
            return Err(wrong(format!(
                "`t` is {}; expected a finite time not before {last}, of the line before",
                sample.t
            )));
        }
        let terms = arm.terms(&q, &qd);
        let inertial = terms.mass_matrix * SVector::from(qdd);
        let tau = std::array::from_fn(|i| inertial[i] + terms.coriolis[i] + terms.gravity[i] - terms.tip[i]);
        meter.sample(if first.is_none() { 0.0 } else { sample.t - last }, &tau, &qd);
        first.get_or_insert(sample.t);
        (last, samples) = (sample.t, samples + 1);
    }
    if samples < 2 {
        return Err(Failure::Input(miette::miette!("{source}: {samples} states found; expected at least two lines")));
    }
    let joints = scene.robot.joints.iter().enumerate().map(|(i, joint)| JointPathWork {
        name: joint.name.clone(),
        positive: meter.positive()[i],
        negative: meter.negative()[i],
    });
    Ok(PathWork {
        scene: scene.name.clone(),
        robot: scene.robot.name.clone(),
        duration: last - first.unwrap_or(0.0),
        samples,
        joints: joints.collect(),
        total: meter.total().iter().sum(),
    })
}

impl PathWork {
    /// The table and the lines below it for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(["joint", "given", "taken back", "together"], 1);
        for JointPathWork { name, positive, negative } in &self.joints {
            let work = [*positive, *negative, positive + negative].map(|x| engineering(x, "J"));
            table.add_row([name.clone()].into_iter().chain(work));
        }
        let lines = [
            ("duration", format!("{}, {} states", engineering(self.duration, "s"), self.samples)),
            ("actuators", engineering(self.total, "J")),
        ];
        let lines: String = lines.iter().map(|(name, text)| format!("{name:<20}{text}\n")).collect();
        format!("{}: {}, work along a path\n{table}\n{lines}", self.scene, self.robot)
    }
}
