//! Quality of a run apart from its tracking error: chatter of the torque, the error at rest, the distance from the reference.

use crate::run::record::Record;
use robot_compiler::scene::SafetySpec;
use serde::Serialize;
use std::ops::Range;

/// Faults that the firmware's safety state machine would have raised in a run. The run itself is without it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Supervision {
    /// True if the safety state machine was in the loop. Always false for a run, in which only faults of the controller or of a drive stop the arm.
    pub state_machine: bool,
    /// The first tick in which a joint was farther from its reference than `reach` of the scene's `[safety]`. The state machine would hold the arm.
    pub out_of_reach: Option<OutOfReach>,
}

/// A joint too far from its reference.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OutOfReach {
    /// Tick, counted from 0.
    pub tick: usize,
    /// Joint, counted from 1.
    pub joint: usize,
}

/// A joint at the end of an interval in which all references are at rest.
pub(super) struct AtRest {
    /// Reference minus actual position in the last tick, rad or m.
    pub(super) error: f64,
    /// Error within which the joint counts as settled, rad or m.
    pub(super) band: f64,
    /// Settling time, s: from the start of the interval until the error is within the band and stays there to the end; `None` if it does not.
    pub(super) settled: Option<f64>,
}

/// Settling band as a share of a joint's last move: 2 %, as usual.
const SETTLED: f64 = 0.02;

impl Supervision {
    /// Judges the ticks before a fault.
    pub(super) fn of(record: &Record, driven: usize, safety: &SafetySpec) -> Self {
        let far = |joint: usize| {
            let reach = safety.reach.get(joint).copied().unwrap_or(f64::INFINITY);
            let tick = record.joint(joint).take(driven).position(|sample| sample.error().abs() > reach)?;
            Some(OutOfReach { tick, joint: joint + 1 })
        };
        // If several joints leave in one tick, the first one is reported, as by the state machine.
        let out_of_reach = (0..record.joints().len()).filter_map(far).min_by_key(|far| far.tick);
        Self { state_machine: false, out_of_reach }
    }
}

/// Chatter, N m or N: `sqrt(mean((tau_k - tau_{k-1})^2))`, the root mean square of the change from one tick to the next.
pub(super) fn chatter(torque: impl Iterator<Item = f64> + Clone) -> f64 {
    let next = torque.clone().skip(1);
    super::numbers::rms(torque.zip(next).map(|(before, now)| now - before).collect::<Vec<_>>().into_iter())
}

/// The last interval of at least two ticks in which the reference of every joint is at rest.
pub(super) fn last_rest(record: &Record, driven: usize) -> Option<Range<usize>> {
    let joints: Vec<Vec<bool>> = (0..record.joints().len())
        .map(|joint| record.joint(joint).take(driven).map(|sample| sample.qd_reference == 0.0).collect())
        .collect();
    let still = |tick: &usize| joints.iter().all(|joint| joint[*tick]);
    let end = (1..driven).rev().find(|tick| still(tick) && still(&(tick - 1)))? + 1;
    let start = (0..end).rev().take_while(still).last()?;
    Some(start..end)
}

/// Evaluates a joint in such an interval. Its band is 2 % of the joint's last move, and at least `resolution`, rad or m: after a move of zero, or of
/// a few encoder counts, a smaller error could not be measured.
pub(super) fn at_rest(record: &Record, joint: usize, rest: &Range<usize>, resolution: f64, period: f64) -> AtRest {
    let errors: Vec<f64> = record.joint(joint).take(rest.end).skip(rest.start).map(|sample| sample.error()).collect();
    let error = errors.last().copied().unwrap_or(0.0);
    let band = f64::max(SETTLED * last_move(record, joint, rest), resolution);
    let outside = errors.iter().rposition(|error| error.abs() > band);
    let from = outside.map_or(0, |last| last + 1);
    AtRest { error, band, settled: (from < errors.len()).then_some(from as f64 * period) }
}

/// Range that a joint's reference covers in the move that ends with this interval, rad or m. The move begins when all references were last at rest
/// for at least two ticks, or at the start of the run.
fn last_move(record: &Record, joint: usize, rest: &Range<usize>) -> f64 {
    let start = last_rest(record, rest.start).map_or(0, |before| before.end - 1);
    let places = record.joint(joint).take(rest.end).skip(start).map(|sample| sample.q_reference);
    let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
    f64::max(high - low, 0.0)
}

#[cfg(test)]
mod tests {
    use super::{Supervision, at_rest, chatter, last_rest};
    use crate::run::joint_label::JointLabel;
    use crate::run::record::{JointSample, Record};
    use dynamics_core::JointKind;
    use dynamics_core::control::LimitFlags;
    use robot_compiler::{Robot, SceneFile};

    /// One joint: reference position and speed, actual position.
    fn record(ticks: &[(f64, f64, f64)]) -> Record {
        let label = JointLabel { name: "swing".to_owned(), kind: JointKind::Revolute };
        let mut record = Record::new(vec![label], ticks.len());
        for (tick, (q_reference, qd_reference, q)) in ticks.iter().enumerate() {
            let (q_reference, qd_reference, q) = (*q_reference, *qd_reference, *q);
            let sample = JointSample { q_reference, q, qd_reference, qd: 0.0, torque: 0.0, limits: LimitFlags::NONE };
            record.push(tick as f64 * 1e-3, [sample], None);
        }
        record
    }

    #[test]
    fn chatter_is_the_rms_of_the_changes() {
        // Changes of 3, -4, 0 and 0.
        let found = chatter([1.0, 4.0, 0.0, 0.0, 0.0].into_iter());
        assert!((found - 2.5).abs() < 1e-15, "{found}");
        assert!(chatter([7.0; 3].into_iter()) == 0.0 && chatter([7.0].into_iter()) == 0.0);
    }

    #[test]
    fn the_last_rest_is_found_and_its_settling_timed() {
        // At rest for one tick, moving, at rest for four, moving again.
        let ticks =
            [(0.0, 0.0, 0.0), (0.1, 1.0, 0.0), (1.0, 0.0, 0.7), (1.0, 0.0, 0.95), (1.0, 0.0, 1.2), (1.0, 0.0, 0.98)];
        let mut moving = ticks.to_vec();
        moving.push((1.1, 1.0, 1.0));
        let record = record(&moving);
        let rest = last_rest(&record, 7).unwrap();
        assert_eq!(rest, 2..6);
        let found = at_rest(&record, 0, &rest, 0.1, 1e-3);
        assert!((found.error - 0.02).abs() < 1e-15 && found.settled == Some(3e-3), "{:?}", found.settled);
        assert!(at_rest(&record, 0, &rest, 0.5, 1e-3).settled == Some(0.0));
        assert_eq!(last_rest(&record, 2), None);
        assert_eq!(last_rest(&record, 0), None);
    }

    /// A move from 0 to `goal`, then a rest with these errors.
    fn moved(goal: f64, errors: &[f64]) -> Record {
        let mut ticks = vec![(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.5 * goal, 1.0, 0.0)];
        ticks.extend(errors.iter().map(|error| (goal, 0.0, goal - error)));
        record(&ticks)
    }

    fn settling(record: &Record, resolution: f64) -> (f64, Option<f64>) {
        let rest = last_rest(record, record.ticks()).unwrap();
        let found = at_rest(record, 0, &rest, resolution, 1e-3);
        (found.band, found.settled)
    }

    #[test]
    fn a_joint_has_settled_when_its_error_stays_within_two_percent_of_its_move() {
        // 2 % of 0.5 rad is 10 mrad; a move in the other direction has the same band.
        for goal in [0.5, -0.5] {
            assert_eq!(settling(&moved(goal, &[0.02, 0.009, -0.011, 0.009, -0.009]), 1e-3), (0.01, Some(3e-3)));
            assert_eq!(settling(&moved(goal, &[0.009, -0.009]), 1e-3), (0.01, Some(0.0)));
        }
        // It was in the band and is outside it at the end.
        assert_eq!(settling(&moved(0.5, &[0.009, 0.009, 0.011]), 1e-3), (0.01, None));
    }

    #[test]
    fn the_band_of_a_tiny_move_or_of_none_is_the_resolution() {
        for goal in [0.0, 1e-3] {
            assert_eq!(settling(&moved(goal, &[3e-3, 1.9e-3, 1.9e-3]), 2e-3), (2e-3, Some(1e-3)));
            assert_eq!(settling(&moved(goal, &[3e-3, 2.1e-3, 2.1e-3]), 2e-3), (2e-3, None));
        }
    }

    #[test]
    fn only_the_last_move_counts_and_back_and_forth_is_a_move() {
        // A move of 1 rad, a rest, and 0.1 rad back: the band is 2 mrad, not 20.
        let mut ticks = vec![(0.0, 1.0, 0.0), (0.5, 1.0, 0.5), (1.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.95, -1.0, 0.95)];
        ticks.extend([(0.9, 0.0, 0.895), (0.9, 0.0, 0.899)]);
        let (band, settled) = settling(&record(&ticks), 1e-4);
        assert!((band - 2e-3).abs() < 1e-15 && settled == Some(1e-3), "{band} {settled:?}");
        // Without a rest in between, both are one move, of 0.3 rad.
        let whole = [(0.0, 1.0, 0.0), (0.3, -1.0, 0.3), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)];
        let (band, _) = settling(&record(&whole), 1e-4);
        assert!((band - 6e-3).abs() < 1e-15, "{band}");
    }

    #[test]
    fn a_joint_beyond_its_reach_is_reported_with_its_first_tick() {
        let robot = "name = \"one\"\n[[joint]]\nname = \"swing\"\ntype = \"revolute\"\nmass = 1.0\ncom = [0.5, 0.0, 0.0]\n\
                     dh = { a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }\nlimits = { velocity = 5.0 }\n";
        let safety = SceneFile::default_for(Robot::from_toml_str(robot, "one.toml").unwrap()).safety;
        let record = record(&[(0.0, 1.0, 0.0), (0.1, 1.0, 0.3), (0.0, 1.0, 0.3)]);
        assert_eq!(Supervision::of(&record, 1, &safety).out_of_reach, None);
        let far = Supervision::of(&record, 3, &safety).out_of_reach.unwrap();
        assert_eq!((far.tick, far.joint), (2, 1), "0.3 rad, for a reach of 0.2 rad");
        let near = Supervision::of(&record, 2, &safety);
        assert!(near.out_of_reach.is_none_or(|far| far.tick == 1) && !near.state_machine);
    }
}
