//! From a scene to a finished run, in memory.

use crate::failure::{Failure, number};
use crate::plant::actuator::ActuatorSettings;
use crate::plant::drives::Drives;
use crate::plant::elasticity::Elasticity;
use crate::plant::friction::{Breakaway, mobility};
use crate::plant::jitter::{Jitter, Moved};
use crate::plant::sensor::{Counter, SensorSettings, Sensors};
use crate::plant::solver::{AtOnce, Solver, now};
use crate::plant::{Arm, Clock, JointFriction, Plant};
use crate::run::batch::{Batch, Job};
use crate::run::closed_loop::{self, Closed, End, World};
use crate::run::marks::Marks;
use crate::run::record::{JointLabel, Record};
use crate::run::summary::{ModelTicks, Setting, SimulatedDrives, Summary};
use crate::run::target::Torques;
use dynamics_core::control::{CollisionWatch, ControllerOf, EveryNth, SpringOwner};
use dynamics_core::safety::SafeAction;
use dynamics_core::trig::Method;
use dynamics_core::{Body, Controller, ControllerConfig, Dynamics, JointSpec, Live, Model, Real, Trig};
use indicatif::ProgressBar;
use robot_compiler::choose::ArmDynamics;
use robot_compiler::names::name;
use robot_compiler::scene::{ElasticitySpec, Integrator, ScalarChoice, joints};
use robot_compiler::{RobotJoint, SceneFile};
use std::sync::atomic::AtomicBool;

/// A finished run.
#[derive(Debug)]
pub struct Run {
    /// Every tick of the run.
    pub record: Record,
    /// The run in a few numbers.
    pub summary: Summary,
    /// Limits and times of waypoints, for the report.
    pub marks: Marks,
    /// Reason why the run ended.
    pub end: End,
    /// Error of the target, if it failed; the record then ends there.
    pub failure: Option<miette::Report>,
}

/// Limit on the samples of a run (ticks times joints), which fit in memory with ease.
const SAMPLES_MAX: f64 = 2e7;

/// Run the controller of a scene in a world, on the desk.
pub(super) async fn on_desk<const N: usize>(
    solver: &impl Solver<N>,
    world: &mut World<N>,
    scene: &SceneFile,
    stop: &AtomicBool,
    progress: &ProgressBar,
) -> Result<Run, Failure> {
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    match scene.control.scalar {
        ScalarChoice::F64 => {
            closed_in::<f64, N, _>(solver, world, scene, "desk", &mut desk(scene, &model), stop, progress).await
        }
        ScalarChoice::F32 => {
            closed_in::<f32, N, _>(solver, world, scene, "desk", &mut desk(scene, &model), stop, progress).await
        }
    }
}

/// A scene that waits to be run beside others.
struct Prepared<'a, F, const N: usize> {
    scene: SceneFile,
    world: World<N>,
    stop: &'a AtomicBool,
    each: &'a F,
}

impl<T, F: Fn(Run) -> T, const N: usize> Job<N> for Prepared<'_, F, N> {
    type Outcome = Result<T, Failure>;

    fn plant(&self) -> &Plant<N> {
        &self.world.plant
    }

    async fn run(mut self, solver: &impl Solver<N>) -> Self::Outcome {
        on_desk(solver, &mut self.world, &self.scene, self.stop, &ProgressBar::hidden()).await.map(self.each)
    }
}

/// Run scenes on the desk side by side: each as [`run`](crate::run::simulation::run) has it, in a fraction of the time where the processor has a
/// [kernel](crate::run::batch) for their arms. Returns what `each` makes of the runs, in the order of the scenes, and in their places the
/// failures of what is no scene.
pub fn on_desk_side_by_side<T, const N: usize>(
    batch: &mut Batch<N>,
    scenes: impl IntoIterator<Item = Result<SceneFile, Failure>>,
    stop: &AtomicBool,
    each: impl Fn(Run) -> T,
) -> Vec<Result<T, Failure>> {
    batch.run(scenes.into_iter().map(|scene| {
        let scene = scene?;
        Ok(Prepared { world: world(&scene)?, scene, stop, each: &each })
    }))
}

/// A controller on the desk that computes in `S`.
pub type Desk<S, const N: usize> =
    ControllerOf<S, N, EveryNth<ArmDynamics<S, N>, S, N>, Method, ControllerConfig<S, N>, Watch<S, N>>;

/// Collision watch, if the scene asks for one.
pub type Watch<S, const N: usize> = Option<CollisionWatch<S, N, Dynamics<S, N>>>;

/// The controller that a scene asks for, computing here in `S`; every live input is zero until [`with`] sets it.
#[must_use]
pub fn desk<S: Real, const N: usize>(scene: &SceneFile, model: &Model<f64, N>) -> Desk<S, N>
where
    Method: Trig<S>,
{
    desk_with(scene, model, &scene.controller_config(model))
}

/// As [`desk`], with another configuration.
#[must_use]
pub fn desk_with<S: Real, const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    config: &ControllerConfig<f64, N>,
) -> Desk<S, N>
where
    Method: Trig<S>,
{
    let config: ControllerConfig<S, N> = config.cast();
    Controller::new(config, scene.every_nth(scene.dynamics(model), &config), scene.control.trig)
        .with_protection(scene.watch(model))
}

/// Live inputs of the scene (gravity, payload, wrench at the tip), for a controller in `S`.
#[must_use]
pub fn live_inputs<S: Real, const N: usize>(scene: &SceneFile, model: &Model<f64, N>) -> Live<S, N> {
    scene.live(model).cast()
}

/// Run a scene with this controller, on any target, after setting its live inputs.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run; [`Failure::Target`] when the target cannot take the live inputs.
/// A target that fails during the run is no error here: see [`Run::failure`].
pub fn with<S: Real, const N: usize, C: Torques<S, N>>(
    scene: &SceneFile,
    target: &str,
    controller: &mut C,
    stop: &AtomicBool,
    progress: &ProgressBar,
) -> Result<Run, Failure> {
    within(&mut world::<N>(scene)?, scene, target, controller, stop, progress)
}

/// As [`with`], in a world that the caller owns.
///
/// # Errors
/// As [`with`].
pub fn within<S: Real, const N: usize, C: Torques<S, N>>(
    world: &mut World<N>,
    scene: &SceneFile,
    target: &str,
    controller: &mut C,
    stop: &AtomicBool,
    progress: &ProgressBar,
) -> Result<Run, Failure> {
    now(closed_in(&AtOnce, world, scene, target, controller, stop, progress))
}

async fn closed_in<S: Real, const N: usize, C: Torques<S, N>>(
    solver: &impl Solver<N>,
    world: &mut World<N>,
    scene: &SceneFile,
    target: &str,
    controller: &mut C,
    stop: &AtomicBool,
    progress: &ProgressBar,
) -> Result<Run, Failure> {
    let ticks = ticks(scene, world.motion.duration())?;
    progress.set_length(ticks);
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    controller.set_live(&live_inputs(scene, &model)).map_err(Failure::Target)?;
    let labels = scene.robot.joints.iter().map(JointLabel::from).collect();
    let mut record = Record::new(labels, usize::try_from(ticks).unwrap_or(usize::MAX));
    // The bar limits its own redraws; fewer calls cost less still.
    let after_tick = |tick: u64| {
        if tick.is_multiple_of(64) {
            progress.set_position(tick);
        }
    };
    let Closed { end, timing, failure } =
        closed_loop::run_with(solver, world, controller, ticks, stop, &mut record, after_tick).await;
    progress.finish_and_clear();
    let summary = Summary::new(setting(scene, target), scene, &record, end, timing);
    let marks = Marks::of(world, &model, record.ticks());
    Ok(Run { record, summary, marks, end, failure })
}

/// The arm that a scene simulates, with its tool, payload, gravity and wrench at the tip, as heavy as it truly is.
///
/// # Errors
/// [`Failure::Input`]: the robot does not have `N` joints.
pub fn arm<const N: usize>(scene: &SceneFile) -> Result<Arm<N>, Failure> {
    let heavy = |(joint, factor): (&RobotJoint, &f64)| {
        let Body { mass, com, inertia } = joint.spec.body;
        JointSpec { body: Body { mass: factor * mass, com, inertia: *factor * inertia }, ..joint.spec }
    };
    let specs: Vec<JointSpec> = scene.robot.joints.iter().zip(&scene.plant.masses).map(heavy).collect();
    let wrong = |_| Failure::Input(miette::miette!("{} does not have {N} joints", scene.robot.path.display()));
    Ok(Arm {
        joints: <[JointSpec; N]>::try_from(specs).map_err(wrong)?,
        tool: scene.robot.tool,
        payload: scene.plant.payload,
        gravity: scene.plant.gravity,
        tip_wrench: scene.plant.tip_wrench,
    })
}

/// The simulated world of a scene.
///
/// # Errors
/// [`Failure::Input`]: the robot does not have `N` joints, or the motion is not possible.
pub fn world<const N: usize>(scene: &SceneFile) -> Result<World<N>, Failure> {
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    let motion = scene
        .trajectory(&model)
        .map_err(|error| Failure::Input(miette::miette!("{}: the motion cannot be: {error}", scene.path.display())))?;
    let arm = arm::<N>(scene)?;
    let start: [f64; N] = joints(&scene.plant.start);
    let clock = Clock { period: scene.period(), steps_per_tick: scene.steps_per_tick() };
    let step = longest_step(scene.plant.integrator, &clock);
    let elasticity = scene.plant.elasticity.as_ref().map(springs::<N>);
    let friction = scene.plant.friction.then(|| friction_laws::<N>(scene));
    if let Some(friction) = friction.as_ref().filter(|laws| laws.iter().any(|law| law.breakaway.is_some())) {
        let mobility = match elasticity {
            None => mobility(&arm, &start),
            Some(_) => arm.joints.each_ref().map(|joint| joint.rotor.reflected().recip()),
        };
        can_follow(scene, step, friction, &mobility)?;
    }
    let fastest = elasticity.and_then(|springs| springs.fastest(&arm, &start));
    fastest.map_or(Ok(()), |fastest| can_swing(scene, step, fastest))?;
    let drives = scene.simulated_drives::<N>();
    // Simulated drives have a delay and a ceiling of their own.
    let ideal = drives.is_none();
    let actuators = ActuatorSettings {
        delay: if ideal { scene.actuators.delay as usize } else { 0 },
        saturation: ideal && scene.actuators.saturation,
        lag: (scene.actuators.lag > 0.0).then_some(scene.actuators.lag),
        ripple: scene.actuators.ripple,
    };
    let control = scene.controller_config(&model);
    let (encoder, config) = (control.encoder, control.cast::<f32>());
    let sensors = SensorSettings {
        position_noise: scene.sensors.position_noise,
        velocity_noise: scene.sensors.velocity_noise,
        counters: scene.sensors.encoder.then(|| encoder.map(|e| Counter { zero: e.zero, per_count: e.per_count })),
        delay: scene.sensors.delay as usize,
    };
    let jitter = |most: f64, moved| (most > 0.0).then(|| Jitter::new(most, scene.seed, moved));
    let plant = Plant::new(&arm, friction, actuators, clock, start)
        .with_integrator(scene.plant.integrator)
        .with_push(scene.plant.push)
        .with_jitter(jitter(scene.sensors.jitter, Moved::Sampling), jitter(scene.actuators.jitter, Moved::Acting));
    let plant = if scene.plant.rotor_coupling { plant.with_rotor_coupling(&arm.joints) } else { plant };
    let drives = drives.map(|(specs, wires)| {
        Drives::new(&specs, wires, clock, scene.actuators.loop_rate)
            .with_failure(scene.actuators.failure)
            .with_torque_factors(&scene.actuators.torque_factor)
    });
    Ok(World {
        drives,
        safe_action: scene.safety.safe_action,
        temperature: scene.safety.temperature,
        plant: match elasticity {
            None => plant,
            Some(springs) => plant.with_elasticity(springs, scene.sensors.side),
        },
        sensors: Sensors::new(sensors, scene.seed),
        motion,
        repeat: scene.motion.repeats(),
        hand_guided: scene.control.law.is_hand_guided(),
        springs: (scene.control.law.traits().spring == SpringOwner::Drive)
            .then(|| config.gains.map(|gains| gains.spring())),
        period: scene.period(),
        model,
    })
}

/// As [`world`], with ideal drives whatever the robot file describes.
///
/// # Errors
/// As [`world`].
pub fn ideal_world<const N: usize>(scene: &SceneFile) -> Result<World<N>, Failure> {
    let mut scene = scene.clone();
    scene.actuators.ideal = true;
    world(&scene)
}

/// Longest step (s) that the integrator is sure to take; zero if it adapts its steps.
fn longest_step(integrator: Integrator, clock: &Clock) -> f64 {
    match integrator {
        Integrator::RungeKutta | Integrator::SemiImplicitEuler => clock.step(),
        Integrator::Adaptive { .. } => 0.0,
    }
}

/// Springs, dampers and play of the simulated joints.
fn springs<const N: usize>(spec: &ElasticitySpec) -> Elasticity<N> {
    Elasticity {
        stiffness: joints(&spec.stiffness),
        damping: joints(&spec.damping),
        backlash: spec.backlash.as_deref().map(joints),
    }
}

/// Refuse a step that is too long for the fastest oscillation or decay in the joints; it would falsify them.
///
/// At the start the step must be below `1 / (2 rate)`: there a Runge-Kutta step loses 1.1e-4 of an oscillation's
/// amplitude, and semi-implicit Euler is 1 % off in its frequency. Stability (2.8 and 2 in place of 1/2) has room for
/// the inertia to change on the way.
fn can_swing(scene: &SceneFile, step: f64, fastest: f64) -> Result<(), Failure> {
    const RATIO: f64 = 0.5;
    if step * fastest <= RATIO {
        return Ok(());
    }
    let longest = RATIO / fastest;
    Err(Failure::Input(miette::miette!(
        help = format!("expected a `step` of at most {longest:.2e} in [plant], or `integrator = \"adaptive\"`"),
        "{}: a step of {step} s is too long for the springs in the joints, of which the fastest has {fastest:.0} rad/s",
        scene.path.display(),
    )))
}

/// Friction of the simulated joints: the plant's own, or the robot file's.
pub fn friction_laws<const N: usize>(scene: &SceneFile) -> [JointFriction; N] {
    core::array::from_fn(|i| {
        let friction = match &scene.plant.friction_law {
            Some(all) => all.get(i).copied(),
            None => scene.robot.joints.get(i).and_then(|joint| joint.friction),
        };
        friction.unwrap_or_default()
    })
}

/// Refuse a step in which a joint that breaks away would leap over the fall from breakaway to Coulomb friction.
///
/// While its friction falls, a joint gains speed at a rate of at most `0.86 (s - c) (D^-1)_ii / v_s`. A step may be half as long as
/// `v_s / ((s - c) (D^-1)_ii)`, at the inertia of the start.
fn can_follow<const N: usize>(
    scene: &SceneFile,
    step: f64,
    friction: &[JointFriction; N],
    mobility: &[f64; N],
) -> Result<(), Failure> {
    const RATIO: f64 = 0.5;
    let slowest = |(joint, friction): (usize, &JointFriction)| {
        let Breakaway { torque, speed, load } = friction.breakaway?;
        let limit = scene.robot.joints.get(joint).map_or(0.0, |joint| joint.spec.limits.torque);
        let most = torque + if limit.is_finite() { load * limit } else { 0.0 };
        let gained = (most - friction.coulomb) * mobility[joint];
        Some((joint, speed, RATIO * speed / gained, gained * step / RATIO))
    };
    let shortest = friction.iter().enumerate().filter_map(slowest).min_by(|a, b| a.2.total_cmp(&b.2));
    let Some((joint, speed, longest, least)) = shortest.filter(|(_, _, longest, _)| step > *longest) else {
        return Ok(());
    };
    let name = scene.robot.joints.get(joint).map_or("", |joint| &joint.name);
    Err(Failure::Input(miette::miette!(
        help = format!(
            "expected a `step` of at most {longest:.2e} in [plant], or a `stribeck_speed` of at least {least:.2e}"
        ),
        "{}: joint {} ({name}): a step of {step} s is too long for breakaway at a Stribeck velocity of {speed}",
        scene.path.display(),
        joint + 1,
    )))
}

/// Number of control periods in the scene's duration.
fn ticks(scene: &SceneFile, motion: f64) -> Result<u64, Failure> {
    let duration = scene.duration.unwrap_or(motion);
    let ticks = (duration / scene.period()).round();
    let problem = if !(duration.is_finite() && ticks >= 1.0) {
        let duration = number(duration);
        format!("a duration of {duration} s; expected at least one control period of {} s", scene.period())
    } else if ticks * scene.robot.dof() as f64 > SAMPLES_MAX {
        let most = SAMPLES_MAX / scene.robot.dof() as f64 * scene.period();
        let [duration, ticks] = [duration, ticks].map(number);
        format!("a duration of {duration} s makes {ticks} ticks; expected at most {most:.0} s, which a log can hold")
    } else {
        return Ok(ticks as u64);
    };
    Err(Failure::Input(miette::miette!("{}: {problem}", scene.path.display())))
}

fn setting(scene: &SceneFile, target: &str) -> Setting {
    let (law, trig) = scene.control.names();
    let every = scene.control.model_every;
    Setting {
        scene: scene.name.clone(),
        robot: scene.robot.name.clone(),
        target: target.to_owned(),
        scalar: name(scene.control.scalar).to_owned(),
        law: law.to_owned(),
        trig: trig.to_owned(),
        model: (every > 1).then(|| ModelTicks { every, between: name(scene.control.model_between).to_owned() }),
        period: scene.period(),
        drives: drives(scene),
    }
}

/// Simulated drives of a scene, in words.
fn drives(scene: &SceneFile) -> Option<SimulatedDrives> {
    let mit = scene.robot.joints.iter().all(|joint| joint.drive.is_some_and(|drive| drive.mit().is_some()));
    (mit && !scene.actuators.ideal).then_some(SimulatedDrives {
        kind: scene.protocol().map_or("", |protocol| protocol.facts().name),
        loop_rate: scene.actuators.loop_rate,
        after_fault: match scene.safety.safe_action {
            SafeAction::Brake => "the brakes held",
            SafeAction::DampedStop => "the drives damped",
            SafeAction::Off => "the drives were off",
        },
    })
}
