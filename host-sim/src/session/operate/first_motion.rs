//! The first motion after homing: the board limits speed and torque until `full-range`, and the operator shows what was seen so far.

use super::arm::Course;
use super::{Operator, Stop};
use link::{Request, Status};
use std::rc::Rc;

/// Share of the board's speed limit that the operator's motions use while it is in force: the arm itself is a little faster than its
/// reference now and then.
const SHARE: f64 = 0.9;

/// Observations of one joint since homing.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    /// Lowest and highest position, rad or m.
    position: (f64, f64),
    /// Largest difference of the commanded torque from the model's gravity torque, N m or N.
    beyond_gravity: f64,
    /// Largest commanded torque, N m or N.
    torque: f64,
}

/// Observations since homing, and the limit of the first motion.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstMotion {
    /// True from homing to `full-range`, if the board limits the first motion.
    limited: bool,
    joints: Vec<Range>,
    /// Ticks in which torque acted, as far as they were reported.
    ticks: u64,
}

impl Operator {
    /// Takes note of accepted requests: homing begins the observations anew.
    pub(super) fn note_accepted(&mut self, request: Request) -> Result<(), Stop> {
        match (request, self.arm.first_motion) {
            (Request::Confirm, Some(share)) => {
                self.first_motion = FirstMotion { limited: true, ..FirstMotion::default() };
                let percent = 100.0 * share;
                self.say(
                    "first-motion",
                    &format!(
                        "first motion: until `full-range` the board allows {percent:.0} % of each velocity limit, and {percent:.0} % of \
                         each torque limit above gravity; motions are slowed accordingly. Move every joint a little, watch it, then lift \
                         the limit"
                    ),
                )
            }
            (Request::Confirm, None) => {
                self.first_motion = FirstMotion::default();
                Ok(())
            }
            (Request::FullRange, _) => {
                self.first_motion.limited = false;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The motion, slowed to the limits of the first motion if these are in force.
    pub(super) fn at_first_speed(&self, motion: Rc<dyn Course>) -> Rc<dyn Course> {
        let Some(share) = self.arm.first_motion.filter(|_| self.first_motion.limited) else { return motion };
        let velocity: Vec<f64> = self.arm.velocity.iter().map(|limit| SHARE * share * limit).collect();
        motion.slowed(&velocity).unwrap_or(motion)
    }

    /// Observes a status in which torque acts.
    pub(super) fn observe(&mut self, status: &Status) {
        let (Some(link::Actuation::Drive { torque, .. }), Some(q)) = (&status.actuation, &self.q) else { return };
        let still = vec![0.0; q.len()];
        let gravity = self.arm.limbs.inverse_dynamics(q, &still, &still, self.arm.payload);
        let first = Range { position: (f64::INFINITY, f64::NEG_INFINITY), beyond_gravity: 0.0, torque: 0.0 };
        self.first_motion.joints.resize(q.len(), first);
        self.first_motion.ticks += 1;
        for (((range, q), torque), gravity) in self.first_motion.joints.iter_mut().zip(q).zip(torque).zip(gravity) {
            let torque = f64::from(*torque);
            range.position = (range.position.0.min(*q), range.position.1.max(*q));
            range.beyond_gravity = range.beyond_gravity.max((torque - gravity).abs());
            range.torque = range.torque.max(torque.abs());
        }
    }

    /// Shows what was seen since homing, and lifts the limits of the first motion.
    pub(super) fn full_range(&mut self) -> Result<(), Stop> {
        let of = |(((name, place, force), range), limit): (((&String, &str, &str), &Range), &f64)| {
            let Range { position: (low, high), beyond_gravity, torque } = *range;
            let share = if limit.is_finite() {
                format!(" ({:.0} % of its limit)", 100.0 * torque / limit)
            } else {
                String::new()
            };
            format!(
                "\n  {name:<12} {low:.3} to {high:.3} {place}; torque at most {torque:.2} {force}{share}, {beyond_gravity:.2} {force} \
                 beyond gravity"
            )
        };
        let joints = self.arm.joints.iter().map(|(name, place, force)| (name, *place, *force));
        let seen: String = joints.zip(&self.first_motion.joints).zip(&self.arm.torque).map(of).collect();
        let seen = match self.first_motion.ticks {
            0 => "; the arm has not been armed since homing: nothing was seen of it".to_owned(),
            ticks => format!("; seen in {ticks} statuses since homing:{seen}"),
        };
        let rejection = self.request(Request::FullRange)?;
        let accepted = rejection.is_none();
        self.answer("full-range", rejection, &seen)?;
        if accepted { self.note_accepted(Request::FullRange) } else { Ok(()) }
    }
}
