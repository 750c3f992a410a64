//! A trial of a scene's loop in the simulated arm: does the arm become quiet when it is held?
//!
//! The arm begins a little away from the position that it holds. The trial compares the swing of each joint's torque at the start with the swing at
//! the end, where
//!
//! ```text
//! swing = max tau - min tau     in a part of the trial, N m or N
//! ```
//!
//! A loop whose gains are too high for its rate, or for the delay of its drives, swings at the end as much as at the start. The trial has the
//! scene's law, gains, rate, sensors and drives, so it needs no theory of any of them. It tests one posture, and the arm as the scene simulates it.

use crate::failure::Failure;
use crate::run::joint_label::JointLabel;
use crate::run::simulation;
use dynamics_core::JointKind;
use dynamics_core::control::{ControlLaw, Fault};
use indicatif::ProgressBar;
use robot_compiler::scene::MotionSpec;
use robot_compiler::{FileError, SceneFile};
use std::sync::atomic::AtomicBool;

/// Duration of the trial: the longer of this time, s, and this number of ticks.
const DURATION: f64 = 1.0;
const TICKS: f64 = 200.0;

/// Distance of each joint from the held position at the start.
const AWAY_ANGLE: f64 = 0.02; // rad
const AWAY_LENGTH: f64 = 0.005; // m

/// Share of the trial that is the start, and share after which the end begins.
const START: f64 = 0.2;
const END: f64 = 0.6;

/// A torque oscillates if its swing at the end is more than this share of the swing at the start, and more than this share of the joint's limit.
const KEPT: f64 = 0.5;
const OF_LIMIT: f64 = 0.1;

/// Factors on the natural frequencies that [`Oscillation::quiet_factor`] tries.
const FACTORS: [f64; 8] = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2];

/// A loop that does not become quiet.
#[derive(Clone, Debug, PartialEq)]
pub struct Oscillation {
    /// The joint whose torque swings most, as a share of its limit.
    pub joint: usize,
    /// Swing of its torque at the end of the trial, N m or N.
    pub swing: f64,
    /// True if it is the law that holds the arm after hand guiding, not the scene's own.
    pub after_guiding: bool,
    /// The fault that ended the trial.
    pub fault: Option<Fault>,
    /// Greatest factor tried on all natural frequencies with which the arm becomes quiet, if there is one.
    pub quiet_factor: Option<f64>,
}

/// Holds the scene's simulated arm and returns how it oscillates, or `None` if it becomes quiet. A law for hand guiding holds no position. In a scene with
/// hand guiding, the law that holds the arm before and after it is tried too.
///
/// Cost: one or two simulations of a second, and up to eight more if the arm oscillates.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run.
pub fn oscillation(scene: &SceneFile) -> Result<Option<Oscillation>, Failure> {
    let own = (!scene.control.law.is_hand_guided()).then(|| scene.clone());
    let after_guiding = scene.control.teach.is_some().then(|| {
        let mut scene = scene.clone();
        scene.control.law = ControlLaw::Teach.standing();
        scene
    });
    for (scene, after_guiding) in [(own, false), (after_guiding, true)] {
        let Some(scene) = scene else { continue };
        if let Some(found) = oscillation_under_its_law(&scene)? {
            return Ok(Some(Oscillation { after_guiding, ..found }));
        }
    }
    Ok(None)
}

fn oscillation_under_its_law(scene: &SceneFile) -> Result<Option<Oscillation>, Failure> {
    let Some(mut found) = held(scene)? else { return Ok(None) };
    for factor in FACTORS {
        let mut softer = scene.clone();
        softer.control.natural_frequency.iter_mut().for_each(|frequency| *frequency *= factor);
        if held(&softer)?.is_none() {
            found.quiet_factor = Some(factor);
            break;
        }
    }
    Ok(Some(found))
}

/// The scene, in which the arm is held at its first position and nothing pushes it or fails.
fn trial_of(scene: &SceneFile) -> SceneFile {
    let mut trial = scene.clone();
    let duration = DURATION.max(TICKS * scene.period());
    trial.motion = MotionSpec::Hold { q: scene.plant.start.clone(), duration };
    trial.duration = None;
    trial.collision = None;
    trial.plant.push = None;
    trial.actuators.failure = None;
    for (q, joint) in trial.plant.start.iter_mut().zip(&scene.robot.joints) {
        let away = if joint.spec.kind == JointKind::Prismatic { AWAY_LENGTH } else { AWAY_ANGLE };
        // Away from the nearer limit.
        let (low, high) = joint.spec.limits.position;
        *q += if high - *q >= *q - low { away } else { -away };
    }
    trial
}

fn held(scene: &SceneFile) -> Result<Option<Oscillation>, Failure> {
    let trial = trial_of(scene);
    let record = simulation::run(&trial, &AtomicBool::new(false), &ProgressBar::hidden())?.record;
    let fault = record.faults().iter().flatten().next().copied();
    let mut worst: Option<(f64, Oscillation)> = None;
    for (joint, robot_joint) in scene.robot.joints.iter().enumerate() {
        let ticks = record.joint(joint).len();
        let part = |from: f64, to: f64| {
            let [from, to] = [from, to].map(|share| (share * ticks as f64) as usize);
            let torques = record.joint(joint).skip(from).take(to - from).map(|sample| sample.torque);
            torques.clone().fold(f64::NEG_INFINITY, f64::max) - torques.fold(f64::INFINITY, f64::min)
        };
        let (start, swing) = (part(0.0, START), part(END, 1.0));
        let limit = robot_joint.spec.limits.torque;
        let share = if limit.is_finite() { swing / limit } else { swing / start };
        let oscillates = swing > KEPT * start && (!limit.is_finite() || share > OF_LIMIT);
        if (oscillates || fault.is_some()) && worst.as_ref().is_none_or(|(most, _)| share > *most) {
            worst = Some((share, Oscillation { joint, swing, after_guiding: false, fault, quiet_factor: None }));
        }
    }
    Ok(worst.map(|(_, found)| found))
}

impl Oscillation {
    /// The finding as an error of the scene file: the problem, and the change that makes the arm quiet.
    #[must_use]
    pub fn error(&self, scene: &SceneFile) -> FileError {
        FileError::whole_file(&scene.path, "control.natural_frequency", self.problem(scene), self.advice(scene))
    }

    fn problem(&self, scene: &SceneFile) -> String {
        let rate = scene.control.rate;
        let name = scene.robot.joints.get(self.joint).map_or("", |joint| joint.name.as_str());
        let when = if self.after_guiding { " after hand guiding" } else { "" };
        match self.fault {
            Some(fault) => format!("the simulated arm, held at rest{when} at {rate} Hz, ends with {fault}"),
            None => format!(
                "the simulated arm, held at rest{when} at {rate} Hz, oscillates: the torque of joint {} ({name}) keeps swinging by {:.2} {}",
                self.joint + 1,
                self.swing,
                scene.robot.joints.get(self.joint).map_or("N m", |joint| JointLabel::from(joint).torque_unit()),
            ),
        }
    }

    fn advice(&self, scene: &SceneFile) -> String {
        let Some(factor) = self.quiet_factor else {
            return "softer gains or a higher `control.rate`: these gains are too high for the rate and for the delay of the drives".into();
        };
        let frequencies = scene.control.natural_frequency.iter().map(|value| format!("{:.1}", factor * value));
        let mut frequencies: Vec<String> = frequencies.collect();
        frequencies.dedup();
        let value = match frequencies.as_slice() {
            [one] => one.clone(),
            _ => format!("[{}]", frequencies.join(", ")),
        };
        format!(
            "a higher `control.rate` or lower gains: the arm becomes quiet at `natural_frequency = {value}`; stay well below it"
        )
    }
}
