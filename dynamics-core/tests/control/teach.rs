//! A hand-guided arm: it stays where it is released, friction is compensated, and walls and speed limit are soft.

use crate::control::support::{by_hand, config, controller, driven, measured};
use dynamics_core::control::{ControlLaw, Controller, Encoder, Friction, Gains, Guard, Teach, TrackingObserver};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::trig::Libm;
use dynamics_core::{ControllerConfig, Limits, Live, Reference, SinCos, Trig as _};
use proptest::prelude::*;

const TEACH: Teach<f64> = Teach {
    friction: 0.24,
    per_still_speed: 20.0,
    breakaway: 0.4,
    slip: 0.4 / 40.0,
    drag: 0.1,
    speed: 1.5,
    wall: (-1.8, 2.2),
    per_wall: 5.0,
    stiffness: 40.0,
    damping: 4.0,
    slowing: 0.0,
};

/// Torque of a free joint.
fn free(q: f64, qd: f64) -> f64 {
    TEACH.torque(q, qd, &mut None)
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 1e-12
}

#[test]
fn where_it_is_kept_it_hangs_on_a_spring_that_yields_and_comes_along() {
    let mut anchor = Some(0.5);
    assert_eq!(TEACH.torque(0.5, 0.0, &mut anchor), 0.0);
    assert!(near(TEACH.torque(0.504, 0.0, &mut anchor), -40.0 * 0.004));
    assert!(near(anchor.unwrap(), 0.5), "inside its reach the anchor stays: {anchor:?}");
    // Spring and damper are together limited to the breakaway torque; the drag is added.
    assert!(near(TEACH.torque(0.504, 0.01, &mut anchor), -(40.0 * 0.004 + 4.0 * 0.01) - 0.1 * 0.01));
    assert!(near(TEACH.torque(0.508, 0.09, &mut anchor), -0.4 - 0.1 * 0.09));
    // Pulled away slowly, the joint follows, and does not return.
    assert!(near(TEACH.torque(0.6, 0.0, &mut anchor), -0.4));
    assert!(near(anchor.unwrap(), 0.59), "{anchor:?}");
}

#[test]
fn a_hand_breaks_it_away_and_it_is_kept_again_where_it_comes_to_rest() {
    // The still speed is 0.05 rad/s. A joint that is fast and near, or far and slow, is kept.
    for (q, qd) in [(0.509, 0.2), (0.6, 0.09)] {
        let mut anchor = Some(0.5);
        TEACH.torque(q, qd, &mut anchor);
        assert!(anchor.is_some(), "at {q}, {qd} rad/s");
    }
    let mut anchor = Some(0.5);
    TEACH.torque(0.52, 0.11, &mut anchor);
    assert_eq!(anchor, None);
    // Between once and twice the still speed the state does not change; the friction compensation fades over the same range.
    assert!(near(TEACH.torque(0.53, 0.075, &mut anchor), 0.5 * 0.24 - 0.1 * 0.075));
    assert_eq!(anchor, None);
    assert!(near(TEACH.torque(0.54, 0.04, &mut anchor), -0.1 * 0.04));
    assert_eq!(anchor, Some(0.54));
}

#[test]
fn moved_by_the_hand_friction_is_made_up_for_and_nothing_keeps_it() {
    for qd in [0.1, 0.7, 1.5] {
        for sign in [-1.0, 1.0] {
            let torque = free(0.5, sign * qd);
            assert!(near(torque, sign * (0.24 - 0.1 * qd)), "{qd}: {torque}");
        }
    }
}

#[test]
fn a_wall_pushes_back_and_swallows_the_bounce_and_too_fast_is_braked() {
    assert!(near(free(2.3, 0.0), -40.0 * 0.1 * 0.55));
    assert!(near(free(-1.9, 0.0), 40.0 * 0.1 * 0.55));
    // Into the wall the whole stiffness acts, and at half the wall's depth half of the damper.
    // Out of it, a tenth of the stiffness and the whole damper.
    let moving = 0.24 - 0.1;
    assert!(near(free(2.3, 1.0), -4.0 + moving - 0.5 * 4.0), "{}", free(2.3, 1.0));
    assert!(near(free(2.3, -1.0), -0.4 - moving + 4.0), "{}", free(2.3, -1.0));
    assert!(near(free(0.0, 2.0), 0.24 - 0.1 * 2.0 - 4.0 * 0.5));
}

proptest! {
    #[test]
    fn let_go_it_adds_no_more_power_than_friction_takes(q in -1.8..2.2_f64, qd in -5.0..5.0_f64) {
        prop_assert!(free(q, qd) * qd <= 0.24 * qd.abs());
    }

    #[test]
    fn what_keeps_it_is_bounded(q in -1.8..2.2_f64, qd in -1.5..1.5_f64, anchor in -3.0..3.0_f64) {
        let torque = TEACH.torque(q, qd, &mut Some(anchor));
        prop_assert!((torque + 0.1 * qd).abs() <= 0.4 + 1e-12);
    }

    #[test]
    fn it_has_no_side(q in -1.8..1.8_f64, qd in -5.0..5.0_f64, anchor in proptest::option::of(-3.0..3.0_f64)) {
        let (mut one, mut other) = (anchor, anchor.map(|anchor| -anchor));
        prop_assert_eq!(TEACH.torque(q, qd, &mut one), -TEACH.torque(-q, -qd, &mut other));
        prop_assert_eq!(one, other.map(|other| -other));
    }

    #[test]
    fn a_nan_stays_one(q in -3.0..3.0_f64, anchor in proptest::option::of(-3.0..3.0_f64)) {
        prop_assert!(TEACH.torque(f64::NAN, q, &mut anchor.clone()).is_nan());
        prop_assert!(TEACH.torque(q, f64::NAN, &mut anchor.clone()).is_nan());
    }
}

/// A pendulum whose inertia about its axis changes with its posture: 1 to 3 kg m^2.
#[derive(Clone, Copy)]
struct Folding;

impl Folding {
    fn inertia(q: f64) -> f64 {
        2.0 + q.cos()
    }
}

impl InverseDynamics<f64, 1> for Folding {
    fn inverse_dynamics(
        &self,
        _: &[SinCos<f64>; 1],
        q: &[f64; 1],
        qd: &[f64; 1],
        qdd: &[f64; 1],
        _: &Live<f64, 1>,
    ) -> [f64; 1] {
        [Self::inertia(q[0]) * qdd[0] - 0.5 * q[0].sin() * qd[0] * qd[0] + 20.0 * q[0].cos()]
    }
}

/// Pushes a joint to `speed` at `q` and releases it, under the law for `ticks` of 1 ms. Returns its positions.
fn let_go(teach: Teach<f64>, friction: f64, q: f64, speed: f64, ticks: u32) -> Vec<f64> {
    let config = ControllerConfig {
        law: ControlLaw::Teach,
        gains: [Gains::new(20.0, 1.0, 2.0)],
        friction: None,
        limits: [Limits::none()],
        torque_step: [f64::INFINITY],
        guard: [Guard { position_margin: f64::INFINITY, velocity_max: f64::INFINITY }],
        age_max: 0,
        encoder: [Encoder { zero: 0, per_count: 0.0 }],
        observer: TrackingObserver::new(500.0, 1e-3),
        integral: None,
        teach: Some([teach]),
        posture_damping: None,
    };
    let mut controller = Controller::new(config, Folding, Libm);
    let (mut q, mut qd) = (q, speed);
    // The hand has exceeded the breakaway torque.
    driven(controller.tick(&Reference::at_rest([q - 1.0]), &measured([q - 1.0], [speed])));
    let mut way = vec![q];
    for _ in 0..ticks {
        let (torque, _) = driven(controller.tick(&Reference::at_rest([q]), &measured([q], [qd])));
        for _ in 0..10 {
            let dry = friction * (qd / 1e-3).clamp(-1.0, 1.0);
            let own = Folding.inverse_dynamics(&Libm.sin_cos_all(&[q]), &[q], &[qd], &[0.0], &Live::zero())[0];
            qd += 1e-4 * (torque[0] - dry - own) / Folding::inertia(q);
            q += 1e-4 * qd;
        }
        way.push(q);
    }
    way
}

/// Settings as a scene would have them: still below 40 mrad/s, 0.1 rad of wall, stiffness and damping of the gains above.
const FEEL: Teach<f64> = Teach {
    friction: 0.8 * 0.6,
    per_still_speed: 25.0,
    breakaway: 0.6,
    slip: 0.6 / 800.0,
    drag: 0.1,
    speed: 1.5,
    wall: (-1.9, 1.9),
    per_wall: 10.0,
    stiffness: 800.0,
    damping: 80.0,
    slowing: 1.5 / 0.085,
};

#[test]
fn let_go_at_the_greatest_speed_it_coasts_a_tenth_of_a_radian_at_most_in_every_posture() {
    for friction in [0.0, 0.6] {
        let teach = Teach { friction: 0.8 * friction, ..FEEL };
        for step in -18..=18 {
            for speed in [-1.5, -0.7, 0.7, 1.5] {
                let q = f64::from(step) * 0.1;
                let way = let_go(teach, friction, q, speed, 1500);
                let coasted = way.iter().map(|x| (x - q).abs()).fold(0.0, f64::max);
                assert!(coasted <= 0.1, "{coasted} rad from {q} at {speed} rad/s, friction {friction}");
                // The joint does not come back.
                let back = way.iter().map(|x| (x - q) * speed.signum()).fold((0.0_f64, 0.0_f64), |(far, back), x| {
                    let far = far.max(x);
                    (far, back.max(far - x))
                });
                assert!(back.1 <= 0.02, "{} rad back from {q} at {speed} rad/s", back.1);
            }
        }
    }
}

#[test]
fn run_into_a_wall_it_stops_there() {
    for (q, speed) in [(1.88, 1.5), (1.85, 1.0), (-1.88, -1.5)] {
        let way = let_go(FEEL, 0.6, q, speed, 3000);
        let far = way.iter().map(|x| x.abs()).fold(0.0, f64::max);
        let back = way.iter().fold((0.0_f64, 0.0_f64), |(far, back), x| (far.max(x.abs()), back.max(far - x.abs())));
        assert!(far < 2.0, "through the wall, to {far}");
        // The soft wall pushes back slowly, which is not a rebound.
        assert!(back.1 <= 0.03, "{} rad back", back.1);
        let out = way.windows(2).map(|x| (x[0].abs() - x[1].abs()) / 1e-3).fold(0.0, f64::max);
        assert!(out <= 0.04, "{out} rad/s back");
    }
}

const FAR: Reference<f64, 2> = Reference { q: [0.4, -1.1], qd: [0.8, 0.3], qdd: [-1.5, 2.5] };
const Q: [f64; 2] = [0.35, -1.02];
const QD: [f64; 2] = [0.9, 0.2];

fn led() -> ControllerConfig<f64, 2> {
    let friction = [Friction { viscous: 0.7, coulomb: 3.0, per_smoothing_speed: 100.0 }; 2];
    ControllerConfig { teach: Some([TEACH; 2]), friction: Some(friction), ..config(ControlLaw::Teach) }
}

#[test]
fn a_led_arm_follows_no_reference_and_its_weight_is_carried() {
    let (torque, _) = driven(controller(led()).tick(&FAR, &measured(Q, QD)));
    let weight = by_hand(Q, [0.0; 2], [0.0; 2]);
    for i in 0..2 {
        let expected = weight[i] + free(Q[i], QD[i]);
        assert!((torque[i] - expected).abs() < 1e-12, "{torque:?}, {expected}");
    }
    // No bit of the result depends on the reference.
    let other = Reference { q: [-0.3, 0.2], qd: [0.0, -2.0], qdd: [9.0, 9.0] };
    assert_eq!(driven(controller(led()).tick(&other, &measured(Q, QD))).0, torque);
}

#[test]
fn without_a_feel_of_its_own_it_is_weightless() {
    let (torque, _) = driven(controller(config(ControlLaw::Teach)).tick(&FAR, &measured(Q, QD)));
    let weight = by_hand(Q, [0.0; 2], [0.0; 2]);
    assert!((torque[0] - weight[0]).abs().max((torque[1] - weight[1]).abs()) < 1e-12);
}
