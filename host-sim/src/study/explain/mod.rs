//! Cost of each term of a scene's model, and the errors without it.

mod chip;
mod explanation;
mod report;

pub use explanation::{ChipSaving, Count, Dropped, Error, Explanation, Fewest, Joint, TermReport, Tracking};

use crate::failure::Failure;
use crate::run::closed_loop::End;
use crate::run::simulate;
use dynamics_core::Term;
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use robot_compiler::choose::Along;
use robot_compiler::kernel::Operations;
use robot_compiler::scene::ModelTerm;
use std::sync::atomic::AtomicBool;

/// Default tolerance, if neither the scene nor the command line gives one: a share of each joint's torque limit.
pub const TOLERANCE: f64 = 0.002;

/// Explain the terms of the scene's model.
///
/// # Errors
/// [`Failure::Input`] if the scene cannot be run, [`Failure::Interrupted`].
pub fn explain<const N: usize>(
    file: &SceneFile,
    tolerance: Option<f64>,
    stop: &AtomicBool,
) -> Result<Explanation, Failure> {
    let model = file.robot.model::<N>().map_err(Failure::input)?;
    let along = Along::new(file, &model)
        .map_err(|error| Failure::Input(miette::miette!("{}: the motion cannot be: {error}", file.path.display())))?;
    let asked = file.model.auto.as_ref().map(|auto| auto.tolerance);
    let tolerance = tolerance.or(asked).unwrap_or(TOLERANCE);
    let lab = Lab { file, along, tolerance, stop };
    let full = file.model.full();
    let terms = ModelTerm::ALL.into_iter().map(|term| {
        let present = full.state(term) != Term::Absent;
        let dropped = if present { Some(lab.dropped(&[term])?) } else { None };
        let (state, why) = state(file, term);
        Ok(TermReport { term: term.name(), state, why, dropped })
    });
    let fewest = lab.along.fewest_terms(tolerance).given_up;
    Ok(Explanation {
        scene: file.name.clone(),
        robot: file.robot.name.clone(),
        law: file.control.names().0,
        level: file.control.kernel.level().unwrap_or(robot_compiler::kernel::Level::Exact).name(),
        joints: file.robot.joints.iter().map(Joint::new).collect(),
        tolerance,
        operations: Count::less(&lab.along.operations_without(&[]), &Operations::default()),
        chip: None,
        tracking: lab.tracking(&[])?,
        terms: terms.collect::<Result<_, Failure>>()?,
        fewest: Fewest {
            chosen: asked == Some(tolerance),
            given_up: fewest.iter().map(|term| term.name()).collect(),
            dropped: lab.dropped(&fewest)?,
        },
    })
}

/// State of a term in the scene, and the source of that state.
fn state(file: &SceneFile, term: ModelTerm) -> (&'static str, String) {
    let name = |state: Term<()>| match state {
        Term::Absent => "absent",
        Term::Constant(()) => "constant",
        Term::Live => "live",
    };
    let line = |table, key| file.line_of(table, key).map(|line| format!("line {line}"));
    if file.model.auto.is_some() {
        let (full, now) = (file.model.full().state(term), file.model.state(term));
        let state = if full == now { name(now) } else { "given up" };
        // Acting terms are stated in [plant]; the other terms come from the robot or always act.
        let world = match term {
            ModelTerm::Rotors | ModelTerm::VelocityTerms => None,
            _ => line("plant", term.key()),
        };
        let auto = line("model", "terms").unwrap_or_default();
        let why =
            if full == now && full == Term::Absent { world.unwrap_or_else(default) } else { format!("auto, {auto}") };
        return (state, why);
    }
    (name(file.model.state(term)), line("model", term.key()).unwrap_or_else(default))
}

fn default() -> String {
    "default".to_owned()
}

/// A scene in which models are tried.
struct Lab<'a, const N: usize> {
    file: &'a SceneFile,
    along: Along<'a, N>,
    tolerance: f64,
    stop: &'a AtomicBool,
}

impl<const N: usize> Lab<'_, N> {
    fn dropped(&self, terms: &[ModelTerm]) -> Result<Dropped, Failure> {
        let error = self.along.error_without(terms);
        let [with, without] = [&[], terms].map(|terms| self.along.operations_without(terms));
        let loop_gain = self.along.loop_gain_without(terms);
        let within_tolerance = error.worst_of_limit() <= self.tolerance;
        Ok(Dropped {
            operations: Count::less(&with, &without),
            chip: None,
            within_tolerance,
            loop_gain: loop_gain.least,
            weakest_joint: (loop_gain.least < 1.0).then_some(loop_gain.joint),
            may_go: within_tolerance && !loop_gain.is_too_weak(),
            torque_error: Error::from(error),
            tracking: self.tracking(terms)?,
        })
    }

    /// Run the loop with the full model less these terms, in the scene's world and along its motion.
    fn tracking(&self, terms: &[ModelTerm]) -> Result<Tracking, Failure> {
        let mut world = simulate::world::<N>(self.file)?;
        let mut scene = self.file.clone();
        scene.model = self.file.model.full().without(terms);
        let run = simulate::on_desk_in::<N>(&mut world, &scene, self.stop, &ProgressBar::hidden())?;
        if run.end == End::Interrupted {
            return Err(Failure::Interrupted);
        }
        let fault = run.summary.faults.first().map(|fault| fault.message.clone());
        Ok(Tracking {
            fault: fault.or(run.summary.stopped),
            max: run.summary.tracking_max,
            rms: run.summary.tracking_rms,
        })
    }
}
