//! Measures inverse dynamics with sine and cosine: one state after another, in batches, and on all cores.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the measurement")]

#[path = "../tests/support/mod.rs"]
mod support;
mod timing;

use dynamics_batch::{Float, inverse_dynamics_batch, inverse_dynamics_batch_parallel};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scalar, Trig};
use kernel_tests as kernels;
use std::hint::black_box;
use support::{Lists, Random, places, scene};
use timing::{instruction_set, shortest};

/// Number of states. Not a power of two, because lists at such distances would share a few cache sets.
const STATES: usize = 4_099;

fn compare<F: Float, const N: usize>(
    name: &str,
    single: &(impl InverseDynamics<F, N> + Sync),
    lanes: &(impl InverseDynamics<F::Lanes, N> + Sync),
) where
    F::Lanes: Send + Sync,
    Polynomial: Trig<F>,
{
    let lists = Lists::<F, N>::random(&mut Random::new(), STATES);
    let states: Vec<_> = (0..STATES).map(|at| lists.state(at)).collect();
    let live = Live::zero();
    let mut one_by_one = vec![[F::zero(); N]; STATES];
    let (mut batch, mut parallel) = (places::<F, N>(STATES), places::<F, N>(STATES));
    let mut contestants: [timing::Contestant<'_>; 3] = [
        (
            "one by one",
            Box::new(|| {
                for ([q, qd, qdd], tau) in black_box(&states).iter().zip(&mut one_by_one) {
                    *tau = single.inverse_dynamics(&Polynomial.sin_cos_all(q), q, qd, qdd, &live);
                }
                black_box(&mut one_by_one);
            }),
        ),
        (
            "batch",
            Box::new(|| {
                let tau = batch.each_mut().map(Vec::as_mut_slice);
                inverse_dynamics_batch(lanes, &Polynomial, black_box(&lists.states()), &live, tau).unwrap();
                black_box(&mut batch);
            }),
        ),
        (
            "all cores",
            Box::new(|| {
                let tau = parallel.each_mut().map(Vec::as_mut_slice);
                inverse_dynamics_batch_parallel(lanes, &Polynomial, black_box(&lists.states()), &live, tau).unwrap();
                black_box(&mut parallel);
            }),
        ),
    ];
    let times = shortest(&mut contestants, STATES);
    let [single, batch, parallel] = [0, 1, 2].map(|i| times[i]);
    println!("| {name} | {single:.1} | {batch:.1} | {:.2} | {parallel:.1} |", single / batch);
}

fn recursion<S: Scalar, const N: usize>(name: &str) -> Dynamics<S, N> {
    let file = scene(name);
    let model = file.robot.model::<N>().unwrap();
    Dynamics::new(model.cast(), file.scene(&model).cast())
}

fn main() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("ns per state, {STATES} states, {}, {cores} cores\n", instruction_set());
    println!("| | one by one | batch | ratio | all cores |\n|---|---|---|---|---|");
    use kernels::puma560_pick_inverse_dynamics_exact_any::Kernel as PumaExact;
    use kernels::puma560_pick_inverse_dynamics_regrouped_any::Kernel as Puma;
    use kernels::stanford_reach_inverse_dynamics_regrouped_any::Kernel as Stanford;
    use kernels::ur5_wave_inverse_dynamics_regrouped_any::Kernel as Ur5;
    compare::<f64, 6>("UR5, regrouped, f64", &Ur5, &Ur5);
    compare::<f64, 6>("Puma 560, regrouped, f64", &Puma, &Puma);
    compare::<f64, 6>("Stanford, regrouped, f64", &Stanford, &Stanford);
    compare::<f64, 6>("Puma 560, exact, f64", &PumaExact, &PumaExact);
    compare::<f64, 6>("Puma 560, recursion, f64", &recursion("puma560_pick"), &recursion("puma560_pick"));
    compare::<f32, 6>("Puma 560, regrouped, f32", &Puma, &Puma);
    compare::<f32, 6>("Puma 560, recursion, f32", &recursion("puma560_pick"), &recursion("puma560_pick"));
}
