//! Verdict on an identification: trusted, doubtful or refused, with reasons.

use crate::hypotheses::{Explanation, Findings};
use crate::identify::Identified;
use crate::prediction::{Prediction, rms};

/// Judgement of an identified model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// The model explains logs that it has not seen, with plausible parameters.
    Trusted,
    /// A person should look before the model is used.
    Doubtful,
    /// The log cannot give a model, or contradicts the arm.
    Refused,
}

impl Grade {
    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trusted => "trusted",
            Self::Doubtful => "doubtful",
            Self::Refused => "refused",
        }
    }
}

/// A finding about an identification. Joints and links are counted from 0.
#[derive(Clone, Debug)]
pub enum Reason {
    /// One or two faults of the log explain it, the most likely first.
    Explained(Vec<Explanation>),
    /// Faults of the logs for validation explain them.
    ExplainedThere(Vec<Explanation>),
    /// The motion does not separate the parameters: the condition number of their columns.
    LittleMotion(f64),
    /// Share of the maker's uncertainty about a joint's torque in other motions that the log leaves.
    Unexcited(usize, f64),
    /// All torques together are predicted no better than by the robot file: the mean relative error before and after.
    NoBetter(f64, f64),
    /// A joint's torque is predicted worse than by the robot file: relative error before and after.
    Worse(usize, f64, f64),
    /// Relative error of a joint's torque that is no noise.
    Missed(usize, f64),
    /// A joint is predicted worse in the logs for validation than in the others: relative errors there and here.
    OtherThere(usize, f64, f64),
    /// All bodies together are so many times as heavy as the maker's.
    Heavier(f64),
    /// The mass of a link is so many times the maker's.
    Mass(usize, f64),
    /// Friction drives a joint instead of braking it: by so many standard deviations.
    Drives(usize, f64),
    /// Possible bodies are so many standard deviations from least squares.
    Impossible(f64),
    /// The torques follow the robot file's own model: largest relative difference.
    FollowsFile(f64),
}

impl Reason {
    /// The worst grade that a model with this finding can have.
    #[must_use]
    pub const fn grade(&self) -> Grade {
        match self {
            Self::Explained(_) | Self::LittleMotion(_) | Self::NoBetter(..) => Grade::Refused,
            _ => Grade::Doubtful,
        }
    }
}

/// A grade and its reasons; none for a trusted model.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// The reasons, the worst first.
    pub reasons: Vec<Reason>,
}

/// Relative errors of torques, a number for each joint.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    /// By the robot file's own numbers, on the judged logs.
    pub before: Vec<f64>,
    /// By the identified model, on the judged logs.
    pub after: Vec<f64>,
    /// By the identified model in blocks of the logs that were held out.
    pub held_out: Vec<f64>,
    /// Autocorrelation of what is left after a quarter of a second, on the judged logs.
    pub persistence: Vec<f64>,
    /// True if the judged logs are others than those of the identification.
    pub others: bool,
}

/// Condition number from which on the parameters are not separated.
const CONDITION: f64 = 200.0;
/// Share of the maker's uncertainty that is left from which on a joint counts as not excited.
const UNEXCITED: f64 = 0.6;
/// Largest error of all torques together over that before, and the relative error up to which this does not count.
const BETTER: (f64, f64) = (0.97, 0.05);
/// Error of one joint over that before from which on it is worse, and from which size of it.
const WORSE: (f64, f64) = (1.5, 0.1);
/// Relative error of a joint, and the autocorrelation from which on it is no noise.
const MISSED: (f64, f64) = (0.3, 0.4);
/// Error in other logs over that in blocks held out, and from which size of it.
const THERE: (f64, f64) = (4.0, 0.25);
/// Bodies together, and a link alone, so many times as heavy.
const HEAVIER: f64 = 1.5;
const MASS: f64 = 4.0;
/// Standard deviations by which friction drives a joint, and by which bodies are impossible.
const DRIVES: f64 = 3.0;
const IMPOSSIBLE: f64 = 4.0;
/// Relative difference below which a torque follows the robot file's own model: no real arm does.
const FOLLOWS: f64 = 0.003;

/// The verdict on an identified model.
///
/// `masses` holds, for each link whose mass the log sees, its mass over the maker's.
#[must_use]
pub fn verdict(
    found: &Identified,
    findings: &Findings,
    errors: &Errors,
    masses: &[(usize, f64)],
    open: &[f64],
) -> Verdict {
    let mut reasons = Vec::new();
    if !findings.explanations.is_empty() {
        // All else that is strange follows from it.
        let reasons = vec![Reason::Explained(findings.explanations.clone())];
        return Verdict { grade: Grade::Refused, reasons };
    }
    if found.condition > CONDITION {
        reasons.push(Reason::LittleMotion(found.condition));
    }
    let mean = |x: &[f64]| (x.iter().map(|x| x.max(1e-9).ln()).sum::<f64>() / x.len().max(1) as f64).exp();
    let (before, after) = (mean(&errors.before), mean(&errors.after));
    if after > BETTER.0 * before && after > BETTER.1 {
        reasons.push(Reason::NoBetter(before, after));
    }
    for (joint, after) in errors.after.iter().enumerate() {
        let before = errors.before[joint];
        if *after > WORSE.0 * before && *after > WORSE.1 {
            reasons.push(Reason::Worse(joint, before, *after));
        }
        if *after > MISSED.0 && errors.persistence[joint] > MISSED.1 {
            reasons.push(Reason::Missed(joint, *after));
        }
        let held_out = errors.held_out[joint];
        if errors.others && *after > THERE.0 * held_out && *after > THERE.1 {
            reasons.push(Reason::OtherThere(joint, *after, held_out));
        }
    }
    let unexcited = open.iter().enumerate().filter(|(_, share)| **share > UNEXCITED);
    reasons.extend(unexcited.map(|(joint, share)| Reason::Unexcited(joint, *share)));
    let recorded = &findings.recorded;
    if !(HEAVIER.recip()..HEAVIER).contains(&recorded.heavier) {
        reasons.push(Reason::Heavier(recorded.heavier));
    }
    let far = masses.iter().filter(|(_, times)| !(MASS.recip()..MASS).contains(times));
    reasons.extend(far.map(|(link, times)| Reason::Mass(*link, *times)));
    let driven = recorded.friction.iter().enumerate().filter(|(_, z)| **z < -DRIVES);
    reasons.extend(driven.map(|(joint, z)| Reason::Drives(joint, -z)));
    let impossible = (found.distance() / found.base.len().max(1) as f64).sqrt();
    if impossible > IMPOSSIBLE {
        reasons.push(Reason::Impossible(impossible));
    }
    let follows = errors.before.iter().fold(0.0_f64, |most, error| most.max(*error));
    if follows < FOLLOWS {
        reasons.push(Reason::FollowsFile(follows));
    }
    reasons.sort_by_key(|reason| std::cmp::Reverse(reason.grade()));
    let grade = reasons.iter().map(Reason::grade).max().unwrap_or(Grade::Trusted);
    Verdict { grade, reasons }
}

impl Verdict {
    /// Adds what explains the logs for validation, if they fit badly.
    pub fn explain_validation(&mut self, findings: impl FnOnce() -> Findings) {
        let bad = |reason: &Reason| {
            matches!(reason, Reason::NoBetter(..) | Reason::Worse(..) | Reason::Missed(..) | Reason::OtherThere(..))
        };
        let known = |reason: &Reason| matches!(reason, Reason::Explained(_));
        if self.reasons.iter().any(known) || !self.reasons.iter().any(bad) {
            return;
        }
        let explanations = findings().explanations;
        if !explanations.is_empty() {
            self.reasons.insert(0, Reason::ExplainedThere(explanations));
        }
    }
}

/// Autocorrelation of what is left of each joint's torque after a quarter of a second, from 0 to 1, and the root mean square of it.
#[must_use]
pub fn persistence(prediction: &Prediction) -> Vec<f64> {
    let (time, measured) = (&prediction.time, &prediction.measured);
    let step = match (time.first(), time.last()) {
        (Some(first), Some(last)) if time.len() > 1 => (last - first) / (time.len() - 1) as f64,
        _ => return vec![0.0; measured.len()],
    };
    let lag = ((0.25 / step).round() as usize).max(1);
    let left = prediction.left(&prediction.model);
    let of = |(left, rms): (&Vec<f64>, f64)| {
        let product: f64 = left.iter().zip(left.iter().skip(lag)).map(|(a, b)| a * b).sum();
        (product / (rms * rms * left.len() as f64).max(1e-300)).max(0.0)
    };
    left.iter().zip(rms(&left)).map(of).collect()
}
