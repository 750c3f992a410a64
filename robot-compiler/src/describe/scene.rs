//! Loads on an arm, its controller and the simulated world, as a scene file describes them.

use crate::describe::friction::JointFriction;
use crate::describe::robot::{Robot, RobotJoint};
use dynamics_core::control::{
    CollisionConfig, Encoder, EveryNth, Friction, FrictionTerms, Gains, Guard, Integral, MomentumFilter, Spring, Teach,
    TrackingObserver,
};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::safety::heat::HeatRules;
use dynamics_core::safety::{JointRules, Rules};
use dynamics_core::trig::Libm;
use dynamics_core::{ControllerConfig, Dynamics, Inertia, Limits, Live, Model, Real, Scene, Trig, Wrench};
use model::inertia;
use nalgebra::SVector;
use std::path::PathBuf;

mod control;
mod default;
mod drives;
mod lists;
mod lowering;
mod model;
mod motion;
mod names;
mod plant;
mod safety;
mod trajectory;

pub use control::{CollisionSpec, ControlSpec, DampingAt, IntegralSpec, KernelChoice, ScalarChoice, TeachSpec};
pub(crate) use drives::UNREAD_MAX;
pub use lists::joints;
pub use lowering::axis_to_tip;
pub use model::{AutoTerms, ModelSpec, ModelTerm};
pub use motion::{MotionSpec, ViaPoint};
pub use plant::{
    ActuatorSpec, DriveFailure, ElasticitySpec, FailureKind, Integrator, PlantSpec, Push, Ripple, SensorSpec, Side,
};
pub use safety::{FIRST_MOTION, SafetySpec};

/// A scene: an arm, the loads on it, its controller, its motion, and the simulated world.
///
/// Plain data, free to change after loading (a command line may replace the law or the scalar). [`SceneFile::load`] returns
/// only checked scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Short name.
    pub name: String,
    /// The arm.
    pub robot: Robot,
    /// The file from which it was read; empty for [`SceneFile::default_for`].
    pub path: PathBuf,
    /// Duration of the run, s; `None` means as long as the motion.
    pub duration: Option<f64>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Terms of the controller's inverse dynamics.
    pub model: ModelSpec,
    /// The controller.
    pub control: ControlSpec,
    /// Conditions for torque, and the reaction when they are not met.
    pub safety: SafetySpec,
    /// Collision detection; `None` if it is off.
    pub collision: Option<CollisionSpec>,
    /// The reference motion.
    pub motion: MotionSpec,
    /// The simulated arm and its surroundings.
    pub plant: PlantSpec,
    /// The simulated sensors.
    pub sensors: SensorSpec,
    /// The simulated actuators.
    pub actuators: ActuatorSpec,
}

/// Longest time to switch the drives on, s. A drive that restarts, clears an error and takes its settings needs less.
const ARMING: f64 = 1.0;

/// Distance that a joint coasts when a hand releases it at `teach.speed`, rad or m.
const COAST: f64 = 0.085;

/// Greatest reflected rotor inertia that can be set at run time, as a multiple of the robot file's.
const ROTOR_FACTOR: f64 = 4.0;

impl SceneFile {
    /// Control period, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        1.0 / self.control.rate
    }

    /// Loads on the arm, as the controller knows them.
    #[must_use]
    pub fn scene<const N: usize>(&self, model: &Model<f64, N>) -> Scene<f64, N> {
        self.model.scene(model)
    }

    /// Values of the scene's live terms, taken from the simulated world; the payload is given in the last link's frame.
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
    /// The fixed inertia of [`Gains`] is the diagonal of the mass matrix at the start of the motion.
    #[must_use]
    pub fn controller_config<const N: usize>(&self, model: &Model<f64, N>) -> ControllerConfig<f64, N> {
        let period = self.period();
        let inertia = self.fixed_inertia(model, &self.model);
        let frequency: [f64; N] = match &self.control.stiffness {
            // K = M0 omega^2.
            Some(stiffness) => {
                let stiffness: [f64; N] = joints(stiffness);
                std::array::from_fn(|i| (stiffness[i] / inertia[i]).sqrt())
            }
            None => joints(&self.control.natural_frequency),
        };
        let damping: [f64; N] = joints(&self.control.damping);
        let limits = model.links().map(|link| link.limits);
        let gains: [Gains<f64>; N] = std::array::from_fn(|i| Gains::new(frequency[i], damping[i], inertia[i]));
        let integral = self.control.integral.as_ref().map(|spec| {
            let (torque, dead_band): ([f64; N], [f64; N]) = (joints(&spec.torque), joints(&spec.dead_band));
            std::array::from_fn(|i| Integral {
                gain: gains[i].inertia * gains[i].position * period / spec.time,
                torque_max: torque[i],
                dead_band: dead_band[i],
                friction: self.friction(i).coulomb,
            })
        });
        let teach =
            self.control.teach.as_ref().map(|spec| std::array::from_fn(|i| self.teach(spec, i, &limits[i], &gains[i])));
        ControllerConfig {
            law: self.control.law,
            gains,
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
            integral,
            teach,
            posture_damping: self.control.damping_at.share(),
        }
    }

    /// Thresholds of the collision detection and the reaction to a collision; `None` if the scene has no collision
    /// detection.
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

    /// Wraps inverse dynamics so that it is evaluated only in every `model_every`-th tick, with the fixed inertia of
    /// `config` in the ticks between.
    #[must_use]
    pub fn every_nth<D, S: Real, const N: usize>(
        &self,
        inner: D,
        config: &ControllerConfig<S, N>,
    ) -> EveryNth<D, S, N> {
        EveryNth::new(inner, self.control.model_every, self.control.model_between, &config.gains)
    }

    /// Diagonal of the inertia matrix of this model at the start of the motion, kg m^2 or kg.
    pub(crate) fn fixed_inertia<const N: usize>(&self, model: &Model<f64, N>, spec: &ModelSpec) -> SVector<f64, N> {
        let start: [f64; N] = joints(self.motion.start());
        let dynamics = Dynamics::new(*model, spec.scene(model));
        mass_matrix(&dynamics, &Libm.sin_cos_all(&start), &start, &self.live(model)).diagonal()
    }

    /// The numbers of the safety state machine; times in whole ticks, rounded up.
    #[must_use]
    pub fn safety_rules<const N: usize>(&self, model: &Model<f64, N>) -> Rules<f64, N> {
        let (safety, period) = (&self.safety, self.period());
        // The cast saturates at the largest value of the type.
        let ticks = |time: f64| (time * self.control.rate - 1e-6).ceil() as u32;
        let list = |list: &[f64]| joints::<N>(list);
        let (rest_speed, resolution) = (list(&safety.rest_speed), list(&safety.resolution));
        let (reach, reach_speed) = (list(&safety.reach), list(&safety.reach_speed));
        let (deceleration, damping) = (list(&safety.deceleration), list(&safety.damping));
        let lowering_speed = self.lowering_speed(model);
        Rules {
            safe_action: safety.safe_action,
            heartbeat_max: ticks(safety.heartbeat),
            hold_max: ticks(safety.hold),
            supply: safety.supply,
            temperature: safety.temperature,
            period,
            rate: self.control.rate,
            latency: safety.latency,
            arming_max: ticks(ARMING),
            brake_delay: ticks(safety.brake_delay),
            live: self.model.live_inputs(),
            live_max: safety.live_age.map_or(0, ticks),
            rest: safety.rest.as_deref().map(joints),
            first_motion: safety.first_motion,
            heat: self.heat(),
            payload: safety.payload,
            joints: std::array::from_fn(|i| JointRules {
                rest_speed: rest_speed[i],
                jump_step: safety.jump_factor * model.links()[i].limits.velocity * period,
                resolution: resolution[i],
                deceleration: deceleration[i],
                reach: reach[i],
                reach_speed: reach_speed[i],
                rotor_max: ROTOR_FACTOR * model.links()[i].rotor,
                damping: damping[i],
                lowering_speed: lowering_speed[i],
            }),
        }
    }

    /// Heat models of the motors, for the board: of those with known rated torque and time constant. `None` if there are none.
    fn heat<const N: usize>(&self) -> Option<[HeatRules<f64>; N]> {
        // One motor is updated in each tick.
        let update = N as f64 * self.period();
        let of = |i: usize| self.robot.joints.get(i).and_then(|joint| joint.heat.rules(update));
        (0..N).any(|i| of(i).is_some()).then(|| std::array::from_fn(|i| of(i).unwrap_or(HeatRules::UNKNOWN)))
    }

    /// Number of steps of the plant in one control period.
    #[must_use]
    pub fn steps_per_tick(&self) -> u32 {
        let ratio = (self.period() / self.plant.step).round();
        if ratio.is_finite() && ratio >= 1.0 { ratio.min(f64::from(u32::MAX)) as u32 } else { 1 }
    }

    /// Springs and dampers of a hand-guided joint follow from the gains that hold it before and after.
    fn teach(&self, spec: &TeachSpec, index: usize, limits: &Limits<f64>, gains: &Gains<f64>) -> Teach<f64> {
        let friction = self.friction(index);
        let Spring { stiffness, damping } = gains.spring();
        let ((lo, hi), wall) = (limits.position, spec.wall[index]);
        Teach {
            friction: spec.friction * friction.coulomb,
            per_still_speed: 1.0 / spec.still_speed[index],
            breakaway: spec.breakaway[index],
            slip: spec.breakaway[index] / stiffness,
            drag: spec.drag[index] - spec.friction * friction.viscous,
            speed: spec.speed[index],
            wall: (lo + wall, hi - wall),
            per_wall: if wall > 0.0 { 1.0 / wall } else { 0.0 },
            stiffness,
            damping,
            slowing: spec.speed[index] / COAST,
        }
    }

    pub(crate) fn friction(&self, index: usize) -> Friction<f64> {
        self.joint_friction(index).feedforward(self.model.friction_smoothing)
    }

    /// Terms of each joint's friction in addition to [`SceneFile::friction`]; `None` if no joint has any, or if the model omits friction.
    pub(crate) fn friction_terms<const N: usize>(&self) -> Option<[FrictionTerms<f64>; N]> {
        self.robot_friction_terms().filter(|_| self.model.friction)
    }

    /// As [`Self::friction_terms`] for the robot, whether or not the model has friction.
    pub(crate) fn robot_friction_terms<const N: usize>(&self) -> Option<[FrictionTerms<f64>; N]> {
        let limit = |index: usize| self.robot.joints.get(index).map_or(0.0, |joint| joint.spec.limits.torque);
        let terms = |index: usize| self.joint_friction(index).terms(limit(index));
        (0..N).any(|index| self.joint_friction(index).has_terms()).then(|| std::array::from_fn(terms))
    }

    fn joint_friction(&self, index: usize) -> JointFriction {
        self.robot.joints.get(index).and_then(|joint| joint.friction).unwrap_or_default()
    }

    fn encoder(&self, index: usize) -> Encoder<f64> {
        let per_count = self.robot.joints.get(index).and_then(RobotJoint::per_count);
        Encoder { zero: 0, per_count: per_count.unwrap_or(0.0) }
    }
}
