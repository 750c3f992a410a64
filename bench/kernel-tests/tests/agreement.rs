//! Tests of compiled kernels against the recursion on the model.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "level exact claims equality")]

use dynamics_core::control::computed_torque;
use dynamics_core::forward_dynamics::acceleration;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::momentum::{GeneralizedMomentum, Momentum};
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::regressor::inverse_dynamics_regressor;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, InverseDynamics, Live, Real, Reference, Scene, SinCos, Term, Trig, Wrench};
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::kernel::functions::Springs;
use robot_compiler::kernel::{Function, Level};
use std::path::Path;

const STATES: usize = 200;

/// Numbers in [-1, 1), the same in every run: a linear congruence with Knuth's multiplier.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn joints<const N: usize>(&mut self, size: f64) -> [f64; N] {
        core::array::from_fn(|_| size * self.next())
    }

    fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from(self.joints::<3>(size))
    }
}

/// All inputs of an inverse dynamics.
struct State<S, const N: usize> {
    turn: [SinCos<S>; N],
    q: [S; N],
    qd: [S; N],
    qdd: [S; N],
    live: Live<S, N>,
}

impl<const N: usize> State<f64, N> {
    fn random(random: &mut Random) -> Self {
        let q = random.joints(3.0);
        let held = Inertia::from_mass_centre(
            1.0 + random.next(),
            &random.vector(0.1),
            &nalgebra::Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.015)),
        );
        let live = Live {
            gravity: random.vector(10.0),
            payload: held,
            tip_wrench: Wrench { force: random.vector(20.0), moment: random.vector(3.0) },
            rotor: random.joints::<N>(0.4).map(|r| r + 0.5),
        };
        Self { turn: Libm.sin_cos_all(&q), q, qd: random.joints(2.0), qdd: random.joints(5.0), live }
    }

    fn cast<S: Real>(&self) -> State<S, N> {
        let list = |x: &[f64; N]| x.map(S::literal);
        let Live { gravity, payload, tip_wrench, rotor } = &self.live;
        State {
            turn: self.turn.map(|t| SinCos { sin: S::literal(t.sin), cos: S::literal(t.cos) }),
            q: list(&self.q),
            qd: list(&self.qd),
            qdd: list(&self.qdd),
            live: Live {
                gravity: gravity.map(S::literal),
                payload: payload.cast(),
                tip_wrench: tip_wrench.cast(),
                rotor: list(rotor),
            },
        }
    }

    fn torque<D: InverseDynamics<S, N>, S: Real>(&self, dynamics: &D) -> [S; N] {
        let State { turn, q, qd, qdd, live } = self.cast::<S>();
        dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &live)
    }
}

fn scene(name: &str) -> SceneFile {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    SceneFile::load(&folder.join(format!("{name}.toml"))).unwrap()
}

/// Largest difference, relative to the largest torque (or 1).
fn distance<S: Real>(found: &[S], wanted: &[f64]) -> f64 {
    let size = wanted.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    found.iter().zip(wanted).fold(0.0_f64, |worst, (f, w)| worst.max((f.to_f64() - w).abs() / size))
}

fn compare<S: Real, const N: usize>(file: &SceneFile, level: Level, bound: f64, kernel: &impl InverseDynamics<S, N>) {
    let name = &file.name;
    let model = file.robot.model::<N>().unwrap();
    let double = Dynamics::new(model, file.scene(&model));
    let generic = Dynamics::new(model.cast::<S>(), file.scene(&model).cast());
    let mut random = Random(1);
    for state in 0..STATES {
        let at = State::<f64, N>::random(&mut random);
        let found = at.torque(kernel);
        match level {
            Level::Exact => assert_eq!(found, at.torque(&generic), "{name}, state {state}"),
            Level::Regrouped => {
                let off = distance(&found, &at.torque(&double));
                assert!(off < bound, "{name}, state {state}: {off:e}");
            }
        }
    }
}

trait Bound {
    const BOUND: f64;
}
impl Bound for f32 {
    const BOUND: f64 = 5e-6;
}
impl Bound for f64 {
    const BOUND: f64 = 1e-13;
}

#[test]
fn every_compiled_kernel_agrees_with_the_recursion() {
    let mut kernels = 0;
    macro_rules! check {
        ($module:ident, $scene:literal, $joints:literal, $real:ident, $level:ident) => {
            let bound = <$real as Bound>::BOUND;
            compare::<$real, $joints>(&scene($scene), Level::$level, bound, &kernel_tests::$module::Kernel);
            kernels += 1;
        };
    }
    kernel_tests::every_kernel!(check);
    assert!(kernels >= 20, "{kernels}");
}

#[test]
fn kernels_read_their_live_inputs() {
    let mut file = scene("puma560_pick");
    let terms = &mut file.model;
    (terms.gravity, terms.payload, terms.tip_wrench, terms.rotor) = (Term::Live, Term::Live, Term::Live, Term::Live);
    compare(&file, Level::Exact, 0.0, &kernel_tests::all_live_inverse_dynamics_exact_f32::Kernel);
    compare(&file, Level::Regrouped, f32::BOUND, &kernel_tests::all_live_inverse_dynamics_regrouped_f32::Kernel);
}

/// Expected outputs of the other functions in a state, computed by the core's own functions, in the kernels' order.
fn expected(function: Function, at: &State<f64, 6>) -> Vec<f64> {
    let file = scene("stanford_reach");
    let model = file.robot.model::<6>().unwrap();
    let scene = file.scene(&model);
    let dynamics = |scene| Dynamics::new(model, scene);
    let State { turn, q, qd, qdd, live } = at;
    let still = Scene { coriolis: Term::Absent, tip_wrench: Term::Absent, ..scene };
    let weightless = Scene { gravity: Term::Absent, tip_wrench: Term::Absent, ..scene };
    let none = [0.0; 6];
    match function {
        Function::InverseDynamics => dynamics(scene).inverse_dynamics(turn, q, qd, qdd, live).to_vec(),
        Function::Gravity => dynamics(still).inverse_dynamics(turn, q, &none, &none, live).to_vec(),
        Function::Coriolis => dynamics(weightless).inverse_dynamics(turn, q, qd, &none, live).to_vec(),
        Function::MassMatrix => {
            let matrix = mass_matrix(&dynamics(scene), turn, q, live);
            (0..6).flat_map(|row| (row..6).map(move |column| matrix[(row, column)])).collect()
        }
        Function::JointWrenches => joint_wrenches(&dynamics(scene), turn, q, qd, qdd, live)
            .iter()
            .flat_map(|w| w.force.iter().chain(w.moment.iter()).copied().collect::<Vec<_>>())
            .collect(),
        Function::Momentum => {
            let Momentum { momentum, rate } = dynamics(scene).momentum(turn, q, qd, live);
            [momentum, rate].concat()
        }
        Function::ForwardDynamics => {
            let found = acceleration(&dynamics(scene), turn, q, qd, tau(at), live);
            found.qdd.into_iter().chain(found.pivot).collect()
        }
        Function::Regressor => {
            let columns = inverse_dynamics_regressor(&dynamics(scene), turn, q, qd, qdd, live);
            columns.iter().enumerate().flat_map(|(i, row)| row[i..].iter().flatten().copied()).collect()
        }
        Function::ComputedTorque(_) => {
            let gains = file.controller_config(&model).gains;
            computed_torque(&gains, &dynamics(scene), || *turn, &reference(at), (q, qd), live).to_vec()
        }
    }
}

/// Joint torques. Their values are arbitrary, so the accelerations are used.
const fn tau(at: &State<f64, 6>) -> &[f64; 6] {
    &at.qdd
}

/// A reference near the state, with its acceleration.
fn reference(at: &State<f64, 6>) -> Reference<f64, 6> {
    let near = |of: &[f64; 6]| core::array::from_fn(|i| of[i] + 0.01 * at.qdd[5 - i]);
    Reference { q: near(&at.q), qd: near(&at.qd), qdd: at.qdd }
}

/// A compiled function of M outputs.
type Compiled<'a, const M: usize> = &'a dyn Fn(&State<f64, 6>) -> [f64; M];

/// Compares the exact and the regrouped kernel of a function in 200 states.
fn compare_function<const M: usize>(function: Function, kernels: [Compiled<'_, M>; 2]) {
    let mut random = Random(2);
    for state in 0..STATES {
        let at = State::random(&mut random);
        let wanted = expected(function, &at);
        assert_eq!(kernels[0](&at)[..], wanted[..], "{}, state {state}", function.name());
        let off = distance(&kernels[1](&at), &wanted);
        // Solving for accelerations magnifies rounding by the condition of D, about 30 with rotors.
        let bound = if function == Function::ForwardDynamics { 100.0 * f64::BOUND } else { f64::BOUND };
        assert!(off < bound, "{}, state {state}: {off:e}", function.name());
    }
}

#[test]
fn gravity_agrees() {
    use kernel_tests::stanford_reach_gravity_exact_f64::gravity as exact;
    use kernel_tests::stanford_reach_gravity_regrouped_f64::gravity as regrouped;
    compare_function(Function::Gravity, [&|s| exact(&s.turn, &s.q), &|s| regrouped(&s.turn, &s.q)]);
}

#[test]
fn coriolis_agrees() {
    use kernel_tests::stanford_reach_coriolis_exact_f64::coriolis as exact;
    use kernel_tests::stanford_reach_coriolis_regrouped_f64::coriolis as regrouped;
    compare_function(Function::Coriolis, [&|s| exact(&s.turn, &s.q, &s.qd), &|s| regrouped(&s.turn, &s.q, &s.qd)]);
}

#[test]
fn mass_matrix_agrees() {
    use kernel_tests::stanford_reach_mass_matrix_exact_f64::mass_matrix as exact;
    use kernel_tests::stanford_reach_mass_matrix_regrouped_f64::mass_matrix as regrouped;
    compare_function(Function::MassMatrix, [&|s| exact(&s.turn, &s.q), &|s| regrouped(&s.turn, &s.q)]);
}

#[test]
fn joint_wrenches_agree() {
    use kernel_tests::stanford_reach_joint_wrenches_exact_f64::joint_wrenches as exact;
    use kernel_tests::stanford_reach_joint_wrenches_regrouped_f64::joint_wrenches as regrouped;
    compare_function(
        Function::JointWrenches,
        [&|s| exact(&s.turn, &s.q, &s.qd, &s.qdd), &|s| regrouped(&s.turn, &s.q, &s.qd, &s.qdd)],
    );
}

#[test]
fn the_regressor_agrees() {
    use kernel_tests::stanford_reach_regressor_exact_f64::regressor as exact;
    use kernel_tests::stanford_reach_regressor_regrouped_f64::regressor as regrouped;
    compare_function(
        Function::Regressor,
        [&|s| exact(&s.turn, &s.q, &s.qd, &s.qdd), &|s| regrouped(&s.turn, &s.q, &s.qd, &s.qdd)],
    );
}

#[test]
fn forward_dynamics_agrees() {
    use kernel_tests::stanford_reach_forward_dynamics_exact_f64::forward_dynamics as exact;
    use kernel_tests::stanford_reach_forward_dynamics_regrouped_f64::forward_dynamics as regrouped;
    compare_function(
        Function::ForwardDynamics,
        [&|s| exact(&s.turn, &s.q, &s.qd, tau(s)), &|s| regrouped(&s.turn, &s.q, &s.qd, tau(s))],
    );
}

#[test]
fn momentum_agrees() {
    use kernel_tests::stanford_reach_momentum_exact_f64::Kernel as Exact;
    use kernel_tests::stanford_reach_momentum_regrouped_f64::Kernel as Regrouped;
    fn found(kernel: &impl GeneralizedMomentum<f64, 6>, at: &State<f64, 6>) -> [f64; 12] {
        let Momentum { momentum, rate } = kernel.momentum(&at.turn, &at.q, &at.qd, &at.live);
        core::array::from_fn(|i| if i < 6 { momentum[i] } else { rate[i - 6] })
    }
    compare_function(Function::Momentum, [&|s| found(&Exact, s), &|s| found(&Regrouped, s)]);
}

#[test]
fn the_law_agrees() {
    use kernel_tests::stanford_reach_computed_torque_exact_f64::computed_torque as exact;
    use kernel_tests::stanford_reach_computed_torque_regrouped_f64::computed_torque as regrouped;
    let file = scene("stanford_reach");
    let springs = Springs::new(&file.controller_config(&file.robot.model::<6>().unwrap()).gains);
    compare_function(
        Function::ComputedTorque(springs),
        [&|s| exact(&s.turn, &s.q, &s.qd, &reference(s)), &|s| regrouped(&s.turn, &s.q, &s.qd, &reference(s))],
    );
}
