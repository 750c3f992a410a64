//! A tick is total: for any bits of its input, it drives finite torques within their limits, or brakes for the correct
//! reason.

use crate::control::support::config;
use dynamics_core::control::{
    CollisionConfig, CollisionReaction, CollisionWatch, ControlLaw, Friction, Guard, LimitFlags, MomentumFilter, Teach,
};
use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Body, Command, Controller, ControllerConfig, Dh, Dynamics, Fault, Frame, JointKind, JointSpec, Limits, Measurement,
    Model, Reference, Rotor, Scene, Sensed, Tool,
};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::{Just, Strategy, any, prop_assert, prop_assert_eq, prop_oneof};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::cell::RefCell;
use std::collections::BTreeSet;

const TORQUE: f64 = 40.0;
const STEP: f64 = 7.0;

fn arm<const N: usize>() -> Dynamics<f32, N> {
    let joints = core::array::from_fn(|i| JointSpec {
        kind: if i == 2 { JointKind::Prismatic } else { JointKind::Revolute },
        frame: Frame::ClassicalDh(Dh { a: 0.3, alpha: [1.57, -0.4, 0.9][i % 3], d: 0.1, theta: 0.2 }),
        body: Body { mass: 2.0, com: Vector3::new(-0.1, 0.05, 0.02), inertia: Matrix3::from_diagonal_element(3.0) },
        rotor: Rotor { inertia: 1e-5, gear: 100.0 },
        limits: Limits::none(),
    });
    let model: Model<f64, N> = Model::new(&joints, &Tool::default()).unwrap();
    Dynamics::new(model.cast(), Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model).cast())
}

const LED: Teach<f64> = Teach {
    friction: 2.0,
    per_still_speed: 20.0,
    breakaway: 3.0,
    slip: 0.01,
    drag: 0.1,
    speed: 2.0,
    wall: (-1.5, 1.5),
    per_wall: 2.0,
    stiffness: 300.0,
    damping: 30.0,
    slowing: 2.0,
};

fn settings<const N: usize>(law: ControlLaw, friction: bool) -> ControllerConfig<f32, N> {
    let limits = Limits { position: (-2.0, 2.0), velocity: 3.0, torque: TORQUE, torque_rate: 1e3 };
    let settings = ControllerConfig {
        friction: friction.then_some([Friction { viscous: 0.5, coulomb: 2.0, per_smoothing_speed: 20.0 }; N]),
        limits: [limits; N],
        torque_step: [STEP; N],
        guard: [Guard { position_margin: 0.5, velocity_max: 6.0 }; N],
        teach: (law == ControlLaw::Teach).then_some([LED; N]),
        ..config(law)
    };
    settings.cast()
}

/// A collision watch that the states below trigger more often than not, but not always.
fn watch<const N: usize>(reaction: CollisionReaction) -> CollisionWatch<f32, N, Dynamics<f32, N>> {
    let config = CollisionConfig {
        filter: MomentumFilter::new(5.0, 1e-3),
        threshold: [40.0; N],
        released: [20.0; N],
        ticks: 1,
        release_ticks: 1,
        reaction,
    };
    CollisionWatch::new(config.cast(), arm())
}

/// Any bit pattern, with those at the edges more often than by chance.
fn wild() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => any::<u32>().prop_map(f32::from_bits),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::NEG_INFINITY),
        1 => (1..0x0080_0000_u32).prop_map(f32::from_bits),
        2 => Just(f32::MAX),
        2 => Just(f32::MIN),
        1 => Just(-0.0),
    ]
}

/// Ordinary numbers, with a few replaced by extreme ones.
fn numbers<const N: usize>() -> impl Strategy<Value = [[f32; N]; 5]> {
    let ordinary = proptest::collection::vec(-2.4_f32..2.4, 5 * N);
    let wild = prop_oneof![
        2 => Just(Vec::new()),
        2 => proptest::collection::vec((0..5 * N, wild()), 1..3),
        1 => proptest::collection::vec((0..5 * N, wild()), 5 * N),
    ];
    (ordinary, wild).prop_map(|(mut all, wild)| {
        for (place, value) in wild {
            all[place] = value;
        }
        core::array::from_fn(|row| core::array::from_fn(|i| all[row * N + i]))
    })
}

type Tick<const N: usize> = (Reference<f32, N>, Measurement<f32, N>, bool);

fn tick<const N: usize>() -> impl Strategy<Value = Tick<N>> {
    let counts = prop_oneof![-20_000..20_000_i32, any::<i32>()];
    let counts = proptest::option::weighted(0.3, proptest::collection::vec(counts, N));
    let age = prop_oneof![6 => 0..3_u32, 1 => any::<u32>()];
    (numbers::<N>(), counts, age, any::<bool>()).prop_map(|([q, qd, qdd, at, speed], counts, age_ticks, reset)| {
        let sensed = match counts {
            Some(counts) => Sensed::Counts(core::array::from_fn(|i| counts[i])),
            None => Sensed::State { q: at, qd: speed },
        };
        (Reference { q, qd, qdd }, Measurement { sensed, age_ticks }, reset)
    })
}

/// The fault that this input must raise, as far as it follows from the input alone.
fn due<const N: usize>(reference: &Reference<f32, N>, measurement: &Measurement<f32, N>) -> Option<Fault> {
    if measurement.age_ticks > 2 {
        return Some(Fault::StaleMeasurement);
    }
    let first = |bad: &dyn Fn(usize) -> bool| (0..N).find(|&i| bad(i)).map(|i| i as u8);
    let reference_bad = |i: usize| [reference.q[i], reference.qd[i], reference.qdd[i]].iter().any(|x| !x.is_finite());
    if let Some(joint) = first(&reference_bad) {
        return Some(Fault::NonFiniteReference { joint });
    }
    let Sensed::State { q, qd } = measurement.sensed else { return None };
    (0..N).find_map(|i| {
        let joint = i as u8;
        if !(q[i].is_finite() && qd[i].is_finite()) {
            Some(Fault::NonFiniteMeasurement { joint })
        } else if q[i].abs() > 2.5 {
            Some(Fault::PositionOutOfBounds { joint })
        } else if qd[i].abs() > 6.0 {
            Some(Fault::VelocityOutOfBounds { joint })
        } else {
            None
        }
    })
}

fn case<const N: usize>(
    law: ControlLaw,
    friction: bool,
    reaction: Option<CollisionReaction>,
    ticks: &[Tick<N>],
    seen: &RefCell<BTreeSet<u8>>,
) -> Result<(), TestCaseError> {
    let mut controller =
        Controller::new(settings::<N>(law, friction), arm::<N>(), Polynomial).with_protection(reaction.map(watch::<N>));
    let mut last: Option<[f32; N]> = None;
    let mut latched = None;
    let mut age = 0;
    for (reference, measurement, reset) in ticks {
        let command = controller.tick(reference, measurement);
        // A reading whose age has grown by one is the last reading again and is ignored: the joint's motion is predicted.
        let predicted = latched.is_none() && measurement.age_ticks == age + 1 && measurement.age_ticks <= 2;
        if latched.is_none() && measurement.age_ticks <= 2 {
            age = measurement.age_ticks;
        }
        let due = latched.or(match due(reference, measurement) {
            Some(fault) if predicted && fault.code() != 2 => None,
            due => due,
        });
        match command {
            Command::Drive { torque, limits } => {
                if limits.iter().any(|flags| flags.contains(LimitFlags::COLLISION)) {
                    prop_assert!(matches!(reaction, Some(CollisionReaction::Hold | CollisionReaction::Comply)));
                    seen.borrow_mut().insert(100);
                }
                prop_assert_eq!(due, None, "it drives");
                for i in 0..N {
                    prop_assert!(torque[i].is_finite() && torque[i].abs() <= TORQUE as f32, "torque {}", torque[i]);
                    if let Some(last) = last {
                        let change = (torque[i] - last[i]).abs();
                        prop_assert!(change <= STEP as f32 * 1.00001, "torque changes by {}", change);
                    }
                }
                last = Some(torque);
                seen.borrow_mut().insert(0);
            }
            Command::Brake(fault) => {
                if let Some(due) = due {
                    prop_assert_eq!(fault, due);
                } else {
                    // These do not follow from the input alone: finite numbers that give a torque that is not finite, or counts that
                    // mean a position or speed out of bounds.
                    let counted = matches!(measurement.sensed, Sensed::Counts(_));
                    let by_state = matches!(fault.code(), 4 | 5);
                    let collided = fault.code() == 14 && reaction == Some(CollisionReaction::Stop);
                    let foreseen = predicted && matches!(fault.code(), 1 | 4 | 5);
                    prop_assert!(fault.code() == 7 || collided || foreseen || (counted && by_state), "{}", fault);
                }
                seen.borrow_mut().insert(fault.code());
                latched = Some(fault);
                last = None;
            }
        }
        if *reset {
            controller.reset();
            latched = None;
            last = None;
            age = 0;
        }
    }
    Ok(())
}

fn run<const N: usize>() {
    let seen = RefCell::new(BTreeSet::new());
    let law = prop_oneof![
        Just(ControlLaw::ComputedTorque),
        Just(ControlLaw::Pd),
        Just(ControlLaw::PdGravity),
        Just(ControlLaw::DiagonalInertia),
        Just(ControlLaw::Feedforward),
        Just(ControlLaw::Impedance),
        Just(ControlLaw::Teach),
        Just(ControlLaw::Split)
    ];
    let reaction = prop_oneof![
        Just(CollisionReaction::Stop),
        Just(CollisionReaction::Hold),
        Just(CollisionReaction::Comply),
        Just(CollisionReaction::Report)
    ];
    let reaction = proptest::option::of(reaction);
    let input = (law, any::<bool>(), reaction, proptest::collection::vec(tick::<N>(), 1..6));
    let config = Config { cases: 4000, failure_persistence: None, ..Config::default() };
    // The same cases every time, so that their coverage can be asserted below.
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let outcome = runner.run(&input, |(law, friction, reaction, ticks)| case(law, friction, reaction, &ticks, &seen));
    if let Err(failure) = outcome {
        panic!("{N} joints: {failure}");
    }
    // The cases reached torques, torques after a collision (100) and every fault that a tick can raise: the checks above were not vacuous.
    assert_eq!(seen.into_inner().into_iter().collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5, 7, 14, 100], "{N} joints");
}

#[test]
fn a_tick_is_total_with_one_joint() {
    run::<1>();
}

#[test]
fn a_tick_is_total_with_two_joints() {
    run::<2>();
}

#[test]
fn a_tick_is_total_with_three_joints() {
    run::<3>();
}

#[test]
fn a_tick_is_total_with_four_joints() {
    run::<4>();
}

#[test]
fn a_tick_is_total_with_five_joints() {
    run::<5>();
}

#[test]
fn a_tick_is_total_with_six_joints() {
    run::<6>();
}
