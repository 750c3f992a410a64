//! Every physically impossible arm is rejected by name, and a merely unusual arm is accepted.
#![allow(clippy::unwrap_used, reason = "the valid arm must build")]

use dynamics_core::model::{Impossible, Place};
use dynamics_core::{Body, Dh, Frame, JointKind, JointSpec, Limits, Model, ModelError, Rotor, Tool};
use nalgebra::{Matrix3, Vector3};

fn valid() -> JointSpec {
    JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: 0.5, alpha: 0.3, d: 0.1, theta: 0.2 }),
        body: Body { mass: 2.0, com: Vector3::new(-0.2, 0.0, 0.1), inertia: diagonal(0.1, 0.2, 0.25) },
        rotor: Rotor { inertia: 1e-4, gear: 100.0 },
        limits: Limits { position: (-3.0, 3.0), velocity: 2.0, torque: 50.0, torque_rate: 1e3 },
    }
}

fn placed(axis: Vector3<f64>, rotation: Matrix3<f64>) -> JointSpec {
    JointSpec { frame: Frame::Placement { rotation, translation: Vector3::zeros(), axis }, ..valid() }
}

fn diagonal(x: f64, y: f64, z: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(x, y, z))
}

fn refused(second: JointSpec) -> Impossible {
    let ModelError { place, what } = Model::new(&[valid(), second], &Tool::default()).unwrap_err();
    assert_eq!(place, Place::Joint(1));
    what
}

fn with_body(change: impl FnOnce(&mut Body)) -> JointSpec {
    let mut joint = valid();
    change(&mut joint.body);
    joint
}

fn with_limits(change: impl FnOnce(&mut Limits<f64>)) -> JointSpec {
    let mut joint = valid();
    change(&mut joint.limits);
    joint
}

#[test]
fn a_valid_arm_is_accepted() {
    assert!(Model::new(&[valid(), valid()], &Tool::default()).is_ok());
    // Massless links are common in models, point masses are common payloads, and rods are common in textbooks.
    let massless = with_body(|b| *b = Body::massless());
    let point = with_body(|b| b.inertia = Matrix3::zeros());
    let rod = with_body(|b| b.inertia = diagonal(0.0, 0.1, 0.1));
    assert!(Model::new(&[massless, point, rod], &Tool::default()).is_ok());
}

#[test]
fn bodies_that_cannot_be_are_refused() {
    assert_eq!(refused(with_body(|b| b.mass = -1.0)), Impossible::NegativeMass(-1.0));
    assert_eq!(refused(with_body(|b| b.mass = 0.0)), Impossible::InertiaWithoutMass(0.0));
    let negative = refused(with_body(|b| b.inertia = diagonal(-0.1, 0.2, 0.2)));
    assert!(matches!(negative, Impossible::NegativePrincipalMoment(m) if (m + 0.1).abs() < 1e-12), "{negative}");
    let flat = refused(with_body(|b| b.inertia = diagonal(0.1, 0.1, 0.3)));
    assert!(matches!(flat, Impossible::TriangleInequality([a, b, c]) if a + b < c), "{flat}");
    let skewed = refused(with_body(|b| b.inertia[(0, 1)] = 0.01));
    assert!(matches!(skewed, Impossible::AsymmetricInertia(d) if (d - 0.01).abs() < 1e-12), "{skewed}");
}

#[test]
fn an_impossible_inertia_is_found_in_turned_axes_too() {
    let turn = dynamics_core::geometry::from_rpy(0.4, -1.1, 2.0);
    let turned = |m: Matrix3<f64>| with_body(|b| b.inertia = turn * m * turn.transpose());
    assert!(matches!(refused(turned(diagonal(0.1, 0.1, 0.3))), Impossible::TriangleInequality(_)));
    assert!(matches!(refused(turned(diagonal(-0.1, 0.2, 0.25))), Impossible::NegativePrincipalMoment(_)));
    assert!(Model::new(&[turned(diagonal(0.1, 0.2, 0.3))], &Tool::default()).is_ok(), "a flat plate is possible");
}

#[test]
fn numbers_that_are_none_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let not_finite = |joint| assert!(matches!(refused(joint), Impossible::NotFinite(_)));
        not_finite(with_body(|b| b.mass = bad));
        not_finite(with_body(|b| b.com.y = bad));
        not_finite(with_body(|b| b.inertia[(2, 2)] = bad));
        not_finite(JointSpec { frame: Frame::ModifiedDh(Dh { alpha: bad, ..Dh::default() }), ..valid() });
        not_finite(JointSpec { rotor: Rotor { inertia: bad, gear: 1.0 }, ..valid() });
        not_finite(JointSpec { rotor: Rotor { inertia: 1.0, gear: bad }, ..valid() });
        not_finite(placed(Vector3::new(0.0, bad, 0.0), Matrix3::identity()));
        not_finite(placed(Vector3::z(), Matrix3::identity() * bad));
    }
    assert!(matches!(refused(with_limits(|l| l.position.0 = f64::NAN)), Impossible::NotFinite(_)));
    assert!(matches!(refused(with_limits(|l| l.velocity = f64::NAN)), Impossible::NotFinite(_)));
}

#[test]
fn axes_and_rotations_must_be_what_they_say() {
    assert_eq!(refused(placed(Vector3::new(0.0, 0.0, 2.0), Matrix3::identity())), Impossible::NonUnitAxis(2.0));
    assert_eq!(refused(placed(Vector3::zeros(), Matrix3::identity())), Impossible::NonUnitAxis(0.0));
    let mirror = diagonal(1.0, 1.0, -1.0);
    assert!(matches!(refused(placed(Vector3::z(), mirror)), Impossible::NotARotation(d) if d > 1.9));
    assert!(matches!(refused(placed(Vector3::z(), diagonal(1.1, 1.0, 1.0))), Impossible::NotARotation(_)));
}

#[test]
fn limits_the_wrong_way_round_are_refused() {
    assert_eq!(refused(with_limits(|l| l.position = (1.0, -1.0))), Impossible::PositionLimitsReversed(1.0, -1.0));
    assert_eq!(refused(with_limits(|l| l.velocity = 0.0)), Impossible::LimitNotPositive("velocity", 0.0));
    assert_eq!(refused(with_limits(|l| l.torque = -5.0)), Impossible::LimitNotPositive("torque", -5.0));
    assert_eq!(refused(with_limits(|l| l.torque_rate = 0.0)), Impossible::LimitNotPositive("torque rate", 0.0));
    let rotor = JointSpec { rotor: Rotor { inertia: -1e-4, gear: 100.0 }, ..valid() };
    assert_eq!(refused(rotor), Impossible::NegativeRotorInertia(-1e-4));
}

#[test]
fn a_tool_is_checked_as_a_link_is() {
    let tool = Tool { body: Body { mass: -1.0, ..Body::massless() }, ..Tool::default() };
    let error = Model::new(&[valid()], &tool).unwrap_err();
    assert_eq!(error, ModelError { place: Place::Tool, what: Impossible::NegativeMass(-1.0) });
    assert_eq!(error.to_string(), "tool: mass -1 kg is negative");
}

#[test]
fn an_unphysical_arm_may_be_allowed_but_never_one_without_numbers() {
    let link_1_of_corkes_puma = with_body(|b| *b = Body { inertia: diagonal(0.0, 0.35, 0.0), ..Body::massless() });
    assert!(matches!(refused(link_1_of_corkes_puma), Impossible::InertiaWithoutMass(_)));
    assert!(Model::new_unphysical(&[link_1_of_corkes_puma], &Tool::default()).is_ok());
    for bad in [with_body(|b| b.mass = f64::NAN), with_body(|b| b.mass = -1.0), with_body(|b| b.inertia[(0, 1)] = 0.01)]
    {
        assert!(Model::new_unphysical(&[bad], &Tool::default()).is_err());
    }
}
