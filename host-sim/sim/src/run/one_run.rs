//! A run in a world, from its first tick to its summary.

use crate::failure::{Failure, number};
use crate::plant::solver::Solver;
use crate::run::closed_loop::{self, Closed, End, World};
use crate::run::joint_label::JointLabel;
use crate::run::marks::Marks;
use crate::run::record::Record;
use crate::run::summary::Summary;
use crate::run::summary_parts::{ModelTicks, Setting, SimulatedDrives};
use crate::run::target::Torques;
use dynamics_core::Real;
use dynamics_core::safety::SafeAction;
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use robot_compiler::names::name;
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

/// Runs a controller in a world.
pub(super) async fn closed_in<S: Real, const N: usize>(
    solver: Solver<'_, N>,
    world: &mut World<N>,
    options: &RunOptions<'_>,
    controller: &mut dyn Torques<S, N>,
) -> Result<Run, Failure> {
    let RunOptions { scene, target, stop, progress } = *options;
    let ticks = ticks(scene, world.motion.duration())?;
    progress.set_length(ticks);
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    controller.set_live(&scene.live(&model).cast()).map_err(Failure::Target)?;
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
