//! All equations of a chain solved at once, compared with the recursion that never writes them down.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::common::moving::{Moving, fixed, moving, worst, worst_over_arms};
use crate::common::{into_base, numbers_of, pinned, pinned_rounding, relative_error, torque, turns};
use dynamics_core::chapter::global::{Assembled, momentum_rate, residuals, weights};
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, Inertia, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Term, Tool, Wrench,
};
use nalgebra::{Matrix3, Vector3};

/// Joint wrenches from the recursion, in base axes.
fn wanted<const N: usize>(case: &Moving<N>) -> [Wrench<f64>; N] {
    let found = joint_wrenches(&case.dynamics(), &turns(&case.q), &case.q, &case.qd, &case.qdd, &Live::zero());
    into_base(&case.posture(), &found)
}

fn assembled<const N: usize>(case: &Moving<N>) -> Assembled<f64, N> {
    let posture = case.posture();
    let motion = posture.motion(&case.qd, &case.qdd);
    Assembled::new(&posture, &motion, &weights(&posture, &case.gravity), &case.push())
}

/// Error of the solution compared with the recursion, over all components of all joints.
fn solution_error<const N: usize>(case: &Moving<N>) -> f64 {
    let found = assembled(case).solve().unwrap();
    relative_error(&numbers_of(&found), &numbers_of(&wanted(case)))
}

/// Residual of the equations with the recursion's wrenches, relative to the wrenches.
fn residual<const N: usize>(case: &Moving<N>) -> f64 {
    let (posture, joint) = (case.posture(), wanted(case));
    let motion = posture.motion(&case.qd, &case.qdd);
    let missed = residuals(&posture, &motion, &joint, &weights(&posture, &case.gravity), &case.push());
    largest(&missed) / largest(&joint)
}

fn largest(wrenches: &[Wrench<f64>]) -> f64 {
    numbers_of(wrenches).into_iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

#[test]
fn the_system_has_the_wrenches_of_the_recursion_as_its_solution() {
    pinned_rounding("assembled against recursion", worst_over_arms!(solution_error), 2.05e-15);
    pinned_rounding("residual of the recursion", worst_over_arms!(residual), 9.34e-16);
}

#[test]
fn single_precision_solves_it_to_its_rounding() {
    let worst = worst::<6>(|case| {
        let chain = Chain::<f32, 6>::new(&case.model, &case.payload);
        let [q, qd, qdd] = [&case.q, &case.qd, &case.qdd].map(crate::common::cast::<f32, 6>);
        let posture = chain.posture(&turns(&case.q), &q);
        let external = weights(&posture, &case.gravity.map(|x| x as f32));
        let system = Assembled::new(&posture, &posture.motion(&qd, &qdd), &external, &case.push().cast());
        let found = system.solve().unwrap().map(|w| w.cast());
        relative_error(&numbers_of(&found), &numbers_of(&wanted(case)))
    });
    pinned_rounding("single precision", worst, 7.17e-7);
}

#[test]
fn numbers_that_are_not_finite_have_no_solution() {
    let case = fixed(moving::<3>(), 1).next().unwrap();
    let posture = case.posture();
    let motion = posture.motion(&case.qd, &[f64::NAN; 3]);
    let none = [Wrench::zero(); 3];
    assert!(Assembled::new(&posture, &motion, &none, &Wrench::zero()).solve().is_none());
    assert!(Assembled::new(&posture, &posture.motion(&case.qd, &case.qdd), &none, &Wrench::zero()).solve().is_some());
}

/// 12.2 as printed, without `omega x (I omega)`: its moments, and so the first joint's, are wrong by the sum of those terms.
#[test]
fn without_the_gyroscopic_term_a_spatial_arm_is_wrong_and_a_planar_one_right() {
    fn printed<const N: usize>(case: &Moving<N>) -> f64 {
        let posture = case.posture();
        let motion = posture.motion(&case.qd, &case.qdd);
        let mut external = weights(&posture, &case.gravity);
        for i in 0..N {
            // Moved to the left side, the missing term is an external moment.
            let linear = posture.links[i].inertia * motion[i].alpha;
            external[i].moment += momentum_rate(&posture.links[i], &motion[i]).moment - linear;
        }
        let found = Assembled::new(&posture, &motion, &external, &case.push()).solve().unwrap();
        relative_error(&numbers_of(&found), &numbers_of(&wanted(case)))
    }
    pinned("six joints without the gyroscopic term", worst::<6>(printed), 0.228);
    let (case, _) = planar();
    assert!(printed(&case) < 1e-15);
}

/// Example 323: a uniform beam on a pivot, its forces and moment in closed form.
#[test]
fn one_beam_has_the_forces_of_12_25_corrected_and_the_moment_of_12_28() {
    let (l, m, iz, g) = (0.9, 3.0, 0.25, 9.81);
    let (theta, qd, qdd) = (0.7_f64, 2.3, -4.0);
    let beam = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: l, ..Dh::default() }),
        body: Body {
            mass: m,
            com: Vector3::new(-l / 2.0, 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.05, 0.24, iz)),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let chain = Chain::<f64, 1>::new(&Model::new(&[beam], &Tool::default()).unwrap(), &Inertia::zero());
    let posture = chain.posture(&turns(&[theta]), &[theta]);
    let external = weights(&posture, &Vector3::new(0.0, -g, 0.0));
    let system = Assembled::new(&posture, &posture.motion(&[qd], &[qdd]), &external, &Wrench::zero());
    let found = system.solve().unwrap()[0];
    let (s, c) = theta.sin_cos();
    let half = m * l / 2.0;
    // With the sign that 12.18 and 12.25 give to the centripetal part, and with the other sign.
    let forces = |sign: f64| [half * (-qdd * s + sign * qd * qd * c), half * (qdd * c + sign * qd * qd * s) + m * g];
    assert!(relative_error(&[found.force.x, found.force.y], &forces(-1.0)) < 1e-15);
    pinned("force of 12.25 as printed", relative_error(&forces(1.0), &[found.force.x, found.force.y]), 0.528);
    let moment = (iz + m * l * l / 4.0) * qdd + m * g * l / 2.0 * c;
    assert!((found.moment.z / moment - 1.0).abs() < 1e-14);
}

/// Two rods in the xy plane, classical rows, mass centres off the line between the joints.
fn planar() -> (Moving<2>, Posture<f64, 2>) {
    let rod = |a: f64, mass: f64, com: [f64; 3], spin: f64| JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a, ..Dh::default() }),
        body: Body {
            mass,
            com: com.into(),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.4 * spin, 0.7 * spin, spin)),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let joints = [rod(0.9, 3.0, [-0.4, 0.05, 0.0], 0.3), rod(0.7, 2.0, [-0.3, -0.02, 0.0], 0.12)];
    let case = Moving {
        model: Model::new(&joints, &Tool::default()).unwrap(),
        gravity: Vector3::new(0.0, -9.81, 0.0),
        payload: Inertia::zero(),
        contact: Wrench::zero(),
        q: [0.4, 0.9],
        qd: [1.3, -2.1],
        qdd: [2.0, 5.0],
    };
    (case, case.posture())
}

/// Rows 3 and 6 of 12.75 with `s = 1`; as printed with `s = -1`.
fn matrix_12_75(posture: &Posture<f64, 2>, s: f64) -> [[f64; 6]; 6] {
    let (n1, m1, n2) = (posture.inner_arm(0) * s, posture.outer_arm(0) * s, posture.inner_arm(1) * s);
    [
        [1.0, 0.0, 0.0, -1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, -1.0, 0.0],
        [-n1.y, n1.x, 1.0, m1.y, -m1.x, -1.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, -n2.y, n2.x, 1.0],
    ]
}

#[test]
fn the_planar_system_is_the_books_with_its_third_and_sixth_row_corrected() {
    let (case, posture) = planar();
    let system = assembled(&case);
    // Force x, force y and moment z of each link and joint.
    let kept = [(0, 0), (0, 1), (0, 5), (1, 0), (1, 1), (1, 5)];
    let matrix = kept.map(|(i, r)| kept.map(|(j, c)| system.matrix[i][r][j][c]));
    assert_eq!(matrix, matrix_12_75(&posture, 1.0));

    // b of 12.76; its g is the signed component of gravity.
    let motion = posture.motion(&case.qd, &case.qdd);
    let b = kept.map(|(i, r)| system.right[i][r]);
    let book: Vec<f64> = (0..2)
        .flat_map(|i| {
            let (link, a) = (&posture.links[i], motion[i].acceleration);
            [link.mass * a.x, link.mass * a.y - link.mass * case.gravity.y, link.inertia.m33 * motion[i].alpha.z]
        })
        .collect();
    assert!(relative_error(&b, &book) < 1e-15);

    // In this order, each unknown follows from those before it: no solver is needed, so none is shared with the core.
    let solved = |matrix: [[f64; 6]; 6]| {
        let mut x = [0.0; 6];
        for k in [3, 4, 5, 0, 1, 2] {
            x[k] = b[k] - (0..6).map(|j| matrix[k][j] * x[j]).sum::<f64>();
        }
        x
    };
    let scene = Scene { rotor: Term::Absent, ..Scene::with_gravity(case.gravity, &case.model) };
    let tau = torque::<f64, 2>(&Dynamics::new(case.model, scene), &case.q, &case.qd, &case.qdd);
    let torques = |x: [f64; 6]| [x[2], x[5]];
    assert!(relative_error(&torques(solved(matrix)), &tau) < 1e-15);
    let printed = relative_error(&torques(solved(matrix_12_75(&posture, -1.0))), &tau);
    pinned("torques of 12.75 as printed", printed, 1.94);
}
