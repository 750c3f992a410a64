//! State of one joint, and its commands.

use super::limits::{JointCounts, OWED_MAX, Order, PROBE_SHARE, PROBES};
use crate::frames::{Frames, Packet};
use crate::mit::Setpoint;
use dynamics_core::control::Spring;
use dynamics_core::drive::MitDrive;
use session::readings::JointFaults;

/// State of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct CanJoint {
    /// The drive has shown that it is on, since it was last commanded off.
    pub(super) on: bool,
    /// It takes damping: the last reply shows that it is on, or nothing shows that it is off.
    pub(super) powered: bool,
    /// Progress of enabling it: 0 before the first frame, then 1; of a drive whose replies carry no state, one more with every probe.
    pub(super) asked: u8,
    /// Replies that have shown it on, each of another tick.
    pub(super) shown: u8,
    /// Replies, each of another tick, that may still be followed by one that shows it off because it was commanded off. 0: it was commanded on
    /// since, or did not hear the command.
    pub(super) off_due: u8,
    /// Setting of its communication timeout.
    pub(super) timeout: Timeout,
    /// Its zero may be lost since the last [`JointIo::measure`].
    pub(super) zero_lost: bool,
    /// The last two commands, in the drive's units, the newer one first.
    pub(super) told: [Setpoint; 2],
    /// Replies, one after the other, with less than half of the torque that was commanded.
    pub(super) weak: u8,
    /// There were too many of them since the last safe action.
    pub(super) torque_lost: bool,
    /// A reply has come since the start.
    pub(super) heard: bool,
    /// A frame was sent since the start.
    pub(super) greeted: bool,
    /// Outstanding replies to commands, from the last two ticks.
    pub(super) owed: u8,
    /// The older outstanding reply has been waited for through a tick that brought one.
    pub(super) overdue: bool,
    /// Replies since the last [`JointIo::measure`].
    pub(super) came: u8,
    pub(super) position: f32,
    pub(super) velocity: f32,
    pub(super) torque: f32,
    /// In the last reply, degrees Celsius.
    pub(super) temperature: Option<f32>,
    /// In the last reply: the drive's own error code.
    pub(super) error: u8,
    /// Ticks since the last reply; `u32::MAX` before the first.
    pub(super) age_ticks: u32,
    /// Found in the last reply or command.
    pub(super) faults: JointFaults,
    pub(super) counts: JointCounts,
}

/// A drive's communication timeout, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Timeout {
    /// In the drive's last answer.
    pub(super) value: Option<u32>,
    /// It was written since that answer.
    pub(super) written: bool,
    /// Frames without a confirmation.
    pub(super) tries: u8,
    /// Ticks in which an answer is still expected.
    pub(super) due: u8,
}

impl Timeout {
    /// True if the drive has confirmed it, or needs not.
    pub(super) fn is_settled(self, drive: &MitDrive) -> bool {
        drive.timeout == 0 || (self.value == Some(drive.timeout) && !self.written)
    }
}

impl CanJoint {
    pub(super) const NEW: Self = Self {
        on: false,
        powered: false,
        asked: 0,
        shown: 0,
        off_due: 0,
        timeout: Timeout { value: None, written: false, tries: 0, due: 0 },
        zero_lost: false,
        told: [Setpoint::torque(0.0); 2],
        weak: 0,
        torque_lost: false,
        heard: false,
        greeted: false,
        owed: 0,
        overdue: false,
        came: 0,
        position: 0.0,
        velocity: 0.0,
        torque: 0.0,
        temperature: None,
        error: 0,
        age_ticks: u32::MAX,
        faults: JointFaults::NONE,
        counts: JointCounts { missing: 0, late: 0, duplicate: 0, refused: 0, unsent: 0 },
    };
}

/// Torque of a probe, N m of the drive.
pub(super) fn probe(drive: &MitDrive) -> f32 {
    PROBE_SHARE * drive.ranges.torque.max
}

impl CanJoint {
    /// The frame that carries out an order.
    pub(super) fn packet<F: Frames>(&mut self, drive: &MitDrive, order: Order, clears: bool) -> Packet {
        self.faults = self.faults.without(JointFaults::NON_FINITE);
        let first = !core::mem::replace(&mut self.greeted, true);
        let setpoint = match order {
            Order::Torque(torque, spring) => {
                let torque = drive.gearing.drive_torque(torque);
                let (torque, spring) = if torque.is_finite() {
                    (torque, spring)
                } else {
                    self.faults |= JointFaults::NON_FINITE;
                    self.counts.refused = self.counts.refused.wrapping_add(1);
                    (0.0, None)
                };
                match spring {
                    _ if !self.on => return self.enable::<F>(drive, false),
                    None => Setpoint::torque(torque),
                    Some(spring) => self.sprung(drive, torque, &spring),
                }
            }
            Order::Enable { damped } if !self.on => return self.enable::<F>(drive, damped),
            Order::Enable { damped: true } => Setpoint::damped(drive.damping),
            Order::Enable { damped: false } => Setpoint::torque(0.0),
            // A drive that a board before its reset has left on is damped too: nothing is known of it yet.
            Order::Damp if self.powered || first => Setpoint::damped(drive.damping),
            Order::Damp | Order::Off => {
                (self.powered, self.off_due) = (false, OWED_MAX);
                if clears
                    && self.error != 0
                    && let Some(clear) = F::clear(drive)
                {
                    return clear;
                }
                return F::exit(drive);
            }
        };
        self.command::<F>(drive, &setpoint)
    }

    /// The frame that makes a drive give this. A setpoint holds NaN only if a range or a damping is NaN: then the drive is switched off.
    pub(super) fn command<F: Frames>(&mut self, drive: &MitDrive, setpoint: &Setpoint) -> Packet {
        self.told = [*setpoint, self.told[0]];
        F::command(drive, setpoint).unwrap_or_else(|| F::exit(drive))
    }

    /// The next frame to a drive that has not shown that it is on.
    #[cold]
    #[inline(never)]
    pub(super) fn enable<F: Frames>(&mut self, drive: &MitDrive, damped: bool) -> Packet {
        if self.error != 0
            && let Some(clear) = F::clear(drive)
        {
            self.off_due = OWED_MAX;
            return clear;
        }
        let answered = self.age_ticks == 0 && self.asked > 0;
        let held = if damped { Setpoint::damped(drive.damping) } else { Setpoint::torque(0.0) };
        if F::FACTS.reports_state && answered && self.powered {
            return self.command::<F>(drive, &held);
        }
        if !F::FACTS.reports_state && answered && self.asked <= PROBES {
            self.asked += 1;
            return self.command::<F>(drive, &Setpoint { torque: probe(drive), ..held });
        }
        // Replies keep the order of the frames: at most one is still due that answers a frame from before this one.
        (self.asked, self.shown, self.off_due) = (1, 0, self.off_due.min(1));
        self.told = [Setpoint::torque(0.0); 2];
        F::enter(drive)
    }

    /// The frame that reads or writes the drive's communication timeout.
    pub(super) fn setting_packet<F: Frames>(&mut self, drive: &MitDrive) -> Option<Packet> {
        let it = &mut self.timeout;
        let differs = it.value.is_some_and(|value| value != drive.timeout);
        (it.tries, it.due) = (it.tries.saturating_add(1), OWED_MAX);
        // What was written is read back.
        let writes = differs && !it.written;
        it.written = writes;
        if writes { F::write_timeout(drive) } else { F::read_timeout(drive) }
    }

    /// Forgets that the drive is on: it is commanded off or to damp, or it cannot be reached.
    pub(super) fn forget(&mut self) {
        (self.on, self.asked, self.shown, self.weak) = (false, 0, 0, 0);
        self.told = [Setpoint::torque(0.0); 2];
    }

    /// The drive may have restarted: its settings and its zero are what they are after a start.
    ///
    /// It is not known to be off: one that was only not heard still damps, and a frame that switches it off would let an arm without
    /// brakes fall. One that is off takes no notice of damping.
    #[cold]
    pub(super) fn restarted(&mut self, drive: &MitDrive) {
        self.forget();
        self.timeout = Timeout::default();
        self.zero_lost |= !drive.absolute;
    }

    /// This torque of the drive where the joint was measured, and the spring's wherever it has gone since.
    ///
    /// `kp (position - p) + kd (velocity - v) + torque` with position and velocity of the last reply, which are codes: no rounding
    /// is between the drive's measurement and this. Of a spring or damper beyond the frame's range the drive renews what it can; the
    /// rest is in the torque.
    pub(super) fn sprung(&self, drive: &MitDrive, torque: f32, spring: &Spring<f32>) -> Setpoint {
        let gearing = &drive.gearing;
        let Spring { stiffness, damping: kd } = gearing.drive_spring(spring);
        // The highest code of all may be part of a special frame.
        let kp = stiffness.min(0.999 * drive.ranges.kp.max);
        let (position, velocity) = (gearing.drive_position(self.position), gearing.drive_velocity(self.velocity));
        Setpoint { position, velocity, kp, kd, torque }
    }
}
