//! Tests that every state of a batch has the same bits as if it is computed alone.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

mod support;

use dynamics_batch::{Float, LengthError, States, inverse_dynamics_batch, inverse_dynamics_batch_parallel};
use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{Dynamics, Inertia, InverseDynamics, Live, Scalar, Trig, Wrench};
use kernel_tests as kernels;
use nalgebra::{Matrix3, Vector3};
use robot_compiler::SceneFile;
use support::{Lists, Random, places, scene};

/// Some live inputs, for the scenes that read them.
fn live<F: Float, const N: usize>() -> Live<F, N> {
    let vector = |x, y, z| Vector3::new(F::literal(x), F::literal(y), F::literal(z));
    Live {
        gravity: vector(0.3, -2.0, -9.0),
        payload: Inertia::from_mass_centre(
            F::literal(1.3),
            &vector(0.02, -0.01, 0.07),
            &Matrix3::from_diagonal(&vector(0.01, 0.02, 0.015)),
        ),
        tip_wrench: Wrench { force: vector(1.0, -20.0, 3.0), moment: vector(0.1, 0.5, -0.7) },
        rotor: core::array::from_fn(|i| F::literal(0.1 * (i + 1) as f64)),
    }
}

/// The torques of every state, each computed alone.
fn alone<F: Float, const N: usize>(
    dynamics: &impl InverseDynamics<F, N>,
    trig: &impl Trig<F>,
    lists: &Lists<F, N>,
) -> Vec<[F; N]> {
    (0..lists.states().len())
        .map(|at| {
            let [q, qd, qdd] = lists.state(at);
            dynamics.inverse_dynamics(&trig.sin_cos_all(&q), &q, &qd, &qdd, &live())
        })
        .collect()
}

fn bits<F: Float>(x: F) -> u64 {
    x.to_f64().to_bits()
}

/// Compares batches on one core with the same dynamics in single floats: 0 to 33 states, more than a block, and so many states that unread sines
/// are left out.
fn compare<F: Float, const N: usize>(
    name: &str,
    single: &impl InverseDynamics<F, N>,
    lanes: &impl InverseDynamics<F::Lanes, N>,
    trig: &impl Trig<F>,
) {
    let mut random = Random::new();
    for count in (0..=33).chain([63, 64, 65, 131, 300]) {
        let lists = Lists::random(&mut random, count);
        let mut tau = places::<F, N>(count);
        inverse_dynamics_batch(lanes, trig, &lists.states(), &live(), tau.each_mut().map(Vec::as_mut_slice)).unwrap();
        for (at, wanted) in alone(single, trig, &lists).into_iter().enumerate() {
            let found = tau.each_ref().map(|list| bits(list[at]));
            assert_eq!(found, wanted.map(bits), "{name}: state {at} of {count}");
        }
    }
}

/// The recursion in a scalar.
fn recursion<S: Scalar, const N: usize>(file: &SceneFile) -> Dynamics<S, N> {
    let model = file.robot.model::<N>().unwrap();
    Dynamics::new(model.cast(), file.scene(&model).cast())
}

/// The recursion and one kernel, in both precisions. The kernel's numbers are folded in f64 for both.
fn compare_arm<K, const N: usize>(name: &str, kernel: &K)
where
    K: InverseDynamics<f64, N>
        + InverseDynamics<f32, N>
        + InverseDynamics<dynamics_batch::F64Lanes, N>
        + InverseDynamics<dynamics_batch::F32Lanes, N>,
{
    let file = scene(name);
    compare::<f64, N>(name, &recursion(&file), &recursion(&file), &Polynomial);
    compare::<f32, N>(name, &recursion(&file), &recursion(&file), &Polynomial);
    compare::<f64, N>(name, kernel, kernel, &Polynomial);
    compare::<f32, N>(name, kernel, kernel, &Polynomial);
    compare::<f64, N>(name, kernel, kernel, &Libm);
}

#[test]
fn batches_of_the_recursion_and_of_exact_kernels_have_the_bits_of_single_states() {
    compare_arm::<_, 6>("ur5_wave", &kernels::ur5_wave_inverse_dynamics_exact_any::Kernel);
    compare_arm::<_, 6>("puma560_pick", &kernels::puma560_pick_inverse_dynamics_exact_any::Kernel);
    compare_arm::<_, 6>("stanford_reach", &kernels::stanford_reach_inverse_dynamics_exact_any::Kernel);
    compare_arm::<_, 4>("scara_pick", &kernels::scara_pick_inverse_dynamics_exact_any::Kernel);
}

#[test]
fn batches_of_regrouped_kernels_have_the_bits_of_single_states() {
    compare_arm::<_, 6>("ur5_wave", &kernels::ur5_wave_inverse_dynamics_regrouped_any::Kernel);
    compare_arm::<_, 6>("puma560_pick", &kernels::puma560_pick_inverse_dynamics_regrouped_any::Kernel);
    compare_arm::<_, 6>("stanford_reach", &kernels::stanford_reach_inverse_dynamics_regrouped_any::Kernel);
    compare_arm::<_, 4>("scara_pick", &kernels::scara_pick_inverse_dynamics_regrouped_any::Kernel);
}

#[test]
fn live_inputs_reach_every_lane() {
    let exact = kernels::all_live_inverse_dynamics_exact_any::Kernel;
    compare::<f64, 6>("all live", &exact, &exact, &Polynomial);
    compare::<f32, 6>("all live", &exact, &exact, &Polynomial);
    let regrouped = kernels::all_live_inverse_dynamics_regrouped_any::Kernel;
    compare::<f64, 6>("all live", &regrouped, &regrouped, &Polynomial);
}

#[test]
fn an_exact_kernel_equals_the_recursion_and_a_regrouped_one_does_not() {
    let lists = Lists::random(&mut Random::new(), 1000);
    let model = recursion::<f64, 6>(&scene("puma560_pick"));
    let wanted = alone(&model, &Polynomial, &lists);
    let run = |lanes: &dyn Fn([&mut [f64]; 6])| {
        let mut tau = places::<f64, 6>(1000);
        lanes(tau.each_mut().map(Vec::as_mut_slice));
        (0..1000).map(|at| tau.each_ref().map(|list| list[at])).collect::<Vec<_>>()
    };
    let exact = kernels::puma560_pick_inverse_dynamics_exact_any::Kernel;
    let regrouped = kernels::puma560_pick_inverse_dynamics_regrouped_any::Kernel;
    let states = lists.states();
    assert_eq!(run(&|tau| inverse_dynamics_batch(&exact, &Polynomial, &states, &live(), tau).unwrap()), wanted);
    // Check of the test: the comparison detects a difference in the last bit.
    assert_ne!(run(&|tau| inverse_dynamics_batch(&regrouped, &Polynomial, &states, &live(), tau).unwrap()), wanted);
}

#[test]
fn all_cores_together_give_the_bits_of_one() {
    let kernel = kernels::ur5_wave_inverse_dynamics_regrouped_any::Kernel;
    for count in [0, 1, 1024, 1025, 5003, 20_000] {
        let lists = Lists::random(&mut Random::new(), count);
        let (mut one, mut all) = (places::<f64, 6>(count), places::<f64, 6>(count));
        let (states, live) = (lists.states(), live());
        inverse_dynamics_batch(&kernel, &Polynomial, &states, &live, one.each_mut().map(Vec::as_mut_slice)).unwrap();
        let places = all.each_mut().map(Vec::as_mut_slice);
        inverse_dynamics_batch_parallel(&kernel, &Polynomial, &states, &live, places).unwrap();
        assert_eq!(
            one.concat().into_iter().map(bits).collect::<Vec<_>>(),
            all.concat().into_iter().map(bits).collect::<Vec<_>>()
        );
    }
}

#[test]
fn a_state_that_is_not_a_number_spoils_no_other() {
    let kernel = kernels::scara_pick_inverse_dynamics_exact_any::Kernel;
    let q: [Vec<f64>; 4] = core::array::from_fn(|_| vec![0.1, f64::NAN, 0.2, f64::INFINITY, 0.3]);
    let q = q.each_ref().map(Vec::as_slice);
    let mut tau = places::<f64, 4>(5);
    let states = States::new(q, q.map(|_| [0.1; 5].as_slice()), q.map(|_| [0.2; 5].as_slice())).unwrap();
    inverse_dynamics_batch(&kernel, &Polynomial, &states, &live(), tau.each_mut().map(Vec::as_mut_slice)).unwrap();
    assert_eq!(tau[0].iter().map(|x| x.is_finite()).collect::<Vec<_>>(), [true, false, true, false, true]);
}

#[test]
fn lists_of_other_lengths_are_refused_by_name() {
    let (three, two) = ([0.0; 3], [0.0; 2]);
    let refused = |q: [&[f64]; 2], qd: [&[f64]; 2], qdd: [&[f64]; 2]| States::new(q, qd, qdd).unwrap_err();
    let wrong = |list, joint| LengthError { list, joint, expected: 3, found: 2 };
    let right: [&[f64]; 2] = [&three, &three];
    assert_eq!(refused([&three, &two], right, right), wrong("q", 1));
    assert_eq!(refused(right, [&two, &three], right), wrong("qd", 0));
    assert_eq!(refused(right, right, [&three, &two]), wrong("qdd", 1));
    assert_eq!(wrong("qdd", 1).to_string(), "qdd[1] holds 2 numbers; expected 3, one for each state, as in q[0]");

    let kernel = recursion(&scene("planar2r_sine"));
    let states = States::new(right, right, right).unwrap();
    let (mut first, mut second) = ([7.0; 3], [7.0; 4]);
    let run = inverse_dynamics_batch::<f64, Dynamics<_, 2>, _, 2>;
    let found = run(&kernel, &Polynomial, &states, &Live::zero(), [&mut first, &mut second]).unwrap_err();
    assert_eq!(found, LengthError { list: "tau", joint: 1, expected: 3, found: 4 });
    assert_eq!((first, second), ([7.0; 3], [7.0; 4]));
    let found = inverse_dynamics_batch_parallel::<f64, Dynamics<_, 2>, _, 2>(
        &kernel,
        &Polynomial,
        &states,
        &Live::zero(),
        [&mut first, &mut second],
    );
    assert!(found.is_err());
}
