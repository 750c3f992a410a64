//! Accuracy of a choice, measured on the desk: torques compared with a computation in 31 digits, and the closed loop.

use super::test_motions::TestMotion;
use dynamics_core::control::ControllerConfig;
use dynamics_core::{
    Command, Dynamics, InverseDynamics, JointKind, Limits, Live, Measurement, Model, Real, Reference, Sensed, SinCos,
};
use indicatif::ProgressBar;
use num_traits::{One, Zero};
use robot_compiler::SceneFile;
use robot_compiler::precision::DoubleDouble;
use robot_compiler::scene::{MotionSpec, ScalarChoice};
use serde::{Deserialize, Serialize};
use sim::failure::Failure;
use sim::run::closed_loop::End;
use sim::run::scene_world;
use sim::run::simulate::{self, RunOptions};
use sim::run::target::Torques;
use std::sync::atomic::AtomicBool;

/// Error of each joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Greatest magnitude of each joint's error.
    pub max: Vec<f64>,
    /// Root mean square of each joint's error.
    pub rms: Vec<f64>,
}

/// Measurements on one test motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnMotion {
    /// Name of the test motion.
    pub course: String,
    /// Torque error with the arm exactly on its reference, N m or N; `None` if the controller braked.
    pub torque: Option<Errors>,
    /// Greatest torque error divided by its joint's limit, or by the joint's greatest torque if it has no limit.
    pub torque_of_limit: Option<f64>,
    /// Tracking error of the closed loop, rad or m.
    pub tracking: Errors,
    /// Reason why the loop ended early or braked.
    pub fault: Option<String>,
}

/// Exact torques, tick by tick.
#[derive(Clone, Debug)]
pub struct Exact<const N: usize> {
    torque: Vec<[DoubleDouble; N]>,
    references: Vec<Reference<f64, N>>,
    /// Greatest magnitude for each joint, N m or N.
    greatest: [f64; N],
}

impl<const N: usize> Exact<N> {
    /// Computes exact torques along a test motion with this control period (s): the full model's recursion in double-double arithmetic, sine and
    /// cosine to 30 digits, and the friction that the scene feeds forward.
    #[must_use]
    pub fn new(file: &SceneFile, model: &Model<f64, N>, course: &TestMotion<N>, period: f64) -> Self {
        let full = file.model.full();
        let dynamics: Dynamics<DoubleDouble, N> = Dynamics::new(model.cast(), full.scene(model).cast());
        let live: Live<DoubleDouble, N> = file.live(model).cast();
        let friction = file.controller_config(model).friction.filter(|_| full.friction);
        let ticks = libm::ceil(course.motion.duration() / period) as u32;
        let references: Vec<Reference<f64, N>> =
            (0..=ticks).map(|tick| course.motion.sample(f64::from(tick) * period)).collect();
        let torque: Vec<[DoubleDouble; N]> = references
            .iter()
            .map(|reference| {
                let literal = |all: &[f64; N]| all.map(|x| DoubleDouble::sum(x, 0.0));
                let turn = core::array::from_fn(|i| match model.links()[i].kind {
                    JointKind::Revolute => DoubleDouble::sin_cos(reference.q[i]),
                    JointKind::Prismatic => SinCos { sin: DoubleDouble::zero(), cos: DoubleDouble::one() },
                });
                let [q, qd, qdd] = [&reference.q, &reference.qd, &reference.qdd].map(literal);
                let mut torque = dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &live);
                for (i, friction) in friction.iter().flatten().enumerate() {
                    torque[i] += DoubleDouble::sum(friction.torque(reference.qd[i]), 0.0);
                }
                torque
            })
            .collect();
        let greatest =
            |i: usize| torque.iter().fold(0.0, |most, at: &[DoubleDouble; N]| f64::max(most, at[i].to_f64().abs()));
        Self { greatest: core::array::from_fn(greatest), torque, references }
    }
}

/// Measures a choice on one test motion.
///
/// # Errors
/// The scene cannot be run, or the measurement is interrupted.
pub fn on_motion<const N: usize>(
    file: &SceneFile,
    model: &Model<f64, N>,
    course: &TestMotion<N>,
    exact: &Exact<N>,
    stop: &AtomicBool,
) -> Result<OnMotion, Failure> {
    let limits = model.links().map(|link| link.limits.torque);
    let (config, live) = (without_limits(file.controller_config(model)), file.live(model));
    let torque = match file.control.scalar {
        ScalarChoice::F32 => torque_errors::<f32, N>(&mut simulate::desk_with(file, model, &config), &live, exact),
        ScalarChoice::F64 => torque_errors::<f64, N>(&mut simulate::desk_with(file, model, &config), &live, exact),
    };
    let (torque, braked) = match torque {
        Ok(torque) => (Some(torque), None),
        Err(fault) => (None, Some(fault)),
    };
    let share = |i: usize, error: f64| {
        let limit = if limits[i].is_finite() { limits[i] } else { exact.greatest[i] };
        if limit > 0.0 { error / limit } else { 0.0 }
    };
    let worst =
        |errors: &Errors| errors.max.iter().enumerate().fold(0.0, |worst, (i, error)| share(i, *error).max(worst));
    let torque_of_limit = torque.as_ref().map(worst);
    let (tracking, fault) = tracking::<N>(file, model, course, stop)?;
    Ok(OnMotion { course: course.name.to_owned(), torque, torque_of_limit, tracking, fault: braked.or(fault) })
}

/// Configuration without torque limits, because limits would hide an error.
fn without_limits<const N: usize>(config: ControllerConfig<f64, N>) -> ControllerConfig<f64, N> {
    let free = f64::INFINITY;
    let limits = config.limits.map(|limits| Limits { torque: free, torque_rate: free, ..limits });
    ControllerConfig { limits, torque_step: [free; N], ..config }
}

/// Errors of a controller's torques against the exact ones, tick by tick with the arm exactly on the reference; `Err` contains the fault.
fn torque_errors<S: Real, const N: usize>(
    controller: &mut impl Torques<S, N>,
    live: &Live<f64, N>,
    exact: &Exact<N>,
) -> Result<Errors, String> {
    controller.set_live(&live.cast()).map_err(|error| error.to_string())?;
    let (mut max, mut squares) = ([0.0; N], [0.0; N]);
    for (reference, exact) in exact.references.iter().zip(&exact.torque) {
        let reference: Reference<S, N> = reference.cast();
        let sensed = Sensed::State { q: reference.q, qd: reference.qd };
        let ticked = controller.tick(&reference, &Measurement { sensed, age_ticks: 0 });
        match ticked.map_err(|error| error.to_string())?.command {
            Command::Drive { torque, .. } => {
                for i in 0..N {
                    let error = exact[i].minus(torque[i].to_f64());
                    max[i] = f64::max(max[i], error.abs());
                    squares[i] += error * error;
                }
            }
            Command::Brake(fault) => return Err(fault.to_string()),
        }
    }
    let count = exact.references.len() as f64;
    Ok(Errors { max: max.to_vec(), rms: squares.iter().map(|sum| libm::sqrt(sum / count)).collect() })
}

/// Runs the closed loop along a test motion, in the scene's world.
fn tracking<const N: usize>(
    file: &SceneFile,
    model: &Model<f64, N>,
    course: &TestMotion<N>,
    stop: &AtomicBool,
) -> Result<(Errors, Option<String>), Failure> {
    let start = course.motion.sample(0.0).q;
    // The simulated arm begins at the start of the test motion; the controller is the scene's.
    let mut scene = file.clone();
    scene.motion = MotionSpec::Hold { q: start.to_vec(), duration: 1.0 };
    scene.plant.start = start.to_vec();
    scene.duration = None;
    let mut world = scene_world::world::<N>(&scene)?;
    world.motion = course.motion.clone();
    world.repeat = false;
    let options = RunOptions { scene: &scene, target: "desk", stop, progress: &ProgressBar::hidden() };
    let run = match file.control.scalar {
        ScalarChoice::F32 => simulate::within::<f32, N>(&mut world, &options, &mut simulate::desk(file, model))?,
        ScalarChoice::F64 => simulate::within::<f64, N>(&mut world, &options, &mut simulate::desk(file, model))?,
    };
    if run.end == End::Interrupted {
        return Err(Failure::Interrupted);
    }
    let fault = run.summary.faults.first().map(|fault| fault.message.clone());
    let errors = Errors { max: run.summary.tracking_max, rms: run.summary.tracking_rms };
    Ok((errors, fault.or(run.summary.stopped)))
}
