//! Selection of friction terms and direction rules by cross-validation.
//!
//! Each candidate is fitted and judged, joint by joint, by its error in held-out blocks of the logs. A candidate that does not lower the error by
//! [`EARNED`] is left out.

use crate::base::Base;
use crate::fit::FitProblem;
use crate::friction::{Direction, FrictionLaw, Term};
use crate::prepare::Prepared;
use rayon::prelude::*;

/// Relative reduction of the held-out error that a term must achieve. With a smaller threshold, chance decides: at a third of it, terms were accepted
/// on one half of a real arm's log and made the other half worse.
pub const EARNED: f64 = 0.03;
/// The same threshold for a change of the direction rule.
const EARNED_DIRECTION: f64 = 0.06;

/// Candidate rules for the direction of motion; widths in rad (m), speeds in rad/s (m/s).
const DIRECTIONS: [Direction; 11] = [
    Direction::Hysteresis(1e-4),
    Direction::Hysteresis(3e-5),
    Direction::Hysteresis(3e-4),
    Direction::Hysteresis(1e-3),
    Direction::Hysteresis(5e-3),
    Direction::Smooth(1e-3),
    Direction::Smooth(2e-3),
    Direction::Smooth(5e-3),
    Direction::Smooth(1e-2),
    Direction::Smooth(2e-2),
    Direction::Smooth(8e-2),
];

/// Candidate terms besides offset, viscous and Coulomb friction. From each group, a joint accepts the best.
const GROUPS: [&[Change]; 5] = [
    &[Change::Term(Term::Load)],
    &[
        Change::Term(Term::Root),
        Change::Term(Term::Stribeck(0.01)),
        Change::Term(Term::Stribeck(0.02)),
        Change::Term(Term::Stribeck(0.04)),
        Change::Term(Term::Stribeck(0.08)),
        Change::Term(Term::Stribeck(0.16)),
    ],
    &[Change::Speed(0.71), Change::Speed(0.84), Change::Speed(1.19), Change::Speed(1.41)],
    &[Change::RiseLoad],
    &[Change::Term(Term::Asymmetric)],
];

/// Name of the candidate without an offset. The joints that keep it do no better with an offset.
pub const WITHOUT_OFFSET: &str = "without offset";

/// A candidate and its results.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Description of the candidate.
    pub what: String,
    /// Root mean square of each joint's torque error in held-out blocks, N m or N.
    pub held_out: Vec<f64>,
    /// True for each joint that keeps the candidate.
    pub kept: Vec<bool>,
}

/// Chooses the friction law of every joint; also returns all candidates that were tried.
#[must_use]
pub fn laws(logs: &[Prepared], base: &Base) -> (Vec<FrictionLaw>, Vec<Tried>) {
    let judge = |laws: &[FrictionLaw]| FitProblem { logs, base, laws }.fit().held_out();
    let mut laws = vec![FrictionLaw::with(DIRECTIONS[0], &[]); base.joints];
    let mut best = judge(&laws);
    let mut tried = vec![Tried { what: DIRECTIONS[0].name(), held_out: best.clone(), kept: vec![true; laws.len()] }];
    let others = DIRECTIONS[1..].iter().map(|direction| Change::Direction(*direction));
    try_group(&judge, &mut laws, &mut best, &mut tried, &others.collect::<Vec<_>>());
    for group in GROUPS {
        try_group(&judge, &mut laws, &mut best, &mut tried, group);
    }
    // The offset stays in the fit, where it absorbs an error of the torque's zero. This comparison only decides whether the robot file gets the
    // offset.
    let without: Vec<FrictionLaw> = laws.iter().map(FrictionLaw::without_offset).collect();
    let held_out = judge(&without);
    let kept = held_out.iter().zip(&best).map(|(without, with)| (1.0 - EARNED) * without < *with).collect();
    tried.push(Tried { what: WITHOUT_OFFSET.to_owned(), held_out, kept });
    (laws, tried)
}

#[derive(Clone, Copy)]
enum Change {
    Direction(Direction),
    Term(Term),
    /// A Stribeck velocity multiplied by this factor.
    Speed(f64),
    /// A rise that grows with the load.
    RiseLoad,
}

impl Change {
    fn of(self, law: &FrictionLaw) -> FrictionLaw {
        let mut law = law.clone();
        match self {
            Self::Direction(direction) => law.direction = direction,
            Self::Term(term) => law.terms.push(term),
            Self::Speed(factor) => {
                for term in &mut law.terms {
                    if let Term::Stribeck(speed) = term {
                        *speed *= factor;
                    }
                }
            }
            Self::RiseLoad => law.terms.extend(law.stribeck_speed().map(Term::StribeckLoad)),
        }
        law
    }

    const fn earned(self) -> f64 {
        match self {
            Self::Direction(_) => EARNED_DIRECTION,
            Self::Term(_) | Self::RiseLoad => EARNED,
            // Changing a speed adds no coefficient, so there is no risk of fitting noise.
            Self::Speed(_) => 0.0,
        }
    }

    fn name(self) -> String {
        match self {
            Self::Direction(direction) => direction.name(),
            Self::Term(term) => term.name(),
            Self::Speed(factor) => format!("stribeck velocity times {factor}"),
            Self::RiseLoad => "stribeck load".to_owned(),
        }
    }
}

/// Fits every change in all joints at once. Each joint then keeps the change that helps it most.
fn try_group(
    judge: &(impl Fn(&[FrictionLaw]) -> Vec<f64> + Sync),
    laws: &mut [FrictionLaw],
    best: &mut [f64],
    tried: &mut Vec<Tried>,
    changes: &[Change],
) {
    let errors: Vec<Vec<f64>> =
        changes.par_iter().map(|change| judge(&laws.iter().map(|law| change.of(law)).collect::<Vec<_>>())).collect();
    let pick = |joint: usize| {
        let all = errors.iter().enumerate().map(|(k, e)| (k, e[joint]));
        all.min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(k, e)| *e < (1.0 - changes[*k].earned()) * best[joint])
            .map(|(k, _)| k)
    };
    let picked: Vec<Option<usize>> = (0..laws.len()).map(pick).collect();
    let combined: Vec<FrictionLaw> =
        laws.iter().zip(&picked).map(|(law, k)| k.map_or_else(|| law.clone(), |k| changes[k].of(law))).collect();
    let together = if picked.iter().any(Option::is_some) { judge(&combined) } else { best.to_vec() };
    // Joints share links: a change that helps one joint alone may not help together with the changes of the others.
    let lower = |joint: usize| picked[joint].is_some() && together[joint] < best[joint];
    let kept: Vec<bool> = (0..laws.len()).map(lower).collect();
    for (k, change) in changes.iter().enumerate() {
        let kept = (0..laws.len()).map(|joint| kept[joint] && picked[joint] == Some(k)).collect();
        tried.push(Tried { what: change.name(), held_out: errors[k].clone(), kept });
    }
    for joint in 0..laws.len() {
        if kept[joint] {
            laws[joint] = combined[joint].clone();
            best[joint] = together[joint];
        }
    }
}
