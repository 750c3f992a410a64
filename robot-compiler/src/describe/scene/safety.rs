//! Conditions for torque, and the reaction when they are not met: the table `[safety]`.

use super::control::ControlSpec;
use crate::describe::robot::{Robot, RobotJoint};
use dynamics_core::safety::SafeAction;
use dynamics_core::{InertiaBounds, JointKind};

/// Conditions for torque, and the reaction when they are not met. Lists hold a number per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetySpec {
    /// Action of the drives when no torque is commanded.
    pub safe_action: SafeAction,
    /// Longest silence of the host, s.
    pub heartbeat: f64,
    /// Time for which the arm holds without the host before the safe action, s.
    pub hold: f64,
    /// Longest time that the brakes need to engage after they lose power, s; 0 if the safe action is not braking.
    pub brake_delay: f64,
    /// True if the file itself gives the brakes' time; the default is a guess about unknown brakes.
    pub brake_delay_given: bool,
    /// Time from a measurement to the resulting torque, s.
    pub latency: f64,
    /// Bounds for a payload that is set at run time.
    pub payload: InertiaBounds<f64>,
    /// Lowest and highest supply voltage, V.
    pub supply: (f64, f64),
    /// Lowest and highest temperature, degrees Celsius.
    pub temperature: (f64, f64),
    /// Multiple of its velocity limit that a joint can physically reach.
    pub jump_factor: f64,
    /// Deceleration that each joint can always reach, rad/s^2 or m/s^2.
    pub deceleration: Vec<f64>,
    /// Largest error of a measured position, rad or m.
    pub resolution: Vec<f64>,
    /// Speed below which a joint counts as at rest, rad/s or m/s.
    pub rest_speed: Vec<f64>,
    /// Largest distance of the reference from the joint, rad or m.
    pub reach: Vec<f64>,
    /// Largest difference between the speed of the first reference and the joint's, rad/s or m/s.
    pub reach_speed: Vec<f64>,
    /// Velocity gain of a damped stop, N m s/rad or N s/m.
    pub damping: Vec<f64>,
    /// Pose in which the arm rests without torque, rad or m: the scene's, otherwise the robot file's.
    pub rest: Option<Vec<f64>>,
    /// Greatest speed of the tip while the arm is lowered to its rest pose, m/s.
    pub lowering_tip_speed: f64,
    /// Share of the velocity limits, and of the torque limits beyond the weight, that the arm may use after homing until a person lifts the
    /// limit; `None` for no such limit.
    pub first_motion: Option<f64>,
    /// Greatest age of the live inputs while the arm runs, s; `None` for no limit.
    pub live_age: Option<f64>,
    /// True for a scene whose firmware is built without drives, so that it can never move an arm. Lifts the bounds on the age of
    /// measurements and on the host's silence.
    pub bench_only: bool,
}

/// Share of the limits in the first motion after homing, for an arm with drives if the scene gives none.
pub const FIRST_MOTION: f64 = 0.2;

impl SafetySpec {
    /// Defaults from the joints' limits.
    ///
    /// | what | default |
    /// |---|---|
    /// | delay of the brakes | 100 ms; none for another safe action |
    /// | deceleration | the velocity limit divided by a quarter of a second; 5 without a limit |
    /// | payload | as heavy as the arm's links together, within 1 m of the last link's origin |
    /// | resolution | two counts of the encoder; 1e-3 without one |
    /// | reach | 0.2 rad, 0.05 m |
    /// | speed of the first reference | a tenth of the velocity limit; 0.1 without a limit |
    /// | damping | the whole torque at the velocity limit; none if either has no limit |
    /// | rest | the robot file's |
    /// | speed of the tip while lowering | 0.05 m/s |
    /// | first motion | a fifth of the limits if a joint has a drive; no limit for an arm that is only simulated |
    /// | age of live inputs | no limit |
    pub(crate) fn default_for(robot: &Robot, control: &ControlSpec) -> Self {
        const STOP_TIME: f64 = 0.25;
        let or = |x: f64, otherwise: f64| if x.is_finite() { x } else { otherwise };
        let velocity = |joint: &RobotJoint| joint.spec.limits.velocity;
        let list = |one: &dyn Fn(&RobotJoint) -> f64| robot.joints.iter().map(one).collect::<Vec<f64>>();
        Self {
            safe_action: SafeAction::Brake,
            heartbeat: 0.1,
            hold: 0.5,
            brake_delay: BRAKE_DELAY,
            brake_delay_given: false,
            latency: 2.0 / control.rate,
            payload: InertiaBounds { mass: robot.joints.iter().map(|joint| joint.spec.body.mass).sum(), radius: 1.0 },
            supply: (f64::NEG_INFINITY, f64::INFINITY),
            temperature: (f64::NEG_INFINITY, f64::INFINITY),
            jump_factor: 2.0,
            deceleration: list(&|joint| or(velocity(joint) / STOP_TIME, 5.0)),
            resolution: list(&|joint| joint.per_count().map_or(1e-3, |count| 2.0 * count)),
            rest_speed: vec![0.05; robot.dof()],
            reach: list(&|joint| match joint.spec.kind {
                JointKind::Revolute => 0.2,
                JointKind::Prismatic => 0.05,
            }),
            reach_speed: list(&|joint| or(0.1 * velocity(joint), 0.1)),
            damping: list(&|joint| {
                let damping = joint.spec.limits.torque / velocity(joint);
                if velocity(joint).is_finite() { or(damping, 0.0) } else { 0.0 }
            }),
            rest: robot.rest.clone(),
            lowering_tip_speed: 0.05,
            first_motion: robot.joints.iter().any(|joint| joint.drive.is_some()).then_some(FIRST_MOTION),
            live_age: None,
            bench_only: false,
        }
    }
}

/// Time that holding brakes need to engage if the scene gives none, s. Makers of holding brakes state 20 to 100 ms.
const BRAKE_DELAY: f64 = 0.1;
