//! The first motion after homing. The board limits speed and torque until `full-range`, and the operator shows the observations so far.

use super::observed::{FirstMotion, Range};
use super::planned_motion::PlannedMotion;
use super::rejection::Rejection;
use super::{Operator, Stop, messages};
use link::{Request, StateCode, Status};
use std::rc::Rc;

/// Share of the board's limits that the operator's motions use in the first motion. The rest is margin: the arm is sometimes a little faster than its
/// reference, and a wrong model needs torque too.
const SHARE: f64 = 0.9;

/// Least share of the torque limit that is assumed available for acceleration. Friction may leave less, and then a slower motion does not help.
const SHARE_MIN: f64 = 0.02;

/// Number of positions along a motion at which its torque is computed.
const SAMPLES: u32 = 200;

/// [`dynamics_core::safety::Refusal::NotHomed`].
const NOT_HOMED: u8 = 3;

/// Advice if the board does not lift the limits, because a moving arm, or one that presses against its limited torque, would jump.
const HOLD_FIRST: &str = "`hold` first, and wait until the arm is at rest; an arm that its limited torque does not hold needs a support, or its payload declared";

/// Range, rad or m, below which a joint counts as not moved.
const MOVED: f64 = 0.02;

/// The answer that lifts the limits although a joint has not moved since homing.
const UNSEEN: &str = "unseen";

/// Time over which a speed is averaged, s: a step of an encoder must not look like a fast joint.
const AVERAGED: f64 = 0.05;

impl Operator {
    /// True if the limits of the first motion are in force.
    pub(crate) fn is_limited(&self) -> bool {
        self.first_motion.limited
    }

    /// Handles an accepted request: homing restarts the observations, and a person who homes or arms is reminded of the limits.
    pub(super) fn note_accepted(&mut self, request: Request) -> Result<(), Stop> {
        match (request, self.arm.first_motion) {
            (Request::Confirm, share) => {
                self.first_motion = FirstMotion { limited: share.is_some(), ..FirstMotion::default() };
                self.remind("; motions are slowed to fit. Move every joint a little and watch it first")
            }
            (Request::Arm, _) => self.remind(""),
            (Request::FullRange, _) => {
                self.first_motion.limited = false;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    pub(super) fn remind(&self, more: &str) -> Result<(), Stop> {
        let Some(share) = self.limit() else { return Ok(()) };
        let percent = 100.0 * share;
        self.say(
            "first-motion",
            &format!(
                "first motion: speed and torque beyond the weight are limited to {percent:.0} % until you enter `full-range`{more}"
            ),
        )
    }

    /// Share of the limits that the first motion may use, while they are in force.
    pub(super) fn limit(&self) -> Option<f64> {
        self.arm.first_motion.filter(|_| self.first_motion.limited)
    }

    /// Returns the motion, slowed to the limits of the first motion if these are in force, and a message about it.
    pub(super) fn at_first_speed(&self, motion: Rc<dyn PlannedMotion>) -> (Rc<dyn PlannedMotion>, String) {
        let slower = self.limit().and_then(|share| motion.slowed(self.first_factor(motion.as_ref(), SHARE * share)));
        match slower {
            Some(slower) => {
                let text = format!(
                    ", slowed from {:.2} s to fit the first motion (`first_motion` in [safety]; `full-range` lifts it)",
                    motion.duration()
                );
                (slower, text)
            }
            None => (motion, String::new()),
        }
    }

    /// Factor by which a motion has to be slowed so that speed, and torque beyond gravity, stay within this share of the limits; at most 1 if the
    /// motion fits. Apart from friction, the torque beyond gravity is proportional to the square of the speed.
    fn first_factor(&self, motion: &dyn PlannedMotion, share: f64) -> f64 {
        let speed = |(peak, limit): (&f64, &f64)| peak / (share * limit);
        let mut factor = motion.peak_velocity().iter().zip(&self.arm.velocity).map(speed).fold(0.0, f64::max);
        for k in 0..=SAMPLES {
            let link::Reference { q, qd, qdd } = motion.at(motion.duration() * f64::from(k) / f64::from(SAMPLES));
            let [q, qd, qdd] = [q, qd, qdd].map(|list| list.iter().copied().map(f64::from).collect::<Vec<f64>>());
            let moving = self.arm.model.inverse_dynamics(&q, &qd, &qdd, self.arm.payload);
            let weight = self.arm.model.gravity(&q, self.arm.payload);
            let joints = self.arm.torque.iter().zip(&self.arm.friction).zip(&self.arm.velocity);
            for ((torque, weight), ((limit, (viscous, coulomb)), velocity)) in moving.iter().zip(weight).zip(joints) {
                let drag = if velocity.is_finite() { viscous * share * velocity } else { 0.0 };
                let left = (share * limit - coulomb - drag).max(SHARE_MIN * limit);
                factor = factor.max(((torque - weight).abs() / left).sqrt());
            }
        }
        factor
    }

    /// Adds a status in which torque acts to the observations.
    pub(super) fn observe(&mut self, status: &Status) {
        let (Some(link::Actuation::Drive { torque, .. }), Some(q)) = (&status.actuation, &self.q) else {
            self.first_motion.from = None;
            return;
        };
        let gravity = self.arm.model.gravity(q, self.arm.payload);
        let first = Range {
            position: (f64::INFINITY, f64::NEG_INFINITY),
            speed: 0.0,
            beyond_gravity: 0.0,
            torque: 0.0,
            error: None,
        };
        self.first_motion.joints.resize(q.len(), first);
        self.first_motion.ticks += 1;
        for (((range, q), torque), gravity) in self.first_motion.joints.iter_mut().zip(q).zip(torque).zip(gravity) {
            let torque = f64::from(*torque);
            range.position = (range.position.0.min(*q), range.position.1.max(*q));
            range.beyond_gravity = range.beyond_gravity.max((torque - gravity).abs());
            range.torque = range.torque.max(torque.abs());
        }
        // The reference is the commanded position only while the arm runs.
        if let Some(reference) = status.reference().filter(|_| status.state == StateCode::Running) {
            for ((range, q), reference) in self.first_motion.joints.iter_mut().zip(q).zip(&reference.q) {
                let error = (q - f64::from(*reference)).abs();
                range.error = Some(range.error.map_or(error, |before| before.max(error)));
            }
        }
        let from = self.first_motion.from.get_or_insert_with(|| (status.tick, q.clone()));
        let time = f64::from(status.tick.wrapping_sub(from.0)) * self.arm.period;
        if time >= AVERAGED {
            for ((range, q), before) in self.first_motion.joints.iter_mut().zip(q).zip(&from.1) {
                range.speed = range.speed.max((q - before).abs() / time);
            }
            *from = (status.tick, q.clone());
        }
    }

    /// Describes the observations since homing, a line for each joint.
    fn observed_in_words(&self) -> String {
        let share = |value: f64, limit: f64| match limit.is_finite() {
            true => format!(" ({:.0} % of its limit)", 100.0 * value / limit),
            false => String::new(),
        };
        let limits = self.arm.velocity.iter().zip(&self.arm.torque);
        let joints = self.arm.joints.iter().zip(&self.first_motion.joints).zip(limits);
        let mut lines = String::new();
        for (((name, place, force), range), (velocity, torque)) in joints {
            let (low, high) = range.position;
            let error = range.error.map_or_else(|| "unknown".to_owned(), |error| format!("{error:.4} {place}"));
            lines += &format!(
                "\n  {name:<12} {low:.3} to {high:.3} {place}; speed at most {:.3} {place}/s{}; torque beyond the weight at most {:.2} {force}{}, \
                 in all {:.2} {force}{}; following error at most {error}",
                range.speed,
                share(range.speed, *velocity),
                range.beyond_gravity,
                share(range.beyond_gravity, *torque),
                range.torque,
                share(range.torque, *torque),
            );
        }
        match self.first_motion.ticks {
            0 => "the arm has not been armed since homing: nothing was seen of it".to_owned(),
            ticks => format!("seen in {ticks} statuses since homing:{lines}{}", self.unmoved_in_words()),
        }
    }

    /// Describes the joints that have not moved since homing: their sign, zero and torque constant are not verified.
    fn unmoved_in_words(&self) -> String {
        let ranges = self.arm.joints.iter().zip(&self.first_motion.joints);
        let unmoved = ranges.filter(|(_, range)| is_unmoved(range));
        let names: Vec<&str> = unmoved.map(|((name, ..), _)| name.as_str()).collect();
        match names.as_slice() {
            [] => String::new(),
            names => format!(
                "\nnot moved by {MOVED} rad or m since homing, so that nothing is known of them: {}",
                names.join(", ")
            ),
        }
    }

    /// Shows a person at a terminal the observations since homing, and asks whether to lift the limits of the first motion.
    pub(crate) fn ask_for_full_range(&self) -> Result<(), Stop> {
        let seen = self.observed_in_words();
        let yes = match self.has_moved_every_joint() {
            true => "y: yes".to_owned(),
            // A habit types `y`; a joint whose sign and zero are not verified needs a decision.
            false => format!("{UNSEEN}: yes, although not every joint was seen moving"),
        };
        self.say(
            "full-range",
            &format!(
                "{seen}\nlift the limits of the first motion, so that the arm may use its full speed and torque? {yes}, n: no"
            ),
        )
    }

    /// True if this answer to [`Operator::ask_for_full_range`] lifts the limits.
    pub(crate) fn lifts(&self, answer: &str) -> bool {
        answer == UNSEEN || (matches!(answer, "y" | "yes") && self.has_moved_every_joint())
    }

    /// True if every joint has moved since homing.
    fn has_moved_every_joint(&self) -> bool {
        let joints = &self.first_motion.joints;
        joints.len() == self.arm.joints.len() && !joints.iter().any(is_unmoved)
    }

    /// Lifts the limits of the first motion, and shows the observations since homing.
    pub(crate) fn full_range(&mut self) -> Result<(), Stop> {
        let seen = self.observed_in_words();
        let rejection = self.request(Request::FullRange)?;
        if let Some(Rejection::Denied(denial)) = rejection
            && denial.code != NOT_HOMED
        {
            self.refused = true;
            let text = messages::denial(&denial);
            return self.say("full-range", &format!("full-range: {text}; {HOLD_FIRST}"));
        }
        let accepted = rejection.is_none();
        self.answer("full-range", rejection, &format!("; {seen}"))?;
        if accepted { self.note_accepted(Request::FullRange) } else { Ok(()) }
    }
}

/// True if a joint has not moved since homing.
fn is_unmoved(range: &Range) -> bool {
    range.position.1 - range.position.0 < MOVED
}
