//! Controller of an arm: the tables `[control]` and `[collision]`.

use crate::describe::robot::{Robot, RobotJoint};
use dynamics_core::JointKind;
use dynamics_core::control::{Between, CollisionReaction, ControlLaw};
use dynamics_core::trig::Method;

/// Settings of the controller.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSpec {
    /// Control rate, Hz.
    pub rate: f64,
    /// The law.
    pub law: ControlLaw,
    /// Ticks between two evaluations of the model: it is evaluated in every tick whose number is a multiple of this; 1 means in every tick.
    pub model_every: u32,
    /// Behaviour of the model's torque between two evaluations.
    pub model_between: Between,
    /// Natural frequency of the error, per joint, rad/s; not used if there is a stiffness.
    pub natural_frequency: Vec<f64>,
    /// Stiffness `M0 Kp` of each joint, N m/rad or N/m, in a law that does not feed back through the model. `None`: it follows from the natural
    /// frequency.
    pub stiffness: Option<Vec<f64>>,
    /// Damping ratio of the error, per joint.
    pub damping: Vec<f64>,
    /// Method for sine and cosine.
    pub trig: Method,
    /// Floating-point type on the desk.
    pub scalar: ScalarChoice,
    /// Inverse dynamics on the chip.
    pub kernel: KernelChoice,
    /// Bandwidth of the velocity observer, rad/s.
    pub observer_bandwidth: f64,
    /// Integral action, if the law has any.
    pub integral: Option<IntegralSpec>,
    /// Feel of a hand-guided arm; present if the law is [`ControlLaw::Teach`].
    pub teach: Option<TeachSpec>,
    /// Inertia for which the damping of a spring is computed.
    pub damping_at: DampingAt,
    /// True if gains and friction are kept in RAM on the chip, where a host can change them while it runs.
    pub tunable: bool,
    /// Greatest age of a measurement that is still used, ticks.
    pub age_max: u32,
    /// Distance beyond a position limit at which a fault is raised, rad or m.
    pub position_margin: f64,
    /// Multiple of the velocity limit at which a fault is raised.
    pub velocity_factor: f64,
}

/// Integral action: a torque that grows while a joint is away from its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegralSpec {
    /// Integral time, s: the time after which a constant error has added as much torque as the position gain gives at once.
    pub time: f64,
    /// Greatest torque of each joint, N m or N.
    pub torque: Vec<f64>,
    /// Error of each joint below which the torque does not grow, rad or m.
    pub dead_band: Vec<f64>,
}

/// Feel of a hand-guided arm, per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct TeachSpec {
    /// Share of the robot file's friction that is compensated while the joint moves.
    pub friction: f64,
    /// Speed below which a joint counts as still, rad/s or m/s.
    pub still_speed: Vec<f64>,
    /// Torque that keeps a joint where it was released, N m or N.
    pub breakaway: Vec<f64>,
    /// Drag, N m s/rad or N s/m.
    pub drag: Vec<f64>,
    /// Speed above which the joint is braked, rad/s or m/s.
    pub speed: Vec<f64>,
    /// Distance from each position limit at which the wall begins, rad or m.
    pub wall: Vec<f64>,
}

/// Collision detection, and the reaction to a collision.
#[derive(Clone, Debug, PartialEq)]
pub struct CollisionSpec {
    /// Bandwidth of the estimated external torque, rad/s.
    pub bandwidth: f64,
    /// External torque that counts as a collision, per joint, N m or N.
    pub threshold: Vec<f64>,
    /// Number of consecutive ticks above the threshold that count as a collision.
    pub ticks: u32,
    /// Time for which every joint must be below half its threshold before the contact counts as ended, s.
    pub release: f64,
    /// The reaction.
    pub reaction: CollisionReaction,
}

/// The inverse dynamics that the chip runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelChoice {
    /// The recursion itself with the model at run time, so that a payload can be set between ticks.
    Generic,
    /// The arm's own kernel, equal to the recursion.
    #[default]
    Exact,
    /// The arm's own kernel with cheaper frames, base parameters and common subexpressions removed: the fewest
    /// operations, with different rounding.
    Regrouped,
}

/// Floating-point type of the controller on the desk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarChoice {
    /// Single precision, as on the chip.
    F32,
    /// Double precision.
    F64,
}

impl ControlSpec {
    /// Computed torque at 1 kHz, in single precision as on the chip.
    pub(crate) fn default_for(robot: &Robot) -> Self {
        Self {
            rate: 1000.0,
            law: ControlLaw::ComputedTorque,
            model_every: 1,
            model_between: Between::Hold,
            natural_frequency: vec![30.0; robot.dof()],
            stiffness: None,
            damping: vec![1.0; robot.dof()],
            trig: Method::Polynomial,
            scalar: ScalarChoice::F32,
            kernel: KernelChoice::Exact,
            observer_bandwidth: 500.0,
            integral: None,
            teach: None,
            damping_at: DampingAt::Start,
            tunable: false,
            age_max: 2,
            position_margin: 0.05,
            velocity_factor: 1.5,
        }
    }
}

/// Share of a joint's velocity limit below which it counts as still. Also the share of its torque limit that the drag reaches at its velocity
/// limit.
const STILL: f64 = 0.02;
/// Speed above which a joint is braked: 1.5 rad/s or 0.25 m/s, or half of the velocity limit if that is less.
const BRAKED: (f64, f64, f64) = (1.5, 0.25, 0.5);
/// Share of a joint's range that is taken by the wall at each end.
const WALL: f64 = 0.05;
/// Share of the friction that is compensated: with all of it, an overestimated friction would keep the arm moving.
const FRICTION: f64 = 0.8;

impl TeachSpec {
    /// Defaults from the robot file's data of each joint.
    #[must_use]
    pub fn default_for(robot: &Robot) -> Self {
        let of_joint = |of: fn(&RobotJoint) -> f64| robot.joints.iter().map(of).collect();
        Self {
            friction: FRICTION,
            still_speed: of_joint(|joint| STILL * joint.spec.limits.velocity),
            breakaway: of_joint(|joint| joint.friction.map_or(0.0, |friction| friction.coulomb)),
            drag: of_joint(|joint| STILL * joint.spec.limits.torque / joint.spec.limits.velocity),
            speed: of_joint(|joint| {
                let most = match joint.spec.kind {
                    JointKind::Revolute => BRAKED.0,
                    JointKind::Prismatic => BRAKED.1,
                };
                most.min(BRAKED.2 * joint.spec.limits.velocity)
            }),
            wall: of_joint(|joint| {
                let width = WALL * joint.spec.limits.range();
                if width.is_finite() { width } else { 0.0 }
            }),
        }
    }
}

/// Inertia for which the damping of a spring is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampingAt {
    /// The inertia at the start of the motion.
    Start,
    /// The inertia of the posture: half of the damping acts through the model, so that the damping ratio is never below the requested one.
    Posture,
}

impl DampingAt {
    /// Share of the damping that acts through the model.
    ///
    /// With `m = M(q) / M0`, the damping ratio becomes `(1 - s) / sqrt(m) + s sqrt(m)` times the requested one. For `s = 1/2` this is never
    /// below 1, since the arithmetic mean is not below the geometric one. It is 1.25 if the inertia is four times or a quarter of `M0`.
    pub(crate) fn share(self) -> Option<f64> {
        match self {
            Self::Start => None,
            Self::Posture => Some(0.5),
        }
    }
}
