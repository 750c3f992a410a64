//! Motions from the arm's present position, with points sent ahead of the arm.

use super::planned_motion::PlannedMotion;
use super::rejection::Rejection;
use super::{Operator, Stop};
use dynamics_core::control::trajectory::MotionError;
use link::{Frame, Request, StateCode};
use std::rc::Rc;

impl Operator {
    /// Sends points while the board has capacity for them.
    pub(super) fn fill(&mut self) -> Result<(), Stop> {
        if self.state() == Some(StateCode::Running) { self.send_points() } else { Ok(()) }
    }

    fn send_points(&mut self) -> Result<(), Stop> {
        let room = self.status.as_ref().map_or(0, |status| usize::from(status.room));
        while self.under_way.len() < room {
            let Some(point) = self.next_point(room) else { break };
            self.send(&Frame::Point(point))?;
            self.under_way.push_back(self.device.tap().sent());
        }
        Ok(())
    }

    /// Start of the next motion: the end of the motion before it, or the arm's present position.
    pub(super) fn here(&self) -> Result<Vec<f64>, Stop> {
        let running = self.goal.as_ref().filter(|_| self.state() == Some(StateCode::Running));
        running
            .or(self.q.as_ref())
            .cloned()
            .ok_or_else(|| Stop::Input("the positions of the arm are not known yet".into()))
    }

    /// Runs the scene's motion, after a motion to its start.
    pub(super) fn run(&mut self) -> Result<(), Stop> {
        let ((motion, slowed), times) = (self.at_first_speed(Rc::clone(&self.arm.motion)), self.arm.times);
        let (here, [start, goal]) = (self.here()?, motion.ends());
        let lead = if same(&here, &start) { None } else { Some(self.way("run", &here, &start, None)?.0) };
        let motions = format!("{:.2} s of motion{slowed}", f64::from(times) * motion.duration());
        let text = match lead.as_ref().map_or(0.0, |lead| lead.duration()) {
            // A motion this short only corrects a measurement error.
            way if way < self.arm.period => format!("; {motions}"),
            way => format!("; {way:.2} s to its start, then {motions}"),
        };
        let legs = lead.into_iter().chain((0..times).map(|_| Rc::clone(&motion))).collect();
        if self.begins_guiding() && !self.may_be_led("run")? {
            return Ok(());
        }
        self.go("run", legs, &here, goal, &text)
    }

    pub(super) fn jog(&mut self, joint: usize, delta: f64, time: Option<f64>) -> Result<(), Stop> {
        let here = self.here()?;
        let mut goal = here.clone();
        if let Some(q) = goal.get_mut(joint) {
            *q += delta;
        }
        self.one_way("jog", &here, goal, time)
    }

    pub(super) fn go_to(&mut self, q: &[f64], time: Option<f64>) -> Result<(), Stop> {
        let expected = self.arm.joints.len();
        if q.len() != expected {
            return Err(Stop::Input(format!("goto: {} positions, expected {expected}", q.len())));
        }
        self.go_to_named("goto", q, time)
    }

    /// As [`Operator::go_to`]; `name` is the command in the messages.
    pub(super) fn go_to_named(&mut self, name: &str, q: &[f64], time: Option<f64>) -> Result<(), Stop> {
        self.one_way(name, &self.here()?, q.to_vec(), time)
    }

    fn one_way(&mut self, name: &str, here: &[f64], goal: Vec<f64>, time: Option<f64>) -> Result<(), Stop> {
        if same(here, &goal) {
            return self.say(name, &format!("{name}: the arm is there"));
        }
        let (motion, slowed) = self.way(name, here, &goal, time)?;
        if !self.may_move(name)? {
            return Ok(());
        }
        let text = format!("; {:.2} s{slowed}", motion.duration());
        self.go(name, vec![motion], here, goal, &text)
    }

    /// Returns a motion from rest to rest in the given time (s), or as fast as the bounds allow. It is slowed if the limits of the first motion
    /// require it; the text describes that.
    pub(super) fn way(
        &self,
        name: &str,
        from: &[f64],
        to: &[f64],
        time: Option<f64>,
    ) -> Result<(Rc<dyn PlannedMotion>, String), Stop> {
        let motion = self.arm.model.way(from, to, time).map_err(|error| {
            let what_to_do = match (error, time) {
                (MotionError::TooFast { .. } | MotionError::TooSteep { .. }, Some(_)) => {
                    "; leave SECONDS away for a time that does"
                }
                (MotionError::Unbounded { .. }, None) => "; give SECONDS",
                _ => "",
            };
            Stop::Input(format!("{name}: {error}{what_to_do}"))
        })?;
        Ok(self.at_first_speed(motion))
    }

    /// Sends these motions after the motions already under way, and reports the result. The caller has checked that the law admits them.
    fn go(
        &mut self,
        name: &str,
        legs: Vec<Rc<dyn PlannedMotion>>,
        here: &[f64],
        goal: Vec<f64>,
        text: &str,
    ) -> Result<(), Stop> {
        if !self.torque_is_believed()? || !self.dead_man_is_held(name)? {
            return Ok(());
        }
        // The walls again: the arm may have been moved while the key was awaited.
        if self.begins_guiding() && !self.is_clear_of_walls(name)? {
            return Ok(());
        }
        let denial = self.set_out(legs, here, goal)?;
        self.answer(name, denial, text)
    }

    /// As [`Operator::go`], without a report. Returns the reason if the board rejects the motion.
    pub(super) fn set_out(
        &mut self,
        legs: Vec<Rc<dyn PlannedMotion>>,
        here: &[f64],
        goal: Vec<f64>,
    ) -> Result<Option<Rejection>, Stop> {
        self.stopped = false;
        let running = self.state() == Some(StateCode::Running);
        if !running {
            self.under_way.clear();
            self.feed.start(self.arm.model.at_rest(here));
            if let Some(start) = self.feed.next_point() {
                // The start point empties the board's trajectory.
                self.send_surely(&Frame::Point(start))?;
            }
        }
        legs.into_iter().for_each(|leg| self.feed.push(leg));
        self.goal = Some(goal);
        self.send_points()?;
        let denial = if running { None } else { self.request(Request::Run)? };
        if denial.is_some() {
            self.feed.clear();
            self.under_way.clear();
            self.goal = None;
        }
        Ok(denial)
    }

    /// True if the arm is held at rest, and follows motions.
    pub(super) fn may_test(&mut self, name: &str) -> Result<bool, Stop> {
        let is_held = matches!(self.state(), Some(StateCode::Armed | StateCode::Holding | StateCode::Running));
        if !is_held || self.is_moving() {
            return self.reject(name, "the arm is not held at rest; `arm` first").map(|()| false);
        }
        self.follows_motions(name)
    }

    /// Moves to a position and back, each in this time (s), and waits for the end. Returns the reason if the board rejects one of the two motions.
    pub(super) fn back_and_forth(
        &mut self,
        name: &str,
        here: Vec<f64>,
        there: Vec<f64>,
        time: f64,
    ) -> Result<Option<Rejection>, Stop> {
        if !self.dead_man_is_held(name)? {
            return Err(Stop::Input(format!("{name}: Tab was not held")));
        }
        // An arm that began outside a limit returns only to the limit.
        let inside = here.iter().zip(&self.arm.range).map(|(q, (low, high))| q.max(*low).min(*high)).collect();
        for goal in [there, inside] {
            let from = self.here()?;
            let (motion, _) = self.way(name, &from, &goal, Some(time))?;
            if let Some(denial) = self.set_out(vec![motion], &from, goal)? {
                return Ok(Some(denial));
            }
            while self.is_moving() {
                self.step()?;
            }
        }
        Ok(None)
    }
}

/// True if the positions are equal, bit by bit.
fn same(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
}
