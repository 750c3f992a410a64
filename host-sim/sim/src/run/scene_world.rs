//! The simulated world of a scene: its arm, its drives, its sensors and its motion.

use crate::failure::Failure;
use crate::plant::actuator::ActuatorSettings;
use crate::plant::drives::Drives;
use crate::plant::elasticity::Elasticity;
use crate::plant::friction::{Breakaway, mobility};
use crate::plant::jitter::{Jitter, Moved};
use crate::plant::sensor::{Counter, SensorSettings, Sensors};
use crate::plant::{Arm, Clock, JointFriction, Plant};
use crate::run::closed_loop::World;
use crate::run::world::Compiled;
use dynamics_core::control::SpringOwner;
use dynamics_core::{Body, JointSpec};
use robot_compiler::scene::{ElasticitySpec, Integrator, joints};
use robot_compiler::{RobotJoint, SceneFile, with_dof};
use std::any::Any;

/// The arm that a scene simulates, with its true masses, tool, payload, gravity and wrench at the tip.
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
    let dof = scene.robot.dof();
    let made = if dof == N { any_world(scene)?.downcast::<World<N>>().ok() } else { None };
    let wrong = || Failure::Input(miette::miette!("{} has {dof} joints, not {N}", scene.robot.path.display()));
    made.map(|world| *world).ok_or_else(wrong)
}

/// A [`World`] of the scene's number of joints. This package compiles its code, whoever calls.
fn any_world(scene: &SceneFile) -> Result<Box<dyn Any>, Failure> {
    with_dof!(scene.robot.dof(), N => Ok(Box::new(new_world::<N>(scene)?)))
}

fn new_world<const N: usize>(scene: &SceneFile) -> Result<World<N>, Failure> {
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
    // Simulated drives have their own delay and torque limit.
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
        compiled: Compiled::new(),
    })
}

/// As [`world`], with ideal drives, whatever drives the robot file describes.
///
/// # Errors
/// As [`world`].
pub fn ideal_world<const N: usize>(scene: &SceneFile) -> Result<World<N>, Failure> {
    let mut scene = scene.clone();
    scene.actuators.ideal = true;
    world(&scene)
}

/// Longest step (s) that the integrator takes with certainty; zero if it adapts its steps.
pub(super) fn longest_step(integrator: Integrator, clock: &Clock) -> f64 {
    match integrator {
        Integrator::RungeKutta | Integrator::SemiImplicitEuler => clock.step(),
        Integrator::Adaptive { .. } => 0.0,
    }
}

/// Springs, dampers and backlash of the simulated joints.
pub(super) fn springs<const N: usize>(spec: &ElasticitySpec) -> Elasticity<N> {
    Elasticity {
        stiffness: joints(&spec.stiffness),
        damping: joints(&spec.damping),
        backlash: spec.backlash.as_deref().map(joints),
    }
}

/// Rejects a step that is too long for the fastest oscillation or decay in the joints, because it would falsify them.
///
/// At the start the step must be below `1 / (2 rate)`. There, a Runge-Kutta step loses 1.1e-4 of an oscillation's amplitude, and semi-implicit Euler
/// has an error of 1 % in its frequency. The stability limits (2.8 and 2 instead of 1/2) leave a margin for a change of the inertia during the
/// motion.
pub(super) fn can_swing(scene: &SceneFile, step: f64, fastest: f64) -> Result<(), Failure> {
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

/// Friction of the simulated joints: the scene's `[plant]`, or else the robot file's.
pub fn friction_laws<const N: usize>(scene: &SceneFile) -> [JointFriction; N] {
    core::array::from_fn(|i| {
        let friction = match &scene.plant.friction_law {
            Some(all) => all.get(i).copied(),
            None => scene.robot.joints.get(i).and_then(|joint| joint.friction),
        };
        friction.unwrap_or_default()
    })
}

/// Rejects a step in which a joint that breaks away would skip the fall from breakaway to Coulomb friction.
///
/// While its friction falls, a joint gains speed at a rate of at most `0.86 (s - c) (D^-1)_ii / v_s`. A step may be half of `v_s / ((s - c)
/// (D^-1)_ii)`, at the inertia of the start.
pub(super) fn can_follow<const N: usize>(
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
