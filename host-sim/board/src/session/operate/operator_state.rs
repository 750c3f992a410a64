//! Questions about the state of a session and its arm.

use super::Operator;
use super::report::Report;
use ::session::trajectory::WAYS;
use link::{Pacing, StateCode};

impl Operator {
    /// Names of the joints, base first.
    pub fn joint_names(&self) -> Vec<String> {
        self.arm.joints.iter().map(|(name, ..)| name.clone()).collect()
    }

    /// True if nothing was refused and the board is not in a fault.
    pub fn is_content(&self) -> bool {
        !self.refused && self.state() != Some(StateCode::Fault)
    }

    /// True if the board's own timer paces the ticks, as on a real board.
    pub fn is_live(&self) -> bool {
        self.device.pacing() == Pacing::Live
    }

    /// True if a motion is under way, or is being ended.
    pub fn is_moving(&self) -> bool {
        let pending = self.status.as_ref().is_some_and(|status| usize::from(status.room) < WAYS);
        let feeds =
            !self.feed.is_empty() || !self.under_way.is_empty() || self.following.is_some() || self.urgent.is_some();
        self.state() == Some(StateCode::Running) && (pending || feeds)
    }

    /// Output for the user.
    pub fn report(&self) -> &Report {
        &self.report
    }

    pub(super) fn state(&self) -> Option<StateCode> {
        self.status.as_ref().map(|status| status.state)
    }

    /// True if the drives apply torque.
    pub(super) fn drives(&self) -> bool {
        self.state().is_some_and(StateCode::has_torque)
    }
}
