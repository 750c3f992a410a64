//! Other programs on this computer: the state for them, and their targets, which the arm follows after the command `follow`.
//!
//! The arm stops along its bounds and is held when no target comes for a time, when the program is gone, and after a target that is refused. If this
//! program stalls, the points at the board run out, and the board stops and holds the arm (cause "the trajectory ended in motion").

use super::command::Command;
use super::follower::{Follower, Following, JointBounds};
use super::heat::Heat;
use super::motion_queue::SPEED_SHARE;
use super::{Operator, Stop};
use crate::session::local::message::{Greeting, Snapshot};
use crate::session::local::shared::Shared;
use crate::session::local::targets::Over;
use ::session::trajectory::WAYS;
use link::{Actuation, Point, Sensed, StateCode};
use std::sync::Arc;
use std::time::Duration;

/// Share of a joint's acceleration limit that the arm uses on its way to a target. The rest is for the board, which stops an arm that could no longer stop
/// before a position limit.
const ACCELERATION_SHARE: f64 = 0.8;

/// Longest wait for the first target.
const FIRST_TARGET: Duration = Duration::from_secs(60);

/// Points at the board, so that this program may pause for 40 ms. More of them would delay the arm more.
const AHEAD: usize = 4;

impl Operator {
    /// Adds what this session shares with other programs.
    #[must_use]
    pub fn with_shared(self, shared: Option<Arc<Shared>>) -> Self {
        Self { shared, ..self }
    }

    /// The session's introduction to other programs.
    #[must_use]
    pub fn greeting(&self) -> Greeting {
        Greeting {
            scene: self.arm.recorded.head.scene.display().to_string(),
            joints: self.joint_names(),
            rate: 1.0 / self.arm.period,
            range: (self.arm.range.iter())
                .map(|(low, high)| (low.is_finite().then_some(*low), high.is_finite().then_some(*high)))
                .collect(),
        }
    }

    /// Shows the state of the last status to other programs.
    pub(super) fn publish(&self) {
        let Some(shared) = &self.shared else { return };
        let Some(seen) = self.seen_now() else { return };
        let status = seen.status;
        let wide = |values: &[f32]| values.iter().copied().map(f64::from).collect();
        let snapshot = Snapshot {
            tick: status.tick,
            time: f64::from(status.tick) * self.arm.period,
            state: status.state.name().to_owned(),
            text: seen.doing(),
            q: self.q.clone().unwrap_or_default(),
            qd: match status.sensed.as_ref().map(|sensed| &sensed.sensed).or(self.device.reading()) {
                Some(Sensed::State { qd, .. }) => wide(qd),
                _ => Vec::new(),
            },
            torque: match &status.actuation {
                Some(Actuation::Drive { torque, .. }) => wide(torque),
                _ => Vec::new(),
            },
            heat: (seen.heat.iter())
                .map(|heat| match heat {
                    Heat::Known(heat) => Some(f64::from(*heat)),
                    Heat::Unknown | Heat::Pending => None,
                })
                .collect(),
            // Added where the state is read.
            timing: None,
            age: None,
            following: false,
        };
        shared.publish(snapshot, self.is_live());
    }

    /// Follows the targets of another program that come at most `patience` (s) after each other.
    pub(super) fn follow(&mut self, patience: f64) -> Result<(), Stop> {
        let Some(shared) = self.shared.clone() else {
            return self.reject(
                "follow",
                "other programs cannot reach this session; in a dry run, `follow` needs a person at a terminal",
            );
        };
        if self.limit().is_some() {
            return self.reject(
                "follow",
                "in the first motion after homing no other program moves the arm: `jog` every joint a little, then `full-range`",
            );
        }
        if !self.follows_motions("follow")? {
            return Ok(());
        }
        if self.is_moving() {
            return self.reject("follow", "the arm moves; `hold` first");
        }
        let here = self.here()?;
        let bounds: Vec<_> = (self.arm.range.iter().zip(&self.arm.velocity).zip(&self.arm.acceleration))
            .map(|((position, velocity), acceleration)| JointBounds {
                position: *position,
                velocity: SPEED_SHARE * velocity,
                acceleration: ACCELERATION_SHARE * acceleration,
            })
            .collect();
        let step = f64::from(self.feed.step()) * self.arm.period;
        let Some(follower) = Follower::new(&here, &bounds, step) else {
            return self.reject("follow", "a joint has no limit of its velocity or acceleration");
        };
        if !self.torque_is_believed()? || !self.dead_man_is_held("follow")? {
            return Ok(());
        }
        self.following = Some(Following { follower, patience });
        let begun = self.set_out(Vec::new(), &here, here.clone());
        if !matches!(begun, Ok(None)) {
            self.leave_targets("the arm did not start");
        }
        let denial = begun?;
        if denial.is_none() && self.following.is_some() {
            // The goal is wherever the targets lead.
            self.goal = None;
            shared.open();
            self.watch_as_needed()?;
        }
        self.answer(
            "follow",
            denial,
            &format!("; follows the targets of another program, until none comes for {patience} s"),
        )
    }

    /// Ends the targets without a request: the board no longer follows them.
    pub(super) fn leave_targets(&mut self, why: &str) {
        if self.following.take().is_some()
            && let Some(shared) = &self.shared
        {
            shared.close(why);
        }
    }

    /// Ends the targets of an arm that still runs: it comes to rest on the shortest way, whatever happens to the request that follows.
    pub(super) fn end_targets(&mut self, why: &str) {
        if let (Some(following), Some(shared)) = (&mut self.following, &self.shared) {
            following.follower.brake();
            shared.close(why);
        }
    }

    /// Takes the newest target, or the reason for the end of the targets.
    pub(super) fn heed_targets(&mut self) -> Result<(), Stop> {
        // Not before the arm runs, and not within another request.
        if self.asking || self.state() != Some(StateCode::Running) || self.urgent.is_some() {
            return Ok(());
        }
        let (Some(following), Some(shared)) = (&mut self.following, &self.shared) else { return Ok(()) };
        if following.follower.has_stopped() {
            let taken = self.status.as_ref().is_some_and(|status| usize::from(status.room) == WAYS);
            if taken && self.under_way.is_empty() {
                self.goal = Some(following.follower.position());
                self.following = None;
                return self.hold_without_waiting();
            }
            return Ok(());
        }
        if following.follower.is_braking() {
            return Ok(());
        }
        let received = shared.received();
        let bad = received.target.and_then(|target| following.follower.go_to(&target).err());
        let late = received.silent.filter(|silent| silent.as_secs_f64() > following.patience);
        let why = match (bad, received.over, late) {
            (Some(bad), ..) => format!("a target was refused: {bad}"),
            (None, Some(Over::Done), _) => "the program has ended its targets".into(),
            (None, Some(Over::Gone), _) => "the program is gone".into(),
            (None, None, Some(late)) => format!("no target came for {:.2} s", late.as_secs_f64()),
            (None, None, None) if received.silent.is_none() && received.waited > FIRST_TARGET => {
                "no first target came".into()
            }
            (None, None, None) => return Ok(()),
        };
        following.follower.brake();
        shared.close(&why);
        self.refused |= received.over != Some(Over::Done);
        self.say("follow", &format!("follow: {why}: the arm stops"))
    }

    /// The next point of a motion for a board with this capacity; `None` if there is none, or if the board has enough for now.
    pub(super) fn next_point(&mut self, room: usize) -> Option<Point> {
        let at_board = WAYS.saturating_sub(room) + self.under_way.len();
        match &mut self.following {
            Some(following) if self.feed.is_empty() => {
                let wanted = at_board < AHEAD && !following.follower.has_stopped();
                wanted.then(|| Point { ticks: self.feed.step(), reference: following.follower.next_point() })
            }
            _ => self.feed.next_point(),
        }
    }

    /// True if this command would move an arm that follows another program.
    pub(super) fn interferes(&self, command: &Command) -> bool {
        let moves = matches!(
            command,
            Command::Run
                | Command::Jog(..)
                | Command::Goto(..)
                | Command::Weigh
                | Command::CheckTorque(_)
                | Command::Follow(_)
                | Command::Law(_)
                | Command::Payload(..)
        );
        moves && self.following.is_some() && self.state() == Some(StateCode::Running)
    }
}
