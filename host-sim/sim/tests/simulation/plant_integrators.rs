//! The plant's integrators: the order of each, and the instants that jitter moves.

use crate::reference::Golden;
use nalgebra::Vector3;
use robot_compiler::scene::Integrator;
use sim::plant::actuator::ActuatorSettings;
use sim::plant::jitter::{Jitter, Moved};
use sim::plant::{Arm, Clock, Diverged, Plant};

/// Position of the free arm after half a second, in one tick of `steps_per_tick`.
fn fall<const N: usize>(arm: &Arm<N>, start: [f64; N], integrator: Integrator, steps_per_tick: u32) -> [f64; N] {
    let clock = Clock { period: 0.5, steps_per_tick };
    let mut plant = Plant::new(arm, None, ActuatorSettings::default(), clock, start).with_integrator(integrator);
    plant.drive(&[0.0; N]).unwrap();
    plant.state().q
}

/// Largest distance from the fall with 5,000 Runge-Kutta steps, rad, for each method.
fn errors<const N: usize>(arm: &Arm<N>, start: [f64; N], by: &[(Integrator, u32)]) -> Vec<f64> {
    let exact = fall(arm, start, Integrator::RungeKutta, 5_000);
    let error = |&(integrator, steps): &(Integrator, u32)| {
        let found = fall(arm, start, integrator, steps);
        (0..N).fold(0.0_f64, |worst, i| worst.max((found[i] - exact[i]).abs()))
    };
    by.iter().map(error).collect()
}

/// True if a number is within 5 % of the measured one.
fn near(found: f64, before: f64) -> bool {
    (found / before - 1.0).abs() < 0.05
}

/// Checks the order of every method; `euler` and `runge_kutta` are the errors measured before.
fn every_order<const N: usize>(arm: &Arm<N>, start: [f64; N], euler: f64, runge_kutta: f64) {
    let mut by = vec![(Integrator::SemiImplicitEuler, 1000), (Integrator::SemiImplicitEuler, 2000)];
    by.extend([(Integrator::RungeKutta, 50), (Integrator::RungeKutta, 100)]);
    let tolerances = [1e-5, 1e-7, 1e-9, 1e-11];
    by.extend(tolerances.map(|tolerance| (Integrator::Adaptive { tolerance }, 1)));
    let errors = errors(arm, start, &by);
    let order = |coarse: f64, fine: f64| (coarse / fine).log2();
    let (first, fourth) = (order(errors[0], errors[1]), order(errors[2], errors[3]));
    assert!((0.95..1.05).contains(&first) && near(errors[0], euler), "order {first}: {errors:?}");
    assert!((3.9..4.1).contains(&fourth) && near(errors[2], runge_kutta), "order {fourth}: {errors:?}");
    for (tolerance, error) in tolerances.iter().zip(&errors[4..]) {
        // Measured: 0.28 to 0.74 of the tolerance over six decades.
        assert!((0.2..1.0).contains(&(error / tolerance)), "{tolerance:e}: {error:e} rad");
    }
}

#[test]
fn every_method_has_its_order_and_the_adaptive_one_its_tolerance() {
    let planar: Arm<2> = Golden::load("planar2r").classical(false);
    every_order(&planar, [0.3, 0.5], 1.55e-3, 2.03e-7);
    let puma: Arm<6> = Golden::load("puma560").classical(true);
    every_order(&puma, [0.1, 0.4, -0.3, 0.2, 0.5, 0.1], 1.05e-3, 9.61e-9);
}

#[test]
fn a_tolerance_that_takes_too_many_steps_is_given_up() {
    let arm: Arm<2> = Golden::load("planar2r").classical(false);
    let clock = Clock { period: 3000.0, steps_per_tick: 1 };
    let mut plant = Plant::new(&arm, None, ActuatorSettings::default(), clock, [0.3, 0.5])
        .with_integrator(Integrator::Adaptive { tolerance: 1e-12 });
    assert_eq!(plant.drive(&[0.0; 2]), Err(Diverged::ToleranceOutOfReach));
}

#[test]
fn a_jitter_moves_the_measurement_to_before_the_tick_and_the_torque_to_after_it() {
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    arm.gravity = Vector3::zeros();
    const MOST: f64 = 4e-4;
    const TICKS: u32 = 1000;
    let clock = Clock { period: 1e-3, steps_per_tick: 4 };
    for integrator in [Integrator::RungeKutta, Integrator::SemiImplicitEuler, Integrator::Adaptive { tolerance: 1e-9 }]
    {
        let plant = || Plant::new(&arm, None, ActuatorSettings::default(), clock, [0.0; 2]).with_integrator(integrator);
        // Distance that the arm has moved since the measurement, over its speed: a time uniform from 0 to MOST.
        let mut early = plant().with_jitter(Some(Jitter::new(MOST, 7, Moved::Sampling)), None);
        (0..50).for_each(|_| early.drive(&[0.2, 0.02]).unwrap());
        let times: Vec<f64> = (0..TICKS)
            .map(|_| {
                early.drive(&[0.2, 0.02]).unwrap();
                let (now, then) = (early.state(), early.measured());
                2.0 * (now.q[0] - then.q[0]) / (now.qd[0] + then.qd[0])
            })
            .collect();
        let of = |times: &[f64]| {
            let mean = times.iter().sum::<f64>() / f64::from(TICKS);
            let rms = (times.iter().map(|t| (t - mean) * (t - mean)).sum::<f64>() / f64::from(TICKS)).sqrt();
            (mean / MOST, rms * 12.0_f64.sqrt() / MOST)
        };
        let inside = |times: &[f64]| times.iter().all(|t| (-1e-6..1.01 * MOST).contains(t));
        let (mean, rms) = of(&times);
        assert!(inside(&times) && (mean - 0.5).abs() < 0.03 && (rms - 1.0).abs() < 0.03, "{mean} {rms}");
        // From rest under the torque of one tick: the missing speed over the acceleration is the delay.
        let speed = |plant: &mut Plant<2>| {
            plant.drive(&[1.0, 0.1]).unwrap();
            plant.state().qd[0]
        };
        let whole = speed(&mut plant());
        let times: Vec<f64> = (0..u64::from(TICKS))
            .map(|seed| {
                let mut late = plant().with_jitter(None, Some(Jitter::new(MOST, seed, Moved::Acting)));
                (1.0 - speed(&mut late) / whole) * clock.period
            })
            .collect();
        let (mean, rms) = of(&times);
        assert!(inside(&times) && (mean - 0.5).abs() < 0.03 && (rms - 1.0).abs() < 0.03, "{mean} {rms}");
    }
}
