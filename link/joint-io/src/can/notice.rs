//! Drives that send notices ([`Frames::NOTICES`]): they are switched on and off by frames that get no reply with the drive's state.

use super::joint::{CanJoint, Entering, probe};
use super::limits::{OFF_NOTICES, ON_NOTICES, OWED_MAX, PROBES};
use crate::frames::{Frames, Notice, Packet};
use crate::mit::Setpoint;
use dynamics_core::drive::MitDrive;
use session::readings::JointFaults;

impl CanJoint {
    /// Takes a notice, requested or not.
    #[cold]
    #[inline(never)]
    pub(super) fn take_notice(&mut self, notice: Notice) {
        // No reply follows the frame that this notice answers.
        if self.timeout.due > 0 && self.owed > 0 {
            (self.timeout.due, self.owed) = (0, self.owed - 1);
        }
        match notice {
            Notice::On => {
                // A notice of an earlier arming does not confirm this one: notices come in the order of the frames.
                self.entering.outstanding = self.entering.outstanding.saturating_sub(1);
                if self.entering.outstanding == 0 {
                    self.entering = Entering::NONE;
                    if self.asked > 0 && self.shown == 0 {
                        self.shown = 1;
                    }
                }
            }
            Notice::Off if self.asked == 0 && self.off_due == OFF_NOTICES => self.off_due = OFF_NOTICES - 1,
            Notice::Off => {}
            Notice::Status(error) => {
                self.error = error;
                self.faults = self.faults.without(JointFaults::DRIVE) | JointFaults::DRIVE.when(error != 0);
                if self.off_due == OFF_NOTICES - 1 {
                    self.off_due = 0;
                }
                if error != 0 {
                    (self.on, self.asked, self.shown) = (false, self.asked.min(1), self.shown.min(ON_NOTICES - 1));
                } else if self.asked > 0 && self.shown == ON_NOTICES - 1 {
                    self.shown = ON_NOTICES;
                }
            }
        }
    }

    /// Returns the next frame to a drive that has not confirmed that it is on.
    ///
    /// A frame that gets no reply with the drive's state is sent only in a tick that has one, so that no two ticks in a row are without. The frame
    /// that switches it on is sent again only after [`ENTER_EVERY`](super::limits::ENTER_EVERY) restart times, because a drive may take long to carry it out.
    #[cold]
    pub(super) fn switch_on<F: Frames>(&mut self, drive: &MitDrive, damped: bool) -> Packet {
        let fresh = self.age_ticks == 0;
        if self.asked > PROBES {
            (self.asked, self.shown) = (0, 0);
        }
        let is_late = self.entering.is_late(drive);
        if self.asked == 0 || (self.shown == 0 && fresh && is_late) {
            (self.asked, self.shown, self.off_due) = (1, 0, OFF_NOTICES);
            self.told = [Setpoint::torque(0.0); 2];
            self.timeout.due = OWED_MAX;
            let outstanding = if is_late { 0 } else { self.entering.outstanding };
            self.entering = Entering { outstanding: outstanding.saturating_add(1), ticks: 0 };
            return F::enter(drive);
        }
        if self.shown == ON_NOTICES - 1
            && fresh
            && let Some(request) = F::request_status(drive)
        {
            self.timeout.due = OWED_MAX;
            return request;
        }
        let held = if damped { Setpoint::damped(drive.damping) } else { Setpoint::torque(0.0) };
        if self.shown >= ON_NOTICES && fresh {
            self.asked += 1;
            return self.command::<F>(drive, &Setpoint { torque: probe(drive), ..held });
        }
        self.command::<F>(drive, &held)
    }

    /// Returns the next frame to a drive that must be off: the frame that switches it off until it confirms that, then a request for its status,
    /// and in all other ticks a command without torque and gains, which measures. `first`: the drive has got no frame since the start.
    #[cold]
    pub(super) fn switch_off<F: Frames>(&mut self, drive: &MitDrive, first: bool, clears: bool) -> Packet {
        let begins = core::mem::replace(&mut self.powered, false) || first;
        if begins {
            self.off_due = OFF_NOTICES;
        }
        // Both frames end the torque. In turns, they bring a reply in every other tick also if the notice is late or lost.
        if self.off_due == OFF_NOTICES && (begins || self.age_ticks.is_multiple_of(2)) {
            self.timeout.due = OWED_MAX;
            return F::exit(drive);
        }
        let request = self.status_request::<F>(drive, clears || self.off_due == OFF_NOTICES - 1);
        let measures = || F::command(drive, &Setpoint::torque(0.0)).unwrap_or_else(|| F::exit(drive));
        request.unwrap_or_else(measures)
    }

    /// Returns the frame that reads the drive's error, if it is wanted. `None` for a drive that sends no notices, and in a tick without a reply.
    #[inline]
    pub(super) fn status_request<F: Frames>(&mut self, drive: &MitDrive, wanted: bool) -> Option<Packet> {
        if !F::NOTICES || !wanted || self.age_ticks != 0 {
            return None;
        }
        self.timeout.due = OWED_MAX;
        F::request_status(drive)
    }
}
