//! Speed against accuracy of the simulator: cost and error of an integrator and its step.

use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use robot_compiler::scene::Integrator;
use serde::Serialize;
use sim::failure::Failure;
use sim::parallel::try_in_parallel;
use sim::run::closed_loop::End;
use sim::run::simulate::Run;
use sim::run::simulation::{Options, simulation};
use std::sync::atomic::AtomicBool;

/// Tolerance of the reference run, with adaptive steps.
const REFERENCE: f64 = 1e-12;

/// An integrator with its step, measured on the scene's own run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodReport {
    /// Name of the integrator in scene files.
    pub integrator: &'static str,
    /// Steps per control period; `None` for adaptive steps.
    pub steps_per_tick: Option<u32>,
    /// Tolerance of a step; `None` for fixed steps.
    pub tolerance: Option<f64>,
    /// Number of evaluations of the equations of motion per control period.
    pub accelerations_per_tick: f64,
    /// Greatest distance of a joint from the reference run, rad or m; `None` if the run ended early.
    pub off_by: Option<f64>,
    /// Greatest tracking error of any joint, rad or m.
    pub tracking: Option<f64>,
}

/// Compares integrators and steps on the scene's own motion, in its own world.
///
/// # Errors
/// The scene cannot be run.
pub fn methods(scene: &SceneFile, stop: &AtomicBool) -> Result<Vec<MethodReport>, Failure> {
    let (reference, _) = run(scene, Integrator::Adaptive { tolerance: REFERENCE }, 1, stop)?;
    let fixed = |integrator, steps: &[u32]| steps.iter().map(|steps| (integrator, *steps)).collect::<Vec<_>>();
    let own = [1e-3, 1e-6, 1e-9].map(|tolerance| (Integrator::Adaptive { tolerance }, 1));
    let all = [
        fixed(Integrator::SemiImplicitEuler, &[1, 4, 16, 64]),
        fixed(Integrator::RungeKutta, &[1, 2, 4, 8, 16]),
        own.to_vec(),
    ]
    .concat();
    try_in_parallel(all.len(), |number| {
        let (integrator, steps) = all[number];
        let (steps_per_tick, tolerance) = match integrator {
            Integrator::Adaptive { tolerance } => (None, Some(tolerance)),
            Integrator::RungeKutta | Integrator::SemiImplicitEuler => (Some(steps), None),
        };
        let refused = MethodReport {
            integrator: name(integrator),
            steps_per_tick,
            tolerance,
            accelerations_per_tick: f64::NAN,
            off_by: None,
            tracking: None,
        };
        let (run, accelerations) = match run(scene, integrator, steps, stop) {
            Ok(done) => done,
            // A step that is too long for friction or a spring is rejected; that is a valid result.
            Err(Failure::Input(_)) => return Ok(refused),
            Err(failure) => return Err(failure),
        };
        let ticks = run.record.ticks();
        let whole = run.end == End::Complete && ticks == reference.record.ticks();
        Ok(MethodReport {
            accelerations_per_tick: accelerations as f64 / ticks.max(1) as f64,
            off_by: whole.then(|| off_by(&run, &reference)),
            tracking: whole.then(|| run.summary.tracking_max.iter().fold(0.0, |most, x| f64::max(most, *x))),
            ..refused
        })
    })
}

fn run(scene: &SceneFile, integrator: Integrator, steps: u32, stop: &AtomicBool) -> Result<(Run, u64), Failure> {
    let mut scene = scene.clone();
    scene.plant.integrator = integrator;
    scene.plant.step = scene.period() / f64::from(steps);
    // Ideal drives: quantised readings would magnify an integrator's last bits to whole steps.
    let mut simulation = simulation(&scene, Options { ideal_drives: true })?;
    let run = simulation.run(&scene, stop, &ProgressBar::hidden())?;
    if run.end == End::Interrupted {
        return Err(Failure::Interrupted);
    }
    Ok((run, simulation.accelerations()))
}

/// Greatest distance of any joint in any tick, rad or m.
fn off_by(run: &Run, reference: &Run) -> f64 {
    let joints = 0..run.record.joints().len();
    let distances = joints.flat_map(|joint| {
        let pairs = run.record.joint(joint).zip(reference.record.joint(joint));
        pairs.map(|(a, b)| (a.q - b.q).abs())
    });
    distances.fold(0.0, f64::max)
}

fn name(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::RungeKutta => "runge-kutta",
        Integrator::SemiImplicitEuler => "semi-implicit-euler",
        Integrator::Adaptive { .. } => "adaptive",
    }
}
