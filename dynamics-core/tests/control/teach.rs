//! An arm that is led by hand: where it is let go it stays, friction is made up for, and walls and speed are soft.

use crate::control::support::{by_hand, config, controller, driven, measured};
use dynamics_core::control::{Friction, Law, Teach};
use dynamics_core::{ControllerConfig, Reference};
use proptest::prelude::*;

const TEACH: Teach<f64> = Teach {
    friction: 0.24,
    per_still_speed: 20.0,
    breakaway: 0.4,
    slip: 0.4 / 40.0,
    drag: 0.1,
    speed: 1.5,
    wall: (-1.8, 2.2),
    stiffness: 40.0,
    damping: 4.0,
};

/// Torque of a joint whose anchor is where it is.
fn at(q: f64, qd: f64) -> f64 {
    TEACH.torque(q, qd, &mut q.clone())
}

#[test]
fn where_it_is_let_go_it_hangs_on_a_spring_that_yields_and_comes_along() {
    let mut anchor = 0.5;
    assert_eq!(TEACH.torque(0.5, 0.0, &mut anchor), 0.0);
    assert_eq!(TEACH.torque(0.504, 0.0, &mut anchor), -40.0 * (0.504 - 0.5));
    assert_eq!(anchor, 0.5, "inside its reach the anchor stays");
    assert!((TEACH.torque(0.6, 0.0, &mut anchor) + 0.4).abs() < 1e-12);
    assert!((anchor - 0.59).abs() < 1e-12, "beyond, it comes along: {anchor}");
    // Damped as the spring is, and together no stronger than what breaks it away.
    assert!((at(0.5, 0.02) + 0.6 * 0.0 + 4.0 * 0.02 + 0.1 * 0.02).abs() < 1e-12);
    assert!((TEACH.torque(0.6, 0.04, &mut 0.0) + 0.4 + 0.1 * 0.04).abs() < 1e-12);
}

#[test]
fn moved_by_the_hand_friction_is_made_up_for_and_nothing_keeps_it() {
    for qd in [0.1, 0.7, 1.5] {
        for sign in [-1.0, 1.0] {
            let torque = TEACH.torque(0.5, sign * qd, &mut 0.0);
            assert!((torque - sign * (0.24 - 0.1 * qd)).abs() < 1e-12, "{qd}: {torque}");
        }
    }
    // Between, half of each: the still speed is 0.05 rad/s.
    let half = TEACH.torque(0.5, 0.075, &mut 0.0);
    assert!((half - (0.5 * 0.24 - 0.5 * 0.4 - 0.1 * 0.075)).abs() < 1e-12, "{half}");
}

#[test]
fn a_wall_pushes_back_and_swallows_the_bounce_and_too_fast_is_braked() {
    assert!((at(2.3, 0.0) + 40.0 * 0.1).abs() < 1e-12);
    assert!((at(-1.9, 0.0) - 40.0 * 0.1).abs() < 1e-12);
    let (moving, out) = (0.24 - 0.1, 4.0);
    assert!((at(2.3, -1.0) - (-4.0 - moving + out)).abs() < 1e-12, "{}", at(2.3, -1.0));
    assert!((at(0.0, 2.0) - (0.24 - 0.1 * 2.0 - 4.0 * 0.5)).abs() < 1e-12);
}

proptest! {
    #[test]
    fn it_never_adds_more_power_than_friction_takes(q in -3.0..3.0_f64, qd in -5.0..5.0_f64, anchor in -3.0..3.0_f64) {
        // Springs give back what they took: at rest in them they are left out.
        let q = q.clamp(-1.8, 2.2);
        let torque = TEACH.torque(q, qd, &mut anchor.clone());
        prop_assert!(torque * qd <= (0.24 + 0.4) * qd.abs());
        if (qd / 0.05).abs() >= 2.0 {
            prop_assert!(torque * qd <= 0.24 * qd.abs());
        }
    }

    #[test]
    fn it_has_no_side(q in -1.8..1.8_f64, qd in -5.0..5.0_f64, anchor in -3.0..3.0_f64) {
        let (mut one, mut other) = (anchor, -anchor);
        prop_assert_eq!(TEACH.torque(q, qd, &mut one), -TEACH.torque(-q, -qd, &mut other));
        prop_assert_eq!(one, -other);
    }

    #[test]
    fn a_nan_stays_one(q in -3.0..3.0_f64) {
        prop_assert!(TEACH.torque(f64::NAN, q, &mut 0.0).is_nan());
        prop_assert!(TEACH.torque(q, f64::NAN, &mut 0.0).is_nan());
    }
}

const FAR: Reference<f64, 2> = Reference { q: [0.4, -1.1], qd: [0.8, 0.3], qdd: [-1.5, 2.5] };
const Q: [f64; 2] = [0.35, -1.02];
const QD: [f64; 2] = [0.9, 0.2];

fn led() -> ControllerConfig<f64, 2> {
    let friction = [Friction { viscous: 0.7, coulomb: 3.0, per_smoothing_speed: 100.0 }; 2];
    ControllerConfig { teach: Some([TEACH; 2]), friction: Some(friction), ..config(Law::Teach) }
}

#[test]
fn a_led_arm_follows_no_reference_and_its_weight_is_carried() {
    let (torque, _) = driven(controller(led()).tick(&FAR, &measured(Q, QD)));
    let weight = by_hand(Q, [0.0; 2], [0.0; 2]);
    for i in 0..2 {
        let expected = weight[i] + at(Q[i], QD[i]);
        assert!((torque[i] - expected).abs() < 1e-12, "{torque:?}, {expected}");
    }
    // Not a bit of it depends on the reference.
    let other = Reference { q: [-0.3, 0.2], qd: [0.0, -2.0], qdd: [9.0, 9.0] };
    assert_eq!(driven(controller(led()).tick(&other, &measured(Q, QD))).0, torque);
}

#[test]
fn without_a_feel_of_its_own_it_is_weightless() {
    let (torque, _) = driven(controller(config(Law::Teach)).tick(&FAR, &measured(Q, QD)));
    let weight = by_hand(Q, [0.0; 2], [0.0; 2]);
    assert!((torque[0] - weight[0]).abs().max((torque[1] - weight[1]).abs()) < 1e-12);
}
