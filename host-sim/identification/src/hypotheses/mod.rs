//! Search for faults that explain a log better than the log as recorded.
//!
//! Each [`Fault`] is a change of the log, or of gravity. It is undone and the result scored by [`crate::evidence`]. Faults of torques need no new
//! columns of the model, so they are tried in combination with every fault of motion. Further pairs are tried starting from the best ones.

mod explanation;
mod fault;
mod orders;
mod search;

pub use explanation::Explanation;
pub use fault::Fault;

use crate::arm::Arm;
use crate::clock::repaired;
use crate::consistent::Maker;
use crate::correction::Correction;
use crate::evidence::{Evidence, Expected, Score};
use crate::log::Log;
use nalgebra::Vector3;

/// Score by which an explanation must beat the log as recorded, nats.
const CLEAR: f64 = 15.0;
/// Explanations within this distance of the best are reported, too, nats.
const CLOSE: f64 = 5.0;

/// Scores of a log as recorded and as corrected.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The log as recorded.
    pub recorded: Score,
    /// Explanations that beat it clearly: the best first, then those that are about as good with as few faults.
    pub explanations: Vec<Explanation>,
}

/// Searches for one or two faults that explain logs of an arm better than no fault does.
#[must_use]
pub fn explain(arm: &dyn Arm, maker: &Maker, logs: &[Log]) -> Findings {
    let logs: Vec<Log> = logs.iter().map(|log| repaired(log).0).collect();
    let expected = Expected::of(arm, maker);
    let evidence = Evidence::of(arm, &expected, &logs);
    let recorded = evidence.score(&expected, &evidence.as_recorded());
    let all = search::search(arm, &expected, &logs, &evidence, &recorded);
    let mut clear: Vec<Explanation> =
        all.into_iter().filter(|found| found.worth() > recorded.nats + CLEAR && found.explains()).collect();
    clear.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
    if let Some(best) = clear.first().cloned() {
        clear.retain(|other| other.worth() > best.worth() - CLOSE && other.faults.len() <= best.faults.len());
        // Of similar explanations, keep the best.
        let mut kinds = Vec::new();
        clear.retain(|found| {
            let kind = found.correction.clone();
            let same = |(known, gravity): &(Correction, Vector3<f64>)| {
                search::alike(known, &kind) && (gravity - found.gravity).norm() < 1.0
            };
            let new = !kinds.iter().any(same);
            kinds.push((kind, found.gravity));
            new
        });
    }
    Findings { recorded, explanations: clear }
}
