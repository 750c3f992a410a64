//! The simulated world: the tables `[plant]`, `[sensors]` and `[actuators]`.

use super::control::ControlSpec;
use super::model::{FLOOR, ModelSpec};
use crate::describe::robot::Robot;
use dynamics_core::{Body, Term, Wrench};
use nalgebra::Vector3;

/// What is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantSpec {
    /// How the motion is integrated.
    pub integrator: IntegratorChoice,
    /// Integration step, s; the control period is a whole multiple of it. The adaptive integrator chooses its own.
    pub step: f64,
    /// The body really held by the tip, in the tip frame.
    pub payload: Option<Body>,
    /// The wrench really exerted by the environment at the tip's origin, in tip axes.
    pub tip_wrench: Option<Wrench<f64>>,
    /// What pushes at the tip for a while, beside that.
    pub push: Option<PushSpec>,
    /// Whether the joints have friction.
    pub friction: bool,
    /// Which; `None`: that of the robot file, which is the controller's too.
    pub friction_law: Option<FrictionSpec>,
    /// Springs in the joints.
    pub elasticity: Option<ElasticitySpec>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Where the arm starts, at rest, rad or m.
    pub start: Vec<f64>,
}

/// A wrench at the tip for a while, of which the controller is told nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushSpec {
    /// When it begins, s.
    pub at: f64,
    /// How long it lasts, s.
    pub duration: f64,
    /// At the tip's origin, in tip axes.
    pub wrench: Wrench<f64>,
}

/// How the simulated motion is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum IntegratorChoice {
    /// Classical Runge-Kutta, fourth order.
    #[default]
    RungeKutta,
    /// Semi-implicit Euler, first order.
    SemiImplicitEuler,
    /// Dormand and Prince's pair, with steps that keep a tolerance.
    Adaptive {
        /// Error of a step, absolute (rad, m and their rates) and relative.
        tolerance: f64,
    },
}

/// Spring, damper and play between the motor and the link of every joint. Lists hold a number per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticitySpec {
    /// Stiffness, N m/rad or N/m.
    pub stiffness: Vec<f64>,
    /// Damping, N m s/rad or N s/m.
    pub damping: Vec<f64>,
    /// Play from flank to flank, rad or m.
    pub backlash: Option<Vec<f64>>,
}

/// Which side of an elastic joint is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeasuredSide {
    /// The motor's.
    #[default]
    Motor,
    /// The link's.
    Link,
}

/// Friction of the simulated joints, whatever the controller takes it for. Lists hold a number per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionSpec {
    /// Viscous coefficient, N m s/rad or N s/m.
    pub viscous: Vec<f64>,
    /// Coulomb torque or force, N m or N.
    pub coulomb: Vec<f64>,
    /// Stribeck's rise towards rest.
    pub breakaway: Option<BreakawaySpec>,
}

/// How friction rises from Coulomb's level to that of breakaway as the velocity vanishes.
#[derive(Clone, Debug, PartialEq)]
pub struct BreakawaySpec {
    /// Breakaway torque or force per joint without load, N m or N; not below Coulomb's.
    pub torque: Vec<f64>,
    /// Stribeck velocity, rad/s or m/s: there the rise is down to `1/e`.
    pub speed: f64,
    /// What breakaway gains per N m or N that the actuator gives.
    pub load: f64,
}

/// A torque that swings about the one commanded as the motor turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RippleSpec {
    /// Amplitude as a share of the torque.
    pub share: f64,
    /// Cycles per turn of the joint, or per metre.
    pub cycles: f64,
}

/// What the sensors do.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SensorSpec {
    /// Measure counts, and leave the velocity to the observer.
    pub encoder: bool,
    /// Noise on the position, root mean square, rad or m.
    pub position_noise: f64,
    /// Noise on the velocity, root mean square, rad/s or m/s.
    pub velocity_noise: f64,
    /// Delay of the measurement, ticks.
    pub delay: u32,
    /// Which side of elastic joints is measured; of others there is only one.
    pub side: MeasuredSide,
    /// Longest time by which a measurement is early, s.
    pub jitter: f64,
}

/// What the actuators do.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ActuatorSpec {
    /// Clip at the joint's torque limit.
    pub saturation: bool,
    /// First-order time constant, s; 0 for none.
    pub lag: f64,
    /// Transport delay, ticks.
    pub delay: u32,
    /// Torque ripple.
    pub ripple: Option<RippleSpec>,
    /// Longest time by which a torque is late, s.
    pub jitter: f64,
}

impl PlantSpec {
    /// The model that knows everything of this world: what acts is constant, what does not is absent.
    pub(crate) fn known(&self, robot: &Robot) -> ModelSpec {
        let gravity = if self.gravity == Vector3::zeros() { Term::Absent } else { Term::Constant(self.gravity) };
        ModelSpec {
            gravity,
            payload: self.payload.map_or(Term::Absent, Term::Constant),
            tip_wrench: self.tip_wrench.map_or(Term::Absent, Term::Constant),
            friction: self.friction && robot.joints.iter().any(|joint| joint.friction.is_some()),
            ..ModelSpec::default_for(robot)
        }
    }

    /// The world that the model describes, with the friction of the robot file, integrated four times a tick.
    pub(crate) fn default_for(robot: &Robot, model: &ModelSpec, control: &ControlSpec, start: &[f64]) -> Self {
        let constant = |gravity: Term<Vector3<f64>>| match gravity {
            Term::Constant(gravity) => gravity,
            Term::Absent | Term::Live => FLOOR,
        };
        Self {
            integrator: IntegratorChoice::RungeKutta,
            step: 0.25 / control.rate,
            payload: match model.payload {
                Term::Constant(body) => Some(body),
                Term::Absent | Term::Live => None,
            },
            tip_wrench: match model.tip_wrench {
                Term::Constant(wrench) => Some(wrench),
                Term::Absent | Term::Live => None,
            },
            push: None,
            friction: robot.joints.iter().any(|joint| joint.friction.is_some()),
            friction_law: None,
            elasticity: None,
            gravity: constant(model.gravity),
            start: start.to_vec(),
        }
    }
}
