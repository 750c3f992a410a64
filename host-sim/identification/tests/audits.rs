//! Extremes of the mass matrix.

use crate::arms::load;
use crate::made::Random;
use identification::audit::{audit, mass_matrix};

#[test]
fn a_mass_matrix_is_that_of_the_core() {
    use dynamics_core::mass_matrix::mass_matrix as of_core;
    use dynamics_core::trig::Libm;
    use dynamics_core::{Dynamics, Live, Scene, Trig};
    let robot =
        robot_compiler::Robot::load(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/yam.toml"));
    let model = robot.unwrap().model::<6>().unwrap();
    let known = load("yam.toml");
    let q = [0.3, 1.1, 0.9, -0.4, 0.7, 1.3];
    let found = mass_matrix(known.arm.as_ref(), &known.parameters, &q);
    let gravity = nalgebra::Vector3::new(0.0, 0.0, -9.81);
    let expected =
        of_core(&Dynamics::new(model, Scene::with_gravity(gravity, &model)), &Libm.sin_cos_all(&q), &q, &Live::zero());
    for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
        assert!((found[(i, j)] - expected[(i, j)]).abs() < 1e-12, "{i} {j}: {} {}", found[(i, j)], expected[(i, j)]);
    }
}

#[test]
fn the_smallest_eigenvalue_of_two_rods_is_that_of_the_closed_form() {
    // Two point masses at the ends of two rods: det M = m1 m2 a^2 b^2 + m2^2 a^2 b^2 sin^2 q2, smallest eigenvalue where q2 = 0 or pi.
    let known = load("planar2r.toml");
    let point = |mass: f64, at: f64| [mass, mass * at, 0.0, 0.0, 0.0, 0.0, 0.0, mass * at * at, 0.0, mass * at * at];
    let parameters = [&point(2.0, 1.0)[..], &point(1.0, 1.0)[..], &[0.0, 0.0]].concat();
    let found = audit(known.arm.as_ref(), &parameters, &parameters, &[(f64::NEG_INFINITY, f64::INFINITY); 2]);
    let matrix = |c: f64| nalgebra::Matrix2::new(4.0 + 2.0 * c, 1.0 + c, 1.0 + c, 1.0);
    let expected = matrix(1.0).symmetric_eigenvalues().min().min(matrix(-1.0).symmetric_eigenvalues().min());
    assert!((found.smallest.value - expected).abs() < 1e-4, "{found:?}, {expected}");
    assert_eq!(found.smallest, found.smallest_before);
    let (low, high) = found.ratio.unwrap();
    assert!((low.value - 1.0).abs() < 1e-9 && (high.value - 1.0).abs() < 1e-9);
    // Twice the mass everywhere.
    let doubled: Vec<f64> = parameters.iter().map(|p| 2.0 * p).collect();
    let (low, high) = audit(known.arm.as_ref(), &parameters, &doubled, &[(-3.0, 3.0); 2]).ratio.unwrap();
    assert!((low.value - 2.0).abs() < 1e-9 && (high.value - 2.0).abs() < 1e-9, "{low:?} {high:?}");
}

#[test]
fn an_arm_that_cannot_be_is_found_and_no_posture_is_beyond_the_extremes() {
    let known = load("yam.toml");
    let n = known.joints();
    let limits = vec![(-1.5, 1.5); n];
    let mut changed = known.parameters.clone();
    // The upper arm heavier, the last rotor lighter.
    (10..20).for_each(|k| changed[k] *= 1.5);
    changed[10 * n + 5] *= 0.5;
    let found = audit(known.arm.as_ref(), &known.parameters, &changed, &limits);
    let (low, high) = found.ratio.clone().unwrap();
    assert!(
        found.smallest.value > 0.0 && low.value > 0.5 && low.value < 0.9 && high.value > 1.1 && high.value < 1.5,
        "{found:?}"
    );
    let mut random = Random::new(9);
    for _ in 0..2000 {
        let q: Vec<f64> = limits.iter().map(|(lo, hi)| lo + random.share() * (hi - lo)).collect();
        let least = mass_matrix(known.arm.as_ref(), &changed, &q).symmetric_eigenvalues().min();
        assert!(least >= found.smallest.value - 1e-9, "{least} at {q:?}, {found:?}");
    }
    // A wrist with negative inertia: the search must find a posture that shows it.
    changed[10 * n + 5] = -0.01;
    assert!(audit(known.arm.as_ref(), &known.parameters, &changed, &limits).smallest.value < 0.0);
}
