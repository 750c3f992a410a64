//! Faults put into the rewrites on purpose: the comparison over random states must find every one.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "level exact claims equality")]

use super::algebra::fewest_operations;
use super::arena::{Arena, Expr, Node, Rewrite};
use super::functions::record;
use super::inputs::{forward_input_values, input_values};
use super::regroup::unfelt;
use super::rewrites::TABLE;
use super::rules::{RewriteRule, RuleSet};
use super::{Function, Precision, Program, REGROUPING, Regrouping, holding};
use crate::{SceneFile, with_dof};
use dynamics_core::trig::Libm;
use dynamics_core::{Inertia, JointKind, Trig};
use std::path::{Path, PathBuf};

/// The shipped rules with a wrong one tried before them.
const fn before_all(rule: RewriteRule, wrong: Rewrite) -> [(RewriteRule, Rewrite); 6] {
    [(rule, wrong), TABLE[0], TABLE[1], TABLE[2], TABLE[3], TABLE[4]]
}

fn zero_of(arena: &Arena, e: Expr) -> bool {
    arena.number(e) == Some(0.0)
}

fn inside(arena: &Arena, e: Expr) -> Option<Expr> {
    if let Node::Neg(x) = arena.node(e) { Some(x) } else { None }
}

/// A name, and a table with one fault.
type Mutant = (&'static str, &'static [(RewriteRule, Rewrite)]);

macro_rules! mutants {
    ($($name:ident: $rule:ident, |$arena:ident, $node:ident| $body:expr;)*) => {
        /// All of them.
        const MUTANTS: &[Mutant] = &[$({
            static TABLE: [(RewriteRule, Rewrite); 6] = before_all(RewriteRule::$rule, |$arena, $node| $body);
            (stringify!($name), &TABLE)
        }),*];
    };
}

mutants! {
    difference_of_numbers_is_their_sum: Fold, |arena, node| match node {
        Node::Sub(a, b) => { let sum = arena.number(a)? + arena.number(b)?; Some(arena.constant(sum)) }
        _ => None,
    };
    product_of_numbers_is_one_of_them: Fold, |arena, node| match node {
        Node::Mul(a, b) => { arena.number(a)?; arena.number(b)?; Some(a) }
        _ => None,
    };
    opposite_of_a_number_is_itself: Fold, |arena, node| match node {
        Node::Neg(a) => arena.number(a).map(|_| a),
        _ => None,
    };
    zero_times_x_is_x: Zero, |arena, node| match node {
        Node::Mul(a, b) if zero_of(arena, a) => Some(b),
        Node::Mul(a, b) if zero_of(arena, b) => Some(a),
        _ => None,
    };
    x_plus_zero_is_zero: Zero, |arena, node| match node {
        Node::Add(a, b) if zero_of(arena, a) || zero_of(arena, b) => Some(arena.constant(0.0)),
        _ => None,
    };
    zero_less_x_is_x: Zero, |arena, node| match node {
        Node::Sub(a, b) if zero_of(arena, a) => Some(b),
        _ => None,
    };
    minus_one_times_x_is_x: One, |arena, node| match node {
        Node::Mul(a, b) if arena.number(a) == Some(-1.0) => Some(b),
        Node::Mul(a, b) if arena.number(b) == Some(-1.0) => Some(a),
        _ => None,
    };
    two_times_x_is_x: One, |_arena, node| match node {
        Node::Add(a, b) if a == b => Some(a),
        _ => None,
    };
    sign_of_a_factor_is_dropped: Signs, |arena, node| match node {
        Node::Mul(a, b) => { let a = inside(arena, a)?; Some(arena.make(Node::Mul(a, b))) }
        _ => None,
    };
    sign_of_a_negative_number_is_dropped: Signs, |arena, node| match node {
        Node::Mul(a, b) => {
            let number = arena.number(b).filter(|x| *x < 0.0 && *x != -1.0)?;
            let positive = arena.constant(-number);
            Some(arena.make(Node::Mul(a, positive)))
        }
        _ => None,
    };
    sign_of_a_summand_is_dropped: Signs, |arena, node| match node {
        Node::Add(a, b) => { let b = inside(arena, b)?; Some(arena.make(Node::Add(a, b))) }
        _ => None,
    };
    minus_minus_is_minus: Signs, |arena, node| match node {
        Node::Sub(a, b) => { let b = inside(arena, b)?; Some(arena.make(Node::Sub(a, b))) }
        _ => None,
    };
    one_over_x_is_x: One, |arena, node| match node {
        Node::Div(a, b) if arena.number(a) == Some(1.0) => Some(b),
        _ => None,
    };
    quotients_are_turned_over: Order, |arena, node| match node {
        Node::Div(a, b) if a < b => Some(arena.write(Node::Div(b, a))),
        _ => None,
    };
    opposite_of_the_opposite_keeps_its_sign: Signs, |arena, node| match node {
        Node::Neg(a) => inside(arena, a).map(|_| a),
        _ => None,
    };
    differences_are_turned_without_their_sign: Order, |arena, node| match node {
        Node::Sub(a, b) if a > b => Some(arena.make(Node::Sub(b, a))),
        _ => None,
    };
    sums_are_regrouped: Order, |arena, node| match node {
        // Correct in exact arithmetic: only the last bits reveal the fault.
        Node::Add(a, b) => match arena.node(a) {
            Node::Add(c, d) if d < b && c < d => {
                let end = arena.write(Node::Add(d, b));
                Some(arena.write(Node::Add(c, end)))
            }
            _ => None,
        },
        _ => None,
    };
    products_are_shared_by_their_first_factor: Order, |arena, node| match node {
        Node::Mul(a, b) if arena.number(b).is_none() && arena.number(a).is_none() && a != b => {
            Some(arena.write(Node::Mul(a, a)))
        }
        _ => None,
    };
}

/// Inputs of a function of an arm in a scene, and the recursion's results for them, operation by operation.
struct Case {
    file: SceneFile,
    function: Function,
    states: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Case {
    fn new<const N: usize>(file: &SceneFile, function: Function) -> Self {
        let live = file.live(&file.robot.model::<N>().unwrap());
        let recursion = program::<N>(file, function, Arena::new(RuleSet::NONE, Precision::Double));
        let state = |k: i32| {
            let wave = |phase: f64| core::array::from_fn(|i| (f64::from(k) * 0.7 + i as f64 + phase).sin() * 2.0);
            let (q, qd, qdd): ([f64; N], [f64; N], [f64; N]) = (wave(0.0), wave(1.0), wave(2.0));
            let values = if function == Function::ForwardDynamics { forward_input_values } else { input_values };
            let inputs = values(&Libm.sin_cos_all(&q), &q, &qd, &qdd, &live);
            let wanted = recursion.evaluate(&inputs);
            (inputs, wanted)
        };
        Self { file: file.clone(), function, states: (0..20).map(state).collect() }
    }

    /// True if the kernel made with these rules differs from the recursion in any state.
    fn differs(&self, table: &'static [(RewriteRule, Rewrite)]) -> bool {
        let tape = Arena::with_table(RuleSet::ALL, table, Precision::Double);
        let program = with_dof!(self.file.robot.dof(), N => program::<N>(&self.file, self.function, tape));
        self.states.iter().any(|(inputs, wanted)| program.evaluate(inputs) != *wanted)
    }
}

fn program<const N: usize>(file: &SceneFile, function: Function, tape: Arena) -> Program {
    let model = file.robot.model::<N>().unwrap();
    let (arena, outputs) = record(function, &model, &file.scene(&model), None, tape);
    Program::new(arena, &outputs)
}

/// Every function in every shipped scene.
fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    let files: Vec<SceneFile> = paths.iter().map(|path| SceneFile::load(path).unwrap()).collect();
    let all = files.iter().flat_map(|file| Function::ALL.map(|function| (file, function)));
    all.map(|(file, function)| with_dof!(file.robot.dof(), N => Case::new::<N>(file, function))).collect()
}

#[test]
fn every_seeded_fault_is_found_and_the_shipped_rules_have_none() {
    let cases = cases();
    assert!(cases.len() >= 50);
    let wrong = |table: &'static [(RewriteRule, Rewrite)]| cases.iter().filter(|case| case.differs(table)).count();
    assert_eq!(wrong(&TABLE), 0);
    let found: Vec<(&str, usize)> = MUTANTS.iter().map(|(name, table)| (*name, wrong(table))).collect();
    println!("of {} kernels, each fault shows in: {found:?}", cases.len());
    let missed: Vec<&str> = found.iter().filter(|(_, kernels)| *kernels == 0).map(|(name, _)| *name).collect();
    assert_eq!(missed, [""; 0]);
}

/// A fault in level `regrouped`: its name, and the change that causes it.
type Fault = (&'static str, fn(&mut Regrouping));

const WRONG_REGROUPINGS: [Fault; 10] = [
    ("the first moment across the axis moves too", |how| {
        how.unfelt = |link, across| Inertia { first_moment: link.inertia.first_moment, ..unfelt(link, across) };
    }),
    ("the inertia about the axis moves too", |how| {
        how.unfelt = |link, across| {
            let mut moved = unfelt(link, across);
            moved.about_origin.m33 = link.inertia.about_origin.m33;
            moved
        };
    }),
    ("the mass on a slide moves", |how| {
        how.unfelt = |link, across| match link.kind {
            JointKind::Revolute => unfelt(link, across),
            JointKind::Prismatic => link.inertia,
        };
    }),
    ("the step from a still frame does not turn", |how| how.turning.step = |_, v| *v),
    ("the body in a still frame does not turn", |how| how.turning.inertia = |_, body| *body),
    ("of two turns the second is lost", |how| how.turning.both = |first, _| first),
    ("a cosine counts as equal to the sine", |how| how.angle = Some(|t| [t, t])),
    ("a shared sum loses its sign", |how| how.moves.shared_sum = |_| false),
    ("the first factor is taken out, not the common one", |how| {
        how.moves.without = |factors, _| factors.get(1..).unwrap_or_default().to_vec();
    }),
    ("signs in a bracket are lost", |how| how.moves.inside = |_| false),
];

/// For each regrouping, true if its torques, in the frames that the correct regrouping chooses, differ from the recursion's by more than rounding.
fn which_leave<const N: usize>(case: &Case, regroupings: &[Regrouping]) -> Vec<bool> {
    let model = case.file.robot.model::<N>().unwrap();
    let (model, scene) = holding(&model, &case.file.scene(&model));
    let frames = REGROUPING.cheapest_frames(case.function, &model, &scene, Precision::Double);
    let leaves = |how: &Regrouping| {
        let (arena, outputs) = how.record(case.function, &model, &scene, &frames, Precision::Double);
        let program = fewest_operations(arena, &outputs, Precision::Double, how.moves);
        case.states.iter().any(|(inputs, wanted)| {
            let size = wanted.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
            program.evaluate(inputs).iter().zip(wanted).any(|(found, wanted)| (found - wanted).abs() > 1e-12 * size)
        })
    };
    regroupings.iter().map(leaves).collect()
}

#[test]
fn every_wrong_regrouping_is_found_and_the_right_one_is_none() {
    let mut cases = cases();
    // Only functions that benefit from regrouping; the others are parts of the first.
    cases.retain(|case| matches!(case.function, Function::InverseDynamics | Function::MassMatrix));
    let mut regroupings = vec![REGROUPING];
    regroupings.extend(WRONG_REGROUPINGS.map(|(_, spoil)| {
        let mut how = REGROUPING;
        spoil(&mut how);
        how
    }));
    let mut kernels = vec![0; regroupings.len()];
    for case in &cases {
        let leave = with_dof!(case.file.robot.dof(), N => which_leave::<N>(case, &regroupings));
        kernels.iter_mut().zip(leave).for_each(|(kernels, leaves)| *kernels += usize::from(leaves));
    }
    assert_eq!(kernels.remove(0), 0);
    let found: Vec<_> = WRONG_REGROUPINGS.iter().map(|(name, _)| name).zip(kernels).collect();
    println!("of {} kernels, each fault shows in: {found:?}", cases.len());
    assert!(found.iter().all(|(_, kernels)| *kernels > 0), "{found:?}");
}
