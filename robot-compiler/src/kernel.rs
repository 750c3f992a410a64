//! From a model and a scene to straight-line Rust: the kernel of this robot in this scene.
//!
//! ```text
//! core's own recursion --tape--> arena --rules--> program --schedule--> source
//! ```
//!
//! The compiler runs the generic recursion of `dynamics-core` once, on a scalar that records every operation, and prints
//! the remaining operations. It contains no equation itself.
//!
//! | module | holds |
//! |---|---|
//! | [`tape`] | the scalar and its arena |
//! | `rules`, `rewrites` | level `exact`: rewrites that keep every result equal |
//! | `regroup`, `frames`, `identities`, `algebra` | level `regrouped`: fewer operations, other rounding |
//! | [`functions`], [`inputs`] | the functions that can be traced; names, order and values of their inputs |
//! | [`interpreter`] | a fast interpreter of a program, for use without a compiler |
//! | `program`, `schedule` | the operations that the outputs need, in an order that keeps few values alive |

mod algebra;
mod arena;
mod frames;
pub mod functions;
mod identities;
pub mod inputs;
pub mod interpreter;
#[cfg(test)]
mod mutants;
mod program;
mod regroup;
mod rewrites;
mod rules;
mod schedule;
pub mod tape;

pub use arena::Precision;
pub use functions::Function;
pub use program::{Operations, Program};
pub use rules::{RewriteRule, RuleSet};

use crate::names::{self, Named};
use arena::{Arena, Expr};
use dynamics_core::{Inertia, Model, Scene, Term};
use frames::Frames;

/// Degree to which the compiler may change the recursion's operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Every result equal (`==`) to the generic recursion's.
    Exact,
    /// Equal in exact arithmetic: base inertial parameters, cheaper frames, common factors and sums. The error is measured.
    Regrouped,
}

impl Level {
    /// Both levels.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Regrouped];

    /// Its name in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        names::name(self)
    }
}

impl Named for Level {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("exact", "Every result equal", Self::Exact),
        ("regrouped", "Fewer operations, other rounding", Self::Regrouped),
    ];
}

/// Traces a function of the arm in the scene, and simplifies it.
///
/// For six joints: a few milliseconds at level exact, about a tenth of a second regrouped, because frames are searched.
#[must_use]
pub fn compile<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    level: Level,
    precision: Precision,
) -> Program {
    match level {
        Level::Exact => compile_with(function, model, scene, RuleSet::ALL, precision),
        Level::Regrouped => regrouped(function, model, scene, None, precision),
    }
}

/// A step of level `regrouped`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The search for the cheapest frames.
    Frames,
    /// Inertia that a joint cannot feel moves into the parent.
    BaseParameters,
    /// Values that are equal in every state are computed once.
    Identities,
    /// Common factors and sums are taken out.
    Algebra,
}

impl Step {
    /// All steps, in their order.
    pub const ALL: [Self; 4] = [Self::Frames, Self::BaseParameters, Self::Identities, Self::Algebra];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frames => "cheapest frames",
            Self::BaseParameters => "base parameters",
            Self::Identities => "identities",
            Self::Algebra => "common factors and sums",
        }
    }
}

/// Level `regrouped` with one step left out, to measure what it saves.
#[must_use]
pub fn compile_without<const N: usize>(
    step: Step,
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    precision: Precision,
) -> Program {
    regrouped(function, model, scene, Some(step), precision)
}

/// Traces with some rules only, to measure what each saves. Results are equal (`==`) with any set of rules.
#[must_use]
pub fn compile_with<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    rules: RuleSet,
    precision: Precision,
) -> Program {
    let (arena, outputs) = functions::record(function, model, scene, None, Arena::new(rules, precision));
    Program::new(arena, &outputs)
}

/// Chooses the cheapest frames, uses base parameters in them, then computes equal and common values once.
fn regrouped<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    without: Option<Step>,
    precision: Precision,
) -> Program {
    let mut how = REGROUPING;
    match without {
        Some(Step::BaseParameters) => how.unfelt = |_, _| Inertia::zero(),
        Some(Step::Identities) => how.angle = None,
        Some(Step::Frames | Step::Algebra) | None => {}
    }
    let (arena, outputs) = if matches!(function, Function::JointWrenches | Function::Regressor) {
        // Not for functions that return wrenches or a regressor: these belong to a frame and its link, and frames and base parameters change them.
        functions::record(function, model, scene, None, Arena::new(RuleSet::ALL, precision))
    } else {
        let (model, scene) = holding(model, scene);
        let frames = match without {
            Some(Step::Frames) => Frames::of_the_model(),
            _ => how.cheapest_frames(function, &model, &scene, precision),
        };
        how.record(function, &model, &scene, &frames, precision)
    };
    match without {
        Some(Step::Algebra) => Program::new(arena, &outputs),
        _ => algebra::fewest_operations(arena, &outputs, precision, how.moves),
    }
}

/// The steps of level `regrouped`. A test replaces some by wrong ones.
struct Regrouping {
    unfelt: regroup::Unfelt,
    turning: frames::Turning,
    /// `None` turns the search for identities off.
    angle: Option<identities::Angle>,
    moves: algebra::Moves,
}

/// The correct steps.
const REGROUPING: Regrouping = Regrouping {
    unfelt: regroup::unfelt,
    turning: frames::TURNING,
    angle: Some(identities::ANGLE),
    moves: algebra::MOVES,
};

impl Regrouping {
    /// The frames in which the function needs the fewest operations, before common values are removed.
    fn cheapest_frames<const N: usize>(
        &self,
        function: Function,
        model: &Model<f64, N>,
        scene: &Scene<f64, N>,
        precision: Precision,
    ) -> Frames<N> {
        // A live payload is given in the model's frame of the last link, so that frame must stay.
        let free = core::array::from_fn(|i| i + 1 < N || !matches!(scene.payload, Term::Live));
        Frames::cheapest(model, &free, |frames| {
            let (arena, outputs) = self.record(function, model, scene, frames, precision);
            program::operations(&arena, &outputs)
        })
    }

    /// The arm in these frames, with base parameters, on a tape.
    fn record<const N: usize>(
        &self,
        function: Function,
        model: &Model<f64, N>,
        scene: &Scene<f64, N>,
        frames: &Frames<N>,
        precision: Precision,
    ) -> (Arena, Vec<Expr>) {
        let arm = regroup::moved_inward(&frames.shifted(model), &frames.across, self.unfelt);
        let tape = Arena::new(RuleSet::ALL, precision);
        let (arena, outputs) = functions::record(function, &arm, scene, Some((frames, &self.turning)), tape);
        match self.angle {
            Some(angle) => identities::once(&arena, &outputs, N, precision, angle),
            None => (arena, outputs),
        }
    }
}

/// Makes a constant payload part of the arm.
fn holding<const N: usize>(model: &Model<f64, N>, scene: &Scene<f64, N>) -> (Model<f64, N>, Scene<f64, N>) {
    let Term::Constant(payload) = scene.payload else { return (*model, *scene) };
    let tip = model.tip();
    let mut links = *model.links();
    links[N - 1].inertia = links[N - 1].inertia + payload.in_parent(&tip.rotation, &tip.translation);
    (Model::from_checked(links, *tip), Scene { payload: Term::Absent, ..*scene })
}
