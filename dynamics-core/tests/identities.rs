//! Identities between the algorithms, over random arms of one to six mixed joints.
#![allow(clippy::unwrap_used, reason = "a random arm that cannot be built should stop the test")]
#![allow(clippy::float_cmp, reason = "exact restoration is what is claimed")]

use crate::common::arms::{arm, body, held, joints, rotation, vector};
use crate::common::moving::for_every_arm;
use crate::common::{along, derivative, torque, turns};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{
    Dynamics, Inertia, InverseDynamics, JointKind, Live, Model, Scene, Term, Wrench, energy, forward_dynamics,
};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use proptest::prelude::{Strategy, prop_assert, prop_assert_eq, proptest};
use proptest::test_runner::TestCaseError;

type Checked = Result<(), TestCaseError>;

/// Test case of every identity.
#[derive(Debug)]
struct Case<const N: usize> {
    model: Model<f64, N>,
    gravity: Vector3<f64>,
    payload: Inertia<f64>,
    contact: Wrench<f64>,
    turn_world: Matrix3<f64>,
    q: [f64; N],
    qd: [f64; N],
    qdd: [f64; N],
    tau: [f64; N],
}

impl<const N: usize> Case<N> {
    fn scene(&self) -> Scene<f64, N> {
        Scene {
            payload: Term::Constant(self.payload),
            tip_wrench: Term::Constant(self.contact),
            ..Scene::with_gravity(self.gravity, &self.model)
        }
    }

    fn live(&self, dynamics: &Dynamics<f64, N>) -> Live<f64, N> {
        Live {
            gravity: self.gravity,
            payload: dynamics.payload_in_last_link(&self.payload),
            tip_wrench: self.contact,
            rotor: self.model.links().map(|link| link.rotor),
        }
    }

    fn torque(&self, scene: Scene<f64, N>) -> [f64; N] {
        torque(&Dynamics::new(self.model, scene), &self.q, &self.qd, &self.qdd)
    }
}

fn case<const N: usize>() -> impl Strategy<Value = Case<N>> {
    let motion = (joints(3.2), joints(3.0), joints(10.0), joints(50.0));
    (arm(), vector(12.0), body(), vector(30.0), vector(5.0), rotation(), motion).prop_map(
        |(model, gravity, payload, force, moment, turn_world, (q, qd, qdd, tau))| Case {
            model,
            gravity,
            payload: held(&payload),
            contact: Wrench { force, moment },
            turn_world,
            q,
            qd,
            qdd,
            tau,
        },
    )
}

fn matrix<const N: usize>(dynamics: &Dynamics<f64, N>, q: &[f64; N]) -> SMatrix<f64, N, N> {
    mass_matrix(dynamics, &turns(q), q, &Live::zero())
}

/// The torque is affine in the acceleration with slope D; D is symmetric and positive definite.
fn slope_is_the_mass_matrix<const N: usize>(case: &Case<N>) -> Checked {
    let dynamics = Dynamics::new(case.model, case.scene());
    let d = matrix(&dynamics, &case.q);
    let rest = torque(&dynamics, &case.q, &case.qd, &[0.0; N]);
    let product = d * SVector::from(case.qdd) + SVector::from(rest);
    let size = (d.amax() * 10.0).max(product.amax());
    let found = SVector::from(case.torque(case.scene()));
    prop_assert!((found - product).amax() < 1e-12 * size, "{found} {product}");
    prop_assert_eq!(d, d.transpose());
    prop_assert!(forward_dynamics::solve(&d, &case.qdd).is_ok(), "not positive definite: {}", d);
    Ok(())
}

/// inverse(forward(tau)) = tau, with rotors and without. This loses accuracy according to the condition number of D.
fn inverse_undoes_forward<const N: usize>(case: &Case<N>) -> Checked {
    for rotor in [case.scene().rotor, Term::Absent, Term::Live] {
        let dynamics = Dynamics::new(case.model, Scene { rotor, ..case.scene() });
        let (turn, live) = (turns(&case.q), case.live(&dynamics));
        let qdd = forward_dynamics::forward_dynamics(&dynamics, &turn, &case.q, &case.qd, &case.tau, &live).unwrap();
        let back = dynamics.inverse_dynamics(&turn, &case.q, &case.qd, &qdd, &live);
        let rest = dynamics.inverse_dynamics(&turn, &case.q, &case.qd, &[0.0; N], &live);
        let size = rest.iter().chain(&case.tau).fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..N {
            prop_assert!((back[i] - case.tau[i]).abs() < 1e-9 * size, "{:?} {:?}", back, case.tau);
        }
    }
    Ok(())
}

/// A pivot is the inertia that its joint feels with the joints beyond it free: 1 / pivot = (D')^-1, first entry, of the trailing block D'.
fn a_pivot_is_the_inertia_with_the_joints_beyond_it_free<const N: usize>(case: &Case<N>) -> Checked {
    for rotor in [case.scene().rotor, Term::Absent, Term::Live] {
        let dynamics = Dynamics::new(case.model, Scene { rotor, ..case.scene() });
        let (turn, live) = (turns(&case.q), case.live(&dynamics));
        let d = mass_matrix(&dynamics, &turn, &case.q, &live);
        let pivot = forward_dynamics::factored(&d, &case.tau).pivot;
        for i in 0..N {
            let block = nalgebra::DMatrix::from_fn(N - i, N - i, |row, column| d[(i + row, i + column)]);
            let free = 1.0 / block.try_inverse().unwrap()[(0, 0)];
            prop_assert!((pivot[i] - free).abs() < 1e-10 * d[(i, i)], "{} {free}", pivot[i]);
        }
    }
    Ok(())
}

/// A removed term equals a term set to zero; a live term equals the constant term with the same value, to the bit.
fn absent_is_zero_and_live_is_constant<const N: usize>(case: &Case<N>) -> Checked {
    let full = case.scene();
    let absent = [
        Scene { gravity: Term::Absent, ..full },
        Scene { payload: Term::Absent, ..full },
        Scene { tip_wrench: Term::Absent, ..full },
        Scene { rotor: Term::Absent, ..full },
        Scene { coriolis: Term::Absent, ..full },
    ];
    let zero = [
        Scene { gravity: Term::Constant(Vector3::zeros()), ..full },
        Scene { payload: Term::Constant(Inertia::zero()), ..full },
        Scene { tip_wrench: Term::Constant(Wrench::zero()), ..full },
        Scene { rotor: Term::Constant([0.0; N]), ..full },
        Scene { coriolis: Term::Constant([0.0; N]), ..full },
    ];
    for (absent, zero) in absent.into_iter().zip(zero) {
        prop_assert_eq!(case.torque(absent), case.torque(zero));
    }
    let constant = Dynamics::new(case.model, full);
    let scene = Scene {
        gravity: Term::Live,
        payload: Term::Live,
        tip_wrench: Term::Live,
        rotor: Term::Live,
        coriolis: Term::Live,
    };
    let live = Dynamics::new(case.model, scene);
    let inputs = case.live(&live);
    let [q, qd, qdd] = [&case.q, &case.qd, &case.qdd];
    let from_live = live.inverse_dynamics(&turns(q), q, qd, qdd, &inputs);
    prop_assert_eq!(from_live, case.torque(full));
    let from_live = mass_matrix(&live, &turns(q), q, &inputs);
    prop_assert_eq!(from_live, matrix(&constant, q));
    Ok(())
}

/// Setting and clearing a payload restores exactly the same bits.
fn payload_cleared_restores_the_bits<const N: usize>(case: &Case<N>) -> Checked {
    let empty = Dynamics::new(case.model, Scene { payload: Term::Absent, ..case.scene() });
    let mut dynamics = empty;
    dynamics.set_payload(Some(case.payload));
    prop_assert!(dynamics != empty);
    prop_assert_eq!(torque::<f64, N>(&dynamics, &case.q, &case.qd, &case.qdd), case.torque(case.scene()));
    dynamics.set_payload(None);
    prop_assert_eq!(dynamics, empty);
    Ok(())
}

/// Turning everything (the base's placement and gravity together) changes no torque.
fn world_rotation_changes_nothing<const N: usize>(case: &Case<N>) -> Checked {
    let r = case.turn_world;
    let mut links = *case.model.links();
    links[0].rotation = r * links[0].rotation;
    links[0].translation = r * links[0].translation;
    let turned = Case {
        model: Model::from_checked(links, *case.model.tip()),
        gravity: r * case.gravity,
        ..Case { q: case.q, ..*case }
    };
    let wanted = case.torque(case.scene());
    // A torque is one component of the joint's wrench, and may be small when the wrench is large: its rounding error is relative to the wrench.
    let carried = |terms: &Scene<f64, N>| {
        let dynamics = Dynamics::new(case.model, *terms);
        let wrenches = joint_wrenches(&dynamics, &turns(&case.q), &case.q, &case.qd, &case.qdd, &Live::zero());
        wrenches.iter().fold(0.0, |most: f64, wrench| most.max(wrench.force.amax()).max(wrench.moment.amax()))
    };
    // Loads that cancel each other are rounded separately.
    let scene = case.scene();
    let without = Scene { payload: Term::Absent, tip_wrench: Term::Absent, ..scene };
    let size = carried(&scene).max(carried(&without)).max(1.0);
    let turned = turned.torque(turned.scene());
    // `f64::max` drops a NaN; a test must not.
    prop_assert!(turned.iter().all(|torque| torque.is_finite()));
    let error = turned.iter().zip(&wanted).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    prop_assert!(error < 1e-12 * size, "{} of {}", error, size);
    Ok(())
}

/// The torque is the component of the joint's wrench along the joint, plus the rotor's share.
fn torque_is_the_wrench_along_the_joint<const N: usize>(case: &Case<N>) -> Checked {
    let dynamics = Dynamics::new(case.model, case.scene());
    let wrench = joint_wrenches(&dynamics, &turns(&case.q), &case.q, &case.qd, &case.qdd, &Live::zero());
    let tau = case.torque(case.scene());
    for (i, link) in case.model.links().iter().enumerate() {
        let along = match link.kind {
            JointKind::Revolute => wrench[i].moment.z,
            JointKind::Prismatic => wrench[i].force.z,
        };
        prop_assert_eq!(tau[i], along + link.rotor * case.qdd[i]);
    }
    Ok(())
}

/// At rest the base carries the whole weight and the contact: computed as a sum over absolute positions, without a recursion.
fn base_wrench_balances_the_world<const N: usize>(case: &Case<N>) -> Checked {
    let dynamics = Dynamics::new(case.model, case.scene());
    let (turn, still) = (turns(&case.q), [0.0; N]);
    let base = joint_wrenches(&dynamics, &turn, &case.q, &still, &still, &Live::zero())[0];
    let poses = dynamics_core::kinematics::link_poses(&case.model, &turn, &case.q);
    let tip = dynamics_core::kinematics::tip_pose(&case.model, &turn, &case.q);
    let push = tip.rotation * case.contact.force;
    let mut force = -push;
    let mut moment = -(tip.rotation * case.contact.moment) - tip.translation.cross(&push);
    let bodies = case.model.links().iter().zip(&poses).map(|(link, pose)| (link.inertia, *pose));
    for (body, pose) in bodies.chain([(case.payload, tip)]) {
        let first = pose.translation * body.mass + pose.rotation * body.first_moment;
        force -= case.gravity * body.mass;
        moment -= first.cross(&case.gravity);
    }
    let found = poses[0].rotation * base.force;
    let about_origin = poses[0].rotation * base.moment + poses[0].translation.cross(&found);
    let size = force.amax().max(moment.amax()).max(1.0);
    prop_assert!((found - force).amax() < 1e-11 * size);
    prop_assert!((about_origin - moment).amax() < 1e-11 * size, "{} {}", about_origin, moment);
    Ok(())
}

/// `tau . qd` is the rate of change of the energy, along the motion `q + qd t + qdd t^2 / 2`.
fn power_is_the_rate_of_energy<const N: usize>(case: &Case<N>) -> Checked {
    let scene = Scene { tip_wrench: Term::Absent, ..case.scene() };
    let dynamics = Dynamics::new(case.model, scene);
    let energy_at = |t: f64| {
        let (q, qd) = along(&case.q, &case.qd, &case.qdd, t);
        let (turn, live) = (turns(&q), Live::zero());
        energy::kinetic(&dynamics, &turn, &q, &qd, &live) + energy::potential(&dynamics, &turn, &q, &live)
    };
    let rate = derivative(energy_at);
    let tau = case.torque(scene);
    let power: f64 = tau.iter().zip(&case.qd).map(|(t, v)| t * v).sum();
    let size = tau.iter().zip(&case.qd).map(|(t, v)| (t * v).abs()).sum::<f64>() + energy_at(0.0).abs() + 1.0;
    prop_assert!((rate - power).abs() < 1e-5 * size, "{} {}", rate, power);
    Ok(())
}

for_every_arm!(
    slope_is_the_mass_matrix,
    inverse_undoes_forward,
    a_pivot_is_the_inertia_with_the_joints_beyond_it_free,
    absent_is_zero_and_live_is_constant,
    payload_cleared_restores_the_bits,
    world_rotation_changes_nothing,
    torque_is_the_wrench_along_the_joint,
    base_wrench_balances_the_world,
    power_is_the_rate_of_energy,
);
