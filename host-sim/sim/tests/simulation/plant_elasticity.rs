//! Elastic joints compared with closed forms and the laws of mechanics.
#![allow(clippy::float_cmp, reason = "what is not touched has not moved")]

use crate::reference::Golden;
use dynamics_core::trig::Polynomial;
use dynamics_core::{Rotor, Trig};
use nalgebra::Vector3;
use robot_compiler::scene::{Integrator, Side};
use sim::plant::actuator::ActuatorSettings;
use sim::plant::elasticity::Elasticity;
use sim::plant::{Arm, Clock, Plant, State};

/// The two rods with this rotor inertia.
fn rods(rotor: f64) -> Arm<2> {
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    for joint in &mut arm.joints {
        joint.rotor = Rotor { inertia: rotor, gear: 1.0 };
    }
    arm
}

/// The first rod alone, without gravity, and its inertia about its joint.
fn rod(rotor: f64) -> (Arm<1>, f64) {
    let Arm { joints: [first, _], tool, .. } = rods(rotor);
    let arm = Arm { joints: [first], tool, payload: None, gravity: Vector3::zeros(), tip_wrench: None };
    let inertia = arm.terms(&[0.0], &[0.0]).mass_matrix[(0, 0)] - rotor;
    (arm, inertia)
}

fn springs<const N: usize>(stiffness: f64, damping: f64) -> Elasticity<N> {
    Elasticity { stiffness: [stiffness; N], damping: [damping; N], backlash: None }
}

fn plant<const N: usize>(arm: &Arm<N>, springs: Elasticity<N>, steps_per_tick: u32, start: [f64; N]) -> Plant<N> {
    let clock = Clock { period: 1e-3, steps_per_tick };
    Plant::new(arm, None, ActuatorSettings::default(), clock, start).with_elasticity(springs, Side::Motor)
}

fn twist<const N: usize>(plant: &Plant<N>, i: usize) -> f64 {
    plant.motors().unwrap().q[i] - plant.state().q[i]
}

#[test]
fn natural_frequencies_are_those_of_the_closed_forms() {
    // Free at both ends: w^2 = k (1/D + 1/J).
    let (arm, inertia) = rod(0.3);
    let found = springs(500.0, 0.0).natural_frequencies(&arm, &[0.4]).unwrap();
    let wanted = (500.0 * (1.0 / inertia + 1.0 / 0.3)).sqrt();
    assert!((found[0] / wanted - 1.0).abs() < 1e-12 && found[1].abs() < 1e-5 * wanted, "{found:?} and {wanted}");
    // Rotors too heavy to move: det(K - w^2 D) = 0, a quadratic for two joints.
    let arm = rods(1e12);
    let q = [0.3, 0.9];
    let found = springs(500.0, 0.0).natural_frequencies(&arm, &q).unwrap();
    let mut bare = arm.clone();
    bare.joints.iter_mut().for_each(|joint| joint.rotor = Rotor::default());
    let d = bare.mechanism().terms(&Polynomial.sin_cos_all(&q), &q, &[0.0; 2]).mass_matrix;
    let (trace, determinant) = (d[(0, 0)] + d[(1, 1)], d[(0, 0)] * d[(1, 1)] - d[(0, 1)] * d[(1, 0)]);
    let root = (trace * trace - 4.0 * determinant).sqrt();
    for (found, inertia) in found.iter().zip([(trace - root) / 2.0, (trace + root) / 2.0]) {
        let wanted = (500.0 / inertia).sqrt();
        assert!((found / wanted - 1.0).abs() < 1e-9, "{found} and {wanted}");
    }
}

/// Largest error of the twist against its closed form, relative to its amplitude, under a constant motor torque.
fn oscillation(rotor: f64, damping: f64, steps: u32) -> f64 {
    const TORQUE: f64 = 3.0;
    let (arm, inertia) = rod(rotor);
    let mut plant = plant(&arm, springs(500.0, damping), steps, [0.0]);
    let together = 1.0 / inertia + 1.0 / rotor;
    let omega_squared = 500.0 * together;
    let decay = damping * together / 2.0;
    let omega = (omega_squared - decay * decay).sqrt();
    let amplitude = TORQUE / (rotor * omega_squared);
    (1..=300).fold(0.0_f64, |worst, tick| {
        plant.drive(&[TORQUE]).unwrap();
        let t = f64::from(tick) * 1e-3;
        let swing = (omega * t).cos() + decay / omega * (omega * t).sin();
        worst.max((twist(&plant, 0) / amplitude - 1.0 + (-decay * t).exp() * swing).abs())
    })
}

#[test]
fn a_pushed_motor_swings_against_its_link_as_the_closed_form_says() {
    // With free motor, with a practically clamped motor, and damped to a tenth of critical.
    for (name, rotor, damping, before) in
        [("free", 0.3, 0.0, 6.92e-7), ("clamped", 1e5, 0.0, 3.72e-8), ("damped", 0.3, 2.0, 1.83e-7)]
    {
        let (coarse, fine) = (oscillation(rotor, damping, 1), oscillation(rotor, damping, 2));
        let order = (coarse / fine).log2();
        assert!((3.8..4.2).contains(&order), "{name}: order {order} from {coarse:e}");
        assert!((coarse / before - 1.0).abs() < 0.05, "{name}: {coarse:e}");
    }
}

/// Kinetic, potential and spring energy, J.
fn energy(arm: &Arm<2>, rotor: f64, springs: &Elasticity<2>, plant: &Plant<2>) -> f64 {
    let mut bare = arm.clone();
    bare.joints.iter_mut().for_each(|joint| joint.rotor = Rotor::default());
    let (link, motor) = (plant.state(), plant.motors().unwrap());
    let rotors: f64 = motor.qd.iter().map(|qd| 0.5 * rotor * qd * qd).sum();
    bare.kinetic(&link.q, &link.qd) + bare.potential(&link.q) + rotors + springs.energy(motor, link)
}

/// Greatest change of energy during a fall of half a second, J, and the change at its end, J.
fn drift(damping: f64, backlash: Option<[f64; 2]>, integrator: Integrator, steps: u32) -> (f64, f64) {
    let arm = rods(0.3);
    let springs = Elasticity { backlash, ..springs(500.0, damping) };
    let mut plant = plant(&arm, springs, steps, [0.3, 0.5]).with_integrator(integrator);
    let before = energy(&arm, 0.3, &springs, &plant);
    let mut worst = 0.0_f64;
    for _ in 0..500 {
        plant.drive(&[0.0; 2]).unwrap();
        worst = worst.max((energy(&arm, 0.3, &springs, &plant) - before).abs());
    }
    (worst, energy(&arm, 0.3, &springs, &plant) - before)
}

#[test]
fn without_damping_energy_is_kept_and_with_it_lost() {
    let [coarse, fine] = [1, 2].map(|steps| drift(0.0, None, Integrator::RungeKutta, steps).0);
    let adaptive = drift(0.0, None, Integrator::Adaptive { tolerance: 1e-9 }, 1).0;
    let euler = [1, 2].map(|steps| drift(0.0, None, Integrator::SemiImplicitEuler, steps).0);
    let play = drift(0.0, Some([2e-3; 2]), Integrator::Adaptive { tolerance: 1e-9 }, 1).0;
    let lost = drift(2.0, None, Integrator::RungeKutta, 2).1;
    let near =
        |found: f64, before: f64| assert!((found / before - 1.0).abs() < 0.05, "{found:e} J, {before:e} J before");
    // The energy loss of Runge-Kutta in an oscillation falls with the fifth power of the step.
    near(coarse, 2.80e-8);
    near(fine, 8.90e-10);
    near(adaptive, 1.10e-9);
    near(euler[0], 5.77e-2);
    near(euler[1], 2.89e-2);
    near(play, 1.03e-7);
    near(lost, -0.644);
}

#[test]
fn stiffer_springs_make_the_rigid_arm_to_first_order_in_their_compliance() {
    let arm = rods(0.3);
    let start = [0.3, 0.5];
    let clock = Clock { period: 1e-3, steps_per_tick: 4 };
    let off = |stiffness: f64| {
        let integrator = Integrator::Adaptive { tolerance: 1e-10 };
        let mut elastic = plant(&arm, springs(stiffness, 0.0), 4, start).with_integrator(integrator);
        let mut rigid = Plant::new(&arm, None, ActuatorSettings::default(), clock, start);
        (0..300).fold(0.0_f64, |worst, _| {
            elastic.drive(&[2.0, -1.0]).unwrap();
            rigid.drive(&[2.0, -1.0]).unwrap();
            (0..2).fold(worst, |worst, i| worst.max((elastic.state().q[i] - rigid.state().q[i]).abs()))
        })
    };
    let (soft, stiff) = (off(1e4), off(4e4));
    // Measured: 3.90e-4 and 9.75e-5 rad.
    assert!((3.8e-4..4.0e-4).contains(&soft) && (3.9..4.1).contains(&(soft / stiff)), "{soft:e} rad, {stiff:e} rad");
}

#[test]
fn flanks_in_play_meet_push_and_do_not_pull() {
    const PLAY: f64 = 2e-3;
    let (arm, inertia) = rod(0.3);
    let springs = Elasticity { backlash: Some([PLAY]), ..springs(500.0, 5.0) };
    let [state, moved] = [0.0, 1.0].map(|qd| State { q: [0.0], qd: [qd] });
    let torque = |twist: f64, motor: &State<1>| springs.torques(&State { q: [twist], ..*motor }, &state)[0];
    assert_eq!(torque(0.9e-3, &moved), 0.0);
    assert!((torque(3e-3, &state) - 1.0).abs() < 1e-12 && (torque(-3e-3, &state) + 1.0).abs() < 1e-12);
    assert!((torque(3e-3, &moved) - 6.0).abs() < 1e-12);
    // A motor that moves away reduces the torque on the flank, but not below zero.
    assert_eq!(torque(-3e-3, &moved), 0.0);
    // The link is at rest until the motor has crossed half of the backlash. Then it moves with the motor: with 3 N m at J + D, minus the torque that
    // accelerates D.
    let mut plant = plant(&arm, springs, 8, [0.4]);
    let mut crossed = 0;
    while twist(&plant, 0) < 0.45 * PLAY {
        plant.drive(&[3.0]).unwrap();
        if twist(&plant, 0) < 0.5 * PLAY {
            assert_eq!(plant.state().q[0], 0.4);
        }
        crossed += 1;
    }
    // 1 mm rad at 10 rad/s^2: 14 ms.
    assert!((12..=15).contains(&crossed), "{crossed} ticks");
    for _ in 0..2000 {
        plant.drive(&[3.0]).unwrap();
    }
    let carried = 3.0 * inertia / (inertia + 0.3);
    let wanted = 0.5 * PLAY + carried / 500.0;
    assert!((twist(&plant, 0) / wanted - 1.0).abs() < 1e-3, "{} and {wanted}", twist(&plant, 0));
}

#[test]
fn an_elastic_arm_starts_where_its_springs_hold_it_and_stops_on_both_sides() {
    let arm = rods(0.3);
    let start = [0.3, 0.5];
    let weight = arm.terms(&start, &[0.0; 2]).gravity;
    let springs = Elasticity { backlash: Some([1e-3; 2]), ..springs(500.0, 1.0) };
    let mut plant = plant(&arm, springs, 4, start);
    for i in 0..2 {
        assert!((twist(&plant, i) - weight[i] / 500.0 - 0.5e-3).abs() < 1e-12);
    }
    // Motors with exactly that torque keep the arm there.
    for _ in 0..200 {
        plant.drive(&weight).unwrap();
    }
    assert!((0..2).all(|i| (plant.state().q[i] - start[i]).abs() < 1e-9), "{:?}", plant.state());
    (0..100).for_each(|_| plant.drive(&[0.0; 2]).unwrap());
    (0..100).for_each(|_| plant.brake());
    let (link, motor) = (*plant.state(), *plant.motors().unwrap());
    assert!(link.qd.iter().chain(&motor.qd).all(|qd| qd.abs() < 1e-12));
    plant.brake();
    assert_eq!((*plant.state(), *plant.motors().unwrap()), (link, motor));
    assert_eq!(plant.measured(), &motor);
}
