//! Effects of replies and of missing replies on a joint's state.

use super::joint::{CanJoint, probe};
use super::limits::{OWED_MAX, SHOWN, WEAK_MAX};
use crate::frames::{Frames, Setting};
use crate::mit::{Reply, Setpoint};
use dynamics_core::drive::{MitDrive, Range};
use session::readings::JointFaults;

impl CanJoint {
    /// Records that a frame was sent: a reply to it is outstanding.
    pub(super) fn sent(&mut self) {
        self.owed = (self.owed + 1).min(OWED_MAX);
    }

    /// Records that a frame counted as sent was not sent: no reply to it is outstanding.
    pub(super) fn dropped(&mut self) {
        self.owed = self.owed.saturating_sub(1);
    }

    pub(super) fn take<F: Frames>(&mut self, reply: &Reply, drive: &MitDrive) {
        if self.owed == 0 {
            return;
        }
        self.owed -= 1;
        let first = self.came == 0;
        self.came = self.came.saturating_add(1);
        self.position = drive.gearing.joint_position(reply.position);
        self.velocity = drive.gearing.joint_velocity(reply.velocity);
        self.torque = drive.gearing.joint_torque(reply.torque);
        // A reply without an error says nothing about the one that the drive's last status reported.
        let error = if F::NOTICES { self.error } else { reply.error };
        (self.temperature, self.error) = (reply.temperature, error);
        let found = JointFaults::RANGE.when(reply.saturated) | JointFaults::DRIVE.when(error != 0);
        self.faults = self.faults.without(JointFaults::RANGE | JointFaults::DRIVE) | found;
        if F::FACTS.reports_state {
            self.take_state(reply, drive, first);
        } else {
            self.take_torque(reply, drive);
        }
    }

    /// Takes the state in a reply. `first`: the first reply of this tick.
    pub(super) fn take_state(&mut self, reply: &Reply, drive: &MitDrive, first: bool) {
        let shows_on = !reply.off && reply.error == 0;
        let was_powered = core::mem::replace(&mut self.powered, shows_on);
        if shows_on {
            if self.on {
                // Its state is "on": even if it gives no torque, it has not restarted.
                self.weigh(reply, drive);
            } else if first {
                self.off_due = self.off_due.saturating_sub(1);
                if self.asked > 0 {
                    self.shown = self.shown.saturating_add(1);
                    self.on = self.shown >= SHOWN && self.timeout.is_settled(drive);
                }
            }
        } else if reply.error == 0 && (self.on || (was_powered && self.off_due == 0)) {
            // It was on or powered, and was not commanded off.
            self.restarted(drive);
        } else {
            (self.on, self.shown) = (false, 0);
        }
    }

    /// Takes the torque in a reply, for a protocol with replies that carry no state.
    pub(super) fn take_torque(&mut self, reply: &Reply, drive: &MitDrive) {
        let floor = probe(drive);
        if reply.error != 0 {
            (self.on, self.powered) = (false, false);
        } else if !self.on {
            self.powered |= self.asked > 0;
            if self.asked > 1 && (reply.torque - floor).abs() <= 0.5 * floor {
                self.on = true;
            }
        } else {
            if self.weigh(reply, drive) {
                self.restarted(drive);
            }
        }
    }

    /// Counts consecutive replies in which the drive gives less than half of the commanded torque. After too many the drive no longer counts as
    /// on, whatever state it reports. Returns true in that case.
    pub(super) fn weigh(&mut self, reply: &Reply, drive: &MitDrive) -> bool {
        let floor = probe(drive);
        // The reply belongs to the last command or, because a drive measures before it acts, to the one before.
        let [new, old] = self.told.map(|told| {
            let Setpoint { position, velocity, kp, kd, torque } = told;
            kp * (position - reply.position) + kd * (velocity - reply.velocity) + torque
        });
        let (low, high) = if new < old { (new, old) } else { (old, new) };
        let Range { min, max } = drive.ranges.torque;
        let weak = (low > floor && reply.torque < 0.5 * if low < max { low } else { max })
            || (high < -floor && reply.torque > 0.5 * if high > min { high } else { min });
        self.weak = if weak { self.weak.saturating_add(1) } else { 0 };
        let lost = self.weak > WEAK_MAX;
        if lost {
            self.forget();
            self.torque_lost = true;
        }
        lost
    }

    /// Takes a drive's answer about a setting. Returns false if none was requested.
    #[cold]
    #[inline(never)]
    pub(super) fn take_setting(&mut self, setting: Setting) -> bool {
        let asked = self.timeout.due > 0 && self.owed > 0;
        if asked {
            (self.timeout.due, self.owed) = (0, self.owed - 1);
            if let Setting::Timeout(value) = setting {
                (self.timeout.value, self.timeout.written) = (Some(value), false);
            }
        }
        asked
    }

    /// Largest possible age of the reading, ticks. While a second reply is outstanding, the reply that arrived may be late: it shows the drive as
    /// it was a tick ago, and the brakes must not open on it. Once they are open (`released`), a late reading counts as fresh.
    pub(super) fn age(&self, released: bool) -> u32 {
        self.age_ticks.max(u32::from(self.overdue && !released))
    }

    /// Begins a tick: evaluates the replies that have arrived, and ages the measurement if there is none.
    pub(super) fn begin_tick(&mut self, drive: &MitDrive) {
        let dark = self.age_ticks;
        self.timeout.due = self.timeout.due.saturating_sub(1);
        if core::mem::take(&mut self.came) > 0 {
            self.age_ticks = 0;
            if dark > drive.restart_ticks && core::mem::replace(&mut self.heard, true) {
                self.restarted(drive);
            }
            // One reply arrived and another is outstanding. Either this one was late, and the next tick brings two, or the other is lost.
            self.overdue = self.owed > 0 && !self.overdue;
            if !self.overdue {
                self.owed = 0;
            }
        } else {
            self.age_ticks = self.age_ticks.saturating_add(1);
            if self.heard && self.age_ticks == drive.restart_ticks.saturating_add(1) {
                self.restarted(drive);
            }
        }
    }
}
