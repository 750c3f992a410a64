//! The parts of a scene.

use super::SceneFile;
use super::terms::AutoTerms;
use crate::kernel::Level;
use crate::robot::{Robot, RobotJoint};
use dynamics_core::control::{Between, Law, Reaction};
use dynamics_core::safety::SafeAction;
use dynamics_core::trig::Method;
use dynamics_core::{Body, InertiaBounds, JointKind, Term, Wrench};
use nalgebra::Vector3;
use std::path::PathBuf;

/// Gravity on a floor, in the base frame, m/s^2.
pub(crate) const FLOOR: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// What the controller's inverse dynamics computes.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSpec {
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Term<Vector3<f64>>,
    /// A body held by the tip, in the tip frame.
    pub payload: Term<Body>,
    /// Wrench of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Term<Wrench<f64>>,
    /// Rotor inertias, at the values of the robot file.
    pub rotor: Term<()>,
    /// Velocity terms: live, or at one constant joint velocity.
    pub coriolis: Term<Vec<f64>>,
    /// Whether friction is fed forward.
    pub friction: bool,
    /// Speed at which the whole Coulomb torque acts, rad/s or m/s.
    pub friction_smoothing: f64,
    /// What these terms are the fewest of, where the file said `terms = "auto"`. The terms above are what is left, and all that
    /// desk, firmware and hash read.
    pub auto: Option<AutoTerms>,
}

/// How the arm is controlled.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSpec {
    /// Control rate, Hz.
    pub rate: f64,
    /// The law.
    pub law: Law,
    /// The model is evaluated in every tick of this number's multiples; 1: in every tick.
    pub model_every: u32,
    /// What its torque does in the ticks between.
    pub model_between: Between,
    /// Natural frequency of the error, per joint, rad/s.
    pub natural_frequency: Vec<f64>,
    /// Damping ratio of the error, per joint.
    pub damping: Vec<f64>,
    /// Which sine and cosine.
    pub trig: Method,
    /// Which floating-point type.
    pub scalar: ScalarChoice,
    /// Which inverse dynamics the chip runs.
    pub kernel: KernelChoice,
    /// What the chip runs the arm's kernel from.
    pub kernel_memory: KernelMemory,
    /// Bandwidth of the velocity observer, rad/s.
    pub observer_bandwidth: f64,
    /// Gains and friction are kept in RAM on the chip, where a host can change them while it runs.
    pub tunable: bool,
    /// Oldest measurement that is believed, ticks.
    pub age_max: u32,
    /// How far beyond a position limit is a fault, rad or m.
    pub position_margin: f64,
    /// How many times the velocity limit is a fault.
    pub velocity_factor: f64,
}

/// What counts as a collision, and what is done about one.
#[derive(Clone, Debug, PartialEq)]
pub struct CollisionSpec {
    /// Bandwidth of the estimated external torque, rad/s.
    pub bandwidth: f64,
    /// External torque of a collision, per joint, N m or N.
    pub threshold: Vec<f64>,
    /// Ticks in a row above the threshold.
    pub ticks: u32,
    /// How long every joint must feel less than half its threshold until nothing pushes any more, s.
    pub release: f64,
    /// What is done.
    pub reaction: Reaction,
}

/// Which inverse dynamics the chip runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelChoice {
    /// The recursion itself, with the model at run time: a payload can be set between ticks.
    Generic,
    /// The arm's own kernel, equal to the recursion.
    #[default]
    Exact,
    /// The arm's own kernel with cheaper frames, base parameters and what is common taken out: the fewest operations, other
    /// rounding.
    Regrouped,
}

impl KernelChoice {
    /// The compiler's level, if a kernel is made.
    #[must_use]
    pub const fn level(self) -> Option<Level> {
        match self {
            Self::Generic => None,
            Self::Exact => Some(Level::Exact),
            Self::Regrouped => Some(Level::Regrouped),
        }
    }
}

/// What the chip runs the arm's kernel from. No bit of a result depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelMemory {
    /// Flash, as part of the tick: at 168 MHz with 5 wait states for each line of 16 bytes that its cache does not hold.
    #[default]
    Flash,
    /// Static RAM, without wait states, as a function of its own that the start-up code copies there.
    Sram,
}

/// Which floating-point type the controller uses on the desk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarChoice {
    /// Single precision, as on the chip.
    F32,
    /// Double precision.
    F64,
}

/// When torque acts, and what happens instead. Lists hold a number per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetySpec {
    /// What the drives do when no torque is commanded.
    pub safe_action: SafeAction,
    /// Longest silence of the host, s.
    pub heartbeat: f64,
    /// How long the arm holds without the host before the safe action, s.
    pub hold: f64,
    /// From a measurement to the torque that it leads to, s.
    pub latency: f64,
    /// What a payload that is told at run time is held to.
    pub payload: InertiaBounds<f64>,
    /// Lowest and highest supply voltage, V.
    pub supply: (f64, f64),
    /// Lowest and highest temperature, degrees Celsius.
    pub temperature: (f64, f64),
    /// How many times its velocity limit a joint can move at.
    pub jump_factor: f64,
    /// Deceleration that each joint is sure to have, rad/s^2 or m/s^2.
    pub deceleration: Vec<f64>,
    /// What a position may be wrong by, rad or m.
    pub resolution: Vec<f64>,
    /// Speed up to which a joint is at rest, rad/s or m/s.
    pub rest_speed: Vec<f64>,
    /// How far the reference may be from the joint, rad or m.
    pub reach: Vec<f64>,
    /// How far the speed of the first reference may be from the joint's, rad/s or m/s.
    pub reach_speed: Vec<f64>,
    /// Velocity gain of a damped stop, N m s/rad or N s/m.
    pub damping: Vec<f64>,
}

/// The reference motion.
#[derive(Clone, Debug, PartialEq)]
pub enum MotionSpec {
    /// Stand still.
    Hold {
        /// Where, rad or m.
        q: Vec<f64>,
        /// How long, s.
        duration: f64,
    },
    /// Quintic polynomials through points. Either every segment has a duration or none has: then the motion is as fast
    /// as velocity, acceleration and torque limits allow.
    Quintic {
        /// The points, start first.
        points: Vec<ViaPoint>,
        /// Acceleration bounds per joint, rad/s^2 or m/s^2.
        acceleration: Option<Vec<f64>>,
        /// Start again at the end.
        repeat: bool,
    },
    /// Trapezoidal speed along a straight line.
    Trapezoid {
        /// Start, rad or m.
        start: Vec<f64>,
        /// Goal, rad or m.
        goal: Vec<f64>,
        /// Acceleration bounds per joint, rad/s^2 or m/s^2; given when the duration is not.
        acceleration: Option<Vec<f64>>,
        /// Duration, s; given when the acceleration is not.
        duration: Option<f64>,
        /// Share of the duration spent on speeding up, and as much again on slowing down.
        ramp_share: f64,
    },
    /// A sine of changing frequency.
    Sine {
        /// Centre, rad or m.
        centre: Vec<f64>,
        /// Amplitude, rad or m.
        amplitude: Vec<f64>,
        /// Frequency at the start, Hz.
        frequency_start: f64,
        /// Frequency at the end, Hz.
        frequency_end: f64,
        /// Duration, s.
        duration: f64,
        /// Time in which the amplitude grows at the start and vanishes at the end, s.
        ramp: f64,
    },
}

/// A point of a quintic motion.
#[derive(Clone, Debug, PartialEq)]
pub struct ViaPoint {
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Duration of the segment that ends here, s.
    pub duration: Option<f64>,
    /// How long to stand still here, s.
    pub dwell: f64,
}

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

impl MotionSpec {
    /// Where the motion starts, rad or m.
    #[must_use]
    pub fn start(&self) -> &[f64] {
        match self {
            Self::Hold { q, .. } => q,
            Self::Quintic { points, .. } => points.first().map_or(&[], |point| &point.q),
            Self::Trapezoid { start, .. } => start,
            Self::Sine { centre, .. } => centre,
        }
    }

    /// Whether it starts again at its end.
    #[must_use]
    pub fn repeats(&self) -> bool {
        matches!(self, Self::Quintic { repeat: true, .. })
    }
}

impl ModelSpec {
    /// Floor, nothing held, and whatever the robot file gives of rotors and friction.
    pub(crate) fn default_for(robot: &Robot) -> Self {
        let rotors = robot.joints.iter().any(|joint| joint.spec.rotor.reflected() > 0.0);
        Self {
            gravity: Term::Constant(FLOOR),
            payload: Term::Absent,
            tip_wrench: Term::Absent,
            rotor: if rotors { Term::Constant(()) } else { Term::Absent },
            coriolis: Term::Live,
            friction: robot.joints.iter().any(|joint| joint.friction.is_some()),
            friction_smoothing: 0.05,
            auto: None,
        }
    }
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
}

impl ControlSpec {
    /// Computed torque at 1 kHz, in single precision as on the chip.
    pub(crate) fn default_for(robot: &Robot) -> Self {
        Self {
            rate: 1000.0,
            law: Law::ComputedTorque,
            model_every: 1,
            model_between: Between::Hold,
            natural_frequency: vec![30.0; robot.dof()],
            damping: vec![1.0; robot.dof()],
            trig: Method::Polynomial,
            scalar: ScalarChoice::F32,
            kernel: KernelChoice::Exact,
            kernel_memory: KernelMemory::Flash,
            observer_bandwidth: 500.0,
            tunable: false,
            age_max: 2,
            position_margin: 0.05,
            velocity_factor: 1.5,
        }
    }
}

impl SafetySpec {
    /// From the joints' limits.
    ///
    /// | what | default |
    /// |---|---|
    /// | deceleration | the velocity limit in a quarter of a second; 5 where there is none |
    /// | payload | as heavy as the arm's links together, within 1 m of the last link's origin |
    /// | resolution | two counts of the encoder; 1e-3 where there is none |
    /// | reach | 0.2 rad, 0.05 m |
    /// | speed of the first reference | a tenth of the velocity limit; 0.1 where there is none |
    /// | damping | the whole torque at the velocity limit; none where either has no limit |
    pub(crate) fn default_for(robot: &Robot, control: &ControlSpec) -> Self {
        const STOP_TIME: f64 = 0.25;
        let or = |x: f64, otherwise: f64| if x.is_finite() { x } else { otherwise };
        let velocity = |joint: &RobotJoint| joint.spec.limits.velocity;
        let list = |one: &dyn Fn(&RobotJoint) -> f64| robot.joints.iter().map(one).collect::<Vec<f64>>();
        Self {
            safe_action: SafeAction::Brake,
            heartbeat: 0.1,
            hold: 0.5,
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
        }
    }
}

impl PlantSpec {
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

pub(super) fn default_scene(robot: Robot) -> SceneFile {
    let start: Vec<f64> = robot.joints.iter().map(rest).collect();
    let aside: Vec<f64> = robot.joints.iter().zip(&start).map(|(joint, q)| q + swing(joint, *q)).collect();
    // A quintic from rest to rest peaks at 15/8 of its mean speed; half the velocity limit leaves room.
    let slowest = robot.joints.iter().zip(start.iter().zip(&aside));
    let duration = slowest.map(|(joint, (a, b))| 1.875 * (b - a).abs() / (0.5 * joint.spec.limits.velocity));
    let duration = Some(duration.fold(1.0, f64::max));
    let point = |q: &[f64], duration| ViaPoint { q: q.to_vec(), duration, dwell: 0.0 };
    let model = ModelSpec::default_for(&robot);
    let control = ControlSpec::default_for(&robot);
    SceneFile {
        name: robot.name.clone(),
        path: PathBuf::new(),
        duration: None,
        seed: 0,
        plant: PlantSpec::default_for(&robot, &model, &control, &start),
        safety: SafetySpec::default_for(&robot, &control),
        motion: MotionSpec::Quintic {
            points: vec![point(&start, None), point(&aside, duration), point(&start, duration)],
            acceleration: None,
            repeat: false,
        },
        model,
        control,
        collision: None,
        sensors: SensorSpec::default(),
        actuators: ActuatorSpec::default(),
        robot,
    }
}

/// Zero where the limits allow it, else the middle between them, else the limit there is.
fn rest(joint: &RobotJoint) -> f64 {
    let (lo, hi) = joint.spec.limits.position;
    if lo <= 0.0 && 0.0 <= hi {
        0.0
    } else if lo.is_finite() && hi.is_finite() {
        0.5 * (lo + hi)
    } else if lo.is_finite() {
        lo
    } else {
        hi
    }
}

/// To the side with more room, at most half of it: half a radian or 10 cm.
fn swing(joint: &RobotJoint, q: f64) -> f64 {
    let (lo, hi) = joint.spec.limits.position;
    let far: f64 = match joint.spec.kind {
        JointKind::Revolute => 0.5,
        JointKind::Prismatic => 0.1,
    };
    if hi - q >= q - lo { far.min(0.5 * (hi - q)) } else { -far.min(0.5 * (q - lo)) }
}
