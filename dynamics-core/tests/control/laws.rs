//! Each law compared with its formula, on an arm with dynamics written out by hand.

use crate::control::support::{Desk, UnitMasses, by_hand, config, controller, driven, measured};
use dynamics_core::control::{ControlLaw, Gains, Spring};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::{
    Body, Controller, ControllerConfig, Dh, Dynamics, Frame, JointKind, JointSpec, Limits, Live, Model, Reference,
    Rotor, Scene, Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};

const LAWS: [ControlLaw; 8] = ControlLaw::ALL;

const REFERENCE: Reference<f64, 2> = Reference { q: [0.4, -1.1], qd: [0.8, 0.3], qdd: [-1.5, 2.5] };
const Q: [f64; 2] = [0.35, -1.02];
const QD: [f64; 2] = [0.9, 0.1];

/// `Kd (qd_ref - qd) + Kp (q_ref - q)`, with gains computed from natural frequency and damping by hand.
fn spring() -> [f64; 2] {
    [0, 1].map(|i| {
        let omega = [20.0, 25.0][i];
        2.0 * 0.9 * omega * (REFERENCE.qd[i] - QD[i]) + omega * omega * (REFERENCE.q[i] - Q[i])
    })
}

fn expected(law: ControlLaw) -> [f64; 2] {
    let spring = spring();
    let pd = [1.5 * spring[0], 1.3 * spring[1]];
    let plus = |model: [f64; 2]| [model[0] + pd[0], model[1] + pd[1]];
    match law {
        ControlLaw::ComputedTorque => by_hand(Q, QD, [REFERENCE.qdd[0] + spring[0], REFERENCE.qdd[1] + spring[1]]),
        ControlLaw::Pd => pd,
        ControlLaw::PdGravity => plus(by_hand(Q, [0.0; 2], [0.0; 2])),
        ControlLaw::DiagonalInertia => {
            let [a, b] = plus(by_hand(Q, [0.0; 2], [0.0; 2]));
            [a + 1.5 * REFERENCE.qdd[0], b + 1.3 * REFERENCE.qdd[1]]
        }
        ControlLaw::Feedforward => plus(by_hand(REFERENCE.q, REFERENCE.qd, REFERENCE.qdd)),
        // Both are the same within a tick; the drives act only between two ticks.
        ControlLaw::Impedance | ControlLaw::Split => plus(by_hand(Q, QD, REFERENCE.qdd)),
        ControlLaw::Teach => by_hand(Q, [0.0; 2], [0.0; 2]),
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

#[test]
fn every_law_gives_the_torque_of_its_formula() {
    for law in LAWS {
        let (torque, _) = driven(controller(config(law)).tick(&REFERENCE, &measured(Q, QD)));
        let error = distance(torque, expected(law));
        assert!(error < 1e-12, "{law:?}: {torque:?}, by hand {:?}", expected(law));
    }
}

#[test]
fn at_this_state_no_two_laws_could_be_mistaken_for_each_other() {
    for (i, a) in LAWS.into_iter().enumerate() {
        for b in LAWS[..i].iter().filter(|b| (a, **b) != (ControlLaw::Split, ControlLaw::Impedance)) {
            assert!(distance(expected(a), expected(*b)) > 0.1, "{a:?} and {b:?}");
        }
    }
}

#[test]
fn damping_by_the_posture_goes_through_the_model_by_its_share() {
    for law in [ControlLaw::Impedance, ControlLaw::Split] {
        let with = |share| {
            let config = ControllerConfig { posture_damping: Some(share), ..config(law) };
            driven(controller(config).tick(&REFERENCE, &measured(Q, QD))).0
        };
        let damper = [0, 1].map(|i| 2.0 * 0.9 * [20.0, 25.0][i] * (REFERENCE.qd[i] - QD[i]));
        for share in [0.0, 0.5, 1.0] {
            let model = by_hand(Q, QD, [0, 1].map(|i| REFERENCE.qdd[i] + share * damper[i]));
            let expected = [0, 1].map(|i| model[i] + [1.5, 1.3][i] * (spring()[i] - share * damper[i]));
            assert!(
                distance(with(share), expected) < 1e-12,
                "{law:?} {share}: {:?}, by hand {expected:?}",
                with(share)
            );
        }
        assert_eq!(with(0.0), driven(controller(config(law)).tick(&REFERENCE, &measured(Q, QD))).0);
    }
}

#[test]
fn a_law_is_found_by_its_number_and_its_gains_are_a_spring() {
    for (number, law) in ControlLaw::ALL.into_iter().enumerate() {
        assert_eq!(usize::from(law.code()), number, "{law:?}");
    }
    let spring = Gains::<f64>::new(20.0, 0.9, 1.5).spring();
    assert_eq!(spring, Spring { stiffness: 1.5 * 400.0, damping: 1.5 * 36.0 });
}

#[test]
fn a_model_law_asks_for_inverse_dynamics_once_a_tick_and_pd_never() {
    for law in LAWS {
        let calls = u32::from(law != ControlLaw::Pd);
        let mut controller = Controller::new(config::<2>(law), UnitMasses::default(), Desk);
        for ticks in 1..=5 {
            driven(controller.tick(&REFERENCE, &measured(Q, QD)));
            assert_eq!(controller.dynamics_mut().calls.get(), calls * ticks, "{law:?}");
        }
    }
}

/// Three rails at right angles, the first along z: nothing turns, so the inertia is diagonal: the masses moved.
fn cartesian() -> Dynamics<f64, 3> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let turned = [(0.0, quarter), (quarter, quarter), (0.0, 0.0)];
    let joints = [0, 1, 2].map(|i| JointSpec {
        kind: JointKind::Prismatic,
        frame: Frame::ClassicalDh(Dh { theta: turned[i].0, alpha: turned[i].1, ..Dh::default() }),
        body: Body {
            mass: [4.0, 2.5, 1.5][i],
            com: Vector3::new(0.03, -0.02, 0.01),
            inertia: Matrix3::from_diagonal_element(0.02),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    });
    let model = Model::new(&joints, &Tool::default()).unwrap();
    Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, 3.0, -9.81), &model))
}

#[test]
fn on_an_arm_whose_inertia_is_a_constant_diagonal_it_is_computed_torque() {
    let arm = cartesian();
    let mass = mass_matrix(&arm, &Desk.sin_cos_all(&[0.0; 3]), &[0.0; 3], &Live::zero());
    for (i, moved) in [8.0, 4.0, 1.5].into_iter().enumerate() {
        assert!((mass[(i, i)] - moved).abs() < 1e-12, "{mass}");
    }
    let torque = |law| {
        let mut settings = config::<3>(law);
        for (gains, inertia) in settings.gains.iter_mut().zip(mass.diagonal().iter()) {
            gains.inertia = *inertia;
        }
        let reference = Reference { q: [0.4, -0.3, 0.2], qd: [0.8, 0.3, -0.5], qdd: [-1.5, 2.5, 4.0] };
        driven(Controller::new(settings, arm, Desk).tick(&reference, &measured([0.35, -0.28, 0.23], [0.9, 0.1, -0.4])))
            .0
    };
    let (whole, diagonal) = (torque(ControlLaw::ComputedTorque), torque(ControlLaw::DiagonalInertia));
    for i in 0..3 {
        assert!((whole[i] - diagonal[i]).abs() < 1e-12 * whole[i].abs(), "{whole:?} and {diagonal:?}");
        // The test is not vacuous: without the reference acceleration the torque would be different.
        assert!((whole[i] - torque(ControlLaw::PdGravity)[i]).abs() > 1.0);
    }
}

#[test]
fn a_latched_fault_asks_for_nothing() {
    let mut controller = Controller::new(config::<2>(ControlLaw::ComputedTorque), UnitMasses::default(), Desk);
    controller.overrun();
    for _ in 0..3 {
        controller.tick(&REFERENCE, &measured(Q, QD));
    }
    assert_eq!(controller.dynamics_mut().calls.get(), 0);
}

#[test]
fn with_an_exact_model_the_error_is_a_damped_spring() {
    // Unit masses: acceleration is torque. The error of a critically damped joint released at distance 1 is
    // (1 + omega t) exp(-omega t).
    let omega: f64 = 10.0;
    let mut settings = config::<1>(ControlLaw::ComputedTorque);
    settings.gains = [dynamics_core::control::Gains::new(omega, 1.0, 1.0)];
    let mut controller = Controller::new(settings, UnitMasses::default(), Desk);
    let (h, mut q, mut qd) = (1e-4, 1.0, 0.0);
    for tick in 0..5000 {
        let t = f64::from(tick) * h;
        let exact = (1.0 + omega * t) * (-omega * t).exp();
        assert!((q - exact).abs() < 1e-3, "at {t} s: {q}, exactly {exact}");
        let (torque, _) = driven(controller.tick(&Reference::at_rest([0.0]), &measured([q], [qd])));
        q += h * qd + 0.5 * h * h * torque[0];
        qd += h * torque[0];
    }
}

#[test]
fn live_inputs_reach_the_dynamics() {
    use dynamics_core::Term;
    let arm = crate::control::support::planar();
    let scene = Scene { gravity: Term::Live, ..*arm.scene() };
    let mut controller = Controller::new(config(ControlLaw::ComputedTorque), Dynamics::new(*arm.model(), scene), Desk);
    let still = Reference::at_rest(Q);
    let (weightless, _) = driven(controller.tick(&still, &measured(Q, [0.0; 2])));
    assert!(distance(weightless, [0.0; 2]) < 1e-15);
    *controller.live_mut() = Live { gravity: nalgebra::Vector3::new(0.0, -9.81, 0.0), ..Live::zero() };
    let (holding, _) = driven(controller.tick(&still, &measured(Q, [0.0; 2])));
    assert!(distance(holding, by_hand(Q, [0.0; 2], [0.0; 2])) < 1e-12);
}
