//! The regressor times the parameters equals the recursion's torque, over random arms of one to six mixed joints.

use crate::common::arms::{arm, joints, vector};
use crate::common::moving::for_every_arm;
use crate::common::{relative_error, torque, turns};
use dynamics_core::regressor::{Columns, inverse_dynamics_regressor};
use dynamics_core::{Dynamics, Inertia, Live, Model, Scene, Term};
use nalgebra::Vector3;
use proptest::prelude::{Strategy, prop_assert, prop_assert_eq, proptest};
use proptest::test_runner::TestCaseError;

#[derive(Debug)]
struct Case<const N: usize> {
    model: Model<f64, N>,
    gravity: Vector3<f64>,
    motion: [[f64; N]; 3],
}

impl<const N: usize> Case<N> {
    fn dynamics(&self) -> Dynamics<f64, N> {
        Dynamics::new(self.model, Scene { rotor: Term::Absent, ..Scene::with_gravity(self.gravity, &self.model) })
    }

    fn columns(&self) -> Columns<f64, N> {
        let [q, qd, qdd] = &self.motion;
        inverse_dynamics_regressor(&self.dynamics(), &turns(q), q, qd, qdd, &Live::zero())
    }
}

fn case<const N: usize>() -> impl Strategy<Value = Case<N>> {
    (arm(), vector(12.0), joints(3.2), joints(3.0), joints(10.0)).prop_map(|(model, gravity, q, qd, qdd)| Case {
        model,
        gravity,
        motion: [q, qd, qdd],
    })
}

/// `Y pi = tau`, for the recursion without rotors.
fn columns_times_parameters_are_the_torque<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    let columns = case.columns();
    let bodies = case.model.links().map(|link| link.inertia.parameters());
    let product = columns.map(|row| {
        row.iter().zip(&bodies).map(|(y, pi)| y.iter().zip(pi).map(|(y, pi)| y * pi).sum::<f64>()).sum::<f64>()
    });
    let [q, qd, qdd] = &case.motion;
    let wanted: [f64; N] = torque(&case.dynamics(), q, qd, qdd);
    prop_assert!(relative_error(&product, &wanted) < 1e-12, "{product:?}, {wanted:?}");
    Ok(())
}

/// A body beyond a joint loads the joint; a body before it does not.
fn links_before_a_joint_do_not_load_it<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    for (joint, row) in case.columns().iter().enumerate() {
        prop_assert_eq!(&row[..joint], &[[0.0; 10]; N][..joint]);
    }
    Ok(())
}

/// The ten numbers determine the whole body.
fn a_body_is_its_parameters<const N: usize>(case: &Case<N>) -> Result<(), TestCaseError> {
    for link in case.model.links() {
        let body = link.inertia.symmetric();
        prop_assert_eq!(Inertia::from_parameters(&body.parameters()), body);
    }
    Ok(())
}

for_every_arm!(columns_times_parameters_are_the_torque, links_before_a_joint_do_not_load_it, a_body_is_its_parameters);
