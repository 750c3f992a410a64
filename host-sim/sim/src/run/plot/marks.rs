//! Waypoints, limits and faults: what the figures of a run show beside its curves.

use super::chart::{Mark, MarkKind};
use crate::run::closed_loop::World;
use crate::run::record::Record;
use dynamics_core::control::LimitFlags;
use dynamics_core::{Limits, Model};

/// Limits and times of waypoints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marks {
    /// Times at which the reference reaches a point, s.
    pub waypoints: Vec<f64>,
    /// Limits of each joint; infinite where there is none.
    pub limits: Vec<Limits<f64>>,
}

impl Marks {
    /// Marks of a run of `ticks` control periods.
    pub(crate) fn of<const N: usize>(world: &World<N>, model: &Model<f64, N>, ticks: usize) -> Self {
        let end = ticks as f64 * world.period;
        let lap = world.motion.duration();
        let points: Vec<f64> = (0..).map_while(|index| world.motion.arrival(index)).collect();
        let laps = if world.repeat && lap > 0.0 { (end / lap).ceil() as usize } else { 1 };
        let starts = (0..laps.max(1)).map(|n| n as f64 * lap);
        let mut waypoints: Vec<f64> = starts.flat_map(|start| points.iter().map(move |at| start + at)).collect();
        // The end of a lap is the start of the next one.
        waypoints.dedup_by(|a, b| (*a - *b).abs() < 0.5 * world.period);
        waypoints.retain(|at| *at <= end);
        Self { waypoints, limits: model.links().iter().map(|link| link.limits).collect() }
    }

    /// Vertical lines: waypoints, then the first fault.
    pub(super) fn lines(&self, record: &Record) -> Vec<Mark> {
        let waypoints = self.waypoints.iter().map(|at| Mark { kind: MarkKind::Waypoint, at: *at });
        let fault = record.faults().iter().position(Option::is_some).map(|tick| record.time()[tick]);
        waypoints.chain(fault.map(|at| Mark { kind: MarkKind::Fault, at })).collect()
    }
}

/// Stretches of time in which a limit acts on a joint, s.
pub(super) fn limited(record: &Record, joint: usize) -> Vec<(f64, f64)> {
    let mut spans: Vec<(f64, f64)> = Vec::new();
    let mut acts = false;
    for (at, sample) in record.time().iter().zip(record.joint(joint)) {
        let now = sample.limits != LimitFlags::NONE;
        match spans.last_mut() {
            Some(span) if now && acts => span.1 = *at,
            _ if now => spans.push((*at, *at)),
            _ => {}
        }
        acts = now;
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::limited;
    use crate::run::record::{JointLabel, JointSample, Record};
    use dynamics_core::JointKind;
    use dynamics_core::control::LimitFlags;

    #[test]
    fn stretches_of_a_limit_are_found_from_end_to_end() {
        let label = JointLabel { name: "swing".to_owned(), kind: JointKind::Revolute };
        let mut record = Record::new(vec![label], 6);
        for (tick, limits) in [1, 1, 0, 4, 0, 8].into_iter().enumerate() {
            let limits = [LimitFlags::NONE, LimitFlags::POSITION, LimitFlags::TORQUE, LimitFlags::TORQUE_RATE]
                .into_iter()
                .find(|flags| flags.bits() == limits)
                .unwrap();
            let sample = JointSample { q_reference: 0.0, q: 0.0, qd_reference: 0.0, qd: 0.0, torque: 0.0, limits };
            record.push(tick as f64, [sample], None);
        }
        assert_eq!(limited(&record, 0), [(0.0, 1.0), (3.0, 3.0), (5.0, 5.0)]);
    }
}
