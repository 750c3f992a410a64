//! From a scene to a finished run, in memory.

use crate::failure::Failure;
use crate::plant::Plant;
use crate::plant::solver::Solver;
use crate::run::batch::{Job, Kernels};
use crate::run::closed_loop::World;
pub use crate::run::compiled::{LoopScalar, within};
use crate::run::one_run::closed_in;
pub use crate::run::one_run::{Run, RunOptions};
pub use crate::run::scene_world::{arm, friction_laws, ideal_world, world};
use crate::run::target::Torques;
use dynamics_core::control::{CollisionWatch, ControllerOf, EveryNth};
use dynamics_core::trig::Method;
use dynamics_core::{Controller, ControllerConfig, Dynamics, Live, Model, Real, Trig};
use indicatif::ProgressBar;
use robot_compiler::choose::ArmDynamics;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use std::cell::RefCell;
use std::sync::atomic::AtomicBool;

/// Runs the controller of a scene in a world, on the desk.
pub(super) async fn on_desk<const N: usize>(
    solver: Solver<'_, N>,
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

    async fn run(mut self, solver: Solver<'_, N>) -> Self::Outcome {
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
// `inline`: compiled for six joint counts and all widths of vectors by the packages that use it. `newtau run`, which a new user compiles first, does not.
#[inline]
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
