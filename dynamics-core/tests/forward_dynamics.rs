//! Forward dynamics by both methods: reference data, massless links, singular arms.
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]

use crate::common::{Golden, cast, numbers, relative_error, turns};
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Singular, Term, Tool,
    articulated_body,
};
use nalgebra::{Matrix3, Vector3};

#[test]
fn articulated_bodies_agree_with_pinocchio() {
    fn worst<const N: usize>(name: &str) -> f64 {
        let golden = Golden::load(name);
        let model = golden.placed::<N>();
        let scene = Scene { gravity: Term::Constant(golden.gravity()), ..Scene::free_space() };
        let dynamics = Dynamics::new(model, scene);
        let errors = golden.states().map(|state| {
            let [q, qd, tau] = ["q", "qd", "tau_in"].map(|key| numbers::<N>(&state[key]));
            let live = Live::zero();
            let qdd = articulated_body::forward_dynamics(&dynamics, &turns(&q), &q, &qd, &tau, &live).unwrap();
            relative_error(&qdd, &numbers::<N>(&state["qdd_fd"]))
        });
        errors.fold(0.0, f64::max)
    }
    let found = [worst::<6>("puma560"), worst::<2>("planar2r"), worst::<4>("scara"), worst::<6>("random6_generic")];
    println!("{found:?}");
    assert!(found.iter().all(|error| *error < 1e-12), "{found:?}");
}

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

/// Accelerations by both methods.
fn both(joints: &[JointSpec; 3]) -> [Result<[f64; 3], Singular>; 2] {
    let dynamics = dynamics(joints);
    [
        forward_dynamics(&dynamics, &turns(&Q), &Q, &QD, &TAU, &Live::zero()),
        articulated_body::forward_dynamics(&dynamics, &turns(&Q), &Q, &QD, &TAU, &Live::zero()),
    ]
}

#[test]
fn a_massless_link_with_a_rotor_works() {
    for massless in 0..3 {
        let joints = core::array::from_fn(|i| turning(if i == massless { Body::massless() } else { heavy() }, 0.02));
        for qdd in both(&joints) {
            let back = crate::common::torque(&dynamics(&joints), &Q, &QD, &qdd.unwrap());
            assert!(relative_error(&back, &TAU) < 1e-13, "{back:?}");
        }
    }
    // Only rotors: each turns independently.
    let qdd = both(&[turning(Body::massless(), 0.02); 3]).map(Result::unwrap);
    assert_eq!(qdd, [TAU.map(|tau| tau * (1.0 / 0.02)); 2]);
}

#[test]
fn a_joint_that_moves_nothing_is_named() {
    let (full, none) = (turning(heavy(), 0.0), turning(Body::massless(), 0.0));
    assert!(both(&[full; 3]).iter().all(Result::is_ok));
    assert_eq!(both(&[full, full, none]), [Err(Singular { joint: 2 }); 2]);
    // The joint of a massless link still moves the links beyond it.
    assert!(both(&[full, none, full]).iter().all(Result::is_ok));
    // A point mass on the axis of the last joint.
    let on_axis = Body { mass: 1.0, com: Vector3::new(-0.4, 0.0, 0.0), inertia: Matrix3::zeros() };
    let straight = JointSpec { frame: Frame::ClassicalDh(Dh { a: 0.4, ..Dh::default() }), ..turning(on_axis, 0.0) };
    assert_eq!(both(&[full, full, straight]), [Err(Singular { joint: 2 }); 2]);
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
    let wanted = both(&joints)[0].unwrap();
    let (turn, q, qd, tau) = (turns::<f32, 3>(&Q), cast(&Q), cast(&QD), cast(&TAU));
    for qdd in [
        forward_dynamics(&single, &turn, &q, &qd, &tau, &Live::zero()),
        articulated_body::forward_dynamics(&single, &turn, &q, &qd, &tau, &Live::zero()),
    ] {
        let off = relative_error(&qdd.unwrap(), &wanted);
        assert!(off < 2e-6, "{off:e}");
    }
}
