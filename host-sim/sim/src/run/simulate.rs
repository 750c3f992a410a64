//! From a scene to a finished run, in memory.

use crate::failure::{Failure, number};
use crate::plant::Plant;
use crate::plant::solver::Solver;
use crate::run::batch::{Job, Kernels};
use crate::run::closed_loop::{self, Closed, End, World};
pub use crate::run::compiled::LoopScalar;
use crate::run::joint_label::JointLabel;
use crate::run::marks::Marks;
use crate::run::record::Record;
pub use crate::run::scene_world::{arm, friction_laws, ideal_world, world};
use crate::run::summary::Summary;
use crate::run::summary_parts::{ModelTicks, Setting, SimulatedDrives};
use crate::run::target::Torques;
use dynamics_core::control::{CollisionWatch, ControllerOf, EveryNth};
use dynamics_core::safety::SafeAction;
use dynamics_core::trig::Method;
use dynamics_core::{Controller, ControllerConfig, Dynamics, Live, Model, Real, Trig};
use indicatif::ProgressBar;
use robot_compiler::choose::ArmDynamics;
use robot_compiler::names::name;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use std::cell::RefCell;
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

/// Parts of a run besides its world and its controller.
#[derive(Clone, Copy)]
pub struct RunOptions<'a> {
    /// The scene of the controller.
    pub scene: &'a SceneFile,
    /// Name of the target, for the summary.
    pub target: &'a str,
    /// Ends the run when it is set.
    pub stop: &'a AtomicBool,
    /// Bar that shows the ticks.
    pub progress: &'a ProgressBar,
}

/// Limit on the samples of a run (ticks times joints); this many fit into memory.
const SAMPLES_MAX: f64 = 2e7;

/// Runs the controller of a scene in a world, on the desk.
pub(super) async fn on_desk<const N: usize>(
    solver: &impl Solver<N>,
    world: &mut World<N>,
    scene: &SceneFile,
    stop: &AtomicBool,
    progress: &ProgressBar,
) -> Result<Run, Failure> {
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    let options = RunOptions { scene, target: "desk", stop, progress };
    match scene.control.scalar {
        ScalarChoice::F64 => closed_in::<f64, N>(solver, world, &options, &mut desk(scene, &model)).await,
        ScalarChoice::F32 => closed_in::<f32, N>(solver, world, &options, &mut desk(scene, &model)).await,
    }
}

/// A scene that waits to be run together with others.
struct Prepared<'a, const N: usize> {
    place: usize,
    scene: SceneFile,
    world: World<N>,
    stop: &'a AtomicBool,
    each: &'a dyn Fn(usize, Run),
}

impl<const N: usize> Job<N> for Prepared<'_, N> {
    type Outcome = Result<(), Failure>;

    fn plant(&self) -> &Plant<N> {
        &self.world.plant
    }

    async fn run(mut self, solver: &impl Solver<N>) -> Self::Outcome {
        let run = on_desk(solver, &mut self.world, &self.scene, self.stop, &ProgressBar::hidden()).await?;
        (self.each)(self.place, run);
        Ok(())
    }
}

/// Runs several scenes on the desk together. Each run has the result of [`run`](crate::run::simulation::run). If the processor has a
/// [kernel](crate::run::batch) for their arms, this takes a fraction of the time. Returns the results of `each`, in the order of the scenes, or the
/// failure of a scene that cannot be run. All scenes have the same number of joints.
pub fn on_desk_side_by_side<T>(
    kernels: &Kernels,
    scenes: Vec<Result<SceneFile, Failure>>,
    stop: &AtomicBool,
    each: impl Fn(Run) -> T,
) -> Vec<Result<T, Failure>> {
    let results = RefCell::new((0..scenes.len()).map(|_| None).collect::<Vec<Option<T>>>());
    let ends = run_side_by_side(kernels, scenes, stop, &|place, run| results.borrow_mut()[place] = Some(each(run)));
    let results = results.into_inner().into_iter().zip(ends);
    results.filter_map(|(result, end)| end.map_or_else(|failure| Some(Err(failure)), |()| result.map(Ok))).collect()
}

/// As [`on_desk_side_by_side`]: `each` gets the index of a scene and its run.
fn run_side_by_side(
    kernels: &Kernels,
    scenes: Vec<Result<SceneFile, Failure>>,
    stop: &AtomicBool,
    each: &dyn Fn(usize, Run),
) -> Vec<Result<(), Failure>> {
    let dof = scenes.iter().flatten().map(|scene| scene.robot.dof()).next().unwrap_or(1);
    with_dof!(dof, N => {
        let mut batch = kernels.borrow::<N>();
        let jobs = scenes.into_iter().enumerate().map(|(place, scene)| {
            let scene = scene?;
            Ok(Prepared::<N> { place, world: world(&scene)?, scene, stop, each })
        });
        let ends = batch.run(jobs);
        kernels.give_back(batch);
        ends
    })
}

/// A controller on the desk that computes in `S`.
pub type Desk<S, const N: usize> =
    ControllerOf<S, N, EveryNth<ArmDynamics<S, N>, S, N>, Method, ControllerConfig<S, N>, Watch<S, N>>;

/// Collision observer, if the scene asks for one.
pub type Watch<S, const N: usize> = Option<CollisionWatch<S, N, Dynamics<S, N>>>;

/// The controller that a scene asks for, which computes on the desk in `S`. Every live input is zero until [`with`] sets it.
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

/// Live inputs of the scene (gravity, payload, wrench at the tip), for a controller that computes in `S`.
#[must_use]
pub fn live_inputs<S: Real, const N: usize>(scene: &SceneFile, model: &Model<f64, N>) -> Live<S, N> {
    scene.live(model).cast()
}

/// Runs a scene with this controller, on any target, after setting its live inputs.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run; [`Failure::Target`] if the target rejects the live inputs. A target that fails during the run
/// is no error here: see [`Run::failure`].
pub fn with<S: LoopScalar, const N: usize>(
    options: &RunOptions<'_>,
    controller: &mut dyn Torques<S, N>,
) -> Result<Run, Failure> {
    within(&mut world::<N>(options.scene)?, options, controller)
}

/// As [`with`], in a world that the caller owns.
///
/// # Errors
/// As [`with`].
pub fn within<S: LoopScalar, const N: usize>(
    world: &mut World<N>,
    options: &RunOptions<'_>,
    controller: &mut dyn Torques<S, N>,
) -> Result<Run, Failure> {
    S::run(world, options, controller)
}

pub(super) async fn closed_in<S: Real, const N: usize>(
    solver: &impl Solver<N>,
    world: &mut World<N>,
    options: &RunOptions<'_>,
    controller: &mut dyn Torques<S, N>,
) -> Result<Run, Failure> {
    let RunOptions { scene, target, stop, progress } = *options;
    let ticks = ticks(scene, world.motion.duration())?;
    progress.set_length(ticks);
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    controller.set_live(&live_inputs(scene, &model)).map_err(Failure::Target)?;
    let labels = scene.robot.joints.iter().map(JointLabel::from).collect();
    let mut record = Record::new(labels, usize::try_from(ticks).unwrap_or(usize::MAX));
    // The bar limits its own redraws; fewer calls save even more time.
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

/// Description of a scene's simulated drives; `None` if it has none.
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
