//! Every path gives the bits of the recursion.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use batch_engine::kernel::{Block, Float, Kernel, LANES};
use batch_engine::statements::statements;
use batch_engine::{Arm, ArmFloat, Quantity, evaluate};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use ndarray::{Array2, ArrayView2};
use robot_compiler::kernel::Precision;
use robot_compiler::{Robot, with_dof};
use std::path::{Path, PathBuf};

/// Arms of the repository: revolute and prismatic joints, one to six of them.
const ROBOTS: [&str; 7] = ["planar2r", "planar3r", "puma560", "rebot_b601_rs", "scara", "stanford", "ur5"];

fn robot(name: &str) -> Robot {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    Robot::load(&folder.join(name).with_extension("toml")).unwrap()
}

/// Numbers between -3 and 3 that anyone can reproduce: the fractions of multiples of an irrational number.
fn states<F: Float>(count: usize, joints: usize, list: usize) -> Array2<F> {
    Array2::from_shape_fn((count, joints), |(state, joint)| {
        let at = (state * 18 + list * 6 + joint + 1) as f64 * 0.618_033_988_749_894_9;
        F::literal(6.0 * (at - at.floor()) - 3.0)
    })
}

fn bits<F: Float>(numbers: &[F]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_f64().to_bits()).collect()
}

/// Compares one state, many states and the core itself.
fn compare<F: ArmFloat>(name: &str)
where
    Polynomial: Trig<F>,
{
    let robot = robot(name);
    let arm = Arm::new(&robot, robot.gravity(), None).unwrap();
    let n = robot.dof();
    // Not a multiple of the block; some states at rest, whose torques have zeros of either sign; some beyond all ranges.
    let count = 2500;
    let mut lists: [Array2<F>; 3] = core::array::from_fn(|list| states(count, n, list));
    for list in &mut lists {
        list.rows_mut().into_iter().step_by(7).for_each(|mut row| row.fill(F::zero()));
        list.row_mut(40)[0] = F::literal(1e30);
        list.row_mut(41)[n - 1] = F::literal(f64::NAN);
        list.row_mut(2400)[0] = F::literal(-9000.0);
    }
    let views: [ArrayView2<'_, F>; 3] = lists.each_ref().map(|list| list.view());
    for quantity in Quantity::ALL {
        let inputs = &views[..quantity.inputs()];
        let mut all = Array2::from_elem((count, quantity.results(n)), F::literal(7.0));
        let done = evaluate(&arm, quantity, inputs, all.view_mut());
        assert!(done.is_ok(), "{name} {quantity:?}: {done:?}");
        for state in 0..count {
            let one: Vec<_> = inputs.iter().map(|list| list.slice(ndarray::s![state..=state, ..])).collect();
            let mut alone = Array2::from_elem((1, quantity.results(n)), F::literal(8.0));
            evaluate(&arm, quantity, &one, alone.view_mut()).unwrap();
            let (found, expected) = (all.row(state).to_vec(), alone.row(0).to_vec());
            assert_eq!(numbers(&found), numbers(&expected), "{name} {quantity:?} {state}");
        }
    }
    let mut all = Array2::from_elem((count, n), F::zero());
    evaluate(&arm, Quantity::InverseDynamics, &views, all.view_mut()).unwrap();
    with_dof!(n, N => {
        let model = robot.model::<N>().unwrap();
        let scene = Scene::with_gravity(robot.gravity(), &model);
        let dynamics = Dynamics::<F, N>::new(model.cast(), scene.cast());
        for state in 0..count {
            let [q, qd, qdd]: [[F; N]; 3] = views.each_ref().map(|list| core::array::from_fn(|i| list[(state, i)]));
            let turn = Polynomial.sin_cos_all(&q);
            let tau = dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero());
            assert_eq!(numbers(&all.row(state).to_vec()), numbers(&tau), "{name} {state}");
        }
    });
}

/// Bits; NaN compares as NaN.
fn numbers<F: Float>(numbers: &[F]) -> Vec<Option<u64>> {
    bits(numbers)
        .into_iter()
        .zip(numbers)
        .map(|(bits, x)| (x.is_finite() || x.abs() > F::MAX).then_some(bits))
        .collect()
}

#[test]
fn one_state_many_states_and_the_core_agree_to_the_bit() {
    for name in ROBOTS {
        compare::<f64>(name);
        compare::<f32>(name);
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let robot = robot("puma560");
    let model = robot.model::<6>().unwrap();
    let scene = Scene::with_gravity(robot.gravity(), &model);
    let list = |list: usize| -> Vec<Block<f64>> {
        let numbers = states::<f64>(LANES, 6, list);
        (0..6).map(|joint| Block(core::array::from_fn(|lane| numbers[(lane, joint)]))).collect()
    };
    let inputs = [list(0), list(1), list(2)];
    for quantity in Quantity::ALL {
        let program = statements(quantity, &model, &scene, Precision::Double);
        let (mut plain, mut wide) = (Kernel::with(&program, pulp::Arch::Scalar), Kernel::<f64>::new(&program));
        plain.run(&inputs);
        wide.run(&inputs);
        for k in 0..quantity.outputs(6) {
            assert_eq!(bits(plain.output(k)), bits(wide.output(k)), "{quantity:?} {k}");
        }
    }
}
