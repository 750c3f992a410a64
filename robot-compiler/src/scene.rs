//! What acts on an arm, how it is controlled and what is simulated, as a scene file says it.

use crate::diagnostics::FileError;
use crate::robot::{Robot, RobotJoint};
use crate::scene_file;
use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, SweepSpec, Timing, TorqueLimits, Waypoint};
use dynamics_core::control::{
    CollisionConfig, Encoder, EveryNth, Friction, Gains, Guard, MomentumFilter, TrackingObserver,
};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::safety::{JointRules, Rules};
use dynamics_core::trig::Libm;
use dynamics_core::{Body, ControllerConfig, Dynamics, Inertia, Live, Model, Real, Scene, Trig, Wrench};
use nalgebra::SVector;
use std::path::{Path, PathBuf};

pub(crate) mod choices;
pub mod loop_gain;
mod settings;
pub mod terms;

pub use settings::{
    ActuatorSpec, BreakawaySpec, CollisionSpec, ControlSpec, ElasticitySpec, FrictionSpec, IntegratorChoice,
    KernelChoice, KernelMemory, MeasuredSide, ModelSpec, MotionSpec, PlantSpec, PushSpec, RippleSpec, SafetySpec,
    ScalarChoice, SensorSpec, ViaPoint,
};

/// A scene: an arm, what acts on it, its controller, its motion, and the simulated world.
///
/// Plain data, free to change after loading (a command line may replace the law or the scalar). Whatever
/// [`SceneFile::load`] returns has been checked.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Short name.
    pub name: String,
    /// The arm.
    pub robot: Robot,
    /// The file it came from; empty for [`SceneFile::default_for`].
    pub path: PathBuf,
    /// How long to run, s; `None`: as long as the motion.
    pub duration: Option<f64>,
    /// Seed of everything random.
    pub seed: u64,
    /// What the controller's inverse dynamics computes.
    pub model: ModelSpec,
    /// How it is controlled.
    pub control: ControlSpec,
    /// When torque acts, and what happens instead.
    pub safety: SafetySpec,
    /// What counts as a collision; `None`: nothing is looked for.
    pub collision: Option<CollisionSpec>,
    /// What it should do.
    pub motion: MotionSpec,
    /// What is simulated.
    pub plant: PlantSpec,
    /// What the sensors do.
    pub sensors: SensorSpec,
    /// What the actuators do.
    pub actuators: ActuatorSpec,
}

impl SceneFile {
    /// Read a scene file and the robot file that it names.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, or that asks for what cannot be.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        scene_file::load(path)
    }

    /// From the text of a scene file; `path` stands for the file in errors, and the robot's path is relative to it.
    ///
    /// # Errors
    /// As [`SceneFile::load`].
    pub fn from_toml_str(text: &str, path: &Path) -> Result<Self, FileError> {
        scene_file::from_text(text, path)
    }

    /// A sensible scene for an arm without one: floor, computed torque at 1 kHz, a swing to one side and back.
    #[must_use]
    pub fn default_for(robot: Robot) -> Self {
        settings::default_scene(robot)
    }

    /// Control period, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        1.0 / self.control.rate
    }

    /// What acts on the arm, as the controller sees it.
    #[must_use]
    pub fn scene<const N: usize>(&self, model: &Model<f64, N>) -> Scene<f64, N> {
        self.model.scene(model)
    }

    /// Values for what the scene calls live, taken from the simulated world; the payload in the last link's frame.
    #[must_use]
    pub fn live<const N: usize>(&self, model: &Model<f64, N>) -> Live<f64, N> {
        let tip = model.tip();
        let payload = self.plant.payload.map_or(Inertia::zero(), |body| inertia(&body));
        Live {
            gravity: self.plant.gravity,
            // Symmetric to the bit: kernels and the link carry six entries of the tensor, the recursion reads nine.
            payload: payload.in_parent(&tip.rotation, &tip.translation).symmetric(),
            tip_wrench: self.plant.tip_wrench.unwrap_or_else(Wrench::zero),
            rotor: model.links().map(|link| link.rotor),
        }
    }

    /// The controller's configuration.
    ///
    /// The fixed inertia of [`Gains`] is the diagonal of the mass matrix where the motion starts.
    #[must_use]
    pub fn controller_config<const N: usize>(&self, model: &Model<f64, N>) -> ControllerConfig<f64, N> {
        let period = self.period();
        let inertia = self.fixed_inertia(model, &self.model);
        let frequency: [f64; N] = joints(&self.control.natural_frequency);
        let damping: [f64; N] = joints(&self.control.damping);
        let limits = model.links().map(|link| link.limits);
        ControllerConfig {
            law: self.control.law,
            gains: std::array::from_fn(|i| Gains::new(frequency[i], damping[i], inertia[i])),
            friction: self.model.friction.then(|| std::array::from_fn(|i| self.friction(i))),
            limits,
            torque_step: limits.map(|limits| limits.torque_rate * period),
            guard: limits.map(|limits| Guard {
                position_margin: self.control.position_margin,
                velocity_max: self.control.velocity_factor * limits.velocity,
            }),
            age_max: self.control.age_max,
            encoder: std::array::from_fn(|i| self.encoder(i)),
            observer: TrackingObserver::new(self.control.observer_bandwidth, period),
        }
    }

    /// When something has been hit, and what is done then; `None` where the scene does not look for it.
    #[must_use]
    pub fn collision_config<const N: usize>(&self) -> Option<CollisionConfig<f64, N>> {
        let spec = self.collision.as_ref()?;
        let threshold: [f64; N] = joints(&spec.threshold);
        Some(CollisionConfig {
            filter: MomentumFilter::new(spec.bandwidth, self.period()),
            threshold,
            released: threshold.map(|threshold| 0.5 * threshold),
            ticks: spec.ticks,
            release_ticks: (spec.release * self.control.rate).ceil() as u32,
            reaction: spec.reaction,
        })
    }

    /// These inverse dynamics, evaluated in the ticks in which the scene asks for it, with the fixed inertia of `config` between.
    #[must_use]
    pub fn every_nth<D, S: Real, const N: usize>(
        &self,
        inner: D,
        config: &ControllerConfig<S, N>,
    ) -> EveryNth<D, S, N> {
        EveryNth::new(inner, self.control.model_every, self.control.model_between, &config.gains)
    }

    /// Diagonal of the inertia matrix that a model of this scene has where the motion starts, kg m^2 or kg.
    pub(crate) fn fixed_inertia<const N: usize>(&self, model: &Model<f64, N>, spec: &ModelSpec) -> SVector<f64, N> {
        let start: [f64; N] = joints(self.motion.start());
        let dynamics = Dynamics::new(*model, spec.scene(model));
        mass_matrix(&dynamics, &Libm.sin_cos_all(&start), &start, &self.live(model)).diagonal()
    }

    /// The numbers of the safety state machine; times in whole ticks, rounded up.
    #[must_use]
    pub fn safety_rules<const N: usize>(&self, model: &Model<f64, N>) -> Rules<f64, N> {
        let (safety, period) = (&self.safety, self.period());
        // A number too large for the type is its largest.
        let ticks = |time: f64| (time * self.control.rate - 1e-6).ceil() as u32;
        let list = |list: &[f64]| joints::<N>(list);
        let (rest_speed, resolution) = (list(&safety.rest_speed), list(&safety.resolution));
        let (reach, reach_speed) = (list(&safety.reach), list(&safety.reach_speed));
        let (deceleration, damping) = (list(&safety.deceleration), list(&safety.damping));
        Rules {
            safe_action: safety.safe_action,
            heartbeat_max: ticks(safety.heartbeat),
            hold_max: ticks(safety.hold),
            supply: safety.supply,
            temperature: safety.temperature,
            period,
            rate: self.control.rate,
            latency: safety.latency,
            payload: safety.payload,
            joints: std::array::from_fn(|i| JointRules {
                rest_speed: rest_speed[i],
                jump_step: safety.jump_factor * model.links()[i].limits.velocity * period,
                resolution: resolution[i],
                deceleration: deceleration[i],
                reach: reach[i],
                reach_speed: reach_speed[i],
                damping: damping[i],
            }),
        }
    }

    /// The reference motion, checked against the joint limits and slowed where that makes it fit.
    ///
    /// # Errors
    /// A motion that cannot be: outside the position limits, too fast, or of a shape that does not exist.
    pub fn trajectory<const N: usize>(&self, model: &Model<f64, N>) -> Result<Motion<f64, N>, MotionError> {
        let bounds = Bounds::from_limits(&model.links().map(|link| link.limits));
        match &self.motion {
            MotionSpec::Hold { q, duration } => Motion::hold(joints(q), *duration, &bounds),
            MotionSpec::Quintic { points, acceleration, .. } => {
                let waypoints: Vec<Waypoint<f64, N>> =
                    points.iter().map(|point| Waypoint { q: joints(&point.q), dwell: point.dwell }).collect();
                let durations: Option<Vec<f64>> = points.iter().skip(1).map(|point| point.duration).collect();
                match durations {
                    Some(durations) => Motion::quintic(&waypoints, Timing::Durations(&durations), &bounds),
                    None => {
                        let bounds = with_acceleration(bounds, acceleration.as_deref());
                        self.within_torque(model, Motion::quintic(&waypoints, Timing::Fastest, &bounds)?)
                    }
                }
            }
            MotionSpec::Trapezoid { start, goal, acceleration, duration, ramp_share } => {
                let (start, goal) = (joints(start), joints(goal));
                match duration {
                    Some(duration) => Motion::trapezoid_in(start, goal, *duration, *ramp_share, &bounds),
                    None => {
                        let bounds = with_acceleration(bounds, acceleration.as_deref());
                        self.within_torque(model, Motion::trapezoid(start, goal, &bounds)?)
                    }
                }
            }
            MotionSpec::Sine { centre, amplitude, frequency_start, frequency_end, duration, ramp } => {
                let spec = SweepSpec {
                    centre: joints(centre),
                    amplitude: joints(amplitude),
                    from: *frequency_start,
                    to: *frequency_end,
                    duration: *duration,
                    ramp: *ramp,
                };
                Motion::sweep(&spec, &bounds)
            }
        }
    }

    /// Slow a motion of no stated duration until the torques leave a tenth of the limit to friction and feedback.
    fn within_torque<const N: usize>(
        &self,
        model: &Model<f64, N>,
        motion: Motion<f64, N>,
    ) -> Result<Motion<f64, N>, MotionError> {
        const SHARE: f64 = 0.9;
        const STEPS: u32 = 500;
        // Whatever of the model `terms = "auto"` took away: the choice is made along the motion, not the motion by the choice.
        let dynamics = Dynamics::new(*model, self.model.full().scene(model));
        let torque = std::array::from_fn(|i| {
            let coulomb = self.robot.joints.get(i).and_then(|joint| joint.friction).map_or(0.0, |f| f.coulomb);
            let limit = model.links()[i].limits.torque;
            // A drive that friction alone could hold is the plant's trouble, not a reason to refuse the motion.
            (SHARE * limit - coulomb).max(0.1 * limit)
        });
        motion.scale_to_torque(&dynamics, &Libm, &self.live(model), &TorqueLimits { torque, steps: STEPS })
    }

    /// How many steps of the plant make one control period.
    #[must_use]
    pub fn steps_per_tick(&self) -> u32 {
        let ratio = (self.period() / self.plant.step).round();
        if ratio.is_finite() && ratio >= 1.0 { ratio.min(f64::from(u32::MAX)) as u32 } else { 1 }
    }

    /// The line of a key of a table, counted from 1, as the scene's file has it now; `None` where the file does not say it.
    #[must_use]
    pub fn line_of(&self, table: &str, key: &str) -> Option<usize> {
        scene_file::line_of(&self.path, table, key)
    }

    pub(crate) fn friction(&self, index: usize) -> Friction<f64> {
        let friction = self.robot.joints.get(index).and_then(|joint| joint.friction);
        let (viscous, coulomb) = friction.map_or((0.0, 0.0), |friction| (friction.viscous, friction.coulomb));
        Friction { viscous, coulomb, per_smoothing_speed: 1.0 / self.model.friction_smoothing }
    }

    fn encoder(&self, index: usize) -> Encoder<f64> {
        let per_count = self.robot.joints.get(index).and_then(RobotJoint::per_count);
        Encoder { zero: 0, per_count: per_count.unwrap_or(0.0) }
    }
}

/// A body as the core carries it.
fn inertia(body: &Body) -> Inertia<f64> {
    Inertia::from_mass_centre(body.mass, &body.com, &body.inertia)
}

fn with_acceleration<const N: usize>(bounds: Bounds<f64, N>, acceleration: Option<&[f64]>) -> Bounds<f64, N> {
    match acceleration {
        Some(acceleration) => bounds.with_acceleration(joints(acceleration)),
        None => bounds,
    }
}

/// One number per joint. Loading has checked the lengths; a list that was changed since reads as zero where it is short.
pub(crate) fn joints<const N: usize>(list: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| list.get(i).copied().unwrap_or(0.0))
}
