//! Forward dynamics: massless links, singular arms, single precision. Reference data are in `golden.rs`.
#![allow(clippy::unwrap_used, reason = "an arm that cannot be built should stop the test")]

use crate::common::{cast, relative_error, turns};
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Singular, Tool,
};
use nalgebra::{Matrix3, Vector3};

fn turning(body: Body, rotor: f64) -> JointSpec {
    JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: 0.4, alpha: 0.9, d: 0.1, theta: 0.2 }),
        body,
        rotor: Rotor { inertia: rotor, gear: 1.0 },
        limits: Limits::none(),
    }
}

fn heavy() -> Body {
    Body {
        mass: 2.0,
        com: Vector3::new(-0.2, 0.05, 0.01),
        inertia: Matrix3::from_diagonal(&Vector3::new(0.01, 0.03, 0.03)),
    }
}

fn dynamics(joints: &[JointSpec; 3]) -> Dynamics<f64, 3> {
    let model = Model::new(joints, &Tool::default()).unwrap();
    Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model))
}

const Q: [f64; 3] = [0.3, -0.8, 1.1];
const QD: [f64; 3] = [1.0, -0.5, 2.0];
const TAU: [f64; 3] = [3.0, 1.0, -0.2];

fn accelerations(joints: &[JointSpec; 3]) -> Result<[f64; 3], Singular> {
    forward_dynamics(&dynamics(joints), &turns(&Q), &Q, &QD, &TAU, &Live::zero())
}

#[test]
fn a_massless_link_with_a_rotor_works() {
    for massless in 0..3 {
        let joints = core::array::from_fn(|i| turning(if i == massless { Body::massless() } else { heavy() }, 0.02));
        let back = crate::common::torque(&dynamics(&joints), &Q, &QD, &accelerations(&joints).unwrap());
        assert!(relative_error(&back, &TAU) < 1e-13, "{back:?}");
    }
    // Only rotors: each turns independently.
    let qdd = accelerations(&[turning(Body::massless(), 0.02); 3]);
    assert_eq!(qdd, Ok(TAU.map(|tau| tau * (1.0 / 0.02))));
}

#[test]
fn a_joint_that_moves_nothing_is_named() {
    let (full, none) = (turning(heavy(), 0.0), turning(Body::massless(), 0.0));
    assert!(accelerations(&[full; 3]).is_ok());
    assert_eq!(accelerations(&[full, full, none]), Err(Singular { joint: 2 }));
    // The joint of a massless link still moves the links beyond it.
    assert!(accelerations(&[full, none, full]).is_ok());
    // A point mass on the axis of the last joint.
    let on_axis = Body { mass: 1.0, com: Vector3::new(-0.4, 0.0, 0.0), inertia: Matrix3::zeros() };
    let straight = JointSpec { frame: Frame::ClassicalDh(Dh { a: 0.4, ..Dh::default() }), ..turning(on_axis, 0.0) };
    assert_eq!(accelerations(&[full, full, straight]), Err(Singular { joint: 2 }));
    assert_eq!(
        Singular { joint: 2 }.to_string(),
        "joint 3 moves neither mass nor rotor: the inertia matrix is singular"
    );
}

#[test]
fn single_precision_agrees_with_double() {
    let joints = [turning(heavy(), 0.02); 3];
    let double = dynamics(&joints);
    let single = Dynamics::new(double.model().cast::<f32>(), double.scene().cast());
    let wanted = accelerations(&joints).unwrap();
    let (turn, q, qd, tau) = (turns::<f32, 3>(&Q), cast(&Q), cast(&QD), cast(&TAU));
    let qdd = forward_dynamics(&single, &turn, &q, &qd, &tau, &Live::zero()).unwrap();
    let off = relative_error(&qdd, &wanted);
    assert!(off < 2e-6, "{off:e}");
}
