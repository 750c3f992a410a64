//! Base parameters.

use crate::arms::load;
use identification::arm::parameter_count;
use identification::base::Base;
use nalgebra::DVector;

/// The base parameters give the same torque as all parameters, at states that were not used to find them.
#[test]
fn base_parameters_give_the_torques_of_all_parameters() {
    for name in ["puma560.toml", "stanford.toml", "scara.toml", "planar3r.toml", "yam.toml"] {
        let known = load(name);
        let n = known.joints();
        let base = Base::of(known.arm.as_ref());
        let beta = base.of_parameters(&known.parameters);
        let mut out = vec![0.0; 10 * n * n];
        for state in 0..20 {
            let wave = |phase: f64| -> Vec<f64> {
                (0..n).map(|i| 2.0 * (f64::from(state) + i as f64 * 1.3 + phase).sin()).collect()
            };
            let (q, qd, qdd) = (wave(0.0), wave(1.0), wave(2.0));
            known.arm.columns(&q, &qd, &qdd, &mut out);
            for joint in 0..n {
                let column = |k: usize| {
                    if k >= 10 * n {
                        if k == 10 * n + joint { qdd[joint] } else { 0.0 }
                    } else {
                        out[10 * n * joint + k]
                    }
                };
                let all: f64 = (0..parameter_count(n)).map(|k| column(k) * known.parameters[k]).sum();
                let few: f64 = base.columns.iter().zip(beta.iter()).map(|(k, beta)| column(*k) * beta).sum();
                assert!((all - few).abs() < 1e-9 * (1.0 + all.abs()), "{name}, joint {joint}: {all}, {few}");
            }
        }
        assert!(base.gap.0 > 1e-3 && base.gap.1 < 1e-12, "{name}: {:?}", base.gap);
    }
}

#[test]
fn a_planar_arm_has_the_base_parameters_of_the_textbooks() {
    // Gravity along the axes: four for the bodies of two links, of which the rotor of the first joint is a part, and the second rotor.
    let known = load("planar2r.toml");
    let base = Base::of(known.arm.as_ref());
    let names: Vec<String> = (0..base.len()).map(|k| base.name(k)).collect();
    assert_eq!(base.len(), 5, "{names:?}");
    assert!(names[0].starts_with("Izz1 + m2 + rotor1"), "{names:?}");
    assert!(names.iter().any(|name| name == "mx2"), "{names:?}");
}

#[test]
fn regrouping_leaves_a_base_parameter_its_own_column() {
    let base = Base::of(load("ur5.toml").arm.as_ref());
    for (b, k) in base.columns.iter().enumerate() {
        let mut unit = vec![0.0; base.regroup.ncols()];
        unit[*k] = 1.0;
        let mut wanted = DVector::zeros(base.len());
        wanted[b] = 1.0;
        assert_eq!(base.of_parameters(&unit), wanted);
    }
}
