//! Verdicts, and arms for which the maker gives only geometry.

use crate::arms::{Known, load};
use crate::made::{Making, log};
use identification::consistent::Maker;
use identification::hypotheses::explain;
use identification::identify::{Settings, identify};
use identification::log::Log;
use identification::prediction::{difference, rms};
use identification::verdict::{Errors, Grade, Reason, Verdict, persistence, verdict};

fn settings() -> Settings {
    Settings { plain_friction: true, motion_cutoff: Some(8.0), ..Settings::default() }
}

/// Parameters of the elbow arm with rotors, and with each body's parameters multiplied by its factor.
fn truth(known: &Known, factors: [f64; 3]) -> Vec<f64> {
    let mut truth: Vec<f64> =
        known.parameters.iter().enumerate().map(|(k, x)| x * factors.get(k / 10).copied().unwrap_or(1.0)).collect();
    truth[30..].copy_from_slice(&[0.05, 0.06, 0.02]);
    truth
}

fn judged(known: &Known, train: &Log, other: &Log) -> Verdict {
    judged_with(known, train, other, &|_| ())
}

/// The verdict after the errors are changed.
fn judged_with(known: &Known, train: &Log, other: &Log, change: &dyn Fn(&mut Errors)) -> Verdict {
    let (arm, maker) = (known.arm.as_ref(), known.maker());
    let found = identify(arm, &maker, std::slice::from_ref(train), &settings());
    let findings = explain(arm, &maker, std::slice::from_ref(train));
    let prediction = found.predict(arm, other);
    let size = rms(&prediction.measured);
    let share = |left: Vec<f64>| left.iter().zip(&size).map(|(left, size)| left / size).collect::<Vec<f64>>();
    let before = found.predict_by(arm, other, &known.parameters, &|_, _, _| 0.0);
    let mut errors = Errors {
        before: share(rms(&difference(&prediction.measured, &before))),
        after: share(rms(&difference(&prediction.measured, &prediction.model))),
        held_out: share(found.held_out.clone()),
        persistence: persistence(&prediction),
        others: true,
    };
    change(&mut errors);
    verdict(&found, &findings, &errors, &[], &found.open(arm))
}

#[test]
fn a_good_log_is_trusted_one_move_is_refused_and_doubled_masses_are_doubtful() {
    let known = load("elbow.toml");
    let other = |truth: &[f64]| log(&known, truth, &Making { motion: 9, ..Making::default() });
    let good = truth(&known, [1.2, 0.85, 1.15]);
    let train = log(&known, &good, &Making::default());
    let found = judged(&known, &train, &other(&good));
    assert!(found.grade == Grade::Trusted && found.reasons.is_empty(), "{found:?}");

    let once = log(&known, &good, &Making { moves: Some(1), duration: 3.0, ..Making::default() });
    let found = judged(&known, &once, &other(&good));
    assert!(found.grade == Grade::Refused, "{found:?}");
    assert!(found.reasons.iter().any(|reason| matches!(reason, Reason::LittleMotion(_))), "{found:?}");

    let heavy = truth(&known, [1.7, 1.7, 1.7]);
    let found = judged(&known, &log(&known, &heavy, &Making::default()), &other(&heavy));
    assert!(found.grade == Grade::Doubtful, "{found:?}");
    assert!(found.reasons.iter().any(|reason| matches!(reason, Reason::Heavier(_))), "{found:?}");

    // Torques that the robot file's own model computed, and a model that is no better than the file.
    let follows = judged_with(&known, &train, &other(&good), &|errors| errors.before.fill(1e-3));
    assert!(follows.reasons.iter().any(|reason| matches!(reason, Reason::FollowsFile(_))), "{follows:?}");
    let none = judged_with(&known, &train, &other(&good), &|errors| {
        errors.after.fill(0.2);
        errors.before.fill(0.2);
    });
    assert!(none.grade == Grade::Refused, "{none:?}");
    assert!(matches!(none.reasons[0], Reason::NoBetter(..)), "{none:?}");
}

#[test]
fn a_log_for_validation_with_a_fault_makes_a_good_model_doubtful() {
    let known = load("elbow.toml");
    let good = truth(&known, [1.2, 0.85, 1.15]);
    let train = log(&known, &good, &Making::default());
    let mut other = log(&known, &good, &Making { motion: 9, ..Making::default() });
    other.tau[1].iter_mut().for_each(|tau| *tau = -*tau);
    let mut found = judged(&known, &train, &other);
    found.explain_validation(|| explain(known.arm.as_ref(), &known.maker(), &[other]));
    assert!(matches!(found.reasons.first(), Some(Reason::ExplainedThere(_))), "{found:?}");
}

#[test]
fn an_arm_of_which_only_the_geometry_is_told_is_identified() {
    let known = load("elbow.toml");
    let good = truth(&known, [1.0; 3]);
    let maker = Maker { links: vec![[0.0; 10]; 3], rotors: vec![0.0; 3], ..known.maker() };
    let train = log(&known, &good, &Making::default());
    let found = identify(known.arm.as_ref(), &maker, std::slice::from_ref(&train), &settings());
    let prediction =
        found.predict(known.arm.as_ref(), &log(&known, &good, &Making { motion: 9, noise: 0.0, ..Making::default() }));
    let left = rms(&difference(&prediction.measured, &prediction.model));
    for (joint, (left, size)) in left.iter().zip(rms(&prediction.measured)).enumerate() {
        assert!(left / size < 0.05, "joint {joint}: {left} of {size}");
    }
    // Gravity determines the last link's first moment.
    let error = (found.bodies.parameters[21] - good[21]).abs();
    assert!(error < 3.0 * found.bodies.deviations[21] && error < 0.05 * good[21].abs(), "{error}");
    // A reversed sign is found without the maker's masses, too, because friction shows it.
    let mut negated = train;
    negated.tau.iter_mut().flatten().for_each(|tau| *tau = -*tau);
    let findings = explain(known.arm.as_ref(), &maker, &[negated]);
    let first = findings.explanations.first().map(|one| one.faults.clone());
    assert_eq!(first, Some(vec![identification::hypotheses::Fault::TorqueSigns]));
}
