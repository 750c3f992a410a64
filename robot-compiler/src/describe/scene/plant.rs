//! The simulated world: the tables `[plant]`, `[sensors]` and `[actuators]`.

use super::control::ControlSpec;
use super::model::ModelSpec;
use crate::describe::friction::JointFriction;
use crate::describe::robot::Robot;
use dynamics_core::{Body, Term, Wrench};
use nalgebra::Vector3;

/// Settings of the simulated world.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantSpec {
    /// Method of integration.
    pub integrator: Integrator,
    /// Integration step, s; the control period is a whole multiple of it. The adaptive integrator chooses its own.
    pub step: f64,
    /// True mass and inertia of each link, as multiples of the robot file's.
    pub masses: Vec<f64>,
    /// The actual body held by the tip, in the tip frame.
    pub payload: Option<Body>,
    /// The actual wrench of the environment at the tip's origin, in tip axes.
    pub tip_wrench: Option<Wrench<f64>>,
    /// A wrench at the tip for a limited time, added to `tip_wrench`.
    pub push: Option<Push>,
    /// True if the joints have friction.
    pub friction: bool,
    /// Friction of the joints; `None` means the robot file's, which the controller uses too.
    pub friction_law: Option<Vec<JointFriction>>,
    /// Springs in the joints.
    pub elasticity: Option<ElasticitySpec>,
    /// True if the spin of each rotor is coupled with the motion of the link that carries it (eq. 12.404, completed).
    pub rotor_coupling: bool,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Position of the arm at the start, at rest, rad or m.
    pub start: Vec<f64>,
}

/// A wrench at the tip for a limited time, unknown to the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Start, s, rounded to the nearest tick.
    pub at: f64,
    /// Duration, s, in whole ticks.
    pub duration: f64,
    /// Wrench at the tip's origin, in tip axes.
    pub wrench: Wrench<f64>,
}

/// Integrator of the simulated motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Integrator {
    /// The classical method of fourth order: four accelerations a step.
    #[default]
    RungeKutta,
    /// `qd += h qdd(q, qd)`, then `q += h qd`: first order, one acceleration a step.
    SemiImplicitEuler,
    /// Dormand and Prince's pair of orders 5 and 4: six accelerations a step and one more a tick. It chooses its
    /// own step. In a step, the estimated error of each state component `x` is at most `tolerance (1 + |x|)`, in rad, m and
    /// their rates.
    Adaptive {
        /// Error in a step, absolute and relative.
        tolerance: f64,
    },
}

/// Spring, damper and backlash between the motor and the link of every joint. Lists hold a number per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticitySpec {
    /// Stiffness, N m/rad or N/m.
    pub stiffness: Vec<f64>,
    /// Damping, N m s/rad or N s/m.
    pub damping: Vec<f64>,
    /// Backlash from flank to flank, rad or m.
    pub backlash: Option<Vec<f64>>,
}

/// Measured side of an elastic joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// The motor's side, converted through the gear to joint coordinates: most arms have their encoders there.
    #[default]
    Motor,
    /// The link's side.
    Link,
}

/// Torque ripple: at the joint position `q` the torque `tau` becomes `tau (1 + a sin(2 pi n x))`, where `x` is `q` in turns or metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// Amplitude `a`, a share of the torque.
    pub share: f64,
    /// Cycles `n` per turn of the joint, or per metre.
    pub cycles: f64,
}

/// Settings of the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SensorSpec {
    /// True if the sensors measure counts and leave the velocity to the observer.
    pub encoder: bool,
    /// Noise on the position, root mean square, rad or m.
    pub position_noise: f64,
    /// Noise on the velocity, root mean square, rad/s or m/s.
    pub velocity_noise: f64,
    /// Delay of the measurement, ticks.
    pub delay: u32,
    /// Measured side of elastic joints; rigid joints have only one.
    pub side: Side,
    /// Greatest time by which a measurement is early, s.
    pub jitter: f64,
}

/// Settings of the actuators.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorSpec {
    /// True if commanded torques act unchanged, even if the robot file describes drives that could be simulated.
    pub ideal: bool,
    /// Rate of a simulated drive's own position and velocity loop, Hz.
    pub loop_rate: f64,
    /// Failure of a simulated drive.
    pub failure: Option<DriveFailure>,
    /// True torque of each simulated drive, as a multiple of the torque in its frames; empty: equal to it.
    pub torque_factor: Vec<f64>,
    /// True if torques saturate at the joint's torque limit.
    pub saturation: bool,
    /// First-order time constant, s; 0 for none.
    pub lag: f64,
    /// Transport delay, ticks.
    pub delay: u32,
    /// Torque ripple.
    pub ripple: Option<Ripple>,
    /// Greatest time by which a torque is late, s.
    pub jitter: f64,
}

impl Default for ActuatorSpec {
    fn default() -> Self {
        Self {
            ideal: false,
            loop_rate: 10_000.0,
            failure: None,
            torque_factor: Vec::new(),
            saturation: false,
            lag: 0.0,
            delay: 0,
            ripple: None,
            jitter: 0.0,
        }
    }
}

/// Failure of one simulated drive, from an instant to the end of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveFailure {
    /// The joint, counted from 0.
    pub joint: usize,
    /// Start of the failure, s.
    pub at: f64,
    /// Kind of the failure.
    pub kind: FailureKind,
}

/// Kind of failure of a simulated drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// The drive reports an internal error.
    Error,
    /// Its cable is unplugged: it neither receives nor sends.
    Unplugged,
    /// It reports the highest temperature that its replies can hold.
    Hot,
    /// Its supply fails.
    UnderVoltage,
}

impl PlantSpec {
    /// The model that matches this world: every load that acts is constant, every other term is absent.
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

    /// The world as the model describes it, with the friction of the robot file, integrated in four steps per tick.
    pub(crate) fn default_for(robot: &Robot, model: &ModelSpec, control: &ControlSpec, start: &[f64]) -> Self {
        let constant = |gravity: Term<Vector3<f64>>| match gravity {
            Term::Constant(gravity) => gravity,
            Term::Absent | Term::Live => robot.gravity(),
        };
        Self {
            integrator: Integrator::RungeKutta,
            step: 0.25 / control.rate,
            masses: vec![1.0; robot.dof()],
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
            rotor_coupling: false,
            gravity: constant(model.gravity),
            start: start.to_vec(),
        }
    }
}
