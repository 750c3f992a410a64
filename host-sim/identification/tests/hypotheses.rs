//! Faults are found in logs of several arms, alone and in pairs; good logs are left alone.

use crate::arms::{Known, load};
use crate::made::{Making, Random, log, parallel};
use identification::hypotheses::{Fault, explain};
use identification::log::Log;
use nalgebra::Vector3;

/// A log of an arm that has rotors, and bodies that differ from the maker's.
fn recorded(known: &Known, seed: u64, making: &Making) -> Log {
    let n = known.joints();
    let mut random = Random::new(seed);
    let factors: Vec<f64> = (0..n).map(|_| 0.8 + 0.4 * random.share()).collect();
    let mut truth: Vec<f64> =
        known.parameters.iter().enumerate().map(|(k, x)| x * factors.get(k / 10).copied().unwrap_or(1.0)).collect();
    truth[10 * n..].iter_mut().for_each(|rotor| *rotor += 0.02 + 0.05 * random.share());
    log(known, &truth, &Making { seed, motion: 100 + seed, ..*making })
}

fn scaled(series: &mut [Vec<f64>], joints: impl IntoIterator<Item = usize>, by: f64) {
    for joint in joints {
        series[joint].iter_mut().for_each(|x| *x *= by);
    }
}

/// Succeeds if these are the faults of the best explanation, or of an equally good one.
fn is_named(known: &Known, log: &Log, wanted: &[Fault]) -> Result<(), String> {
    let found = explain(known.arm.as_ref(), &known.maker(), std::slice::from_ref(log));
    let same = |a: &Fault, b: &Fault| match (a, b) {
        (Fault::TorqueScale(a, x), Fault::TorqueScale(b, y)) => a == b && (x / y).max(y / x) < 1.5,
        (Fault::TorqueScales(x), Fault::TorqueScales(y)) => (x / y).max(y / x) < 1.5,
        (Fault::Gravity(a), Fault::Gravity(b)) => (a - b).norm() < 1.0,
        _ => a == b,
    };
    let all = |faults: &[Fault]| {
        faults.len() == wanted.len() && wanted.iter().all(|one| faults.iter().any(|other| same(one, other)))
    };
    match found.explanations.iter().any(|one| all(&one.faults)) {
        true => Ok(()),
        false => Err(format!(
            "{wanted:?}: {:?} {:?}",
            found.explanations.iter().map(|one| &one.faults).collect::<Vec<_>>(),
            found.recorded.left
        )),
    }
}

type Spoil = (Vec<Fault>, Box<dyn Fn(&mut Log) + Sync>);

/// Every kind of fault, at one joint.
fn singles(n: usize, joint: usize) -> Vec<Spoil> {
    let reversed: Vec<usize> = (0..n).rev().collect();
    let (a, b) = (joint, (joint + 1) % n);
    let mut exchanged: Vec<usize> = (0..n).collect();
    exchanged.swap(a, b);
    vec![
        (vec![Fault::TorqueSign(joint)], Box::new(move |log| scaled(&mut log.tau, [joint], -1.0))),
        (vec![Fault::TorqueSigns], Box::new(move |log| scaled(&mut log.tau, 0..n, -1.0))),
        (vec![Fault::PositionSign(joint)], Box::new(move |log| scaled(&mut log.q, [joint], -1.0))),
        (vec![Fault::TorqueScales(0.01)], Box::new(move |log| scaled(&mut log.tau, 0..n, 100.0))),
        (vec![Fault::TorqueScales(0.113)], Box::new(move |log| scaled(&mut log.tau, 0..n, 8.85))),
        (vec![Fault::TorqueScales(50.0)], Box::new(move |log| scaled(&mut log.tau, 0..n, 0.02))),
        (vec![Fault::TorqueScale(joint, 0.1)], Box::new(move |log| scaled(&mut log.tau, [joint], 10.0))),
        (vec![Fault::TorqueScale(joint, 0.001)], Box::new(move |log| scaled(&mut log.tau, [joint], 1000.0))),
        (
            vec![Fault::Order(reversed)],
            Box::new(|log| {
                log.q.reverse();
                log.tau.reverse();
            }),
        ),
        (vec![Fault::TorqueOrder(exchanged.clone())], Box::new(move |log| log.tau.swap(a, b))),
        (vec![Fault::PositionOrder(exchanged)], Box::new(move |log| log.q.swap(a, b))),
        (
            vec![Fault::PositionScales(1f64.to_radians())],
            Box::new(move |log| scaled(&mut log.q, 0..n, 1f64.to_degrees())),
        ),
    ]
}

/// Pairs of faults that hold together.
fn pairs(n: usize) -> Vec<Spoil> {
    let last = n - 1;
    vec![
        (
            vec![Fault::TorqueSign(0), Fault::TorqueSign(last)],
            Box::new(move |log| scaled(&mut log.tau, [0, last], -1.0)),
        ),
        (
            vec![Fault::PositionSign(1), Fault::TorqueSign(1)],
            Box::new(|log| {
                scaled(&mut log.q, [1], -1.0);
                scaled(&mut log.tau, [1], -1.0);
            }),
        ),
        (
            vec![Fault::PositionSign(1), Fault::TorqueSign(last)],
            Box::new(move |log| {
                scaled(&mut log.q, [1], -1.0);
                scaled(&mut log.tau, [last], -1.0);
            }),
        ),
        (
            vec![Fault::TorqueScales(0.001), Fault::TorqueSign(1)],
            Box::new(move |log| {
                scaled(&mut log.tau, 0..n, 1000.0);
                scaled(&mut log.tau, [1], -1.0);
            }),
        ),
        (
            vec![Fault::Order((0..n).rev().collect()), Fault::TorqueScales(0.1)],
            Box::new(move |log| {
                log.q.reverse();
                log.tau.reverse();
                scaled(&mut log.tau, 0..n, 10.0);
            }),
        ),
        (vec![Fault::PositionSign(1), Fault::PositionSign(2)], Box::new(|log| scaled(&mut log.q, [1, 2], -1.0))),
        (
            vec![Fault::TorqueScale(1, 0.1), Fault::TorqueSign(2)],
            Box::new(|log| {
                scaled(&mut log.tau, [1], 10.0);
                scaled(&mut log.tau, [2], -1.0);
            }),
        ),
    ]
}

/// Checks that every fault in these logs of an arm is found.
fn all_are_named(name: &str, making: &Making, spoils: &[Spoil]) {
    let known = load(name);
    let good = recorded(&known, 3, making);
    let missed: Vec<String> = parallel(spoils.len(), |k| {
        let mut log = good.clone();
        spoils[k].1(&mut log);
        is_named(&known, &log, &spoils[k].0)
    })
    .into_iter()
    .filter_map(Result::err)
    .collect();
    assert!(missed.is_empty(), "{name}: {missed:#?}");
}

#[test]
fn single_faults_of_a_six_joint_arm_are_named() {
    all_are_named("yam.toml", &Making::default(), &singles(6, 2));
}

#[test]
fn single_faults_of_an_elbow_arm_are_named_at_each_joint() {
    for joint in 0..3 {
        all_are_named("elbow.toml", &Making::default(), &singles(3, joint));
    }
}

#[test]
fn pairs_of_faults_are_named() {
    all_are_named("elbow.toml", &Making::default(), &pairs(3));
}

#[test]
fn another_mounting_and_weight_taken_off_are_named() {
    for (name, truth, wanted) in [
        ("yam.toml", Vector3::new(0.0, 0.0, 9.81), Fault::Gravity(Vector3::new(0.0, 0.0, 9.81))),
        ("yam.toml", Vector3::new(9.81, 0.0, 0.0), Fault::Gravity(Vector3::new(9.81, 0.0, 0.0))),
        ("yam.toml", Vector3::zeros(), Fault::NoGravity),
        ("elbow.toml", Vector3::new(0.0, -9.81, 0.0), Fault::Gravity(Vector3::new(0.0, -9.81, 0.0))),
    ] {
        let known = load(name);
        let mounted = Known { arm: known.arm.under(truth), ..load(name) };
        let log = recorded(&mounted, 3, &Making::default());
        assert_eq!(is_named(&known, &log, &[wanted]), Ok(()), "{name}");
    }
}

/// 200 good logs: bodies up to 20 % from the maker's, unknown rotors, various friction and noise.
#[test]
fn no_fault_is_named_in_good_logs() {
    let arms = ["yam.toml", "elbow.toml", "planar3r.toml", "puma560.toml"].map(load);
    let alarms: Vec<String> = parallel(200, |k| {
        let known = &arms[k % 4];
        let mut random = Random::new(900 + k as u64);
        let making = Making {
            duration: 10.0 + 10.0 * random.share(),
            rate: 50.0,
            friction: (0.3 * random.share(), 0.4 * random.share()),
            noise: 0.08 * random.share(),
            encoder: 1e-4 * random.share(),
            ..Making::default()
        };
        let found = explain(known.arm.as_ref(), &known.maker(), &[recorded(known, k as u64, &making)]);
        found.explanations.first().map(|one| format!("{k}: {:?} {:?}", one.faults, found.recorded.left))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(alarms.is_empty(), "{alarms:#?}");
}
