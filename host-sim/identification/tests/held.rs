//! Payloads.

use crate::arms::{ball, load};
use crate::made::{Making, log};
use identification::identify::{Settings, identify};
use identification::payload::{Known, torque_scale};
use nalgebra::Vector3;

#[test]
fn a_load_is_weighed_within_its_interval_though_friction_has_changed() {
    let known = load("yam.toml");
    let arm = known.arm.as_ref();
    let empty = [log(&known, &known.parameters, &Making::default())];
    let settings = Settings { plain_friction: true, motion_cutoff: Some(8.0), ..Settings::default() };
    let found = identify(arm, &known.maker(), &empty, &settings);
    let against = Known::of(&found);
    let com = Vector3::new(0.02, -0.01, -0.08);
    for (seed, mass) in [(1, 0.5), (2, 1.0), (3, 0.2)] {
        let mut loaded = known.parameters.clone();
        loaded[50..60].iter_mut().zip(ball(mass, com, 0.03)).for_each(|(sum, x)| *sum += x);
        let making = Making { seed, motion: 9, friction: (0.12, 0.17), ..Making::default() };
        let held = against.payload(arm, &[log(&known, &loaded, &making)], (1.0, 0.0));
        assert!((held.mass - mass).abs() < 3.0 * held.mass_deviation + 1e-3, "{mass}: {held:?}");
        assert!(held.mass_deviation < 0.03, "{held:?}");
        assert!((held.com.unwrap() - com).norm() < 0.01, "{held:?}");
        assert!(held.inertia.symmetric_eigenvalues().min() > 0.0, "{held:?}");
    }
    let nothing =
        against.payload(arm, &[log(&known, &known.parameters, &Making { motion: 9, ..Making::default() })], (1.0, 0.0));
    assert!(nothing.mass.abs() < 3.0 * nothing.mass_deviation + 1e-3, "{nothing:?}");
}

#[test]
fn torques_that_are_all_a_tenth_too_large_show_against_the_makers_masses() {
    let known = load("yam.toml");
    let arm = known.arm.as_ref();
    let stated: Vec<f64> = known.parameters.iter().map(|x| 1.1 * x).collect();
    let settings = Settings { plain_friction: true, motion_cutoff: Some(8.0), ..Settings::default() };
    let found = identify(arm, &known.maker(), &[log(&known, &stated, &Making::default())], &settings);
    let (scale, deviation) = torque_scale(arm, &Known::of(&found), &known.maker(), 0.1);
    assert!((scale - 1.1).abs() < 2.0 * deviation && deviation < 0.1, "{scale} {deviation}");
    // With a trusted torque constant, the scale stays near 1.
    let (scale, _) = torque_scale(arm, &Known::of(&found), &known.maker(), 0.005);
    assert!((scale - 1.0).abs() < 0.01, "{scale}");
}
