//! Search over single faults and pairs of faults.

use super::orders::{all_orders, usual_orders};
use super::{Explanation, Fault};
use crate::arm::Arm;
use crate::correction::Correction;
use crate::evidence::{Evidence, Expected, Score, Source};
use crate::log::Log;
use nalgebra::Vector3;
use rayon::prelude::*;

/// A factor nearer to 1 than this does not indicate another unit: torque constants and masses can be wrong by as much.
const NEAR: f64 = 1.8;
/// The same for a single joint, whose scale follows from the other joints.
const NEAR_ONE: f64 = 1.6;
/// Factors between angle units and radians: degrees and turns, both directions.
const ANGLES: [f64; 4] =
    [std::f64::consts::PI / 180.0, 180.0 / std::f64::consts::PI, std::f64::consts::TAU, 1.0 / std::f64::consts::TAU];
/// Largest number of joints for which every order of the torques is tried.
const ALL_ORDERS: usize = 6;
/// Number of best explanations that are extended by a second fault of torque, and of motion.
const BEAM: usize = 4;
const BEAM_OF_MOTION: usize = 2;
/// A log is suspicious beyond one of these: unexplained share of a joint's torque; standard deviations by which friction drives a joint; squared
/// distance from the maker's numbers per unknown; ratio of all bodies' weight to the maker's.
const MISSES: f64 = 0.2;
const DRIVES: f64 = 2.0;
const DISTANT: f64 = 0.3;
const HEAVIER: f64 = 1.5;
/// Number of explanations whose scale is estimated again at the end.
const POLISHED: usize = 3;
/// Smallest gain for which faults of a log that fits well are searched further, nats.
const SUSPECT: f64 = 8.0;

struct Bench<'a> {
    arm: &'a dyn Arm,
    expected: &'a Expected,
    logs: &'a [Log],
    joints: usize,
}

/// True if two corrections differ only in the size of factors, and by less than 35 %.
pub(super) fn alike(a: &Correction, b: &Correction) -> bool {
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 0.35);
    a.positions_from == b.positions_from
        && a.torques_from == b.torques_from
        && near(&a.position, &b.position)
        && near(&a.torque, &b.torque)
}

/// Explanations by one and by two faults, the best first. Empty if the log is explained as recorded.
pub(super) fn search(
    arm: &dyn Arm,
    expected: &Expected,
    logs: &[Log],
    evidence: &Evidence,
    recorded: &Score,
) -> Vec<Explanation> {
    let bench = Bench { arm, expected, logs, joints: arm.joints() };
    let mut found = rough(&bench, evidence, recorded);
    found.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
    for one in found.iter_mut().take(POLISHED) {
        if let Some(better) = bench.polished(one) {
            *one = better;
        }
    }
    found
}

/// Explanations with scales from the coarse estimates, before refinement.
fn rough(bench: &Bench<'_>, evidence: &Evidence, recorded: &Score) -> Vec<Explanation> {
    let suspicious = is_suspicious(recorded);
    let mut found = bench.torque_faults(evidence, &[], suspicious);
    if !suspicious && !found.iter().any(|one| one.worth() > recorded.nats + SUSPECT) {
        return Vec::new();
    }
    let clean = |found: &[Explanation]| best(found).is_some_and(|one| !is_suspicious(&one.score));
    // About an axis of symmetry, a reversed torque cannot be told from a reversed position, so try those too.
    let torques_suffice = clean(&found);
    let motions = if torques_suffice { bench.signs_alike(&found) } else { bench.motion_faults() };
    let alone: Vec<(Fault, Evidence)> = motions
        .into_par_iter()
        .map(|fault| {
            let evidence = bench.evidence(std::slice::from_ref(&fault));
            (fault, evidence)
        })
        .collect();
    let singles: Vec<Explanation> =
        alone.iter().map(|(fault, evidence)| bench.explanation(evidence, vec![fault.clone()])).collect();
    found.extend(singles.iter().cloned());
    let hopeful = found.iter().any(|one| one.worth() > recorded.nats + SUSPECT);
    if clean(&found) || !hopeful {
        return found;
    }
    // One fault of motion and one of torque.
    let both =
        |(fault, evidence): &(Fault, Evidence)| bench.torque_faults(evidence, std::slice::from_ref(fault), false);
    found.extend(alone.par_iter().map(both).collect::<Vec<_>>().into_iter().flatten());
    let pair = |(a, b): &(usize, usize)| {
        let faults = vec![alone[*a].0.clone(), alone[*b].0.clone()];
        bench.explanation(&bench.evidence(&faults), faults)
    };
    let sign = |k: &usize| matches!(alone[*k].0, Fault::PositionSign(_));
    let signs: Vec<usize> = (0..alone.len()).filter(sign).collect();
    let pairs: Vec<(usize, usize)> =
        signs.iter().flat_map(|a| signs.iter().filter(move |b| *b > a).map(move |b| (*a, *b))).collect();
    found.par_extend(pairs.par_iter().map(pair));
    // Two faults of torques: from the best single ones, and from common scales, which can hide the effect of a second fault.
    found.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
    let torques = |one: &&Explanation| one.faults.len() == 1 && !one.faults[0].is_of_motion();
    let scales = |one: &&Explanation| matches!(one.faults[..], [Fault::TorqueScales(_)]);
    let mut first: Vec<Vec<Fault>> = found.iter().filter(torques).take(BEAM).map(|one| one.faults.clone()).collect();
    first.extend(found.iter().filter(scales).map(|one| one.faults.clone()));
    for faults in first {
        found.extend(bench.torque_faults(evidence, &faults, false));
    }
    if clean(&found) {
        return found;
    }
    // Two faults of motion.
    let mut order: Vec<usize> = (0..alone.len()).collect();
    order.sort_by(|a, b| singles[*b].worth().total_cmp(&singles[*a].worth()));
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for &a in order.iter().take(BEAM_OF_MOTION) {
        pairs.extend((0..alone.len()).filter(|b| *b != a).map(|b| (a, b)));
    }
    found.par_extend(pairs.par_iter().map(pair));
    found
}

/// Explanation with the greatest worth.
fn best(found: &[Explanation]) -> Option<&Explanation> {
    found.iter().max_by(|a, b| a.worth().total_cmp(&b.worth()))
}

impl Bench<'_> {
    fn mend(&self, faults: &[Fault]) -> (Correction, Vector3<f64>) {
        let (mut correction, mut gravity) = (Correction::none(self.joints), self.arm.gravity());
        // Apply orders first: the other faults count joints of the arm, not columns of the file.
        let (orders, others): (Vec<&Fault>, Vec<&Fault>) = faults
            .iter()
            .partition(|fault| matches!(fault, Fault::Order(_) | Fault::TorqueOrder(_) | Fault::PositionOrder(_)));
        orders.into_iter().chain(others).for_each(|fault| fault.mend(&mut correction, &mut gravity));
        (correction, gravity)
    }

    fn evidence(&self, faults: &[Fault]) -> Evidence {
        let (correction, gravity) = self.mend(faults);
        // The score itself sorts and scales the torques.
        let n = self.joints;
        let motion = Correction { torques_from: (0..n).collect(), torque: vec![1.0; n], ..correction };
        let logs: Vec<Log> = self.logs.iter().map(|log| motion.apply(log)).collect();
        Evidence::of(self.arm.under(gravity).as_ref(), self.expected, &logs)
    }

    /// The explanation with its scale estimated again while its other faults stay.
    fn polished(&self, found: &Explanation) -> Option<Explanation> {
        let scale = |fault: &&Fault| matches!(fault, Fault::TorqueScale(..) | Fault::TorqueScales(_));
        let (scales, others): (Vec<&Fault>, Vec<&Fault>) = found.faults.iter().partition(scale);
        let [scale] = scales[..] else { return None };
        let others: Vec<Fault> = others.into_iter().cloned().collect();
        let evidence = self.evidence(&others);
        let sources = sources(&self.mend(&others).0);
        let with = |by: f64| {
            let fault = match scale {
                Fault::TorqueScale(joint, _) => Fault::TorqueScale(*joint, by),
                _ => Fault::TorqueScales(by),
            };
            self.explanation(&evidence, [others.as_slice(), &[fault]].concat())
        };
        let estimates = match scale {
            Fault::TorqueScale(joint, _) => vec![evidence.joint_scale(self.expected, &sources, *joint)],
            _ => evidence.common_scales(self.expected, &sources).to_vec(),
        };
        let found = estimates.into_iter().filter_map(|by| best_scale(by, NEAR_ONE, &with));
        found.max_by(|a, b| a.score.nats.total_cmp(&b.score.nats))
    }

    /// Explanation by these faults; `evidence` must contain the columns that belong to them.
    fn explanation(&self, evidence: &Evidence, faults: Vec<Fault>) -> Explanation {
        let (correction, gravity) = self.mend(&faults);
        let score = evidence.score(self.expected, &sources(&correction));
        Explanation { faults, correction, gravity, score }
    }

    /// Explanations with one torque fault in addition to `faults`, whose columns `evidence` contains. If `wide`, tries every order and every pair of
    /// signs.
    fn torque_faults(&self, evidence: &Evidence, faults: &[Fault], wide: bool) -> Vec<Explanation> {
        let n = self.joints;
        let with = |more: &[Fault]| self.explanation(evidence, [faults, more].concat());
        let mut found: Vec<Explanation> = (0..n).map(|joint| with(&[Fault::TorqueSign(joint)])).collect();
        found.push(with(&[Fault::TorqueSigns]));
        if wide {
            let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
            found.extend(pairs.map(|(a, b)| with(&[Fault::TorqueSign(a), Fault::TorqueSign(b)])));
        }
        let orders = if wide && n <= ALL_ORDERS { all_orders(n) } else { usual_orders(n) };
        found.extend(orders.into_iter().map(|order| with(&[Fault::TorqueOrder(order)])));
        let sources = sources(&self.mend(faults).0);
        for common in evidence.common_scales(self.expected, &sources) {
            found.extend(best_scale(common, NEAR, &|by| with(&[Fault::TorqueScales(by)])));
        }
        for joint in 0..n {
            let own = evidence.joint_scale(self.expected, &sources, joint);
            found.extend(best_scale(own, NEAR_ONE, &|by| with(&[Fault::TorqueScale(joint, by)])));
        }
        found
    }

    /// Position-sign faults for the joints whose torques have the wrong sign.
    fn signs_alike(&self, found: &[Explanation]) -> Vec<Fault> {
        let faults = best(found).map(|one| one.faults.clone()).unwrap_or_default();
        let of = |fault: Fault| match fault {
            Fault::TorqueSign(joint) => Some(Fault::PositionSign(joint)),
            Fault::TorqueSigns => Some(Fault::PositionSigns),
            _ => None,
        };
        faults.into_iter().filter_map(of).collect()
    }

    /// Every single fault of motion and gravity.
    fn motion_faults(&self) -> Vec<Fault> {
        let n = self.joints;
        let mut found: Vec<Fault> = (0..n).map(Fault::PositionSign).collect();
        found.push(Fault::PositionSigns);
        found.extend(ANGLES.map(Fault::PositionScales));
        let orders = usual_orders(n);
        found.extend(orders.iter().cloned().map(Fault::Order));
        found.extend(orders.into_iter().map(Fault::PositionOrder));
        let gravity = self.arm.gravity();
        let size = if gravity.norm() > 1.0 { gravity.norm() } else { 9.81 };
        for k in 1..27 {
            let part = |place: i32| f64::from(k / 3_i32.pow(place as u32) % 3 - 1);
            let direction = Vector3::new(part(0), part(1), part(2));
            if direction.norm() > 0.5 {
                let other = direction.normalize() * size;
                if (other - gravity).norm() > 0.1 * size {
                    found.push(Fault::Gravity(other));
                }
            }
        }
        if gravity.norm() > 1.0 {
            found.push(Fault::NoGravity);
        }
        found
    }
}

/// True if the log is explained badly, or only by implausible parameters.
fn is_suspicious(score: &Score) -> bool {
    let b = score.x.len() as f64;
    score.left.iter().any(|left| *left > MISSES)
        || score.friction.iter().any(|z| *z < -DRIVES)
        || score.distance > DISTANT * b
        || !(HEAVIER.recip()..HEAVIER).contains(&score.heavier)
}

/// Column of each joint's torque in the file, and its factor.
fn sources(correction: &Correction) -> Vec<Source> {
    correction.torques_from.iter().copied().zip(correction.torque.iter().copied()).collect()
}

/// The best factor near an estimate, if it is far enough from 1.
fn best_scale(estimate: f64, near: f64, with: &dyn Fn(f64) -> Explanation) -> Option<Explanation> {
    if !(1e-6..1e6).contains(&estimate) {
        return None;
    }
    let tried = [0.7, 0.85, 1.0, 1.2, 1.4].map(|by| estimate * by).into_iter().filter(|by| by.max(by.recip()) > near);
    tried.map(with).max_by(|a, b| a.score.nats.total_cmp(&b.score.nats))
}
