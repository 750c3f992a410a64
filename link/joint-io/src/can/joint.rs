//! State of one joint, and its commands.

use super::limits::{ENTER_EVERY, OFF_NOTICES, OWED_MAX, Order, PROBE_SHARE, PROBES};
use crate::frames::{Frames, Packet};
use crate::mit::Setpoint;
use dynamics_core::control::Spring;
use dynamics_core::drive::MitDrive;
use session::readings::JointFaults;

/// State of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct CanJoint {
    /// True if the drive has confirmed that it is on since it was last commanded off.
    pub(super) on: bool,
    /// True if the drive accepts damping: the last reply shows that it is on, or nothing shows that it is off.
    pub(super) powered: bool,
    /// Progress of enabling: 0 before the first frame, then 1. For a drive with replies that carry no state, one more with every probe.
    pub(super) asked: u8,
    /// Number of ticks with a reply that has shown the drive on. For a drive that sends notices, the number of notices that it has sent since it
    /// was first commanded on.
    pub(super) shown: u8,
    /// Number of ticks with a reply after which one may still show the drive off because it was commanded off. 0: it was commanded on since, or
    /// did not receive the command. For a drive that sends notices, the number of notices that are due since it was last commanded to move.
    pub(super) off_due: u8,
    /// Frames that switch on a drive that sends notices.
    pub(super) entering: Entering,
    /// Setting of its communication timeout.
    pub(super) timeout: Timeout,
    /// True if its zero may have been lost since the last [`JointIo::measure`](crate::JointIo::measure).
    pub(super) zero_lost: bool,
    /// The last two commands, in the drive's units, the newer one first.
    pub(super) told: [Setpoint; 2],
    /// Number of consecutive replies with less than half of the commanded torque.
    pub(super) weak: u8,
    /// True if there were too many of them since the last safe action.
    pub(super) torque_lost: bool,
    /// True if a reply has arrived since the start.
    pub(super) heard: bool,
    /// True if a frame was sent since the start.
    pub(super) greeted: bool,
    /// Number of outstanding replies to commands, from the last two ticks.
    pub(super) owed: u8,
    /// True if a reply was outstanding at the end of a tick that brought another one.
    pub(super) overdue: bool,
    /// Number of replies since the last [`JointIo::measure`](crate::JointIo::measure).
    pub(super) came: u8,
    pub(super) position: f32,
    pub(super) velocity: f32,
    pub(super) torque: f32,
    /// Temperature in the last reply, degrees Celsius.
    pub(super) temperature: Option<f32>,
    /// The drive's error code in the last reply.
    pub(super) error: u8,
    /// Ticks since the last reply; `u32::MAX` before the first.
    pub(super) age_ticks: u32,
    /// Faults found in the last reply or command.
    pub(super) faults: JointFaults,
}

/// Frames that switch on a drive that sends notices ([`Frames::enter`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entering {
    /// Number of them whose notice is outstanding.
    pub(super) outstanding: u8,
    /// Ticks since the last of them was sent; the highest number if none is outstanding.
    pub(super) ticks: u16,
}

impl Entering {
    pub(super) const NONE: Self = Self { outstanding: 0, ticks: u16::MAX };

    /// True if none is outstanding, or the last one counts as lost.
    pub(super) fn is_late(self, drive: &MitDrive) -> bool {
        u32::from(self.ticks) >= drive.restart_ticks.saturating_mul(ENTER_EVERY).min(u16::MAX.into())
    }
}

/// State of a drive's communication timeout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Timeout {
    /// Value in the drive's last answer.
    pub(super) value: Option<u32>,
    /// True if it was written since that answer.
    pub(super) written: bool,
    /// Number of frames sent about it.
    pub(super) tries: u8,
    /// Number of ticks in which an answer is still expected.
    pub(super) due: u8,
}

impl Timeout {
    /// True if the drive has confirmed it, or has none to confirm.
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
        entering: Entering::NONE,
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
    };
}

/// Torque of a probe at the drive, N m.
pub(super) fn probe(drive: &MitDrive) -> f32 {
    PROBE_SHARE * drive.ranges.torque.max
}

impl CanJoint {
    /// Returns the frame that carries out an order.
    pub(super) fn packet<F: Frames>(&mut self, drive: &MitDrive, order: Order, clears: bool) -> Packet {
        self.faults = self.faults.without(JointFaults::NON_FINITE);
        let first = !core::mem::replace(&mut self.greeted, true);
        if F::NOTICES && !self.entering.is_late(drive) {
            self.entering.ticks = self.entering.ticks.saturating_add(1);
        }
        let setpoint = match order {
            Order::Torque(torque, spring) => {
                let torque = drive.gearing.drive_torque(torque);
                let (torque, spring) = if torque.is_finite() {
                    (torque, spring)
                } else {
                    self.faults |= JointFaults::NON_FINITE;
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
            // Before the first frame the drive's state is unknown: a drive that was left on before the board's reset is damped too.
            Order::Damp if self.powered || first => match self.status_request::<F>(drive, clears) {
                Some(request) => return request,
                None => Setpoint::damped(drive.damping),
            },
            Order::Damp | Order::Off if F::NOTICES => return self.switch_off::<F>(drive, first, clears),
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

    /// Returns the frame with this setpoint. A setpoint holds NaN only if a range or a damping is NaN: then the drive is switched off.
    pub(super) fn command<F: Frames>(&mut self, drive: &MitDrive, setpoint: &Setpoint) -> Packet {
        self.told = [*setpoint, self.told[0]];
        if F::NOTICES {
            self.off_due = OFF_NOTICES;
        }
        F::command(drive, setpoint).unwrap_or_else(|| F::exit(drive))
    }

    /// Returns the next frame to a drive that has not confirmed that it is on.
    #[cold]
    #[inline(never)]
    pub(super) fn enable<F: Frames>(&mut self, drive: &MitDrive, damped: bool) -> Packet {
        if F::NOTICES {
            return self.switch_on::<F>(drive, damped);
        }
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
        // Replies arrive in the order of the frames: at most one that answers an earlier frame is still outstanding.
        (self.asked, self.shown, self.off_due) = (1, 0, self.off_due.min(1));
        self.told = [Setpoint::torque(0.0); 2];
        F::enter(drive)
    }

    /// Returns the frame that reads or writes the drive's communication timeout.
    pub(super) fn setting_packet<F: Frames>(&mut self, drive: &MitDrive) -> Option<Packet> {
        let it = &mut self.timeout;
        let differs = it.value.is_some_and(|value| value != drive.timeout);
        (it.tries, it.due) = (it.tries.saturating_add(1), OWED_MAX);
        // A value that was written is read back next.
        let writes = differs && !it.written;
        it.written = writes;
        if writes { F::write_timeout(drive) } else { F::read_timeout(drive) }
    }

    /// Records that the drive no longer counts as on: it is commanded off or to damp, or it cannot be reached.
    pub(super) fn forget(&mut self) {
        (self.on, self.asked, self.shown, self.weak) = (false, 0, 0, 0);
        self.told = [Setpoint::torque(0.0); 2];
    }

    /// Handles a possible restart of the drive: its settings and its zero may be those after a start.
    ///
    /// The drive does not count as off. If only its replies were lost, it still damps, and a frame that switches it off would let an arm without
    /// brakes fall. A drive that is off ignores damping.
    #[cold]
    pub(super) fn restarted(&mut self, drive: &MitDrive) {
        self.forget();
        (self.timeout, self.entering) = (Timeout::default(), Entering::NONE);
        self.zero_lost |= !drive.absolute;
    }

    /// Returns a setpoint with this torque (N m at the drive) at the measured state, and with a spring and a damper for deviations from it.
    ///
    /// The drive gives `kp (position - p) + kd (velocity - v) + torque`. Position and velocity are those of the last reply, which are codes of the
    /// frame: they are sent back without rounding. A spring or damper beyond the frame's range is limited to that range, and acts only so far
    /// between ticks; the torque at the measured state is not affected.
    pub(super) fn sprung(&self, drive: &MitDrive, torque: f32, spring: &Spring<f32>) -> Setpoint {
        let gearing = &drive.gearing;
        let Spring { stiffness, damping: kd } = gearing.drive_spring(spring);
        // With the highest code a command could equal a special frame.
        let kp = stiffness.min(0.999 * drive.ranges.kp.max);
        let (position, velocity) = (gearing.drive_position(self.position), gearing.drive_velocity(self.velocity));
        Setpoint { position, velocity, kp, kd, torque }
    }
}
