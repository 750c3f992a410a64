//! Friction, and which of its terms are chosen.

use crate::arms::load;
use crate::made::{Making, log};
use identification::friction::{Direction, Term};
use identification::identify::{Settings, difference, identify, rms};

#[test]
fn a_joint_that_jitters_at_rest_keeps_the_friction_it_came_with() {
    let mut q: Vec<f64> = (0..100).map(|k| 1e-3 * f64::from(k)).collect();
    q.extend((0..100).map(|k| 0.099 + 2e-5 * f64::from(k % 2)));
    let qd = vec![0.0; q.len()];
    let s = Direction::Hysteresis(1e-3).along(&q, &qd);
    assert!(s[100..].iter().all(|s| *s > 0.95), "{:?}", &s[100..110]);
}

#[test]
fn an_arm_with_plain_friction_is_found_and_gets_no_other_terms() {
    let known = load("yam.toml");
    let logs = [log(&known, &known.parameters, &Making::default())];
    let found = identify(known.arm.as_ref(), &known.maker(), &logs, &Settings::default());
    for joint in 0..6 {
        let terms = &found.laws[joint].terms;
        assert!(!terms.contains(&Term::Asymmetric) && !terms.contains(&Term::Load), "joint {joint}: {terms:?}");
        assert!((found.friction[joint][2] - 0.2).abs() < 0.03, "joint {joint}: {:?}", found.friction[joint]);
    }
    let other = log(&known, &known.parameters, &Making { motion: 8, noise: 0.0, ..Making::default() });
    let prediction = found.predict(known.arm.as_ref(), &other);
    let left = rms(&difference(&prediction.measured, &prediction.model));
    for (joint, (left, size)) in left.iter().zip(rms(&prediction.measured)).enumerate() {
        assert!(left / size < 0.02, "joint {joint}: {left} of {size}");
    }
}

/// Without the friction that the arm has, the same check fails.
#[test]
fn an_arm_identified_without_its_masses_misses_its_torques() {
    let known = load("yam.toml");
    let heavier: Vec<f64> = known.parameters.iter().map(|x| 1.2 * x).collect();
    let logs = [log(&known, &heavier, &Making::default())];
    let found = identify(known.arm.as_ref(), &known.maker(), &logs, &Settings::default());
    let before = found.predict_by(known.arm.as_ref(), &logs[0], &known.parameters, &|_, _, _| 0.0);
    let prediction = found.predict(known.arm.as_ref(), &logs[0]);
    let missed = rms(&difference(&prediction.measured, &before));
    let left = rms(&difference(&prediction.measured, &prediction.model));
    for joint in 0..6 {
        assert!(missed[joint] > 5.0 * left[joint], "joint {joint}: {missed:?}, {left:?}");
    }
}
