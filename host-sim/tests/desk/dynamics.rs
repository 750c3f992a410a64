//! `dynamics` compared with external reference data (`robots/golden/`).

use crate::reference::{Golden, Reference, relative};
use dynamics_core::trig::Libm;
use dynamics_core::{Model, Real, Trig};
use sim::plant::Arm;
use studies::dynamics::{DynamicsRequest, DynamicsResult, answer};

fn model<const N: usize>(arm: &Arm<N>) -> Model<f64, N> {
    Model::new_unphysical(&arm.joints, &arm.tool).unwrap()
}

fn ask<S: Real, const N: usize>(
    model: &Model<S, N>,
    state: &Reference,
    gravity: &[f64; 3],
    wrench: bool,
) -> DynamicsResult
where
    Libm: Trig<S>,
{
    let question = DynamicsRequest {
        q: state.q.clone(),
        qd: Some(state.qd.clone()),
        qdd: Some(state.qdd.clone()),
        tau: Some(state.tau_in.clone()),
        wrench_tip: wrench.then(|| state.wrench_tip.to_vec()),
        gravity: Some(gravity.to_vec()),
    };
    answer(model, &[0.0, 0.0, -9.81], &question).unwrap()
}

/// Worst relative difference of torques and of accelerations over all states.
fn worst<S: Real, const N: usize>(model: &Model<S, N>, golden: &Golden) -> (f64, f64)
where
    Libm: Trig<S>,
{
    let (mut torque_off, mut acceleration_off) = (0.0_f64, 0.0_f64);
    for state in &golden.states {
        let free = ask(model, state, &golden.gravity, false);
        let touched = ask(model, state, &golden.gravity, true);
        let rotation: Vec<f64> = free.tip.rotation.concat();
        let pairs = [
            (&free.tau, &state.tau),
            (&touched.tau, &state.tau_wrench),
            (&free.gravity, &state.gravity),
            (&touched.gravity, &state.gravity),
            (&free.coriolis_qd, &state.coriolis_qd),
            (&free.mass_matrix.concat(), &state.mass_matrix.concat()),
            (&rotation, &state.tip_rotation.concat()),
            (&free.tip.position.to_vec(), &state.tip_p.to_vec()),
        ];
        torque_off = pairs.iter().fold(torque_off, |m, (found, expected)| m.max(relative(found, expected)));
        acceleration_off = acceleration_off
            .max(relative(&free.qdd.unwrap(), &state.qdd_fd))
            .max(relative(&touched.qdd.unwrap(), &state.qdd_fd_wrench));
    }
    (torque_off, acceleration_off)
}

#[test]
fn answers_agree_with_outside_data() {
    let (puma, planar) = (Golden::load("puma560"), Golden::load("planar2r"));
    let (scara, random) = (Golden::load("scara"), Golden::load("random6_generic"));
    let found = [
        ("puma560", worst(&model::<6>(&puma.classical(false)), &puma)),
        ("planar2r", worst(&model::<2>(&planar.classical(false)), &planar)),
        ("scara", worst(&model::<4>(&scara.classical(false)), &scara)),
        ("random 6R/P", worst(&model::<6>(&random.placed()), &random)),
    ];
    for (robot, (torques, accelerations)) in found {
        // Measured: torques at most 3.9e-15, accelerations at most 1.2e-14.
        assert!(torques < 1e-14, "{robot}: {torques:e}");
        assert!(accelerations < 1e-13, "{robot}: {accelerations:e}");
    }
}

#[test]
fn single_precision_answers_are_off_by_its_rounding_and_no_more() {
    let (planar, random) = (Golden::load("planar2r"), Golden::load("random6_generic"));
    let cases = [
        // The velocity terms of one state, where sin(q2) is small; the torques themselves are off by 6.7e-7 at most.
        (1.70e-6, worst(&model::<2>(&planar.classical(false)).cast::<f32>(), &planar).0),
        (6.03e-7, worst(&model::<6>(&random.placed()).cast::<f32>(), &random).0),
    ];
    for (measured, off) in cases {
        assert!(off < 1.05 * measured && off > 0.95 * measured, "{off:e}, measured before: {measured:e}");
    }
}

#[test]
fn rotors_count_as_the_robot_file_has_them() {
    let golden = Golden::load("puma560");
    let model = model::<6>(&golden.classical(true));
    for state in &golden.states {
        let found = ask(&model, state, &golden.gravity, false);
        let with = state.rotor.as_ref().unwrap();
        assert!(relative(&found.tau, &with.tau) < 1e-14);
        assert!(relative(&found.mass_matrix.concat(), &with.mass_matrix.concat()) < 1e-14);
        assert!(relative(&found.qdd.unwrap(), &with.qdd_fd) < 1e-13);
    }
}
