//! Check that motions keep their clearance, and its description.

use super::motion::{REST, fastest_ramp, quintic};
use super::surroundings::{JudgedSurroundings, Surroundings};
use crate::clearance::cell::Reason;
use dynamics_core::Model;
use dynamics_core::control::trajectory::Motion;
use identification::excite::Workspace;
use serde_json::{Value, json};
use sim::failure::Failure;

/// Largest amount by which the stated clearance may be below the true one, m.
const TOLERANCE: f64 = 2e-4;

/// A workspace that checks every motion for clearance.
pub(super) struct Watched<'a, const N: usize> {
    pub(super) model: &'a Model<f64, N>,
    pub(super) judged: &'a JudgedSurroundings<N>,
    pub(super) around: &'a Surroundings,
    pub(super) centre: &'a [f64],
    pub(super) period: f64,
}

fn fixed<const N: usize>(q: &[f64]) -> [f64; N] {
    core::array::from_fn(|i| q[i])
}

impl<const N: usize> Workspace for Watched<'_, N> {
    fn posture(&self, q: &[f64]) -> bool {
        self.judged.cell.is_clear(&fixed(q), self.around.clearance)
    }

    fn line(&self, from: &[f64], to: &[f64]) -> bool {
        let motion = quintic::<N>(&[(from.to_vec(), 0.0, 0.0), (to.to_vec(), REST.1, 0.0)]);
        // If both are the same posture, there is no motion.
        motion.map_or_else(|_| self.posture(to), |motion| self.judged.cell.keeps(&motion, self.around.clearance))
    }

    fn series(&self, sine: &[Vec<f64>], cosine: &[Vec<f64>]) -> bool {
        // Check one period and both ramps: further periods pass the same postures. If there is no valid motion, the reason is reported later.
        fastest_ramp(self.model, self.centre, self.period, 1, [sine, cosine])
            .map_or(true, |(motion, _)| self.judged.cell.keeps(&motion, self.around.clearance))
    }
}

impl<const N: usize> Watched<'_, N> {
    /// Rejects a start without enough clearance.
    ///
    /// # Errors
    /// [`Failure::Input`] with the two parts and their gap.
    pub(super) fn check_start(&self) -> Result<(), Failure> {
        let Some(found) = self.judged.cell.posture(&fixed(self.centre)) else { return Ok(()) };
        let required = self.around.clearance;
        if found.gap >= required {
            return Ok(());
        }
        let (a, b) = self.judged.cell.names(found.pair);
        let how = match found.gap {
            gap if gap <= 0.0 => format!("overlap by {:.4} m or more", -gap),
            gap => format!("are {gap:.4} m apart, with a --clearance of {required} m"),
        };
        let centre: Vec<String> = self.centre.iter().map(|q| format!("{q:.4}")).collect();
        Err(Failure::Input(miette::miette!(
            help = "expected a start in free space: give another --centre, or, if the shapes are too large, --radius or --clearance",
            "start pose [{}]: {a} and {b} {how}",
            centre.join(", ")
        )))
    }

    /// Description of pairs that are not judged, without neighbours.
    fn exempt_beside_neighbours(&self) -> String {
        let of = |reason: Reason| {
            let all = self.judged.cell.exempt.iter().filter(|exempt| exempt.2 == reason);
            let pairs: Vec<String> = all.map(|(a, b, _)| format!("{a} and {b}")).collect();
            if pairs.is_empty() { String::new() } else { format!("; {}: {}", reason.words(), pairs.join(", ")) }
        };
        of(Reason::AlwaysNear) + &of(Reason::OverlapAtRest)
    }

    /// Description of the smallest gap at the centre.
    pub(super) fn nearest_at_centre(&self) -> String {
        self.judged.cell.posture(&fixed(self.centre)).map_or_else(String::new, |found| {
            let (a, b) = self.judged.cell.names(found.pair);
            format!("; at the centre {a} and {b} are nearest, {:.4} m apart", found.gap)
        })
    }

    /// Clearance of the chosen motion, as comments for its file and as JSON.
    ///
    /// # Errors
    /// [`Failure::Input`]: the motion comes closer than allowed.
    pub(super) fn state(&self, motion: &Motion<f64, N>) -> Result<(String, Value), Failure> {
        let (cell, required) = (&self.judged.cell, self.around.clearance);
        let exempt: Vec<String> =
            cell.exempt.iter().map(|(a, b, reason)| format!("{a} and {b} ({})", reason.words())).collect();
        let (line, value) = match cell.least(motion, TOLERANCE) {
            None => ("Clearance: no two parts are judged.".to_owned(), Value::Null),
            Some(least) => {
                let (a, b) = cell.names(least.pair);
                if least.found < required {
                    return Err(Failure::Input(miette::miette!(
                        help = "expected another --centre, less --swing or a smaller --clearance",
                        "{a} and {b} come within {:.4} m at {:.3} s, with a --clearance of {required} m",
                        least.found,
                        least.time
                    )));
                }
                // An accepted motion keeps the required clearance as a whole, so the bound is at least that.
                let bound = least.bound.max(if cell.keeps(motion, required) { required } else { f64::NEG_INFINITY });
                let line = format!(
                    "Clearance: at least {bound:.4} m at every time, for the shapes below; {:.4} m at {:.3} s between {a} and {b}.",
                    least.found, least.time
                );
                (line, json!({ "bound": bound, "found": least.found, "time": least.time, "between": [a, b] }))
            }
        };
        let mut comments = format!("# {line}\n");
        for note in &self.judged.notes {
            comments += &format!("#   {note}\n");
        }
        comments += &format!("#   not judged: links that share a joint{}\n", self.exempt_beside_neighbours());
        let value = json!({ "least": value, "required": required, "not_judged": exempt, "notes": self.judged.notes });
        Ok((comments, value))
    }
}
