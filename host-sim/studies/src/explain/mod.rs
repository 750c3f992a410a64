//! Cost of each term of a scene's model, and the errors without it.

mod chip;
mod explanation;
mod friction;
mod report;

pub use explanation::{
    ChipSaving, Dropped, Error, Explanation, Fewest, Joint, OnChip, OperationCount, PartReport, TermReport, Tracking,
};

use dynamics_core::{JointKind, Term};
use indicatif::ProgressBar;
use robot_compiler::choose::Along;
use robot_compiler::kernel::Operations;
use robot_compiler::scene::ModelTerm;
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use sim::run::closed_loop::End;
use sim::run::simulation::{Options, simulation};
use std::sync::atomic::AtomicBool;

/// Default tolerance, if neither the scene nor the command line gives one: a share of each joint's torque limit.
pub const TOLERANCE: f64 = 0.002;

/// Explains the terms of the scene's model.
///
/// # Errors
/// [`Failure::Input`] if the scene cannot be run; [`Failure::Interrupted`] after an interruption.
pub fn explain(file: &SceneFile, tolerance: Option<f64>, stop: &AtomicBool) -> Result<Explanation, Failure> {
    with_dof!(file.robot.dof(), N => explain_for::<N>(file, tolerance, stop))
}

fn explain_for<const N: usize>(
    file: &SceneFile,
    tolerance: Option<f64>,
    stop: &AtomicBool,
) -> Result<Explanation, Failure> {
    let model = file.robot.model::<N>().map_err(Failure::input)?;
    let along = Along::new(file, &model)
        .map_err(|error| Failure::Input(miette::miette!("{}: the motion cannot be: {error}", file.path.display())))?;
    let asked = file.model.auto.as_ref().map(|auto| auto.tolerance);
    let tolerance = tolerance.or(asked).unwrap_or(TOLERANCE);
    let mut lab = Lab { file, along, tolerance, stop, full: Tracking::default() };
    lab.full = lab.tracking(&[])?;
    let full = file.model.full();
    let terms = ModelTerm::ALL.into_iter().map(|term| {
        let present = full.state(term) != Term::Absent;
        let dropped = if present { Some(lab.dropped(&[term])?) } else { None };
        let (state, why) = state(file, term);
        Ok(TermReport { term: term.name(), state, why, dropped })
    });
    let terms: Vec<TermReport> = terms.collect::<Result<_, Failure>>()?;
    let (fewest, dropped) = lab.fewest(&terms)?;
    let friction = lab.friction()?;
    Ok(Explanation {
        scene: file.name.clone(),
        robot: file.robot.name.clone(),
        law: file.control.names().0,
        level: file.control.kernel.level().unwrap_or(robot_compiler::kernel::Level::Exact).name(),
        joints: file.robot.joints.iter().map(Joint::new).collect(),
        tolerance,
        operations: OperationCount::less(&lab.along.operations_without(&[]), &Operations::default()),
        chip: None,
        tracking: lab.full,
        terms,
        friction,
        fewest: Fewest {
            chosen: asked == Some(tolerance),
            given_up: fewest.iter().map(|term| term.name()).collect(),
            dropped,
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
        // Terms that act on the arm are in [plant]; the others come from the robot or always act.
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

/// A scene in which reduced models are tried.
struct Lab<'a, const N: usize> {
    file: &'a SceneFile,
    along: Along<'a, N>,
    tolerance: f64,
    stop: &'a AtomicBool,
    /// The closed loop with the full model.
    full: Tracking,
}

/// Largest allowed ratio of the tracking error of a reduced model to that of the full model. It corresponds to the deflection by a steady torque in
/// the weakest loop that is allowed ([`robot_compiler::choose::LoopGain::LEAST`]).
const FOLLOWS: f64 = 2.0;

impl<const N: usize> Lab<'_, N> {
    /// The terms that may be dropped together, and the effect of that.
    fn fewest(&self, terms: &[TermReport]) -> Result<(Vec<ModelTerm>, Dropped), Failure> {
        let follows = |term: &ModelTerm| {
            let report = terms.iter().find(|report| report.term == term.name());
            report.and_then(|report| report.dropped.as_ref()).is_some_and(|dropped| dropped.follows)
        };
        let mut droppable: Vec<ModelTerm> = ModelTerm::ALL.into_iter().filter(follows).collect();
        loop {
            let fewest = self.along.fewest_terms_without(self.tolerance, &droppable).given_up;
            let dropped = self.dropped(&fewest)?;
            // Terms that can be dropped one by one may not be dropped together. Keep the last of them, and try the rest again.
            match fewest.last() {
                Some(last) if !dropped.follows => droppable.retain(|term| term != last),
                _ => return Ok((fewest, dropped)),
            }
        }
    }

    /// True if the loop tracks within the allowed ratio; always true if every joint has a torque limit.
    fn follows(&self, tracking: &Tracking) -> bool {
        let joints = &self.file.robot.joints;
        if joints.iter().all(|joint| joint.spec.limits.torque.is_finite()) {
            return true;
        }
        let most = |tracking: &Tracking, kind: JointKind| {
            let of_kind = joints.iter().zip(&tracking.max).filter(|(joint, _)| joint.spec.kind == kind);
            of_kind.fold(0.0, |most, (_, error)| f64::max(most, *error))
        };
        let within = |kind| most(tracking, kind) <= FOLLOWS * most(&self.full, kind);
        tracking.fault.is_none() && within(JointKind::Revolute) && within(JointKind::Prismatic)
    }

    fn dropped(&self, terms: &[ModelTerm]) -> Result<Dropped, Failure> {
        let error = self.along.error_without(terms);
        let [with, without] = [&[], terms].map(|terms| self.along.operations_without(terms));
        let loop_gain = self.along.loop_gain_without(terms);
        let within_tolerance = error.worst_share() <= self.tolerance;
        let tracking = self.tracking(terms)?;
        let follows = self.follows(&tracking);
        Ok(Dropped {
            operations: OperationCount::less(&with, &without),
            chip: None,
            within_tolerance,
            loop_gain: loop_gain.least,
            weakest_joint: (loop_gain.least < 1.0).then_some(loop_gain.joint),
            follows,
            may_go: within_tolerance && follows && !loop_gain.is_too_weak(),
            torque_error: Error::from(error),
            tracking,
        })
    }

    /// Runs the loop with the full model minus these terms, in the scene's world and along its motion.
    fn tracking(&self, terms: &[ModelTerm]) -> Result<Tracking, Failure> {
        let mut scene = self.file.clone();
        scene.model = self.file.model.full().without(terms);
        self.tracking_of(&scene)
    }

    /// Runs the loop with the controller of another scene in this scene's world.
    fn tracking_of(&self, scene: &SceneFile) -> Result<Tracking, Failure> {
        let run = simulation(self.file, Options::default())?.run(scene, self.stop, &ProgressBar::hidden())?;
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
