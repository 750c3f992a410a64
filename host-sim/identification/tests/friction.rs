//! Friction, and which of its terms are chosen.

use crate::arms::load;
use crate::made::{Making, log};
use identification::base::Base;
use identification::fit::FitProblem;
use identification::friction::{Direction, FrictionLaw, Term};
use identification::identify::{Settings, identify};
use identification::prediction::{difference, rms};
use identification::prepare::{Filters, Prepared};

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

/// With true masses 20 % above the robot file's, the file's torque error is more than five times that of the identified model.
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

/// Friction balances any torque of a held joint. With those samples in the fit the friction is wrong; without them it is right.
#[test]
fn samples_in_which_friction_holds_a_joint_are_left_out_and_would_spoil_the_fit() {
    let known = load("yam.toml");
    let making = Making { moves: Some(12), duration: 24.0, ..Making::default() };
    let mut log = log(&known, &known.parameters, &making);
    let at_rest = |q: &[f64], k: usize| (q[k.saturating_sub(3)] - q[(k + 3).min(q.len() - 1)]).abs() < 1e-4;
    for joint in 0..6 {
        // The drive has reduced its torque until friction holds the joint from the other side.
        let direction = Direction::Hysteresis(1e-4).along(&log.q[joint], &[]);
        for k in 0..log.time.len() {
            if at_rest(&log.q[joint], k) {
                log.tau[joint][k] -= 0.39 * direction[k];
            }
        }
    }
    let base = Base::of(known.arm.as_ref());
    let filters = Filters { motion: 20.0, torque: 8.0 };
    let prepared = Prepared::new(&log, known.arm.as_ref(), &base, filters);
    let mut all = prepared.clone();
    all.held.iter_mut().flatten().for_each(|held| *held = false);
    let laws = vec![FrictionLaw::with(Direction::Hysteresis(1e-4), &[]); 6];
    let coulomb = |logs: &[Prepared]| -> Vec<f64> {
        let problem = FitProblem { logs, base: &base, laws: &laws };
        let fit = problem.fit();
        (0..6).map(|joint| fit.x[problem.offset(joint) + 2]).collect()
    };
    let (moving, with_held) = (coulomb(std::slice::from_ref(&prepared)), coulomb(&[all]));
    let share = |joint: usize| {
        let held = &prepared.held[joint];
        held.iter().filter(|held| **held).count() as f64 / held.len() as f64
    };
    for joint in 0..6 {
        assert!((0.05..0.8).contains(&share(joint)), "joint {joint}: {}", share(joint));
        assert!((moving[joint] - 0.2).abs() < 0.03, "joint {joint}: {moving:?}");
        assert!((with_held[joint] - 0.2).abs() > 0.05, "joint {joint}: {with_held:?}");
    }
}
