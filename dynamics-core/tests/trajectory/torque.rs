//! Time scaling to torque limits.

use crate::trajectory::support::moments;
use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, Timing, TorqueLimits, Waypoint};
use dynamics_core::trig::Libm;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};

fn arm(gravity: f64) -> Dynamics<f64, 2> {
    let joint = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: 0.5, ..Dh::default() }),
        body: Body { mass: 2.0, com: Vector3::new(-0.25, 0.0, 0.0), inertia: Matrix3::from_diagonal_element(0.04) },
        rotor: Rotor { inertia: 1e-4, gear: 50.0 },
        limits: Limits::none(),
    };
    let model = Model::new(&[joint, joint], &Tool::default()).unwrap();
    Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -gravity, 0.0), &model))
}

fn motion() -> Motion<f64, 2> {
    let points = [[-1.2, 0.3], [0.1, 1.0], [0.8, -0.4]].map(Waypoint::through);
    Motion::quintic(&points, Timing::Durations(&[0.4, 0.5]), &Bounds::none()).unwrap()
}

/// Largest share of its torque limit that the motion uses, by sampling.
fn used(motion: &Motion<f64, 2>, arm: &Dynamics<f64, 2>, limits: [f64; 2], samples: u32) -> f64 {
    moments(motion.duration(), samples).fold(0.0, |most: f64, t| {
        let r = motion.sample(t);
        let torque = arm.inverse_dynamics(&Libm.sin_cos_all(&r.q), &r.q, &r.qd, &r.qdd, &Live::zero());
        most.max(torque[0].abs() / limits[0]).max(torque[1].abs() / limits[1])
    })
}

#[test]
fn a_scaled_motion_uses_its_torque_limit_and_no_more() {
    for (gravity, torque) in [(0.0, [8.0, 3.0]), (9.81, [26.0, 7.0]), (9.81, [300.0, 200.0])] {
        let (arm, motion) = (arm(gravity), motion());
        let limits = TorqueLimits { torque, steps: 500 };
        let k = motion.torque_scale(&arm, &Libm, &Live::zero(), &limits).unwrap();
        let scaled = motion.stretched(k).unwrap();
        let at_the_samples = used(&scaled, &arm, torque, 500);
        assert!((at_the_samples - 1.0).abs() < 1e-9, "{at_the_samples}");
        let between = used(&scaled, &arm, torque, 50_000);
        assert!((1.0 - 1e-9..1.002).contains(&between), "{between}");
    }
}

#[test]
fn slowing_to_torque_leaves_alone_what_is_slow_enough() {
    let (arm, motion) = (arm(9.81), motion());
    let generous = TorqueLimits { torque: [300.0, 200.0], steps: 500 };
    assert!(motion.torque_scale(&arm, &Libm, &Live::zero(), &generous).unwrap() < 1.0);
    assert_eq!(motion.scale_to_torque(&arm, &Libm, &Live::zero(), &generous).unwrap(), motion);
    let tight = TorqueLimits { torque: [26.0, 7.0], steps: 500 };
    assert!(used(&motion, &arm, tight.torque, 500) > 1.5, "it needs slowing");
    let slowed = motion.scale_to_torque(&arm, &Libm, &Live::zero(), &tight).unwrap();
    assert!((0.999..=1.0).contains(&used(&slowed, &arm, tight.torque, 500)));
}

#[test]
fn without_gravity_the_factor_is_the_root_of_the_torque_ratio() {
    let (arm, motion) = (arm(0.0), motion());
    let torque = [5.0, 1.5];
    let k = motion.torque_scale(&arm, &Libm, &Live::zero(), &TorqueLimits { torque, steps: 300 }).unwrap();
    assert!((k - used(&motion, &arm, torque, 300).sqrt()).abs() < 1e-12);
}

#[test]
fn where_holding_still_takes_the_whole_limit_no_time_is_enough() {
    let limits = TorqueLimits { torque: [10.0, 7.0], steps: 100 };
    let error = motion().torque_scale(&arm(9.81), &Libm, &Live::zero(), &limits).unwrap_err();
    let MotionError::TorqueTooSmall { joint: 0, holding, limit, .. } = error else { panic!("{error}") };
    assert!(holding.abs() >= 10.0 && limit == 10.0);
}

#[test]
fn limits_and_steps_that_cannot_be_are_refused() {
    let scale =
        |torque, steps| motion().torque_scale(&arm(9.81), &Libm, &Live::zero(), &TorqueLimits { torque, steps });
    for bad in [0.0, -1.0, f64::NAN] {
        assert_eq!(scale([50.0, bad], 10), Err(MotionError::BadBound { what: "torque", joint: 1 }));
    }
    for steps in [0, u32::MAX] {
        assert!(matches!(scale([50.0; 2], steps), Err(MotionError::OutOfRange { what: "number of steps", .. })));
    }
    assert_eq!(scale([f64::INFINITY; 2], 10), Ok(0.0));
    let mut live = Live::zero();
    live.gravity.y = f64::NAN;
    let arm = arm(9.81);
    let nan = Dynamics::new(*arm.model(), Scene { gravity: dynamics_core::Term::Live, ..*arm.scene() });
    let limits = TorqueLimits { torque: [50.0; 2], steps: 10 };
    assert_eq!(
        motion().torque_scale(&nan, &Libm, &live, &limits),
        Err(MotionError::TorqueNotFinite { joint: 0, time: 0.0 })
    );
}
