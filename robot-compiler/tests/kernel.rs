//! The kernel compiler, compared with the recursion that it traces.
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]
#![allow(clippy::float_cmp, reason = "level exact claims equality")]

#[path = "../../dynamics-core/tests/common/arms.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with the core's tests, which use more of it")]
pub(crate) mod arms;

use arms::{arm, body, joints, vector};
use dynamics_core::momentum::{GeneralizedMomentum, Momentum};
use dynamics_core::trig::Libm;
use dynamics_core::{
    Body, Dynamics, Frame, Inertia, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Real, Rotor, Scalar,
    Scene, SinCos, Term, Tool, Trig, Wrench, forward_dynamics, geometry,
};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::{Just, Strategy, prop_assert, prop_assert_eq, prop_oneof, proptest};
use proptest::test_runner::{Config, TestCaseError};
use robot_compiler::kernel::inputs::{forward_input_values, input_values};
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{
    Function, Level, Operations, Precision, Program, RewriteRule, RuleSet, compile, compile_with,
};
use robot_compiler::{Robot, SceneFile, with_dof};
use std::path::{Path, PathBuf};

/// An arm, a scene with each term absent, constant or live, live values, and a state.
#[derive(Debug)]
struct Case<const N: usize> {
    model: Model<f64, N>,
    scene: Scene<f64, N>,
    live: Live<f64, N>,
    q: [f64; N],
    qd: [f64; N],
    qdd: [f64; N],
}

fn term<T: Clone + core::fmt::Debug>(constant: T) -> impl Strategy<Value = Term<T>> {
    prop_oneof![Just(Term::Absent), Just(Term::Constant(constant)), Just(Term::Live)]
}

fn case<const N: usize>() -> impl Strategy<Value = Case<N>> {
    let world = (vector(10.0), body(), vector(20.0), vector(3.0));
    let motion = (joints(3.1), joints(2.0), joints(5.0));
    (arm::<N>(), world, motion).prop_flat_map(|(model, (gravity, held, force, moment), (q, qd, qdd))| {
        // A kernel reads one triangle of a live inertia, the recursion both, so a live inertia must be symmetric to the
        // bit.
        let payload = Inertia::from_mass_centre(held.mass, &held.com, &held.inertia).symmetric();
        let tip_wrench = Wrench { force, moment };
        let rotor = model.links().map(|link| link.rotor);
        let terms = (term(gravity), term(payload), term(tip_wrench), term(rotor), term(qd));
        terms.prop_map(move |(g, p, w, r, c)| Case {
            model,
            scene: Scene { gravity: g, payload: p, tip_wrench: w, rotor: r, coriolis: c },
            live: Live { gravity, payload, tip_wrench, rotor },
            q,
            qd,
            qdd,
        })
    })
}

/// A case's inputs in one scalar.
struct At<S, const N: usize> {
    turn: [SinCos<S>; N],
    q: [S; N],
    qd: [S; N],
    /// Accelerations, or torques in forward dynamics.
    last: [S; N],
    live: Live<S, N>,
}

impl<const N: usize> Case<N> {
    fn at<S: Real>(&self) -> At<S, N> {
        let cast = |x: [f64; N]| x.map(S::literal);
        let v = |v: Vector3<f64>| v.map(S::literal);
        let Live { gravity, payload, tip_wrench, rotor } = self.live;
        let turn = Libm.sin_cos_all(&self.q).map(|t| SinCos { sin: S::literal(t.sin), cos: S::literal(t.cos) });
        let live =
            Live { gravity: v(gravity), payload: payload.cast(), tip_wrench: tip_wrench.cast(), rotor: cast(rotor) };
        At { turn, q: cast(self.q), qd: cast(self.qd), last: cast(self.qdd), live }
    }
}

/// Results of the generic recursion and of the program, in one scalar.
fn both<S: Real, const N: usize>(case: &Case<N>, program: &Program) -> ([S; N], Vec<S>) {
    let At { turn, q, qd, last: qdd, live } = case.at::<S>();
    let generic = Dynamics::new(case.model.cast::<S>(), case.scene.cast());
    let found = program.evaluate(&input_values(&turn, &q, &qd, &qdd, &live));
    (generic.inverse_dynamics(&turn, &q, &qd, &qdd, &live), found)
}

fn exact_equals_generic<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    let program = |precision| compile(Function::InverseDynamics, &case.model, &case.scene, Level::Exact, precision);
    let (generic, found) = both::<f32, N>(case, &program(Precision::Single));
    prop_assert_eq!(generic.to_vec(), found);
    let (generic, found) = both::<f64, N>(case, &program(Precision::Double));
    prop_assert_eq!(generic.to_vec(), found);
    Ok(())
}

/// Accelerations and pivots, of the generic source and of the program.
fn forward<S: Real, const N: usize>(case: &Case<N>, program: &Program) -> (Vec<S>, Vec<S>) {
    let At { turn, q, qd, last: tau, live } = case.at::<S>();
    let generic = Dynamics::new(case.model.cast::<S>(), case.scene.cast());
    let wanted = forward_dynamics::acceleration(&generic, &turn, &q, &qd, &tau, &live);
    let found = program.evaluate(&forward_input_values(&turn, &q, &qd, &tau, &live));
    (wanted.qdd.into_iter().chain(wanted.pivot).collect(), found)
}

fn exact_forward_equals_generic<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    let program = |precision| compile(Function::ForwardDynamics, &case.model, &case.scene, Level::Exact, precision);
    let (generic, found) = forward::<f32, N>(case, &program(Precision::Single));
    prop_assert_eq!(generic, found);
    let (generic, found) = forward::<f64, N>(case, &program(Precision::Double));
    prop_assert_eq!(generic, found);
    Ok(())
}

/// inverse(forward(tau)) = tau, with both programs of the same level.
fn inverse_undoes_forward<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    let At { turn, q, qd, last: tau, live } = case.at::<f64>();
    for level in Level::ALL {
        let program = |function| compile(function, &case.model, &case.scene, level, Precision::Double);
        let found = program(Function::ForwardDynamics).evaluate(&forward_input_values(&turn, &q, &qd, &tau, &live));
        let (qdd, pivots) = found.split_at(N);
        prop_assert!(pivots.iter().all(|&pivot| pivot > 0.0));
        let qdd: [f64; N] = qdd.try_into().unwrap();
        let inverse = program(Function::InverseDynamics);
        let back = inverse.evaluate(&input_values(&turn, &q, &qd, &qdd, &live));
        let rest = inverse.evaluate(&input_values(&turn, &q, &qd, &[0.0; N], &live));
        let size = rest.iter().chain(&tau).fold(1.0_f64, |size, x| size.max(x.abs()));
        for (back, tau) in back.iter().zip(tau) {
            prop_assert!((back - tau).abs() < 1e-9 * size, "{back} {tau}");
        }
    }
    Ok(())
}

fn regrouped_agrees<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    let program = compile(Function::InverseDynamics, &case.model, &case.scene, Level::Regrouped, Precision::Double);
    let (generic, found) = both::<f64, N>(case, &program);
    let size = generic.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    for (g, f) in generic.iter().zip(&found) {
        prop_assert!((g - f).abs() < 1e-12 * size, "{:?} {:?}", generic, found);
    }
    Ok(())
}

macro_rules! over_arms {
    ($cases:literal cases; $($name:ident: $check:ident::<$n:literal>,)*) => {
        proptest! {
            #![proptest_config(Config::with_cases($cases))]
            $(#[test] fn $name(case in case::<$n>()) { $check(&case)?; })*
        }
    };
}

over_arms! {
    96 cases;
    exact_equals_generic_for_one_joint: exact_equals_generic::<1>,
    exact_equals_generic_for_two_joints: exact_equals_generic::<2>,
    exact_equals_generic_for_three_joints: exact_equals_generic::<3>,
    exact_equals_generic_for_four_joints: exact_equals_generic::<4>,
    exact_equals_generic_for_five_joints: exact_equals_generic::<5>,
    exact_equals_generic_for_six_joints: exact_equals_generic::<6>,
}

// Fewer cases, because each one searches for the cheapest frames.
over_arms! {
    16 cases;
    regrouped_agrees_for_one_joint: regrouped_agrees::<1>,
    regrouped_agrees_for_two_joints: regrouped_agrees::<2>,
    regrouped_agrees_for_three_joints: regrouped_agrees::<3>,
    regrouped_agrees_for_four_joints: regrouped_agrees::<4>,
    regrouped_agrees_for_five_joints: regrouped_agrees::<5>,
    regrouped_agrees_for_six_joints: regrouped_agrees::<6>,
}

over_arms! {
    24 cases;
    exact_forward_equals_generic_for_one_joint: exact_forward_equals_generic::<1>,
    exact_forward_equals_generic_for_two_joints: exact_forward_equals_generic::<2>,
    exact_forward_equals_generic_for_three_joints: exact_forward_equals_generic::<3>,
    exact_forward_equals_generic_for_four_joints: exact_forward_equals_generic::<4>,
    exact_forward_equals_generic_for_five_joints: exact_forward_equals_generic::<5>,
    exact_forward_equals_generic_for_six_joints: exact_forward_equals_generic::<6>,
}

// Fewer cases, because each one traces two functions at both levels.
over_arms! {
    8 cases;
    inverse_undoes_forward_for_one_joint: inverse_undoes_forward::<1>,
    inverse_undoes_forward_for_three_joints: inverse_undoes_forward::<3>,
    inverse_undoes_forward_for_six_joints: inverse_undoes_forward::<6>,
}

/// Momentum and its rate, of the generic source and of the program.
fn moments<S: Real, const N: usize>(case: &Case<N>, program: &Program) -> (Vec<S>, Vec<S>) {
    let At { turn, q, qd, last, live } = case.at::<S>();
    let generic = Dynamics::new(case.model.cast::<S>(), case.scene.cast());
    let Momentum { momentum, rate } = generic.momentum(&turn, &q, &qd, &live);
    ([momentum, rate].concat(), program.evaluate(&input_values(&turn, &q, &qd, &last, &live)))
}

fn momentum_agrees<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    let program = |level, precision| compile(Function::Momentum, &case.model, &case.scene, level, precision);
    let (generic, found) = moments::<f32, N>(case, &program(Level::Exact, Precision::Single));
    prop_assert_eq!(generic, found);
    let (generic, found) = moments::<f64, N>(case, &program(Level::Exact, Precision::Double));
    prop_assert_eq!(&generic, &found);
    let (_, regrouped) = moments::<f64, N>(case, &program(Level::Regrouped, Precision::Double));
    let size = generic.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    for (g, f) in generic.iter().zip(&regrouped) {
        prop_assert!((g - f).abs() < 1e-12 * size, "{:?} {:?}", generic, regrouped);
    }
    Ok(())
}

over_arms! {
    16 cases;
    momentum_agrees_for_one_joint: momentum_agrees::<1>,
    momentum_agrees_for_two_joints: momentum_agrees::<2>,
    momentum_agrees_for_three_joints: momentum_agrees::<3>,
    momentum_agrees_for_four_joints: momentum_agrees::<4>,
    momentum_agrees_for_five_joints: momentum_agrees::<5>,
    momentum_agrees_for_six_joints: momentum_agrees::<6>,
}

fn literal(x: f64) -> Expr {
    Expr::literal(x)
}

/// A program with two outputs from the inputs `a` and `b`: its operations, and the outputs at `a = 6`, `b = -4`.
fn two(write: fn(Expr, Expr) -> [Expr; 2]) -> (Operations, Vec<f64>) {
    let (outputs, tape) = trace(Arena::new(RuleSet::ALL, Precision::Double), || write(input(0), input(1)));
    let program = Program::new(tape, &outputs);
    (program.operations(), program.evaluate(&[6.0, -4.0]))
}

#[test]
fn quotients_are_folded_signed_and_shared_as_products_are() {
    let only = |div, neg| Operations { div, neg, ..Operations::default() };
    assert_eq!(two(|_, _| [literal(6.0) / literal(-4.0), literal(0.0)]), (only(0, 0), vec![-1.5, 0.0]));
    assert_eq!(two(|a, _| [literal(0.0) / a, a / literal(1.0)]), (only(0, 0), vec![0.0, 6.0]));
    assert_eq!(two(|a, _| [a / literal(-1.0), a]), (only(0, 1), vec![-6.0, 6.0]));
    assert_eq!(two(|a, b| [a / b, (-a) / (-b)]), (only(1, 0), vec![-1.5, -1.5]));
    assert_eq!(two(|a, b| [a / b, a / (-b)]), (only(1, 1), vec![-1.5, 1.5]));
    assert_eq!(two(|a, b| [a / b, b / a]), (only(2, 0), vec![-1.5, -4.0 / 6.0]));
    // A division by zero stays in the program, because infinity and NaN have no literal.
    let (work, found) = two(|a, _| [a / literal(0.0), literal(-2.0) / literal(0.0)]);
    assert_eq!((work.div, found), (2, vec![f64::INFINITY, -f64::INFINITY]));
}

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn scenes() -> Vec<PathBuf> {
    let folder = std::fs::read_dir(workspace().join("scenes")).unwrap();
    folder.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "toml")).collect()
}

fn robot(name: &str) -> Robot {
    Robot::load(&workspace().join(format!("robots/{name}.toml"))).unwrap()
}

/// Gravity on the floor and velocity terms, no rotors: the scene for comparing operation counts.
fn plain<const N: usize>() -> Scene<f64, N> {
    Scene { gravity: Term::Constant(Vector3::new(0.0, 0.0, -9.81)), ..Scene::free_space() }
}

fn counts(name: &str, function: Function, level: Level) -> [usize; 4] {
    let model = robot(name).model::<6>().unwrap();
    let program = compile(function, &model, &plain(), level, Precision::Single);
    let n = program.operations();
    [n.mul, n.add, n.sub, n.neg]
}

#[test]
fn operation_counts_are_what_is_written_here() {
    let count = |name| Level::ALL.map(|level| counts(name, Function::InverseDynamics, level));
    let found = ["ur5", "puma560", "stanford"].map(count);
    // mul, add, sub, neg; exact and regrouped, of each arm.
    let ur5 = [[234, 109, 84, 0], [150, 58, 56, 1]];
    let puma = [[218, 102, 81, 0], [167, 72, 52, 0]];
    let stanford = [[176, 87, 54, 0], [115, 48, 40, 2]];
    assert_eq!(found, [ur5, puma, stanford]);
}

#[test]
fn operation_counts_of_momentum_are_what_is_written_here() {
    let count = |name| Level::ALL.map(|level| counts(name, Function::Momentum, level));
    let found = ["ur5", "puma560", "stanford"].map(count);
    // mul, add, sub, neg; exact and regrouped, of each arm.
    let ur5 = [[189, 76, 62, 0], [128, 42, 44, 2]];
    let puma = [[175, 66, 61, 1], [132, 43, 48, 1]];
    let stanford = [[143, 57, 43, 2], [95, 29, 33, 1]];
    assert_eq!(found, [ur5, puma, stanford]);
}

#[test]
fn operation_counts_of_forward_dynamics_are_what_is_written_here() {
    let count = |name, function| {
        let model = robot(name).model::<6>().unwrap();
        let n = compile(function, &model, &plain(), Level::Exact, Precision::Double).operations();
        [n.mul, n.add, n.sub, n.div]
    };
    let found = ["ur5", "puma560", "stanford"]
        .map(|name| [Function::MassMatrix, Function::ForwardDynamics].map(|function| count(name, function)));
    // mul, add, sub, div. Two of the six pivots are constants: the inertia that the last two joints feel with the others free.
    let ur5 = [[82, 50, 34, 0], [374, 164, 159, 4]];
    let puma = [[83, 52, 32, 0], [357, 164, 142, 4]];
    let stanford = [[48, 29, 15, 0], [273, 115, 101, 4]];
    assert_eq!(found, [ur5, puma, stanford]);
}

#[test]
fn every_rule_saves_work_and_none_costs_any() {
    let mut saved = [0_i64; RewriteRule::ALL.len()];
    for path in scenes() {
        let file = SceneFile::load(&path).unwrap();
        with_dof!(file.robot.dof(), N => add_savings::<N>(&file, &mut saved));
    }
    println!("{:?}", RewriteRule::ALL.map(RewriteRule::name).iter().zip(saved).collect::<Vec<_>>());
    assert!(saved.iter().all(|&n| n > 0), "{saved:?}");
}

fn add_savings<const N: usize>(file: &SceneFile, saved: &mut [i64]) {
    let model = file.robot.model::<N>().unwrap();
    let scene = file.scene(&model);
    for function in Function::ALL {
        let total = |rules| {
            let n = compile_with(function, &model, &scene, rules, Precision::Single).operations();
            i64::try_from(n.total() + n.neg).unwrap()
        };
        for (rule, saved) in RewriteRule::ALL.into_iter().zip(&mut *saved) {
            *saved += total(RuleSet::ALL.without(rule)) - total(RuleSet::ALL);
        }
    }
}

#[test]
fn every_shipped_scene_has_an_exact_kernel() {
    for path in scenes() {
        let file = SceneFile::load(&path).unwrap();
        with_dof!(file.robot.dof(), N => equals_on_states::<N>(&file));
    }
}

fn equals_on_states<const N: usize>(file: &SceneFile) {
    let model = file.robot.model::<N>().unwrap();
    let (scene, live) = (file.scene(&model), file.live(&model));
    let program = compile(Function::InverseDynamics, &model, &scene, Level::Exact, Precision::Single);
    for k in 0..50 {
        let wave = |phase: f64| core::array::from_fn(|i| (f64::from(k) * 0.7 + i as f64 + phase).sin() * 2.0);
        let case = Case { model, scene, live, q: wave(0.0), qd: wave(1.0), qdd: wave(2.0) };
        let (generic, found) = both::<f32, N>(&case, &program);
        assert_eq!(generic.to_vec(), found, "{} state {k}", file.name);
    }
}

/// Three joints, each tilted against the one before and with a body of scaled mass, in a state that moves all of them.
fn three(tilts: [f64; 3], masses: [f64; 3]) -> Case<3> {
    let joint = |i: usize| JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::Placement {
            rotation: geometry::from_rpy(tilts[i], 0.0, 0.0),
            translation: Vector3::new(0.3, 0.2, 0.1),
            axis: Vector3::z(),
        },
        body: Body {
            mass: masses[i],
            com: Vector3::new(-0.2, 0.03, 0.05),
            inertia: Matrix3::new(4e-3, 1e-4, 2e-4, 1e-4, 3e-3, 3e-4, 2e-4, 3e-4, 2e-3) * masses[i],
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let model = Model::new(&core::array::from_fn(joint), &Tool::default()).unwrap();
    let live = Live { gravity: Vector3::new(0.0, 0.0, -9.81), ..Live::zero() };
    let (q, qd, qdd) = ([0.3, -0.9, 1.4], [1.1, -0.7, 2.0], [3.0, -5.0, 4.0]);
    Case { model, scene: plain(), live, q, qd, qdd }
}

/// Relative error of each single torque, regrouped against the recursion.
fn regrouped_errors(case: &Case<3>) -> [f64; 3] {
    let program = compile(Function::InverseDynamics, &case.model, &case.scene, Level::Regrouped, Precision::Double);
    let (generic, found) = both::<f64, 3>(case, &program);
    core::array::from_fn(|i| ((found[i] - generic[i]) / generic[i]).abs())
}

/// Here the feet of common normals are a kilometre away, and no origin may move to them.
#[test]
fn axes_that_are_nearly_parallel_cost_no_digits() {
    for tilt in [1e-2, 1e-4, 1e-6] {
        let errors = regrouped_errors(&three([0.0, 1.2, tilt], [3.0, 2.0, 1.0]));
        assert!(errors.iter().all(|&error| error < 1e-13), "tilt {tilt}: {errors:?}");
    }
}

/// A gripper's moments must not be mistaken for rounding errors of the base's.
#[test]
fn a_light_link_on_a_heavy_one_keeps_its_digits() {
    for light in [1e-3, 1e-9, 1e-15] {
        let errors = regrouped_errors(&three([1.2, -0.7, 0.4], [1e3, 1.0, light]));
        assert!(errors.iter().all(|&error| error < 1e-12), "mass {light}: {errors:?}");
    }
}
