//! An operator's data about a scene's arm.
//!
//! The operator's code is the same for every arm: only [`ArmModel`] and [`PlannedMotion`] depend on the number of joints, and
//! are compiled for each number.

use super::planned_motion::PlannedMotion;
use super::reason::Stop;
use super::scene_arm::{ArmModel, SceneArm};
use super::torque_cause::DriveNumbers;
use crate::chip::hello;
use crate::session::frame_log::Head;
use crate::session::frame_log::viewer::Recorded;
use dynamics_core::control::trajectory::Bounds;
use dynamics_core::control::{ControlLaw, ControllerConfig};
use dynamics_core::safety::SafeAction;
use dynamics_core::{Dynamics, Inertia, InertiaBounds, JointKind, Live, Model, Term};
use link::{Hello, Pacing};
use robot_compiler::{RobotJoint, SceneFile, with_dof};
use std::rc::Rc;
use std::time::Duration;

/// Share of the torque limit that counts as measurement noise.
const NOISE: f64 = 0.005;

/// The terms that `terms = "auto"` left out of the scene's model, and the motion on which it judged them.
fn left_out(scene: &SceneFile) -> Option<String> {
    let given_up = scene.model.given_up();
    let auto = scene.model.auto.as_ref().filter(|_| !given_up.is_empty())?;
    let names: Vec<&str> = given_up.iter().map(|term| term.name()).collect();
    let percent = 100.0 * auto.tolerance;
    Some(format!(
        "model without {}: left out by `terms = \"auto\"`, judged on the motion of {} alone ({percent} % of each torque limit); `jog` and \
         `goto` may go where more is missing",
        names.join(", "),
        scene.name
    ))
}

/// An operator's data about a scene's arm.
#[derive(Debug)]
pub(super) struct Arm {
    /// The arm's data for a record.
    pub(super) recorded: Recorded,
    pub(super) hello: Hello,
    /// The payload last sent to the board, in the tip frame, if it differs from the scene's.
    pub(super) payload: Option<Inertia<f32>>,
    /// True if the board's model uses a live payload.
    pub(super) payload_is_live: bool,
    /// Bounds of the board on a payload, in the last link's frame.
    pub(super) payload_bounds: InertiaBounds<f64>,
    /// True if the scene lets gains, frictions and the control law be changed.
    pub(super) tunable: bool,
    pub(super) motion: Rc<dyn PlannedMotion>,
    /// Number of repetitions of the motion.
    pub(super) times: u32,
    pub(super) model: Box<dyn ArmModel>,
    /// Names of the joints, and the units of position and force.
    pub(super) joints: Vec<(String, &'static str, &'static str)>,
    pub(super) period: f64,
    /// Terms that the board's model leaves out, and how that was judged; `None` if `terms = "auto"` left nothing out.
    pub(super) left_out: Option<String>,
    /// True if the board estimates external torques.
    pub(super) estimates: bool,
    /// Longest silence of the host that the board accepts.
    pub(super) heartbeat: Duration,
    /// Interval at which the live inputs are sent again, if the board limits their age.
    pub(super) live_every: Option<Duration>,
    /// True if brakes hold the arm when no torque acts.
    pub(super) has_brakes: bool,
    /// Pose in which the arm needs no torque, rad or m, if the scene or the robot file gives one.
    pub(super) rest: Option<Vec<f64>>,
    /// Share of velocity and torque limits that the board allows between homing and `full-range`, if it limits the first motion.
    pub(super) first_motion: Option<f64>,
    /// The control law, as last set by this operator.
    pub(super) law: ControlLaw,
    /// Velocity limit of each joint, rad/s or m/s.
    pub(super) velocity: Vec<f64>,
    /// Acceleration limit of each joint, rad/s^2 or m/s^2.
    pub(super) acceleration: Vec<f64>,
    /// Torque limit of each joint, N m or N.
    pub(super) torque: Vec<f64>,
    /// Lowest and highest position of each joint, rad or m.
    pub(super) range: Vec<(f64, f64)>,
    /// Positions between which no soft wall of hand guiding acts on a joint, rad or m; `None` if the scene has no hand guiding.
    pub(super) walls: Option<Vec<(f64, f64)>>,
    /// Torque of each joint that friction and noise can explain, N m or N.
    pub(super) hidden: Vec<f64>,
    /// Viscous and Coulomb friction of each joint.
    pub(super) friction: Vec<(f64, f64)>,
    /// Data of each joint's drive, to identify the cause of a wrong torque.
    pub(super) drives: Vec<DriveNumbers>,
    /// For each joint, true if the board follows its motor's heat; empty for an arm without drives.
    pub(super) has_heat: Vec<bool>,
    /// The drives' error texts.
    pub(super) words: Option<fn(u8) -> &'static str>,
}

impl Arm {
    pub(super) fn new(scene: &SceneFile, plays: &SceneFile, head: Head, pacing: Pacing) -> Result<Self, Stop> {
        with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>().map_err(|error| Stop::Input(error.to_string()))?;
            Self::of(scene, plays, &model, head, hello(scene, &model, pacing))
        })
    }

    /// Name of a joint, and its units of position and force; empty for a joint that the arm does not have.
    pub(super) fn joint(&self, joint: usize) -> (&str, &'static str, &'static str) {
        self.joints.get(joint).map_or(("", "", ""), |(name, place, force)| (name.as_str(), *place, *force))
    }

    fn of<const N: usize>(
        scene: &SceneFile,
        plays: &SceneFile,
        model: &Model<f64, N>,
        head: Head,
        hello: Hello,
    ) -> Result<Self, Stop> {
        let motion = plays.trajectory(model).map_err(|error| Stop::Input(format!("the motion cannot be: {error}")))?;
        let whole = |duration: f64| (duration / motion.duration() + 1e-9).floor().clamp(1.0, 1e6) as u32;
        let times = if plays.motion.repeats() { scene.duration.map_or(1, whole) } else { 1 };
        let ControllerConfig { encoder, limits, teach, .. } = scene.controller_config(model);
        let rules = scene.safety_rules(model);
        let deceleration = rules.joints.map(|joint| joint.deceleration);
        let units = |kind| match kind {
            JointKind::Revolute => ("rad", "N m"),
            JointKind::Prismatic => ("m", "N"),
        };
        let named = scene.robot.joints.iter().map(|joint| {
            let (place, force) = units(joint.spec.kind);
            (joint.name.clone(), place, force)
        });
        let of_friction = |joint: &RobotJoint| {
            hidden(joint.friction.map_or(0.0, |friction| friction.starting()), joint.spec.limits.torque)
        };
        let coefficients =
            |joint: &RobotJoint| joint.friction.map_or((0.0, 0.0), |friction| (friction.viscous, friction.coulomb));
        // A board without a payload in its model cannot use the simulated arm's payload, so it is not sent.
        let mut declared: Live<f32, N> = scene.live(model).cast();
        if !matches!(scene.model.payload, Term::Live) {
            declared.payload = Inertia::zero();
        }
        let bounds = Bounds::from_limits(&limits).with_acceleration(deceleration);
        Ok(Self {
            recorded: Recorded { head, robot: scene.robot.clone(), encoders: encoder.to_vec() },
            hello,
            payload: None,
            payload_is_live: matches!(scene.model.payload, Term::Live),
            payload_bounds: rules.payload,
            tunable: scene.control.tunable,
            motion: Rc::new(motion),
            times,
            model: Box::new(SceneArm {
                live: declared,
                payload: scene.plant.payload.map_or_else(Inertia::zero, |body| {
                    Inertia::from_mass_centre(body.mass, &body.com, &body.inertia).cast().symmetric()
                }),
                bounds,
                encoder,
                dynamics: Dynamics::new(*model, scene.scene(model)),
            }),
            joints: named.collect(),
            period: scene.period(),
            left_out: left_out(scene),
            estimates: scene.collision.is_some(),
            heartbeat: Duration::from_secs_f64(scene.safety.heartbeat),
            // A quarter of the limit, so that three frames in a row may be lost.
            live_every: (rules.live_max > 0)
                .then(|| Duration::from_secs_f64(0.25 * f64::from(rules.live_max) * scene.period())),
            has_brakes: matches!(scene.safety.safe_action, SafeAction::Brake),
            rest: rules.rest.map(|rest| rest.to_vec()),
            first_motion: rules.first_motion,
            law: scene.control.law,
            velocity: limits.map(|limits| limits.velocity).to_vec(),
            acceleration: deceleration.to_vec(),
            torque: limits.map(|limits| limits.torque).to_vec(),
            range: limits.map(|limits| limits.position).to_vec(),
            walls: teach.map(|teach| teach.map(|joint| joint.wall).to_vec()),
            hidden: scene.robot.joints.iter().map(of_friction).collect(),
            friction: scene.robot.joints.iter().map(coefficients).collect(),
            drives: scene.robot.joints.iter().map(DriveNumbers::of).collect(),
            has_heat: has_heat(scene),
            words: scene.protocol().map(joint_io::frames::error_text),
        })
    }
}

/// Torque of a joint that friction and noise can explain, N m or N.
fn hidden(coulomb: f64, limit: f64) -> f64 {
    coulomb + if limit.is_finite() { NOISE * limit } else { 0.0 }
}

/// For each joint with a drive, true if the robot file gives the thermal data of its motor.
fn has_heat(scene: &SceneFile) -> Vec<bool> {
    let driven = scene.robot.joints.iter().filter(|joint| joint.drive.is_some());
    driven.map(|joint| joint.heat.rules(scene.period()).is_some()).collect()
}
