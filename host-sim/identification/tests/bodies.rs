//! Physically consistent bodies.

use crate::arms::load;
use identification::base::Base;
use identification::consistent::{nearest, pseudo};
use nalgebra::DMatrix;

fn least_eigenvalue(parameters: &[f64]) -> f64 {
    pseudo(&core::array::from_fn(|k| parameters[k])).symmetric_eigenvalues().min()
}

#[test]
fn bodies_are_possible_whatever_the_data_say() {
    let known = load("yam.toml");
    let n = known.joints();
    let base = Base::of(known.arm.as_ref());
    let mut wanted = base.of_parameters(&known.parameters);
    // Impossible data: every other parameter has the wrong sign, with small covariance.
    wanted.iter_mut().step_by(2).for_each(|beta| *beta = -*beta);
    let found = nearest(&base, &known.maker(), &wanted, &DMatrix::from_diagonal_element(base.len(), base.len(), 1e-6));
    for link in 0..n {
        assert!(least_eigenvalue(&found.parameters[10 * link..10 * link + 10]) > 0.0, "link {link}");
    }
    assert!(found.parameters[10 * n..].iter().all(|rotor| *rotor > 0.0));
}

#[test]
fn the_makers_bodies_stay_where_the_data_say_the_same() {
    let known = load("yam.toml");
    let base = Base::of(known.arm.as_ref());
    let wanted = base.of_parameters(&known.parameters);
    let found = nearest(&base, &known.maker(), &wanted, &DMatrix::from_diagonal_element(base.len(), base.len(), 1e-8));
    for (found, maker) in found.parameters.iter().zip(&known.parameters) {
        assert!((found - maker).abs() < 2e-3 * maker.abs() + 1e-5, "{found}, {maker}");
    }
    // Torques depend on only one moment of the first link.
    assert!(found.unseen[0] > 0.9, "{}", found.unseen[0]);
}

#[test]
fn a_body_that_no_mass_distribution_has_becomes_one() {
    // The Puma's first link: an inertia without a mass.
    let known = load("puma560.toml");
    let base = Base::of(known.arm.as_ref());
    let wanted = base.of_parameters(&known.parameters);
    let found = nearest(&base, &known.maker(), &wanted, &DMatrix::from_diagonal_element(base.len(), base.len(), 1e-6));
    for link in 0..6 {
        assert!(least_eigenvalue(&found.parameters[10 * link..10 * link + 10]) > 0.0, "link {link}");
    }
    let off = (&wanted - &found.beta).amax();
    assert!(off < 0.02, "{off}");
}
