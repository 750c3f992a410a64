//! Verdict on an identification: trusted, doubtful or refused, with reasons.

use crate::hypotheses::{Explanation, Findings};
use crate::identify::Identified;
use crate::prediction::{Prediction, rms};

/// Judgement of an identified model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// The model explains logs that it has not seen, with plausible parameters.
    Trusted,
    /// The user should inspect the results before using the model.
    Doubtful,
    /// The log does not determine a model, or contradicts the arm.
    Refused,
}

impl Grade {
    /// Name in reports.
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
    /// Faults of the validation logs explain them.
    ExplainedThere(Vec<Explanation>),
    /// The motion does not separate the parameters. Holds the condition number of their columns.
    LittleMotion(f64),
    /// The log leaves a joint's torque in other motions uncertain. Holds the joint, and the remaining share of the maker's uncertainty.
    Unexcited(usize, f64),
    /// All torques together are predicted no better than by the robot file. Holds the mean relative error before and after.
    NoBetter(f64, f64),
    /// A joint's torque is predicted worse than by the robot file. Holds the joint, and its relative error before and after.
    Worse(usize, f64, f64),
    /// A joint's relative torque error, which is not noise.
    Missed(usize, f64),
    /// A joint is predicted worse in the validation logs than in the others. Holds the joint, and its relative errors there and here.
    OtherThere(usize, f64, f64),
    /// All bodies together are heavier than the maker's by this factor.
    Heavier(f64),
    /// The mass of a link is this multiple of the maker's.
    Mass(usize, f64),
    /// Friction drives a joint instead of braking it, by this many standard deviations.
    Drives(usize, f64),
    /// The physically consistent bodies are this many standard deviations from least squares.
    Impossible(f64),
    /// The torques equal those of the robot file's own model. Holds the largest relative difference.
    FollowsFile(f64),
}

impl Reason {
    /// The grade that this finding causes; the model's grade is the worst of them.
    #[must_use]
    pub const fn grade(&self) -> Grade {
        match self {
            Self::Explained(_) | Self::LittleMotion(_) | Self::NoBetter(..) => Grade::Refused,
            _ => Grade::Doubtful,
        }
    }
}

/// A grade and its reasons; a trusted model has no reasons.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// The reasons, the worst first.
    pub reasons: Vec<Reason>,
}

/// Relative errors of torques, one number for each joint.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    /// Errors of the robot file's own numbers, on the judged logs.
    pub before: Vec<f64>,
    /// Errors of the identified model, on the judged logs.
    pub after: Vec<f64>,
    /// Errors of the identified model in held-out blocks of the logs.
    pub held_out: Vec<f64>,
    /// Autocorrelation of the residual at a lag of 0.25 s, on the judged logs.
    pub persistence: Vec<f64>,
    /// True if the judged logs are not those of the identification.
    pub others: bool,
}

/// Condition number above which the parameters are not separated.
const CONDITION: f64 = 200.0;
/// Remaining share of the maker's uncertainty above which a joint counts as not excited.
const UNEXCITED: f64 = 0.6;
/// Largest ratio of the mean error to the error before, and the relative error up to which this check does not apply.
const BETTER: (f64, f64) = (0.97, 0.05);
/// Ratio of a joint's error to its error before that counts as worse, and the smallest relative error for which it counts.
const WORSE: (f64, f64) = (1.5, 0.1);
/// Relative error of a joint, and the autocorrelation above which the residual is not noise.
const MISSED: (f64, f64) = (0.3, 0.4);
/// Ratio of the error in validation logs to that in held-out blocks, and the smallest relative error for which it counts.
const THERE: (f64, f64) = (4.0, 0.25);
/// Largest mass ratio to the maker's: of all bodies together, and of a single link.
const HEAVIER: f64 = 1.5;
const MASS: f64 = 4.0;
/// Standard deviations from which friction drives a joint, and from which the least-squares bodies are impossible.
const DRIVES: f64 = 3.0;
const IMPOSSIBLE: f64 = 4.0;
/// Relative difference below which the torques come from the robot file's own model; no real arm agrees so well.
const FOLLOWS: f64 = 0.003;

/// Judges an identified model.
///
/// `masses` holds, for each link whose mass the log determines, its index and the ratio of its mass to the maker's.
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
        // All other findings follow from the fault.
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
    /// Adds explanations of the validation logs if they fit badly.
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

/// Autocorrelation of each joint's residual torque at a lag of 0.25 s, from 0 to 1.
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
