//! Torque errors of an arm in a scene: largest found error and proven upper bound.

use super::{Effort, LargestError, Region, State, TorqueError, search};
use crate::numbers::numbers;
use crate::posture_search::positions;
use crate::robot_or_scene::RobotOrScene;
use clap::Args;
use dynamics_core::trig::Method;
use dynamics_core::{Limits, Model};
use indicatif::ProgressBar;
use robot_compiler::kernel::Level;
use robot_compiler::names;
use robot_compiler::{Ends, Robot, with_dof};
use serde::Serialize;
use sim::failure::Failure;
use sim::run::joint_label::JointLabel;
use sim::terminal::named;
use std::path::Path;

/// Number of climbs for every joint, and of steps in each climb.
const CLIMBS: (usize, usize) = (32, 3000);

/// Divisor of the effort in the search for the largest bound of a single state, because that function is smooth and has few maxima.
const LESS: usize = 10;

/// Input of an error bound.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct BoundRequest {
    /// Difference allowed from the operations of the recursion.
    #[arg(long, value_parser = named::<Level>(), default_value = names::name(Level::Exact))]
    pub level: Level,
    /// Number of random states for the largest error found; a tenth of them for the bound of single states.
    #[arg(long, value_name = "COUNT", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: u32,
    /// Number of boxes of states for each joint's bound.
    #[arg(long, value_name = "COUNT", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub boxes: u32,
    /// Seed of the random states and climbs.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Greatest joint speeds, rad/s or m/s, one for each joint. Without it, the robot file's.
    #[arg(long, value_name = "QD1,QD2,..", value_delimiter = ',')]
    pub velocity: Option<Vec<f64>>,
    /// Greatest joint accelerations, rad/s^2 or m/s^2, one for each joint. Without it, the speed limit in 0.2 s.
    #[arg(long, value_name = "QDD1,QDD2,..", value_delimiter = ',')]
    pub acceleration: Option<Vec<f64>>,
}

/// Torque errors of an arm in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TorqueErrorBound {
    /// Name of the robot.
    pub robot: String,
    /// Name of the scene, if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// `exact` or `regrouped`.
    pub level: &'static str,
    /// Number of random states.
    pub samples: usize,
    /// Number of boxes evaluated for each joint.
    pub boxes: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Every joint, base first.
    pub joints: Vec<JointErrorBound>,
}

/// Torque error of a joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointErrorBound {
    /// Name of the joint.
    pub name: String,
    /// `N m` or `N`.
    pub unit: &'static str,
    /// Lowest and highest position, rad or m.
    pub position: (f64, f64),
    /// Greatest speed, rad/s or m/s.
    pub velocity: f64,
    /// Greatest acceleration, rad/s^2 or m/s^2.
    pub acceleration: f64,
    /// Limit of the actuator, N m or N; absent without a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// The largest error found, N m or N.
    pub found: f64,
    /// State of that error: position, velocity, acceleration.
    pub found_at: [Vec<f32>; 3],
    /// Bound for that state alone, N m or N.
    pub bound_there: f64,
    /// The largest bound found for a single state, N m or N.
    pub one_state: f64,
    /// Bound for all states in a single box, N m or N.
    pub one_box: f64,
    /// Proven bound for all states, N m or N.
    pub proven: f64,
}

/// Loads a robot or a scene. Its sine and cosine must have known errors.
pub fn load(path: &Path, ends: Ends<'_>) -> Result<RobotOrScene, Failure> {
    let subject = RobotOrScene::load(path, ends)?;
    if subject.file.control.trig != Method::Polynomial {
        let (_, trig) = subject.file.control.names();
        return Err(Failure::Input(miette::miette!(
            help = "expected trig = \"polynomial\", whose errors over every float the bound starts from",
            "{}: control.trig: \"{trig}\" has no bound",
            path.display()
        )));
    }
    Ok(subject)
}

fn effort(asked: &BoundRequest) -> Effort {
    Effort { samples: asked.samples as usize, climbs: CLIMBS.0, steps: CLIMBS.1, seed: asked.seed }
}

fn less(effort: &Effort) -> Effort {
    Effort { samples: effort.samples / LESS, climbs: effort.climbs / 4, ..*effort }
}

/// Number of states and boxes to evaluate.
pub fn work(joints: usize, asked: &BoundRequest) -> u64 {
    let effort = effort(asked);
    let states: usize =
        [effort, less(&effort)].iter().map(|effort| effort.samples + joints * effort.climbs * effort.steps).sum();
    (states + joints * asked.boxes as usize) as u64
}

/// Computes the torque errors of an arm in a scene.
///
/// # Errors
/// [`Failure::Input`]: missing limits, or limits without a finite bound.
pub fn answer(
    asked: &BoundRequest,
    subject: &RobotOrScene,
    progress: &ProgressBar,
) -> Result<TorqueErrorBound, Failure> {
    with_dof!(subject.file.robot.dof(), N => answer_for::<N>(asked, subject, progress))
}

fn answer_for<const N: usize>(
    asked: &BoundRequest,
    subject: &RobotOrScene,
    progress: &ProgressBar,
) -> Result<TorqueErrorBound, Failure> {
    let file = &subject.file;
    let model = &file.robot.model::<N>().map_err(Failure::input)?;
    let limits = model.links().map(|link| link.limits);
    let region = region(asked, &file.robot, model, &limits)?;
    let level = asked.level;
    let arm = TorqueError::new(model, &file.scene(model), &file.live(model), level);
    let (bounds, effort) = (arm.bounds(), effort(asked));
    let found = search(&region, &effort, &|state| arm.error(state), progress);
    let at_one = |state: &State<N>| bounds.over(&Region::of(state));
    let one_state = search(&region, &less(&effort), &at_one, progress);
    let proven = bounds.everywhere(&region, asked.boxes as usize, progress);
    let one_box = bounds.over(&region);
    if let Some(i) = proven.iter().position(|x| !x.is_finite()) {
        return Err(Failure::Input(miette::miette!(
            help = "expected joint limits within which no torque overflows single precision, and angles up to 8192 rad",
            "joint {} ({}): there is no bound",
            i + 1,
            file.robot.joints[i].name
        )));
    }
    let joints = (0..N).map(|i| {
        let joint = &file.robot.joints[i];
        let LargestError { value, state: at } = found[i];
        JointErrorBound {
            name: joint.name.clone(),
            unit: JointLabel::from(joint).torque_unit(),
            position: region.inputs[0][i],
            velocity: region.inputs[1][i].1,
            acceleration: region.inputs[2][i].1,
            limit: Some(limits[i].torque).filter(|limit| limit.is_finite()),
            found: value,
            found_at: [at.q, at.qd, at.qdd].map(|all| all.to_vec()),
            bound_there: at_one(&at)[i],
            one_state: one_state[i].value,
            one_box: one_box[i],
            proven: proven[i],
        }
    });
    Ok(TorqueErrorBound {
        robot: file.robot.name.clone(),
        scene: subject.scene.clone(),
        level: level.name(),
        samples: effort.samples,
        boxes: asked.boxes as usize,
        seed: effort.seed,
        joints: joints.collect(),
    })
}

/// Region of all states within the joint limits.
fn region<const N: usize>(
    asked: &BoundRequest,
    robot: &Robot,
    model: &Model<f64, N>,
    limits: &[Limits<f64>; N],
) -> Result<Region<N>, Failure> {
    let given = |option: &str, values: &Option<Vec<f64>>| -> Result<Option<[f64; N]>, Failure> {
        let Some(values) = values else { return Ok(None) };
        if let Some(value) = values.iter().find(|x| !(**x >= 0.0 && x.is_finite())) {
            return Err(wrong(&format!("`--{option}` holds {value}; expected finite numbers of zero or more")));
        }
        numbers(option, values, "one for each joint").map(Some).map_err(|problem| wrong(&problem))
    };
    let velocity = given("velocity", &asked.velocity)?.unwrap_or(limits.map(|limits| limits.velocity));
    if let Some(i) = velocity.iter().position(|x| !x.is_finite()) {
        let name = &robot.joints[i].name;
        return Err(wrong(&format!("joint {} ({name}) has no limit of velocity: give --velocity", i + 1)));
    }
    let acceleration = given("acceleration", &asked.acceleration)?.unwrap_or(velocity.map(|speed| 5.0 * speed));
    let mut position = [(0.0, 0.0); N];
    for (i, link) in model.links().iter().enumerate() {
        let name = &robot.joints[i].name;
        position[i] = positions(link.kind, link.limits.position).ok_or_else(|| {
            wrong(&format!("joint {} ({name}) slides without limits: nothing bounds its force", i + 1))
        })?;
    }
    Ok(Region::new(position, velocity, acceleration))
}

fn wrong(problem: &str) -> Failure {
    Failure::Input(miette::miette!(help = "see `newtau help choose bound`", "{problem}"))
}
